//! The loop: engagement, feeds, the twin again, until no feed changes.
//!
//! ```text
//!   program --> twin --> samples --> largest feed of each line --> new text --> twin --> ...
//!                 ^                                                    |
//!                 '---- lines that the machine paces keep their feed --'
//! ```
//!
//! The limits hold for the speed that is reached, and the speed of a block is never above its feed, so that a
//! feed at the limit keeps it. Where the control still is faster as it comes from the block before, that
//! block is lowered. A line whose feed was raised and whose blocks neither reach it nor gain time keeps the
//! feed of the program: joints, corners or the block cycle pace it.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use proveout_feeds::{Binds, FeedMode, ForceModel, LimitsFile, Loads, ToolLimits, feed_of_block};
use proveout_input::InputError;
use proveout_machine::Machine;
use proveout_tool::Tool;

use crate::{
    cut::engaged_samples::{EngagedSample, EngagedSlice},
    feeds::{
        demand::{LineDemand, SampleLoads, ToolRule, lines, sample_loads},
        program_feeds::{KeptWhy, ProgramFeeds},
        twin::{self, JointLimit, TwinBlock, TwinRun},
    },
    prepare::{choice::Choice, error::SimError, prepared::Prepared},
};

/// Below this part of its feed a block has not reached it.
const REACHED: f64 = 0.98;
/// Part of its time that a raised block must gain.
const GAIN: f64 = 0.01;
/// A joint that uses this part of a limit is at it.
const BUSY: f64 = 0.95;
/// A block that takes less than this over the block cycle is paced by it.
const CYCLE: f64 = 1.02;
/// A load this much over its limit is one over it: rounding, and what the time of a sample hides.
const OVER: f64 = 1.01;
/// The last digit of a feed, as a part of it: such a change is none.
const A_DIGIT: f64 = 0.01;
/// Part of the program's chips that are no thicker than the one that is learned.
const LEARNED: f64 = 0.95;
/// A command's runs of the twin at most.
pub const MOST_RUNS: usize = 8;

/// What the call asks for.
#[derive(Clone, Copy, Debug)]
pub struct FeedsCall<'a> {
    /// Scene.
    pub scene: &'a Path,
    /// Program, stock, cells and so on.
    pub choice: &'a Choice,
    /// Limits of the tools.
    pub limits: Option<&'a LimitsFile>,
    /// Which feeds may change.
    pub mode: FeedMode,
    /// Changes below this part of a feed are not made.
    pub dead_band: f64,
}

/// What the machine does where a feed is not reached.
#[derive(Clone, Debug, PartialEq)]
pub enum MachinePace {
    /// A joint at a limit.
    Joint {
        /// Its name.
        name: String,
        /// Which limit.
        limit: JointLimit,
    },
    /// The shortest time of a block.
    BlockCycle,
    /// Corners and ramps: the block is too short for its feed.
    Corner,
}

/// What sets the feed of a block.
#[derive(Clone, Debug, PartialEq)]
pub enum FeedSetBy {
    /// A limit of the tool, or the program.
    Limit(Binds),
    /// The machine.
    Machine(MachinePace),
    /// The line keeps its feed.
    Kept(KeptWhy),
}

impl FeedSetBy {
    /// Words for it.
    pub fn words(&self) -> String {
        match self {
            Self::Limit(binds) => binds.word().to_owned(),
            Self::Machine(MachinePace::Joint { name, limit }) => format!("joint {name} ({})", limit.word()),
            Self::Machine(MachinePace::BlockCycle) => "block cycle".to_owned(),
            Self::Machine(MachinePace::Corner) => "corner".to_owned(),
            Self::Kept(why) => format!("kept: {}", why.words()),
        }
    }
}

/// A block in feed, before and after.
#[derive(Clone, Debug, PartialEq)]
pub struct FeedRow {
    /// Index of the executed block.
    pub block: u32,
    /// File.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Name of the tool.
    pub tool: Option<String>,
    /// Feed of the program, and the new one, mm/min.
    pub feed_mm_min: [f64; 2],
    /// Highest feed that was reached before and after, mm/min.
    pub reached_mm_min: [f64; 2],
    /// Time before and after, s.
    pub time_s: [f64; 2],
    /// What sets the new feed.
    pub set_by: FeedSetBy,
    /// It takes material.
    pub engaged: bool,
    /// Largest loads after; none without material, teeth or engagement.
    pub loads: Option<Loads>,
    /// The worst load over its limit, after: 1 is at the limit.
    pub over: Option<f64>,
    /// Removed material over time, mm³/s, after.
    pub removal_mm3_s: f64,
}

/// What the command has found.
#[derive(Clone, Debug)]
pub struct FeedsResult {
    /// The new text; none where no feed changes.
    pub text: Option<Vec<u8>>,
    /// Lines with another feed.
    pub changed: usize,
    /// Every block in feed.
    pub rows: Vec<FeedRow>,
    /// Time of the program before and after, s.
    pub time_s: [f64; 2],
    /// Runs of the twin.
    pub runs: usize,
    /// The last run changed no feed any more.
    pub settled: bool,
    /// Largest load over its limit in lines whose feed could change, with its line: 1 is at the limit.
    pub worst: Option<(f64, Binds, u32)>,
    /// Samples over a limit in lines that keep their feed.
    pub over_in_kept: usize,
    /// Findings that fail a gate and that the program did not have, with their lines.
    pub new_faults: Vec<(String, u32)>,
    /// Chip thickness that was learned, by tool, mm.
    pub learned: Vec<(String, f64)>,
    /// What the result rests on.
    pub assumed: Vec<String>,
    /// Longest edge of a cell, mm.
    pub cell_mm: f64,
    /// Samples of the last run with their slices, and the loads of each.
    pub engagement: Vec<EngagementRow>,
}

/// A sample of the last run.
#[derive(Clone, Debug)]
pub struct EngagementRow {
    /// The sample.
    pub sample: EngagedSample,
    /// Its slices, joined over a cell of path.
    pub slices: Vec<EngagedSlice>,
    /// File and line of its block.
    pub place: Option<(String, u32)>,
    /// Name, and teeth of the tool where they are known.
    pub tool: (String, Option<u32>),
    /// Loads, where the teeth are known and the spindle turns.
    pub loads: Option<Loads>,
    /// Forces are known.
    pub has_forces: bool,
}

/// Finds feeds; `tell` hears what goes on.
///
/// # Errors
/// [`SimError`] with place and remedy: nothing is then to be written.
pub fn schedule(call: &FeedsCall<'_>, tell: &mut dyn FnMut(&str)) -> Result<FeedsResult, SimError> {
    let prepared = Prepared::read(call.scene, call.choice)?;
    if let Some(limits) = call.limits {
        limits.check_names(&prepared.tools)?;
    }
    let needs_limits = matches!(call.mode, FeedMode::Air | FeedMode::Chip | FeedMode::Force);
    if needs_limits && call.limits.is_none() {
        let help = "name a file of limits with --limits";
        return Err(InputError::file(&prepared.program_path, "no limits are given for this mode", help).into());
    }
    let program = ProgramFeeds::read(&prepared)?;
    if call.mode != FeedMode::Analyse {
        program.check_writable()?;
    }
    let file = prepared.shown_as(&prepared.program_path.display().to_string());
    let (machine, tools) = (prepared.machine.clone(), prepared.tools.tools.clone());
    tell("run 1: the program as it is");
    let first = twin::run(prepared)?;
    let mut rules = rules(call, &tools, &first)?;
    let learned = if call.mode == FeedMode::Learned { learn(call, &tools, &first, &mut rules)? } else { Vec::new() };
    let mut work = Work::new(call, &program, &file, &machine, &rules);

    let mut loads = sample_loads(&first, &rules);
    work.check_limits(&first, &loads)?;
    let (mut runs, mut settled) = (1, true);
    let mut last: Option<TwinRun> = None;
    let mut written: Option<(Vec<u8>, BTreeMap<u32, f64>)> = None;
    if call.mode != FeedMode::Analyse {
        loop {
            let run = last.as_ref().unwrap_or(&first);
            work.look(&first, run, &loads, written.as_ref().map(|(_, scales)| scales));
            let wanted = work.scales(run, &loads)?;
            let new = program.write(&wanted)?;
            work.taken_over.extend(new.taken_over.iter().copied());
            let same = match &written {
                Some((_, scales)) => settles(scales, &new.scales),
                None => new.scales.is_empty(),
            };
            settled = same;
            if same || runs >= MOST_RUNS {
                break;
            }
            runs += 1;
            tell(&format!("run {runs}: {} lines with another feed", new.scales.len()));
            let mut again = Prepared::read(call.scene, call.choice)?;
            again.with_feeds = Some(new.text);
            let run = twin::run(again)?;
            loads = sample_loads(&run, &rules);
            written = Some((new.bytes, new.scales));
            last = Some(run);
        }
    }
    let run = last.as_ref().unwrap_or(&first);
    let scales = written.as_ref().map(|(_, scales)| scales.clone()).unwrap_or_default();
    let mut result = work.result(&first, run, &loads, &scales, &tools);
    (result.runs, result.settled, result.learned) = (runs, settled, learned);
    result.text = written.filter(|(_, scales)| !scales.is_empty()).map(|(bytes, _)| bytes);
    Ok(result)
}

/// Whether the same lines change, by the same factor but for a digit of rounding.
fn settles(old: &BTreeMap<u32, f64>, new: &BTreeMap<u32, f64>) -> bool {
    old.len() == new.len()
        && old.iter().zip(new).all(|((a, x), (b, y))| a == b && (x - y).abs() <= A_DIGIT * x.abs().max(y.abs()))
}

/// Models and limits of the tools that cut in feed.
fn rules(call: &FeedsCall<'_>, tools: &[Tool], run: &TwinRun) -> Result<BTreeMap<usize, ToolRule>, SimError> {
    let used: BTreeSet<usize> = run.blocks.iter().filter_map(|b| b.row.tool).map(|t| t as usize).collect();
    let mut rules = BTreeMap::new();
    for index in used {
        let Some(tool) = tools.get(index) else { continue };
        let limits = call.limits.and_then(|l| l.of(&tool.name)).map(|l| call.mode.of(&l));
        let forces = !matches!(call.mode, FeedMode::Air | FeedMode::Chip | FeedMode::Learned);
        let model = match call.limits {
            // A tool without limits may be a drill: its chips are shown, its forces are not those of milling.
            Some(file) if limits.as_ref().is_some_and(|l| forces || l.max_chip_mm.is_some()) => file.model_of(tool)?,
            _ => None,
        };
        let has_material = model.is_some();
        let model = model.or_else(|| ForceModel::of_chips(tool));
        rules.insert(index, ToolRule { model, has_material, limits });
    }
    Ok(rules)
}

/// Takes the limit of the chip from what the program has, tool by tool.
fn learn(
    call: &FeedsCall<'_>,
    tools: &[Tool],
    run: &TwinRun,
    rules: &mut BTreeMap<usize, ToolRule>,
) -> Result<Vec<(String, f64)>, SimError> {
    let loads = sample_loads(run, rules);
    let mut all = Vec::new();
    for (index, rule) in rules.iter_mut() {
        let Some(tool) = tools.get(*index) else { continue };
        let own = || run.samples.iter().zip(&loads).filter(|(s, l)| s.tool == *index && !l.plunges && !l.at_rest);
        if own().next().is_none() {
            continue;
        }
        if rule.model.is_none() {
            let message = format!("tool {:?} has no teeth in the library, so that no chip can be learned", tool.name);
            return Err(InputError::file(call.scene, message, "write `flutes` into the tool library").into());
        }
        let mut chips: Vec<f64> = own().map(|(_, l)| l.loads.chip_mm).filter(|c| *c > 0.0).collect();
        chips.sort_by(f64::total_cmp);
        let at = ((chips.len() as f64 * LEARNED).ceil() as usize).saturating_sub(1);
        let Some(chip) = chips.get(at) else { continue };
        let limits = rule.limits.get_or_insert_with(ToolLimits::default);
        limits.max_chip_mm = Some(*chip);
        all.push((tool.name.clone(), *chip));
    }
    Ok(all)
}

/// What is known over the runs.
struct Work<'a> {
    call: &'a FeedsCall<'a>,
    program: &'a ProgramFeeds,
    file: &'a str,
    machine: &'a Machine,
    rules: &'a BTreeMap<usize, ToolRule>,
    /// Lines that the machine paces.
    paced: BTreeMap<u32, MachinePace>,
    /// Lines that must be slower for the sake of the block after them, mm/s.
    caps: BTreeMap<u32, (f64, Binds)>,
    taken_over: BTreeSet<u32>,
    /// Feeds of the program by line, mm/s.
    programmed: BTreeMap<u32, f64>,
}

impl<'a> Work<'a> {
    fn new(
        call: &'a FeedsCall<'a>,
        program: &'a ProgramFeeds,
        file: &'a str,
        machine: &'a Machine,
        rules: &'a BTreeMap<usize, ToolRule>,
    ) -> Self {
        Self {
            call,
            program,
            file,
            machine,
            rules,
            paced: BTreeMap::new(),
            caps: BTreeMap::new(),
            taken_over: BTreeSet::new(),
            programmed: BTreeMap::new(),
        }
    }

    /// Why a line keeps its feed.
    fn kept(&self, line: u32, demand: &LineDemand) -> Option<KeptWhy> {
        let own = self.program.kept(line).or(demand.kept);
        let own = own.or_else(|| self.taken_over.contains(&line).then_some(KeptWhy::TakenOver));
        own.or_else(|| self.limits(demand).is_none().then_some(KeptWhy::NoLimits))
    }

    fn limits(&self, demand: &LineDemand) -> Option<&ToolLimits> {
        demand.tool.and_then(|t| self.rules.get(&t)).and_then(|rule| rule.limits.as_ref())
    }

    /// Refuses limits that no feed meets.
    fn check_limits(&mut self, run: &TwinRun, loads: &[SampleLoads]) -> Result<(), SimError> {
        for (line, demand) in lines(run, loads, self.file) {
            self.programmed.insert(line, demand.demand.programmed);
            if let Some(binds) =
                demand.no_feed.filter(|_| self.call.mode != FeedMode::Analyse && self.kept(line, &demand).is_none())
            {
                let message = format!(
                    "no feed keeps the limit of {} here: edge force or run-out alone are above it; nothing is written",
                    binds.word()
                );
                return Err(self.program.error("feeds-no-feed", line, message, "raise the limit, or change the cut"));
            }
        }
        Ok(())
    }

    /// Looks at a run: which lines the machine paces, and which are too fast for the block after them.
    fn look(&mut self, first: &TwinRun, run: &TwinRun, loads: &[SampleLoads], scales: Option<&BTreeMap<u32, f64>>) {
        let Some(scales) = scales else { return };
        let before: BTreeMap<u32, f64> = first.blocks.iter().map(|b| (b.row.block, b.time())).collect();
        let mut gained: BTreeMap<u32, (f64, f64, bool)> = BTreeMap::new();
        for block in run.blocks.iter().filter(|b| *b.row.file == *self.file) {
            let Some(feed) = block.row.feed else { continue };
            let sum = gained.entry(block.row.line).or_insert((0.0, 0.0, false));
            sum.0 += before.get(&block.row.block).copied().unwrap_or(0.0);
            sum.1 += block.time();
            sum.2 |= block.reached >= REACHED * feed;
        }
        for (line, scale) in scales.iter().filter(|(_, scale)| **scale > 1.0) {
            let Some((before, now, reached)) = gained.get(line) else { continue };
            let block = run.blocks.iter().find(|b| b.row.line == *line && *b.row.file == *self.file);
            if let Some(block) = block.filter(|_| !reached && *now > (1.0 - GAIN) * before && *scale > 1.0) {
                self.paced.insert(*line, self.pace(block));
            }
        }
        let at: BTreeMap<u32, usize> = run.blocks.iter().enumerate().map(|(k, b)| (b.row.block, k)).collect();
        for (sample, of_sample) in run.samples.iter().zip(loads) {
            let Some((limit, binds)) = of_sample.limit.filter(|_| of_sample.over.is_some_and(|(o, _)| o > OVER)) else {
                continue;
            };
            let Some(k) = at.get(&sample.block).copied() else { continue };
            let own = run.blocks.get(k).and_then(|b| b.row.feed).unwrap_or(0.0);
            if sample.tip_speed() <= own * OVER {
                // Its own feed is too high: the line's demand says so.
                continue;
            }
            // The nearest block before it that is faster.
            let before = run.blocks.get(..k).unwrap_or(&[]).iter().rev();
            let faster = before.take_while(|b| b.row.feed.is_some()).find(|b| b.row.feed.is_some_and(|f| f > limit));
            if let Some(block) = faster.filter(|b| *b.row.file == *self.file) {
                let cap = self.caps.entry(block.row.line).or_insert((limit, binds));
                if limit < cap.0 {
                    *cap = (limit, binds);
                }
            }
        }
    }

    /// What paces a block that does not reach its feed.
    fn pace(&self, block: &TwinBlock) -> MachinePace {
        let cycle = self.machine.control.block_time;
        if cycle > 0.0 && block.time() <= CYCLE * cycle {
            return MachinePace::BlockCycle;
        }
        match block.busiest.filter(|(part, ..)| *part >= BUSY) {
            Some((_, joint, limit)) => MachinePace::Joint {
                name: self.machine.joints.get(joint).map(|j| j.name.clone()).unwrap_or_default(),
                limit,
            },
            None => MachinePace::Corner,
        }
    }

    /// The feed of a line, mm/s, and what sets it.
    fn feed(&self, line: u32, demand: &LineDemand) -> Result<(f64, FeedSetBy), SimError> {
        let programmed = self.programmed.get(&line).copied().unwrap_or(demand.demand.programmed);
        if let Some(why) = self.kept(line, demand) {
            return Ok((programmed, FeedSetBy::Kept(why)));
        }
        let Some(limits) = self.limits(demand) else {
            return Ok((programmed, FeedSetBy::Kept(KeptWhy::NoLimits)));
        };
        let mut asked = demand.demand;
        asked.programmed = programmed;
        if let Some((cap, binds)) = self.caps.get(&line)
            && asked.limit.is_none_or(|(limit, _)| *cap < limit)
        {
            asked.limit = Some((*cap, *binds));
        }
        let (feed, binds) = feed_of_block(&asked, limits, self.call.mode, self.call.dead_band).map_err(|binds| {
            let message =
                format!("no feed keeps both min_chip_mm and the limit of {} here: nothing is written", binds.word());
            self.program.error("feeds-no-feed", line, message, "lower min_chip_mm, or change the cut")
        })?;
        match self.paced.get(&line) {
            Some(pace) if feed > programmed => Ok((programmed, FeedSetBy::Machine(pace.clone()))),
            _ => Ok((feed, FeedSetBy::Limit(binds))),
        }
    }

    /// The factors of the lines whose feed changes.
    fn scales(&self, run: &TwinRun, loads: &[SampleLoads]) -> Result<BTreeMap<u32, f64>, SimError> {
        let mut scales = BTreeMap::new();
        for (line, demand) in lines(run, loads, self.file) {
            let (feed, _) = self.feed(line, &demand)?;
            let programmed = self.programmed.get(&line).copied().unwrap_or(0.0);
            if programmed > 0.0 && feed != programmed {
                scales.insert(line, feed / programmed);
            }
        }
        Ok(scales)
    }

    /// All that is reported.
    fn result(
        &self,
        first: &TwinRun,
        run: &TwinRun,
        loads: &[SampleLoads],
        scales: &BTreeMap<u32, f64>,
        tools: &[Tool],
    ) -> FeedsResult {
        let by_line = lines(run, loads, self.file);
        let mut of_block: BTreeMap<u32, BlockLoads> = BTreeMap::new();
        for (sample, l) in run.samples.iter().zip(loads) {
            let known = of_block.entry(sample.block).or_default();
            known.loads = worst_of(&known.loads, &l.loads);
            known.over = match (known.over, l.over) {
                (Some(a), Some(b)) => Some(if b.0 > a.0 { b } else { a }),
                (a, b) => a.or(b),
            };
        }
        let before: BTreeMap<u32, &TwinBlock> = first.blocks.iter().map(|b| (b.row.block, b)).collect();
        let (mut rows, mut worst, mut over_in_kept) = (Vec::new(), None::<(f64, Binds, u32)>, 0);
        for block in &run.blocks {
            let Some(feed) = block.row.feed else { continue };
            let was = before.get(&block.row.block).copied().unwrap_or(block);
            let main = *block.row.file == *self.file;
            let demand = by_line.get(&block.row.line).filter(|_| main).copied().unwrap_or_default();
            let set_by = match main {
                true => self.feed(block.row.line, &demand).map_or(FeedSetBy::Limit(Binds::Programmed), |(_, by)| by),
                false => FeedSetBy::Kept(KeptWhy::Subprogram),
            };
            let set_by = match set_by {
                FeedSetBy::Limit(_) if block.reached < REACHED * feed => FeedSetBy::Machine(self.pace(block)),
                other => other,
            };
            let known = of_block.get(&block.row.block);
            let over = known.and_then(|k| k.over);
            match (&set_by, over) {
                (FeedSetBy::Kept(_), Some((ratio, _))) => over_in_kept += usize::from(ratio > OVER),
                (_, Some((ratio, binds))) if worst.is_none_or(|(most, ..)| ratio > most) => {
                    worst = Some((ratio, binds, block.row.line));
                }
                _ => {}
            }
            let rule = block.row.tool.and_then(|t| self.rules.get(&(t as usize)));
            let time = block.time();
            rows.push(FeedRow {
                block: block.row.block,
                file: block.row.file.to_string(),
                line: block.row.line,
                tool: block.row.tool.and_then(|t| tools.get(t as usize)).map(|t| t.name.clone()),
                feed_mm_min: [was.row.feed.unwrap_or(feed), feed].map(|f| 60.0 * f),
                reached_mm_min: [was.reached, block.reached].map(|f| 60.0 * f),
                time_s: [was.time(), time],
                set_by,
                engaged: known.is_some(),
                loads: known.filter(|_| rule.is_some_and(|r| r.model.is_some())).map(|k| k.loads),
                over: over.map(|(ratio, _)| ratio),
                removal_mm3_s: if time > 0.0 { block.row.volume_mm3 / time } else { 0.0 },
            });
        }
        let place: BTreeMap<u32, (String, u32)> =
            run.blocks.iter().map(|b| (b.row.block, (b.row.file.to_string(), b.row.line))).collect();
        let engagement = run.samples.iter().zip(&run.slices).zip(loads).map(|((sample, slices), l)| {
            let tool = tools.get(sample.tool);
            let rule = self.rules.get(&sample.tool);
            EngagementRow {
                sample: sample.clone(),
                slices: slices.clone(),
                place: place.get(&sample.block).cloned(),
                tool: (tool.map(|t| t.name.clone()).unwrap_or_default(), tool.and_then(|t| t.flutes)),
                loads: rule.filter(|r| r.model.is_some() && !l.at_rest).map(|_| l.loads),
                has_forces: rule.is_some_and(|r| r.has_material),
            }
        });
        let known = |code: &str, line: u32| first.faults.get(code).is_some_and(|lines| lines.contains(&line));
        let faults = run.faults.iter().flat_map(|(code, lines)| lines.iter().map(move |line| (code.clone(), *line)));
        FeedsResult {
            text: None,
            changed: scales.len(),
            rows,
            time_s: [first.time_s, run.time_s],
            runs: 0,
            settled: true,
            worst,
            over_in_kept,
            new_faults: faults.filter(|(code, line)| !known(code, *line)).collect(),
            learned: Vec::new(),
            assumed: self.call.limits.map(LimitsFile::assumed).unwrap_or_default(),
            cell_mm: run.cell_mm,
            engagement: engagement.collect(),
        }
    }
}

/// Largest loads of a block, and the worst of them over its limit.
#[derive(Clone, Copy, Debug, Default)]
struct BlockLoads {
    loads: Loads,
    over: Option<(f64, Binds)>,
}

/// The larger of each load.
fn worst_of(a: &Loads, b: &Loads) -> Loads {
    Loads {
        chip_mm: a.chip_mm.max(b.chip_mm),
        force_peak_n: a.force_peak_n.max(b.force_peak_n),
        force_mean_n: a.force_mean_n.max(b.force_mean_n),
        torque_peak_nm: a.torque_peak_nm.max(b.torque_peak_nm),
        torque_mean_nm: a.torque_mean_nm.max(b.torque_mean_nm),
        power_kw: a.power_kw.max(b.power_kw),
        deflection_um: match (a.deflection_um, b.deflection_um) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        },
    }
}
