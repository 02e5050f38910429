//! Published values over what the experiment leaves open.
//!
//! Every choice of `[[compare.choice]]` is tried at its ends (its values) alone, then all of them
//! at once in draws of a Latin hypercube: of n draws each choice has one in every n-th part of its
//! range, in an order of its own (`McKay`, Beckman, Conover 1979). The order comes from a fixed
//! seed: same scene, same draws. A try makes the programs again as the scene with these values says
//! (plan, re-scheduling, machine's limits) and runs their motion, no stock. Values that depend on
//! the cut part are not varied; the report says so.
//!
//! The verdicts are those of `agreement`.

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

use proveout_controller::Settings as ControlSettings;
use proveout_geom::Pose;
use proveout_input::{InputError, Step::Item, Step::Key, read_input};
use proveout_machine::Machine;
use proveout_nc::{Command, Dialect, Program, Settings as NcSettings};
use rayon::prelude::*;

use super::{
    Comparing, Entry,
    agreement::{self, agreement, decided_by},
    finish::{stretch_of, time_of},
    judge,
    pictures::study_of,
    result::{Choices, Comparison, Made, ProgramFigures, TriedChoice},
};
use crate::{
    latin_hypercube::latin_hypercube,
    prepare::{
        control_settings::control_settings,
        error::SimError,
        motion_only::{Motion, Source},
        part_on_table::PartOnTable,
        planning,
        prepared::Prepared,
        programs, reader_settings,
    },
    scene::{
        ChoiceValueFile, CompareFile, HELIX, Scene, StrategyFile,
        choice::{limit_machine, with_values},
        compare::QuantityFile,
        joint_limits::limit_joints,
    },
    verdict::verdict_file::State,
};

/// Where the draws begin; any number does.
const SEED: u64 = 0x5EED_CA5E;
/// Most reasons of refused draws that are reported.
const REASONS: usize = 3;
/// A published value whose change over choices is below this part of it is not acted on: decimals of posted
/// programs.
const ACTS: f64 = 1e-6;

/// What is kept of a program to make it again.
#[derive(Debug)]
pub(super) struct Again {
    scene: PathBuf,
    program: PathBuf,
    /// As its file describes it.
    machine: Machine,
    table_from_work: Pose,
    /// Part and fixtures, where the program is made by a method.
    part: Option<PartOnTable>,
    /// How the text that it is made from is read.
    nc: NcSettings,
    dialect: Dialect,
}

impl Again {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let open = prepared.scene.file.compare.as_ref().is_some_and(|c| !c.choice.is_empty());
        Self {
            scene: prepared.scene.path.clone(),
            program: prepared.program_path.clone(),
            machine: prepared.own_machine.as_ref().unwrap_or(&prepared.machine).clone(),
            table_from_work: prepared.table_from_work,
            part: prepared.part_on_table.clone().filter(|_| open),
            nc: prepared.source_nc_settings.clone(),
            dialect: prepared.program().map_or(Dialect::Auto, |p| p.dialect()),
        }
    }
}

/// Checks that every choice can be put into the scene. A key that leads nowhere, or a value that
/// the scene refuses, is reported before anything runs.
///
/// # Errors
/// The first such choice.
pub(super) fn check(scene: &Scene) -> Result<(), InputError> {
    let Some(file) = &scene.file.compare else { return Ok(()) };
    let text = if file.choice.is_empty() { String::new() } else { read_input(&scene.path)? };
    for (i, choice) in file.choice.iter().enumerate() {
        for value in choice.ends() {
            let words = value.words();
            let refused = |why: String| {
                let message =
                    format!("the choice {:?} cannot be tried with {} = {words}: {why}", choice.name, choice.key);
                let path = [Key("compare"), Key("choice"), Item(i), Key("key")];
                scene.error_at(&path, message, "correct the key or its range in [[compare.choice]]")
            };
            let other = with_values(&text, &[(choice.key.as_str(), value)]).map_err(refused)?;
            Scene::of_text(scene.path.clone(), &other).map_err(|e| refused(e.message.clone()))?;
        }
    }
    Ok(())
}

/// Values of choices that are tried together, by their number.
pub(super) type Try = Vec<(usize, ChoiceValueFile)>;

/// All tries: each choice alone, then the draws.
pub(super) fn tries(file: &CompareFile) -> Vec<Try> {
    let alone = file.choice.iter().enumerate().flat_map(|(k, c)| c.ends().into_iter().map(move |v| vec![(k, v)]));
    let mut all: Vec<Try> = alone.collect();
    if !file.choice.is_empty() {
        all.extend(draws(file));
    }
    all
}

/// Latin hypercube: place of every choice in every draw.
fn draws(file: &CompareFile) -> Vec<Try> {
    let n = file.draws;
    let mut all = vec![Try::new(); n];
    let places = latin_hypercube(file.choice.len(), n, SEED);
    for (k, (choice, places)) in file.choice.iter().zip(places).enumerate() {
        for (draw, place) in all.iter_mut().zip(places) {
            draw.extend(choice.at(place).map(|v| (k, v)));
        }
    }
    all
}

/// What the tries gave.
#[derive(Debug)]
pub(super) struct Tried {
    pub(super) told: Choices,
    /// Values of the published rows over the choices alone and over the draws; none where a row is not known
    /// without a cut.
    alone: Vec<Option<[f64; 2]>>,
    drawn: Vec<Option<[f64; 2]>>,
}

fn wider(range: &mut Option<[f64; 2]>, value: f64) {
    let [low, high] = range.unwrap_or([value; 2]);
    *range = Some([low.min(value), high.max(value)]);
}

impl Comparing {
    /// Tries them all. One that a method or the control refuses is reported, and counts in no
    /// range.
    pub(super) fn tried(&self, tries: &[Try], step: &(dyn Fn() + Sync)) -> Tried {
        let values: Vec<Result<Vec<Option<f64>>, String>> = tries
            .par_iter()
            .map(|values| {
                let found = self.values_with(values);
                self.entries.iter().for_each(|_| step());
                found
            })
            .collect();
        let rows = &self.file.published;
        let nominal: Vec<Option<f64>> = self.nominal_rows();
        let (mut alone, mut drawn) = (vec![None; rows.len()], vec![None; rows.len()]);
        let mut told: Vec<TriedChoice> = self.file.choice.iter().map(told).collect();
        let single = tries.iter().take_while(|t| tries.len() > self.file.draws && t.len() == 1).count();
        let single = single.min(tries.len() - self.file.draws);
        let mut reasons = Vec::new();
        let mut refused = 0;
        for (k, (values, found)) in tries.iter().zip(values).enumerate() {
            match found {
                Ok(found) => {
                    for (row, value) in found.into_iter().enumerate() {
                        let (Some(value), Some(own)) = (value, nominal[row]) else { continue };
                        wider(if k < single { &mut alone[row] } else { &mut drawn[row] }, value);
                        if k < single && (value - own).abs() > ACTS * own.abs().max(1.0) {
                            let range = told[values[0].0].acts_on.entry(rows[row].name.clone()).or_insert([own; 2]);
                            *range = [range[0].min(value), range[1].max(value)];
                        }
                    }
                }
                Err(why) if k < single => told[values[0].0].refused = why,
                Err(why) => {
                    refused += 1;
                    if reasons.len() < REASONS && !reasons.contains(&why) {
                        reasons.push(why);
                    }
                }
            }
        }
        let acted = |name: &str| told.iter().any(|c| c.acts_on.contains_key(name));
        for (row, (a, d)) in rows.iter().zip(alone.iter_mut().zip(&mut drawn)) {
            // Choices that cannot act on a value are not counted.
            if !acted(&row.name) {
                (*a, *d) = (None, None);
            }
        }
        let draws = (tries.len() - single) as u64;
        Tried { told: Choices { choices: told, draws, refused, reasons }, alone, drawn }
    }

    /// Published rows of the nominal twin, as far as they follow from motion alone.
    fn nominal_rows(&self) -> Vec<Option<f64>> {
        let figures = |entry: &Entry| {
            let made = self.made_figures(entry);
            Some(ProgramFigures::of_motion(
                String::new(),
                time_of(&entry.motion.as_ref()?.summary),
                made,
                self.stretch(entry),
            ))
        };
        let all = self.entries.iter().filter_map(|e| Some((e.name.clone(), figures(e)?))).collect();
        judge::published(&self.file, &bare(all)).into_iter().map(|p| p.value).collect()
    }

    /// The programs that published rows refer to, and those they are made from. No other program is
    /// made again for a choice.
    fn asked<'a>(&'a self, scene: &'a Scene) -> BTreeSet<&'a str> {
        let rows = self.file.published.iter();
        let mut asked: BTreeSet<&str> =
            rows.flat_map(|p| [Some(p.program.as_str()), p.against.as_deref()]).flatten().collect();
        let from = |name: &&str| scene.program(Some(name)).and_then(|p| p.reschedule.as_ref()).map(|r| r.from.as_str());
        let sources: Vec<&str> = asked.iter().filter_map(from).collect();
        asked.extend(sources);
        asked
    }

    /// The published rows with other values of choices.
    fn values_with(&self, values: &Try) -> Result<Vec<Option<f64>>, String> {
        let keys = |k: &usize| self.file.choice.get(*k).map_or("", |c| c.key.as_str());
        let values: Vec<(&str, ChoiceValueFile)> = values.iter().map(|(k, v)| (keys(k), v.clone())).collect();
        let plans = values.iter().any(|(key, _)| key.starts_with("plan.") || key.starts_with("part."));
        let first = self.entries.first().ok_or("no program")?;
        let path = first.again.scene.clone();
        let text = read_input(&path).map_err(|e| e.to_string())?;
        let scene = Scene::of_text(path, &with_values(&text, &values)?).map_err(|e| e.to_string())?;
        let mut motions: BTreeMap<&str, MadeAgain<'_>> = BTreeMap::new();
        let mut machines = BTreeMap::new();
        let asked = self.asked(&scene);
        for entry in self.entries.iter().filter(|e| asked.contains(e.name.as_str())) {
            let mut machine = entry.again.machine.clone();
            limit_machine(&mut machine, &values)?;
            limit_joints(&scene, &mut machine).map_err(|e| e.to_string())?;
            let acted = values.iter().any(|(key, _)| acts_on(key, &entry.name, &scene));
            let made = match (&entry.motion, &entry.ideal) {
                (Some(motion), Some(ideal)) if !acted => {
                    (Cow::Borrowed(motion), Cow::Borrowed(ideal), self.made_figures(entry))
                }
                _ => again(entry, &scene, &machine, plans).map_err(|e| format!("{}: {e}", entry.name))?,
            };
            motions.insert(&entry.name, made);
            machines.insert(entry.name.as_str(), machine);
        }
        let mut all = BTreeMap::new();
        for (name, (motion, ideal, made)) in &motions {
            let machine = machines.get(name).ok_or("no machine")?;
            let stretch = stretch_of(self.file.trimmed_ends_s, machine, motion, ideal);
            let made = made.clone().map(|m| Made {
                center_shift_mm: motions.get(m.from.as_str()).and_then(|(_, source, _)| ideal.center_shift(source)),
                ..m
            });
            let figures = ProgramFigures::of_motion(String::new(), time_of(&motion.summary), made, stretch);
            all.insert((*name).to_owned(), figures);
        }
        Ok(judge::published(&self.file, &bare(all)).into_iter().map(|p| p.value).collect())
    }
}

/// Whether the value of a key can change the motion of a program: plans and options of other programs do not.
fn acts_on(key: &str, program: &str, scene: &Scene) -> bool {
    let own = scene.program(Some(program));
    let from = own.and_then(|p| p.reschedule.as_ref()).map(|r| r.from.as_str());
    let mut steps = key.split('.');
    match (steps.next(), steps.next()) {
        (Some("plan"), Some(plan)) => {
            let source = from.map_or(own, |from| scene.program(Some(from)));
            source.and_then(|s| s.planned.as_deref()).is_none_or(|planned| planned == plan)
        }
        // An entry by its number is not looked up.
        (Some("program"), Some(name)) => name == program || Some(name) == from || name.parse::<usize>().is_ok(),
        _ => true,
    }
}

fn told(choice: &crate::scene::ChoiceFile) -> TriedChoice {
    let tried = match choice.range {
        Some([low, high]) => [low, high].map(|v| ChoiceValueFile::Number(v).words()).to_vec(),
        None => choice.ends().iter().map(ChoiceValueFile::words).collect(),
    };
    TriedChoice {
        name: choice.name.clone(),
        key: choice.key.clone(),
        tried,
        source: choice.source.word().to_owned(),
        reason: choice.reason.clone(),
        acts_on: BTreeMap::new(),
        refused: String::new(),
    }
}

/// A comparison of programs alone, for the rows to be taken from.
fn bare(programs: BTreeMap<String, ProgramFigures>) -> Comparison {
    Comparison {
        schema_version: super::SCHEMA_VERSION,
        scene: String::new(),
        description: String::new(),
        experiment: String::new(),
        machine: String::new(),
        joint_limits: Vec::new(),
        baseline: String::new(),
        cells_mm: [0.0; 3],
        scene_cells: true,
        motion_only: false,
        order: Vec::new(),
        verdict: State::Unchecked,
        programs,
        gains: BTreeMap::new(),
        variations: Vec::new(),
        own_limits: None,
        choices: None,
        null_program: None,
        must_pass: None,
        published: Vec::new(),
        expectations: Vec::new(),
        rules: BTreeMap::new(),
    }
}

/// Motion of a program as it cuts and along the programmed path, and the figures of its method.
type MadeAgain<'a> = (Cow<'a, Motion>, Cow<'a, Motion>, Option<Made>);

/// A program made again and its motion.
fn again(entry: &Entry, scene: &Scene, machine: &Machine, plans: bool) -> Result<MadeAgain<'static>, SimError> {
    let (kept, case) = (&entry.again, &entry.case);
    let file = scene.program(Some(&entry.name));
    let from = file.and_then(|f| f.reschedule.as_ref()).map(|r| r.from.as_str());
    let source = from.map_or(file, |from| scene.program(Some(from)));
    let planned = source.and_then(|s| s.planned.as_deref()).filter(|_| plans);
    let plan = planned.zip(source);
    let text = plan.map(|(plan, s)| planned_text(&scene.planned_for(s), machine, entry, plan)).transpose()?;
    let source = match text {
        Some(text) => Source::Text { name: "planned.mpf".into(), text },
        None => Source::File(kept.program.clone()),
    };
    let (source, nc, made) = match file.and_then(|f| f.reschedule.as_ref()) {
        None => (source, case.nc().clone(), None),
        Some(reschedule) => {
            let commands = read(&source, &kept.nc)?;
            let solids = kept.part.clone().unwrap_or_default();
            let part = solids.under_surface_of(scene, &kept.table_from_work)?;
            let tools = case.tools();
            let out = programs::rescheduled_commands(scene, reschedule, commands, &kept.nc, machine, tools, &part)?;
            let text = programs::text(&out.commands, Dialect::Siemens840d, &kept.nc)?;
            let method = reschedule.method();
            let made = Made {
                method: method.name().to_owned(),
                source: method.source().to_owned(),
                from: reschedule.from.clone(),
                center_shift_mm: None,
                figures: out.runs.first().map_or_else(Vec::new, |run| study_of(run).figures),
                over_velocity: Vec::new(),
            };
            let nc = reader_settings::settings_of_made(kept.nc.clone());
            (Source::Text { name: "made.mpf".into(), text }, nc, Some(made))
        }
    };
    let settings = ControlSettings {
        dynamics: case.settings.dynamics,
        plant: case.settings.plant,
        ..control_settings(scene, kept.dialect)
    };
    let case = case.with(machine.clone(), settings, source, nc).measured_on(scene);
    let motion = case.run()?;
    let ideal = motion.along_program();
    Ok((Cow::Owned(motion), Cow::Owned(ideal), made))
}

fn read(source: &Source, nc: &NcSettings) -> Result<Vec<Command>, SimError> {
    let program: Program = source.program(nc)?;
    Ok(program.collect::<Result<Vec<Command>, _>>()?)
}

/// What a plan of the scene writes.
fn planned_text(scene: &Scene, machine: &Machine, entry: &Entry, plan: &str) -> Result<String, SimError> {
    let tools = entry.case.tools();
    let commands = match StrategyFile::named(plan) {
        Some(strategy) => planning::plan(scene, machine, tools, strategy)?.commands,
        None => {
            debug_assert_eq!(plan, HELIX.0);
            programs::helix(scene, machine, tools)?
        }
    };
    programs::text(&commands, Dialect::Siemens840d, &entry.again.nc)
}

impl Tried {
    /// Puts ranges and judgements into the published rows, which are judged by their band until then.
    pub(super) fn judge(&self, file: &CompareFile, all: &mut Comparison) {
        let twin: Vec<Option<[f64; 2]>> = file.published.iter().map(|p| over_twin(p, all)).collect();
        for (k, row) in all.published.iter_mut().enumerate() {
            (row.over_choices, row.over_draws, row.over_twin) = (self.alone[k], self.drawn[k], twin[k]);
            row.agreement = agreement(row);
            row.decided_by = decided_by(row, &self.told).map(|(name, range)| (name.to_owned(), range));
            if let (Some(state), Some(_)) = (agreement::state(row), row.band) {
                row.state = state;
            }
        }
    }
}

/// The gain in the time of a stretch over the variations that act on it; variations of the twin change no
/// other row.
fn over_twin(row: &crate::scene::PublishedFile, all: &Comparison) -> Option<[f64; 2]> {
    let against = row.against.as_ref().filter(|a| **a == all.baseline && row.quantity == QuantityFile::StretchTime)?;
    let mut range = None;
    for variation in all.variations.iter().filter(|v| v.acts) {
        let (own, base) = (variation.times.get(&row.program)?, variation.times.get(against)?);
        let percent = match row.form {
            crate::scene::FormFile::Reduction => 100.0 * (1.0 - own.stretch_s / base.stretch_s),
            crate::scene::FormFile::Rate => 100.0 * (base.stretch_s / own.stretch_s - 1.0),
        };
        wider(&mut range, percent);
    }
    range
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(draws: usize) -> CompareFile {
        let choice = |name: &str, values: &str| {
            format!(
                "[[choice]]\nname = \"{name}\"\nkey = \"control.{name}\"\nsource = \"chosen\"\nreason = \"r\"\n{values}\n"
            )
        };
        let text =
            choice("a", "range = [10, 20]") + &choice("b", "values = [1, 2, 3]") + &choice("c", "range = [0, 1]");
        CompareFile { draws, ..toml::from_str(&text).expect("choices") }
    }

    #[test]
    fn every_part_of_every_range_is_drawn_once() {
        let all = tries(&file(12));
        assert_eq!(all.len(), 2 + 3 + 2 + 12);
        assert!(all[..7].iter().all(|t| t.len() == 1) && all[7..].iter().all(|t| t.len() == 3));
        let number = |v: &ChoiceValueFile| match v {
            ChoiceValueFile::Number(v) => *v,
            ChoiceValueFile::Whole(v) => *v as f64,
            _ => f64::NAN,
        };
        let part = |k: usize, of: &dyn Fn(f64) -> usize| {
            let mut parts: Vec<usize> = all[7..].iter().map(|t| of(number(&t[k].1))).collect();
            parts.sort_unstable();
            parts
        };
        assert_eq!(part(0, &|v| ((v - 10.0) / 10.0 * 12.0) as usize), (0..12).collect::<Vec<_>>());
        assert_eq!(part(2, &|v| (v * 12.0) as usize), (0..12).collect::<Vec<_>>());
        assert_eq!(part(1, &|v| v as usize), [1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
        assert_eq!(tries(&file(12)), all, "same scene, same draws");
        assert!(tries(&CompareFile::default()).is_empty());
    }

    #[test]
    fn a_choice_of_one_plan_or_program_makes_no_other_again() {
        let scene = |name: &str| {
            let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
            Scene::read(&folder).unwrap_or_else(|e| panic!("{e}"))
        };
        let (lu, li) = (scene("lu-2022-quasi-circle"), scene("li-2022-s-theta"));
        let acted = |key: &str, scene: &Scene| -> Vec<String> {
            let names = scene.file.program.iter().map(|p| p.name.clone());
            names.filter(|name| acts_on(key, name, scene)).collect()
        };
        assert_eq!(acted("plan.iso-planar.lines_mm.0", &lu), ["iso-planar"]);
        assert_eq!(acted("machine.B.position_gain_1_s", &lu).len(), lu.file.program.len(), "all of them have it");
        assert_eq!(acted("program.quaternion.reschedule.keys", &li), ["quaternion"]);
        assert_eq!(acted("program.0.file", &li).len(), 3, "an entry by its number may be any");
        // What a program is made from is planned, so that it changes with the plan.
        assert_eq!(acted("plan.helix.start", &li), ["original", "quaternion", "s-theta"]);
        assert_eq!(acted("part.blade.camber_angle_deg", &li).len(), 3);
    }
}
