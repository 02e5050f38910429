//! How much overhang each tool needs: the least at which nothing of the setup comes too near.
//!
//! The whole motion is run again with the tool clamped further out or less far. With another
//! overhang the joints are at other positions, so that travel, spindle and table are checked again,
//! not the holder alone. Judged is what happens while the tool is in the spindle: findings of
//! collision and near miss, of travel, and of neck or shank in material. Where the present overhang
//! is clear, shorter ones are tried, else longer ones; the interval is halved until it is no longer
//! than [`STEP_MM`].
//!
//! ```text
//!  overhang   |--x----x--x-o-o-----------o-->     o  clear: a run without such a finding
//!             least that   ^ reported             x  a run with one
//!             is clamped   the shortest run that was clear
//! ```
//!
//! The reported overhang was run, and so was the one below it that was not clear. *Limit.* Between
//! the two ends of the search it is assumed that more overhang clears more; a setup with a ceiling
//! may have a clear overhang below one that is not.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

use proveout_controller::Event;
use proveout_nc::{Op, ToolAction, ToolName};
use proveout_tool::Tool;

use crate::{
    observe::{
        observer::{Batch, Observer, Outcome, Setup},
        observer_error::ObserverError,
    },
    prepare::{choice::Choice, error::SimError, prepared::Prepared},
    run::main_loop::rehearse,
    verdict::finding::{self, Family, Finding, Severity},
};

/// The reported overhang is at most this much more than needed, mm.
pub const STEP_MM: f64 = 0.5;
/// First step beyond an overhang that is not clear, doubled until one is clear, mm.
const FIRST_MM: f64 = 5.0;
/// Longest overhang that is tried beyond the present one, mm.
const LONGEST_MM: f64 = 160.0;

/// What was found for one tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Overhang {
    /// Name of the tool.
    pub tool: String,
    /// As the library clamps it, mm.
    pub now_mm: f64,
    /// Least overhang whose run was clear, mm; none where no run was.
    pub least_mm: Option<f64>,
    /// Overhang below it whose run was not clear, with the first finding; none where the shortest that can be
    /// clamped is clear.
    pub too_short: Option<(f64, String)>,
    /// Runs that were made.
    pub runs: usize,
}

/// Searches the least overhang of every tool with a holder that the program uses; `told` is called
/// for every run.
///
/// # Errors
/// As [`crate::run::main_loop::run`].
pub fn least_overhangs(scene: &Path, choice: &Choice, told: &mut dyn FnMut(&str)) -> Result<Vec<Overhang>, SimError> {
    let used = tools_used(Prepared::read(scene, choice)?)?;
    used.into_iter().map(|(name, now, range)| search(scene, choice, &name, now, range, told)).collect()
}

/// Most lines of a program for which the shortest overhang is looked for without being asked.
const SHORT_LINES: u32 = 3000;
/// Largest stock for the same, bytes.
const SMALL_STOCK: u64 = 48 << 20;

/// The same for tools whose length was chosen and not measured, if the program is short and the stock small.
/// The search runs the program about ten times for each tool, at the coarse cells of a preview. Empty if no
/// length is assumed, or if the stock cannot be represented at those cells.
///
/// # Errors
/// As [`crate::run::main_loop::run`].
pub fn least_of_assumed(scene: &Path, choice: &Choice, prepared: &Prepared) -> Result<Vec<Overhang>, SimError> {
    let stock: u64 = prepared.memory.stocks.iter().map(|(_, bytes)| bytes).sum();
    if choice.stop_at.is_some() || prepared.program_lines > SHORT_LINES || stock > SMALL_STOCK {
        return Ok(Vec::new());
    }
    let library = &prepared.tools;
    let mut called = BTreeSet::new();
    let start = prepared.scene.file.start.tool.map(ToolName::Number);
    let mut note = |name: &ToolName| {
        let is = |t: &Tool| match name {
            ToolName::Empty => false,
            ToolName::Number(number) => t.number == *number,
            ToolName::Name(name) => t.name == *name,
        };
        called.extend(library.tools.iter().position(is));
    };
    start.iter().for_each(&mut note);
    for command in prepared.program()? {
        if let Op::Tool(ToolAction::Change(name)) = command?.op {
            note(&name);
        }
    }
    let assumed = called.into_iter().filter(|index| library.is_length_assumed(*index));
    let known = assumed.filter_map(|index| {
        let tool = library.tools.get(index)?;
        Some((tool.name.clone(), tool.overhang()?, tool.clamping_range()?))
    });
    let coarse = Choice { preview: true, ..choice.clone() };
    let found: Result<Vec<Overhang>, SimError> =
        known.map(|(name, now, range)| search(scene, &coarse, &name, now, range, &mut |_| ())).collect();
    Ok(found.unwrap_or_default())
}

/// Name, overhang and range of the tools in the spindle that have a holder.
fn tools_used(prepared: Prepared) -> Result<Vec<(String, f64, [f64; 2])>, SimError> {
    let library = prepared.tools.tools.clone();
    let heard = listen(prepared)?;
    let tools = heard.changes.iter().filter_map(|(_, tool)| *tool).collect::<BTreeSet<usize>>();
    let known = |i: &usize| {
        let tool = library.get(*i)?;
        Some((tool.name.clone(), tool.overhang()?, tool.clamping_range()?))
    };
    Ok(tools.iter().filter_map(known).collect())
}

fn search(
    scene: &Path,
    choice: &Choice,
    name: &str,
    now: f64,
    [shortest, longest]: [f64; 2],
    told: &mut dyn FnMut(&str),
) -> Result<Overhang, SimError> {
    let mut runs = 0;
    let mut first_fault = |overhang: f64| -> Result<Option<String>, SimError> {
        runs += 1;
        let mut choice = choice.clone();
        choice.clamped_out_mm.insert(name.to_owned(), overhang - now);
        let prepared = Prepared::read(scene, &choice)?;
        let index = prepared.tools.tools.iter().position(|t| t.name == name);
        let fault = listen(prepared)?.first_fault(index);
        let words = fault.as_deref().unwrap_or("clear");
        told(&format!("{name} with {overhang:.1} mm of overhang: {words}"));
        Ok(fault)
    };
    // Half a step above the foot of what the holder grips.
    let shortest = (shortest + 0.5 * STEP_MM).min(now);
    let (mut clear, mut short) = (None, None);
    match first_fault(now)? {
        None => {
            clear = Some(now);
            if shortest < now {
                match first_fault(shortest)? {
                    None => clear = Some(shortest),
                    Some(fault) => short = Some((shortest, fault)),
                }
            }
        }
        Some(fault) => {
            short = Some((now, fault));
            let end = longest.min(now + LONGEST_MM);
            let mut more = FIRST_MM;
            let mut last = now;
            while clear.is_none() && last < end {
                last = (now + more).min(end);
                more *= 2.0;
                match first_fault(last)? {
                    None => clear = Some(last),
                    Some(fault) => short = Some((last, fault)),
                }
            }
        }
    }
    while let (Some(long), Some((low, _))) = (clear, &short) {
        if long - low <= STEP_MM {
            break;
        }
        let middle = 0.5 * (long + low);
        match first_fault(middle)? {
            None => clear = Some(middle),
            Some(fault) => short = Some((middle, fault)),
        }
    }
    Ok(Overhang { tool: name.to_owned(), now_mm: now, least_mm: clear, too_short: short, runs })
}

/// What a run says while it goes on.
#[derive(Debug, Default)]
struct Heard {
    /// Tool in the spindle from this time on, s.
    changes: Vec<(f64, Option<usize>)>,
    findings: Vec<Finding>,
}

impl Heard {
    /// The first finding against the overhang of a tool, with its place.
    fn first_fault(&self, tool: Option<usize>) -> Option<String> {
        let in_spindle = |time: f64| self.changes.iter().rev().find(|(t, _)| *t <= time).and_then(|(_, tool)| *tool);
        let against = |f: &&Finding| {
            let concerned = matches!(f.family, Family::Collision | Family::Limits)
                || [finding::NECK_RUBS.code, finding::SHANK_RUBS.code].contains(&f.code.as_str());
            concerned && f.severity != Severity::Info && f.time_s.is_some_and(|t| in_spindle(t) == tool)
        };
        self.findings.iter().find(against).map(|f| f.message.clone())
    }
}

struct Listener(Arc<Mutex<Heard>>);

impl Observer for Listener {
    fn name(&self) -> &'static str {
        "overhang"
    }

    fn begin(&mut self, _setup: &Setup<'_>, _folder: &Path) -> Result<(), ObserverError> {
        Ok(())
    }

    fn batch(&mut self, _setup: &Setup<'_>, batch: &Batch<'_>) -> Result<(), ObserverError> {
        let mut heard = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for event in batch.events {
            if let Event::ToolChange { time, tool, .. } = event {
                heard.changes.push((*time, *tool));
            }
        }
        heard.findings.extend_from_slice(batch.findings);
        Ok(())
    }

    fn end(&mut self, _setup: &Setup<'_>, _outcome: &Outcome<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

fn listen(prepared: Prepared) -> Result<Heard, SimError> {
    let heard = Arc::new(Mutex::new(Heard::default()));
    rehearse(prepared, &mut [Box::new(Listener(heard.clone()))])?;
    let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(std::mem::take(&mut heard))
}

/// Least overhangs by the name of the tool, as a run takes them over.
pub fn by_tool(found: &[Overhang]) -> BTreeMap<String, f64> {
    found.iter().filter_map(|o| Some((o.tool.clone(), o.least_mm?))).collect()
}
