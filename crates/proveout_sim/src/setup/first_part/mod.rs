//! From a program to a scene that runs: what the text says, what only the user knows, and a folder
//! with scene, tools and README.
//!
//! [`propose`] reads the programs with the control of the call, the machine, or the one that their
//! text names. It follows where they take their tools (`program_trace`), looks for unit, stock and tools in
//! headers and comments (`facts`), proposes stock and mounting (`place`), and asks for the rest
//! (`interview`). Values that were chosen rather than given are marked so in the files (`writing`).
//! Nothing is written here: [`Proposal::write`] does, into a folder that does not exist yet, moved
//! into its place when it is whole.
//!
//! The frame of the workpiece is that of the first work offset that the program uses: its zero is the zero of
//! the program.

mod control_words;
mod facts;
mod home_zero;
mod interview;
mod over_table;
pub(crate) mod place;
mod stock_choice;
mod summary;
mod tool_choice;
mod tool_names;
mod tool_sizes;
mod tool_statements;
mod tool_words;
mod workholding;
mod writing;
mod zeros;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use proveout_geom::{Aabb, Point, Pose, TriMesh, Vector};
use proveout_input::MAX_LENGTH_MM;
use proveout_machine::Machine;
use proveout_nc::{Control, Dialect, ProgramText, Settings, ToolName, WorkOffset};
use proveout_step::StepFiles;
use proveout_tool::{LengthUnit, ToolDraft, ToolLibrary};

pub use interview::{Ask, Question, holder, read_answers};
pub use summary::{ProgramTold, StockTold, Summary, ToolTold};

use self::home_zero::HomeZero;
use self::interview::{Interview, PROPOSED};
use self::place::Reach;
use self::stock_choice::{Cuts, check_design, design, resolution, stock, unit_of_design};
pub(crate) use self::tool_choice::shown;
use self::tool_choice::tools;
use self::workholding::{Workholding, workholding};
use self::zeros::{offsets, own_mount, stated_mount};
use crate::prepare::{
    control_file::{control_of, settings_on},
    control_settings::length_active_after_change,
    error::SimError,
    machine_data::with_machine,
    program_extent::{NO_TURN, Reading, ToolUse},
    program_trace::setup,
};

/// What the call gives.
#[derive(Clone, Debug, Default)]
pub struct FirstPart {
    /// Program texts.
    pub programs: Vec<PathBuf>,
    /// Folder of the machine.
    pub machine: PathBuf,
    /// Control: a built-in one or a file.
    pub control: Option<String>,
    /// Design: a mesh or a STEP file.
    pub design: Option<PathBuf>,
    /// Tool library: of this program, or one that [`proveout_tool::import_tools`] reads.
    pub tools: Option<PathBuf>,
    /// Unit of that library, where the library does not state it.
    pub unit: Option<LengthUnit>,
    /// Answers by their keys.
    pub answers: BTreeMap<String, String>,
    /// Folder that is to be written.
    pub output: PathBuf,
    /// STEP files that the call has read already.
    pub step_files: StepFiles,
}

/// Why there is no proposal.
#[derive(Debug)]
pub enum FirstPartError {
    /// A file of the call is wrong.
    Sim(Box<SimError>),
    /// Questions without an answer.
    Unanswered(Vec<Question>),
    /// What else keeps a scene from being made.
    Refused {
        /// What is wrong.
        message: String,
        /// What to do.
        help: String,
    },
}

impl<E: Into<SimError>> From<E> for FirstPartError {
    fn from(e: E) -> Self {
        Self::Sim(Box::new(e.into()))
    }
}

fn refused(message: impl Into<String>, help: impl Into<String>) -> FirstPartError {
    FirstPartError::Refused { message: message.into(), help: help.into() }
}

/// A scene that can be written.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// What was found, line by line, for people.
    pub told: Vec<String>,
    /// The same for programs that read.
    pub summary: Summary,
    /// Questions that were answered.
    pub answered: usize,
    files: Vec<(&'static str, String)>,
    machine: Option<HomeZero>,
    design: Option<TriMesh>,
    output: PathBuf,
}

/// A value with the reason for it.
#[derive(Clone, Debug)]
pub(crate) struct Reasoned<T> {
    pub(crate) value: T,
    pub(crate) reason: String,
    /// Nothing that was given says it: the reason begins with the word `chosen`.
    pub(crate) chosen: bool,
}

/// Stock of the scene.
#[derive(Clone, Debug)]
pub(crate) enum StockForm {
    Box(Aabb),
    /// Along the axis of this index.
    Cylinder {
        base: [f64; 3],
        radius: f64,
        height: f64,
        along: usize,
    },
    Mesh(PathBuf, Aabb),
}

impl StockForm {
    pub(crate) fn aabb(&self) -> Aabb {
        match self {
            Self::Box(b) | Self::Mesh(_, b) => *b,
            Self::Cylinder { base, radius, height, along } => {
                let mut bounds = Aabb { min: (*base).into(), max: (*base).into() };
                for i in 0..3 {
                    if i == *along {
                        bounds.max[i] += height;
                    } else {
                        bounds.min[i] -= radius;
                        bounds.max[i] += radius;
                    }
                }
                bounds
            }
        }
    }
}

/// Everything that the files of the scene say.
pub(crate) struct Plan<'a> {
    pub(crate) call: &'a FirstPart,
    pub(crate) machine: &'a Machine,
    /// A copy of the machine that the scene gets.
    pub(crate) home_zero: Option<HomeZero>,
    pub(crate) dialects: Vec<Dialect>,
    pub(crate) control: Option<String>,

    pub(crate) stock: Reasoned<StockForm>,
    pub(crate) mount: Reasoned<Vector>,
    pub(crate) workholding: Workholding,
    /// Work offsets: word, base coordinates, rotary positions, reason.
    pub(crate) offsets: Vec<(String, [f64; 3], String)>,
    /// The library: its path as it is, or drafts that are written.
    pub(crate) tools: Tools,
    pub(crate) start_tool: Option<(u32, String)>,
    pub(crate) design: Option<Design>,
    pub(crate) resolution: Reasoned<f64>,
    pub(crate) notes: Vec<String>,
}

pub(crate) enum Tools {
    Library(PathBuf),
    Drafts(Vec<ToolDraft>),
}

/// Design of the part.
pub(crate) struct Design {
    pub(crate) path: PathBuf,
    pub(crate) mesh: TriMesh,
    /// Its numbers are inches, as an answer says.
    pub(crate) inch: bool,
}

/// Characters of a text that are read.
const LOOKED_AT: usize = 1 << 16;
/// Share of control characters above which a file is no text: a picture or an archive has a fifth, a text in
/// any code page hardly one.
const CONTROLS: f64 = 0.05;

/// Whether a file that reads as a text looks like a picture, an archive or another binary file.
pub fn looks_binary(text: &ProgramText) -> bool {
    let (mut all, mut controls) = (0_usize, 0_usize);
    for c in text.all().flat_map(str::chars).take(LOOKED_AT) {
        all += 1;
        controls += usize::from(c.is_control() && !matches!(c, '\t' | '\r' | '\u{c}'));
    }
    // An archive may hold plain text.
    let zip = text.all().next().is_some_and(|line| line.starts_with("PK\u{3}\u{4}"));
    zip || controls as f64 > CONTROLS * all as f64
}

/// Makes a scene for programs on a machine; `ask` is called for what neither text nor answers give.
///
/// # Errors
/// [`FirstPartError`]: what is wrong with a file of the call, with all faults of a program's text; all
/// questions that stay open.
pub fn propose(call: &FirstPart, ask: &mut Ask<'_>) -> Result<Proposal, FirstPartError> {
    if call.output.symlink_metadata().is_ok() {
        let message = format!("{} is there already", call.output.display());
        return Err(refused(message, "name another folder with --output: existing files are never overwritten"));
    }
    let mut machine = Machine::read(&call.machine)?;
    let mut interview = Interview::new(call.answers.clone(), ask);
    let texts = call.programs.iter().map(ProgramText::open).collect::<Result<Vec<_>, _>>()?;
    if let Some((program, _)) = call.programs.iter().zip(&texts).find(|(_, text)| looks_binary(text)) {
        let message = format!("{} is not plain text: it looks like a binary file", program.display());
        return Err(refused(message, "name the text of an NC program"));
    }
    let (mut settings, mut notes) = settings_of(call, &machine)?;

    // What is called, before anything is known of tools and zero.
    let none = |dialect| setup(&Pose::identity(), BTreeMap::new(), dialect, ToolName::Empty);
    let read = |settings: &[Settings], machine: &Machine| -> Vec<Reading> {
        call.programs.iter().zip(settings).map(|(p, s)| Reading::of(p, s, machine, none(s.dialect))).collect()
    };
    let mut first = read(&settings, &machine);
    let mut home_zero = None;
    if let Some((at_home, copy)) = home_zero::chosen(&call.machine, &machine, &first) {
        machine = at_home;
        (settings, notes) = settings_of(call, &machine)?;
        first = read(&settings, &machine);
        notes.push(copy.reason.clone());
        home_zero = Some(copy);
    }
    let hint = |i: usize| -> Option<String> {
        let unnamed = settings.get(i)?.control.name().is_empty();
        unnamed.then(|| control_words::hint(texts.get(i)?, first.get(i)?.survey.dialect)).flatten()
    };
    for (i, reading) in first.iter().enumerate() {
        // A call that the control file leaves out is its choice, and the run reports it.
        let survey = &reading.survey;
        let mut faults = if survey.faults.is_empty() { survey.own_defects() } else { survey.faults.clone() };
        let hint = hint(i);
        if let Some(fault) = faults.first_mut() {
            // The words of another control are often the fault.
            let last = texts.get(i).and_then(|t| (1_u32..).zip(t.all()).filter(|(_, l)| !l.trim().is_empty()).last());
            let cut = last
                .filter(|(line, text)| {
                    *line == fault.line && call.programs.get(i).is_some() && !text.trim().starts_with('%')
                })
                .map(|_| "the text ends in this line: is the file complete?".to_owned());
            fault.help = [fault.help.take(), cut, hint].into_iter().flatten().reduce(|a, b| format!("{a}; {b}"));
            return Err(FirstPartError::from(proveout_nc::Diagnostics(faults)));
        }
        // Another control may answer what is asked for.
        interview.note = interview.note.take().or_else(|| hint.clone());
        notes.extend(hint);
    }
    let dialects: Vec<Dialect> = first.iter().map(|r| r.survey.dialect).collect();
    // What lengths count in before the first word for it.
    let start_unit =
        |s: &Settings| if s.control.starts_in_inch() == Some(true) { LengthUnit::Inch } else { LengthUnit::Millimeter };
    let all_facts: Vec<facts::Facts> =
        texts.iter().zip(&dialects).zip(&settings).map(|((t, d), s)| facts::of_text(t, *d, start_unit(s))).collect();
    let unit = all_facts.iter().find_map(|f| f.unit.clone());
    let mut told = told_of_programs(call, &first, &settings, unit.as_ref());
    let speaks = all_facts.iter().find_map(|f| f.inch_comment).filter(|_| unit.is_none());
    if let (Some(line), Some(false)) = (speaks, settings.first().map(|s| start_unit(s) == LengthUnit::Inch)) {
        let note = format!(
            "the comment in line {line} mentions inches, but the program has no G20: lengths are read in millimeters; if the control starts in inches, say so in a file for --control: inherits = \"fanuc-0i\", start.unit = \"inch\""
        );
        interview.note.get_or_insert_with(|| note.clone());
        notes.push(note);
    }

    let start_tool = start_tool(&first, &all_facts, &mut interview)?;
    let tools = tools(call, &first, &all_facts, start_tool.as_ref(), &mut interview, &mut notes)?;
    // Where the zeros are: the first work offset is the frame of the workpiece.
    let offsets = offsets(&first, &dialects, &mut interview)?;
    let indexed = first.iter().find_map(|r| r.indexed.clone());
    let turned: Vec<char> = first
        .iter()
        .flat_map(|r| &r.rotary)
        .filter(|(_, [low, high])| low.abs().max(high.abs()) > NO_TURN)
        .map(|(letter, _)| *letter)
        .collect();
    let again = |word: &str, base: [f64; 3]| -> Option<Reading> {
        let work_offsets = BTreeMap::from([(word.to_owned(), WorkOffset { translation: base, rotary: [0.0; 3] })]);
        let (program, s) = (call.programs.first()?, settings.first()?);
        Some(Reading::of(program, &Settings { work_offsets, ..s.clone() }, &machine, none(s.dialect)))
    };
    let own_mount = own_mount(&machine, &first, &mut interview, &again);
    let sets_zero = own_mount.is_some();
    let stated_mount = match own_mount {
        Some(mount) => Some(mount),
        None => stated_mount(&machine, indexed.as_ref(), &turned, &mut interview)?,
    };
    let design = design(call)?;

    // The same with tools and zeros: where the cuts are in the workpiece frame.
    let provisional = stated_mount.as_ref().map_or_else(|| Vector::new(0.0, 0.0, 100.0), |m| m.value);
    // Without any word for a length the coordinates are taken as those of the tips.
    let untold = untold(&first, &dialects);
    let start_name = start_tool.as_ref().map_or(ToolName::Empty, |(n, _)| ToolName::Number(*n));
    let zero = machine.program_zero();
    let base = |mount: &Vector, shift: &[f64; 3]| -> [f64; 3] {
        let zero = zero.unwrap_or_else(Point::origin);
        [0, 1, 2].map(|i| mount[i] - zero[i] + shift[i])
    };
    let follow_with = |mount: &Vector, lengths: &BTreeMap<ToolName, f64>| -> Vec<Reading> {
        let pose = Pose::from_translation(*mount);
        let followed = if untold { BTreeMap::new() } else { lengths.clone() };
        call.programs
            .iter()
            .zip(&settings)
            .zip(&dialects)
            .map(|((program, s), dialect)| {
                let work_offsets = offsets
                    .iter()
                    .map(|(word, shift, _)| {
                        (word.clone(), WorkOffset { translation: base(mount, shift), rotary: [0.0; 3] })
                    })
                    .collect();
                let s = Settings { work_offsets, ..s.clone() };
                Reading::of(program, &s, &machine, setup(&pose, followed.clone(), *dialect, start_name.clone()))
            })
            .collect()
    };
    let readings = follow_with(&provisional, &tools.lengths());
    let uses: Vec<&ToolUse> = readings.iter().flat_map(|r| &r.tools).collect();
    let room = readings.iter().fold(Aabb::empty(), |all, r| all.union(&r.feed()));
    // What is asked here needs the answers before; a proposal that may be wrong without them is none.
    let guessed = interview.open.iter().any(|q| q.key != "holder");
    let found = (|| {
        if room.is_empty() {
            notes.push(NOTHING_CUT.to_owned());
        }
        let with_design = design.is_some();
        let design =
            design.map(|d| unit_of_design(d, &all_facts, &room, unit.as_ref(), &mut interview)).transpose()?.flatten();
        // A design of which the unit is asked decides the stock.
        let guessed = guessed || with_design && design.is_none();
        let cuts = Cuts { uses: &uses, tools: &tools, untold, guessed, step_files: &call.step_files };
        let stock = stock(&all_facts, &cuts, design.as_ref(), &mut interview)?;
        Ok::<_, FirstPartError>((design, stock))
    })();
    // All open questions are reported at once, before faults that may only follow from them.
    stop_if_open(&interview)?;
    let (design, stock) = found?;
    let workholding = match &stock {
        Some(stock) => workholding(&stock.value.aabb(), &mut interview)?,
        None => Workholding::Unknown,
    };
    if let Some((stray, near)) = interview.stray() {
        let help = near.map_or_else(|| "leave it out".to_owned(), |n| format!("did you mean `{n}`? Else leave it out"));
        return Err(refused(format!("there is no question for the answer `{stray}`"), help));
    }
    let Some(stock) = stock else { return Err(refused("the stock is not known", "state it with --stock")) };
    let bounds = stock.value.aabb();
    let largest = (0..3).flat_map(|i| [bounds.min[i], bounds.max[i]]).map(f64::abs).fold(0.0, f64::max);
    if largest > MAX_LENGTH_MM {
        return Err(refused(
            format!("the stock extends to {largest:.3e} mm, beyond the travel of any machine"),
            format!(
                "check its unit and the coordinates of the program; the limit of a scene is {:.0} mm",
                MAX_LENGTH_MM
            ),
        ));
    }
    if let Some(design) = &design {
        check_design(design, &stock.value, &room)?;
    }
    // What is chosen of the tools reaches their cuts; then the motion is followed once more.
    let depths: Vec<(ToolName, f64)> = uses
        .iter()
        .filter(|t| t.feeds > 0 && !t.feed.is_empty())
        .map(|t| (t.name.clone(), if t.tilted { t.along } else { bounds.max.z - t.feed.min.z }))
        .collect();
    let mut tools = tools;
    let longer = tools.reach(&depths);
    let lengths = tools.lengths();
    let touch_off = if untold { touch_off(&first, start_tool.as_ref(), &lengths) } else { 0.0 };
    let follow = |mount: &Vector| follow_with(mount, &lengths);
    let readings = if longer { follow(&provisional) } else { readings };
    let uses: Vec<&ToolUse> = readings.iter().flat_map(|r| &r.tools).collect();

    let mount = match stated_mount {
        // Without a word for a length the tip hangs below where the program puts its zero.
        Some(mount) if sets_zero => Reasoned { value: mount.value - Vector::z() * touch_off, ..mount },
        Some(mount) => mount,
        None => {
            let reaches: Vec<Reach> = uses
                .iter()
                .filter(|t| !t.feed.is_empty() && !t.tilted)
                .map(|t| Reach {
                    // Without a length and without a zero at the tip the gauge line goes where the tip is
                    // programmed.
                    gauge: if untold && touch_off == 0.0 { 0.0 } else { lengths.get(&t.name).copied().unwrap_or(0.0) },
                    tip: [t.feed.min.z, t.feed.max.z.max(stock.value.aabb().max.z) + 2.0],
                })
                .collect();
            let (value, reason) = place::propose_mount(&machine, &stock.value.aabb(), &reaches);
            let proposed = Reasoned { value, reason, chosen: true };
            let mount = over_table::cleared(&machine, proposed, &readings, tools.widest_holder());
            let mount = if readings.iter().any(|r| r.tcp) {
                let range = |mount: &Vector| place::range_of_z(&machine, &follow(mount));
                place::lifted(&machine, mount, &range)
            } else {
                mount
            };
            // With a length that is never active Z is no place of the tip.
            let axes = if touch_off == 0.0 { "XYZ" } else { "XY" };
            place::in_travel(&machine, mount, axes, &follow)
        }
    };
    let offsets: Vec<(String, [f64; 3], String)> = offsets
        .iter()
        .map(|(word, shift, reason)| {
            let [x, y, z] = base(&mount.value, shift);
            (word.clone(), [x, y, z + touch_off], reason.clone())
        })
        .collect();

    let gap = mount.value.z + stock.value.aabb().min.z - machine.table.point.z;
    let (workholding, deep) = workholding.on_table(&stock.value.aabb(), gap);
    notes.extend(deep);
    let resolution = resolution(&stock.value.aabb(), &uses, &tools);
    let in_spindle = start_tool.as_ref().map_or(ToolName::Empty, |(n, _)| ToolName::Number(*n));
    let never = readings.iter().filter_map(|r| crate::setup::causes::never_changed(r, &in_spindle));
    notes.extend(never.map(|c| format!("{}; {}", c.what, c.add)));
    notes.extend(
        crate::setup::causes::outside_travel(&machine, &readings).into_iter().map(|c| format!("{}; {}", c.what, c.add)),
    );
    told.extend(writing::told_of_setup(&uses, &tools, &stock, &mount, &offsets, &readings, touch_off));
    told.push(format!("workholding: {}", workholding.words()));
    told.extend(notes.iter().map(|n| format!("note: {n}")));
    let answered = interview.answered;
    let plan = Plan {
        call,
        machine: &machine,
        home_zero,
        control: call.control.clone(),
        dialects,

        stock,
        mount,
        workholding,
        offsets,
        tools,
        start_tool,
        design,
        resolution,
        notes,
    };
    let files = writing::files(&plan, &told);
    // A library that cannot be read would be found out by the first run.
    if let Some((_, text)) = files.iter().find(|(name, _)| *name == writing::TOOLS) {
        ToolLibrary::from_text(Path::new(writing::TOOLS), text)?;
    }
    let summary = Summary::of(&plan);
    let copy = plan.home_zero;
    let design = plan.design.filter(|d| d.inch).map(|d| {
        let mut mesh = d.mesh;
        mesh.positions.iter_mut().for_each(|v| *v *= 25.4);
        mesh
    });
    Ok(Proposal { told, summary, answered, files, machine: copy, design, output: call.output.clone() })
}

/// Said of programs that cut nothing: a dry run, positions of a tilted plane, the ways of a probe.
const NOTHING_CUT: &str =
    "no feed motion with known X, Y and Z: no stock is proposed; the run still shows rapids and retracts";

/// Reports all open questions at once.
fn stop_if_open(interview: &Interview<'_, '_>) -> Result<(), FirstPartError> {
    if interview.open.is_empty() { Ok(()) } else { Err(FirstPartError::Unanswered(interview.open.clone())) }
}

/// Settings of the reader for each program, with the notes to report.
fn settings_of(call: &FirstPart, machine: &Machine) -> Result<(Vec<Settings>, Vec<String>), FirstPartError> {
    let control = match &call.control {
        Some(name) => Some(Control::find(name, None).map_err(SimError::from)?),
        None => control_of(None, machine)?,
    };
    let mut notes = Vec::new();
    let mut all = Vec::new();
    for program in &call.programs {
        let (settings, note) = settings_on(control.as_ref(), Dialect::Auto, program)?;
        if let (Some(note), Some(name)) = (&note, &call.control) {
            return Err(refused(note.clone(), format!("name another control than {name}, or leave --control out")));
        }
        notes.extend(note);
        all.push(with_machine(settings, machine));
    }
    // The dialect that is spoken decides what comes with a tool.
    for (settings, program) in all.iter_mut().zip(&call.programs) {
        if settings.dialect == Dialect::Auto
            && let Ok(open) = proveout_nc::Program::open(program, settings)
        {
            settings.dialect = open.dialect();
        }
    }
    Ok((all, notes))
}

/// Lines about control, unit, offsets and rotary axes.
fn told_of_programs(
    call: &FirstPart,
    readings: &[Reading],
    settings: &[Settings],
    unit: Option<&(LengthUnit, String)>,
) -> Vec<String> {
    let mut told = Vec::new();
    for ((program, reading), settings) in call.programs.iter().zip(readings).zip(settings) {
        let control = settings.control.name();
        let by = if control.is_empty() { String::new() } else { format!(", control \"{control}\"") };
        told.push(format!(
            "{}: {}{by}, {} commands, {} motions",
            program.display(),
            reading.survey.dialect.name(),
            reading.survey.commands,
            reading.survey.motions
        ));
    }
    told.push(match unit {
        Some((LengthUnit::Inch, word)) => format!("unit: inch ({word})"),
        Some((LengthUnit::Millimeter, word)) => format!("unit: mm ({word})"),
        None => {
            let inch = settings.iter().any(|s| s.control.starts_in_inch() == Some(true));
            format!(
                "unit: not stated in the program; read in {}, as {}",
                if inch { "inches" } else { "millimeters" },
                if inch { "its control begins" } else { "most controls do by default" }
            )
        }
    });
    for reading in readings {
        for (letter, [low, high]) in &reading.rotary {
            told.push(format!("rotary axis {letter}: {:.3} to {:.3} degrees", low.to_degrees(), high.to_degrees()));
        }
        if reading.tcp {
            told.push("tool center point control or tilted planes are used".into());
        }
    }
    told
}

/// The tool in the spindle of a program that cuts and calls none.
fn start_tool(
    readings: &[Reading],
    all_facts: &[facts::Facts],
    interview: &mut Interview<'_, '_>,
) -> Result<Option<(u32, String)>, FirstPartError> {
    let bare = readings.iter().find_map(|r| r.tools.iter().find(|t| t.name == ToolName::Empty && t.feeds > 0));
    let key = "start_tool";
    let Some(bare) = bare else { return Ok(None) };
    let at = bare.first_feed.as_ref().unwrap_or(&bare.at);
    // The only one that a comment describes and nothing calls; else the one that is made ready and never
    // changed in.
    let calls: Vec<&ToolName> = readings.iter().flat_map(|r| &r.tools).map(|t| &t.name).collect();
    let number = |name: &ToolName| if let ToolName::Number(n) = name { Some(*n) } else { None };
    let described: Vec<u32> =
        all_facts.iter().flat_map(|f| f.tools.keys()).filter(|n| !calls.contains(n)).filter_map(number).collect();
    let ready = readings.iter().find_map(|r| r.selected.first()).filter(|(name, _)| !calls.contains(&name));
    let made_ready = ready.map_or_else(String::new, |(name, at)| {
        format!(" ({} in line {} has no tool change, M6, after it)", shown(name), at.line)
    });
    let proposed = match &described[..] {
        [one] => *one,
        _ => ready.and_then(|(name, _)| number(name)).unwrap_or(1),
    }
    .to_string();
    // Where no word names a tool, its number changes nothing.
    if interview.given(key).is_none() && all_facts.iter().all(|f| !f.names_tool) {
        let number = proposed.parse().unwrap_or(1);
        return Ok(Some((number, "assumed: the program names no tool, so the number has no effect".into())));
    }
    let text = format!(
        "Which tool is in the spindle when the program begins? It cuts in line {} of {} before it calls one{made_ready}. A number",
        at.line, at.file
    );
    let Some(answer) = interview.get(key, text, Some(proposed.clone())) else { return Ok(None) };
    let answer = if answer == PROPOSED { &proposed } else { &answer };
    match answer.trim_start_matches(['T', 't']).parse::<u32>() {
        Ok(number) if number > 0 => Ok(Some((number, "the answer of the call".into()))),
        _ => Err(refused(format!("`{key}` = {answer:?} is not a tool number"), "write a number above zero")),
    }
}

/// No program ever takes a tool length into account while it cuts, on controls that want a word (G43) for it.
fn untold(readings: &[Reading], dialects: &[Dialect]) -> bool {
    let cutting = || readings.iter().flat_map(|r| &r.tools).filter(|t| t.feeds > 0);
    dialects.iter().all(|d| !length_active_after_change(*d))
        && cutting().next().is_some()
        && cutting().all(|t| t.bare.is_some() && !t.lengthened)
}

/// What a length that is never active adds to Z of the work offset: that of the tool, where one
/// cuts alone, since the zero was taken at its tip. Several tools without lengths cannot all be
/// right; `check` reports that.
fn touch_off(readings: &[Reading], start: Option<&(u32, String)>, lengths: &BTreeMap<ToolName, f64>) -> f64 {
    let name = |t: &ToolUse| match (&t.name, start) {
        (ToolName::Empty, Some((number, _))) => ToolName::Number(*number),
        (name, _) => name.clone(),
    };
    let mut cutting = readings.iter().flat_map(|r| &r.tools).filter(|t| t.feeds > 0).map(name);
    let Some(first) = cutting.next() else { return 0.0 };
    if cutting.all(|other| other == first) { lengths.get(&first).copied().unwrap_or(0.0) } else { 0.0 }
}

impl Proposal {
    /// Writes the folder: next to its place first, moved there when it is whole.
    ///
    /// # Errors
    /// What the system refuses; nothing is then left.
    pub fn write(&self) -> Result<(), FirstPartError> {
        writing::write(self)
    }
}

#[cfg(test)]
mod tests;
