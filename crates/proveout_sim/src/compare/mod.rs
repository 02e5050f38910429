//! All programs of a scene on the same twin, side by side.
//!
//! ```text
//! Comparing::read ──► vary ──► take, run::run, add ──► finish ──► Compared
//!
//! read                  scene, texts; nothing written
//! vary                  motion of all programs, nominal and with one parameter changed; no stock
//! take, run::run, add   whole prove-outs: stock, bodies, cut part; baseline first, then each program
//! Compared              compare.json, pictures
//! ```
//!
//! The gain of a program is a difference of two times on the same twin; its error comes from running the
//! motion of all programs again with one parameter changed at a time ([`Variation`], [`TimeGain`]). Motion
//! needs no stock, so that this costs little, and a program that the control cannot execute is refused before
//! the first stock is cut.
//!
//! Everything in [`Comparison`] follows from the inputs: same inputs, same bytes at any thread count.
//!
//! | file | what it does |
//! |---|---|
//! | `certificate/` | bounds on the time of any schedule |
//! | `choices.rs` | published values over what the experiment leaves open |
//! | `depth.rs` | the depth of cut along lines |
//! | `finish.rs` | the results of all programs put together |
//! | `judge.rs` | published values and criteria against what was measured |
//! | `markdown.rs` | a comparison as a section of a page |
//! | `pictures.rs` | curves and meshes for the page |
//! | `remade.rs` | a program made again, with its certificate |
//! | `result.rs` | `compare.json` |
//! | `schedule.rs` | a re-scheduled program compared with its source |
//! | `sphere.rs` | tool axes on the Gauss sphere |
//! | `surface.rs` | scallop, and cut parts compared with each other |
//! | `uncertainty.rs` | the error of a gain |
//! | `unrolled.rs` | the side of a blade laid flat |
//! | `variation.rs` | the twin with one parameter changed |

mod agreement;
pub mod certificate;
mod choices;
pub(crate) mod depth;
mod finish;
mod judge;
mod markdown;
mod pictures;
pub(crate) mod remade;
mod result;
pub mod schedule;
mod sphere;
mod surface;
mod uncertainty;
mod unrolled;
mod variation;

use std::{
    collections::BTreeMap,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use proveout_controller::ReprogrammedRun;
use proveout_input::Step::Key;
use proveout_step::StepFiles;
use rayon::prelude::*;

use self::{
    finish::windows,
    surface::scallop,
    uncertainty::saved,
    variation::{TwinVariation, own_limits, variations},
};
pub use self::{
    markdown::{HEADLINES, headlines, markdown},
    pictures::{DemandRow, JointPicture, PartPicture, Pictures, ProgramPicture, Role, Study, StudyCurve},
    result::*,
    uncertainty::{TimeGain, VariationKind},
};
use crate::{
    compare::{
        certificate::{blocks_of, certify, gain_curves},
        schedule::Motions,
    },
    judge::design::deviation_on,
    observe::{
        schedule_rows::{Schedule, ScheduleBound},
        surface_map::SurfaceMap,
    },
    prepare::{
        choice::Choice,
        error::SimError,
        motion_only::{Motion, MotionCase},
        part_shape::Shape,
        prepared::Prepared,
    },
    run::main_loop::RunResult,
    scene::{CompareFile, Dynamics, Scene},
    verdict::verdict_file::Verdict,
};
pub(crate) use pictures::study_of;

/// A variation that changes no time of a cutting stretch by more than this part cannot act on a gain.
const ACTS: f64 = 1e-9;

/// What the call chooses.
#[derive(Clone, Debug, Default)]
pub struct CompareChoice {
    /// Program that the others are compared with, instead of the scene's.
    pub baseline: Option<String>,
    /// Distance of the stock's rays instead of the scene's, mm.
    pub resolution_mm: Option<f64>,
    /// Dynamics of all programs instead of those of the scene.
    pub dynamics: Option<Dynamics>,
    /// Leaves the choices of the scene out, which take most of the time: published values have no range then,
    /// and the comparison does not pass.
    pub without_choices: bool,
}

/// A comparison under way.
#[derive(Debug)]
pub struct Comparing {
    file: CompareFile,
    scene: String,
    description: String,
    cells: [f64; 3],
    scene_cells: bool,
    shape: Option<Shape>,
    baseline: usize,
    entries: Vec<Entry>,
    variations: Vec<Variation>,
    own_limits: Option<Variation>,
    choices: Option<choices::Tried>,
    without_choices: bool,
    part: Option<PartPicture>,
}

/// A program of the comparison.
#[derive(Debug)]
struct Entry {
    name: String,
    /// Until it is taken to be run.
    prepared: Option<Prepared>,
    case: MotionCase,
    changed_limits: Vec<ChangedLimit>,
    /// Method, paper, source program.
    made: Option<(String, String, String)>,
    /// What was made, before it ran.
    runs: Vec<ReprogrammedRun>,
    studies: Vec<Study>,
    judged: bool,
    digests: BTreeMap<String, String>,
    /// What programs are made again with, for choices.
    again: choices::Again,
    motion: Option<Motion>,
    ideal: Option<Motion>,
    over_velocity: Vec<GainAtLimit>,
    /// Time and bound of each of `runs`, once the motion is known.
    bounds: Vec<Result<ScheduleBound, String>>,
    run: Option<Ran>,
}

/// How far the stretch of a made program is from the best schedule.
#[derive(Debug)]
struct Gap {
    bound: Result<ScheduleBound, String>,
    figures: Vec<StudyFigure>,
    curves: Vec<StudyCurve>,
    over_velocity: Vec<GainAtLimit>,
}

/// Figures of it: time, and what is left to gain.
pub(crate) const GAP: [&str; 2] = ["time of the planned stretch", "left to gain at most"];
/// Its bound, by the schedules that it is about.
pub(crate) const BOUNDS: [&str; 3] = [
    "no schedule in the channel is below",
    "no schedule of axes as near to those of the program before is below",
    "no schedule at these feeds is below",
];

/// What is kept of a prove-out.
#[derive(Debug)]
struct Ran {
    verdict: Verdict,
    surface: crate::verdict::verdict_file::Surface,
    deviation: Vec<f64>,
}

/// A complete comparison.
#[derive(Clone, Debug)]
pub struct Compared {
    /// `compare.json`.
    pub comparison: Comparison,
    /// What a page shows in addition.
    pub pictures: Pictures,
}

impl Comparing {
    /// Reads a scene and all its programs; nothing is run yet.
    ///
    /// # Errors
    /// [`SimError`] with place and remedy: nothing to compare, an unknown baseline, or what keeps a program
    /// from being read.
    pub fn read(path: &Path, choice: &CompareChoice) -> Result<Self, SimError> {
        let scene = Scene::read(path)?;
        let names: Vec<String> = scene.file.program.iter().map(|p| p.name.clone()).collect();
        if names.len() < 2 {
            let message = format!("the scene has {} program: there is nothing to compare", names.len());
            let help = "name another [[program]] in the scene, or prove this one out with `proveout run`";
            return Err(scene.error_at(&[Key("program")], message, help).into());
        }
        let file = scene.file.compare.clone().unwrap_or_default();
        let wanted = choice.baseline.as_ref().or(file.baseline.as_ref()).unwrap_or(&names[0]);
        let Some(baseline) = names.iter().position(|n| n == wanted) else {
            let message = format!("there is no program {wanted:?} to compare with");
            let help = format!("programs of the scene: {}", names.join(", "));
            return Err(scene.error_at(&[Key("program")], message, help).into());
        };
        choices::check(&scene)?;
        let step_files = StepFiles::default();
        let read = |name: &String| -> Result<Entry, SimError> {
            let choice = Choice {
                step_files: step_files.clone(),
                program: Some(name.clone()),
                nc: None,
                resolution_mm: choice.resolution_mm,
                dynamics: choice.dynamics,
                plant: None,
                ..Choice::default()
            };
            Entry::new(Prepared::read(path, &choice)?, name)
        };
        // In parallel, since methods take their time; the first fault in the order of the scene is
        // reported.
        let entries: Vec<Result<Entry, SimError>> = names.par_iter().map(read).collect();
        let entries = entries.into_iter().collect::<Result<Vec<_>, _>>()?;
        let blade = scene.file.part.as_ref().and_then(|p| p.blade);
        let shape = blade.map(|b| Shape::of_scene(&scene, &b, 0.0)).transpose()?;
        let own = scene.file.resolution_mm.get_ref().edges();
        let cells = choice.resolution_mm.map_or(own, |c| [c; 3]);
        Ok(Self {
            file,
            cells,
            scene_cells: cells == own,
            shape,
            scene: scene.file.name,
            description: scene.file.description,
            baseline,
            entries,
            variations: Vec::new(),
            own_limits: None,
            choices: None,
            without_choices: choice.without_choices,
            part: None,
        })
    }

    /// Whether the scene looks at motion alone: its programs are not run.
    pub fn motion_only(&self) -> bool {
        self.file.motion_only
    }

    /// Name of the scene.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Names of the programs in the order in which they must be run: the baseline first.
    pub fn order(&self) -> Vec<String> {
        let others = self.entries.iter().enumerate().filter(|(i, _)| *i != self.baseline);
        let all = std::iter::once(&self.entries[self.baseline]).chain(others.map(|(_, e)| e));
        all.map(|e| e.name.clone()).collect()
    }

    /// Runs the motion of all programs, nominal and in every variation; `told` is called with the
    /// number done and the total.
    ///
    /// # Errors
    /// [`SimError`] when a program cannot be executed on the nominal twin.
    pub fn vary(&mut self, told: &(dyn Fn(usize, usize) + Sync)) -> Result<(), SimError> {
        let ends = self.file.trimmed_ends_s;
        // The dynamics of the twin are those of the baseline; another program may have its own.
        let mut twins = variations(self.entries[self.baseline].case.settings.dynamics);
        let limited = !self.entries[self.baseline].changed_limits.is_empty();
        twins.extend(limited.then(own_limits));
        let tries = if self.without_choices { Vec::new() } else { choices::tries(&self.file) };
        let total = self.entries.len() * (twins.len() + 1 + tries.len());
        let done = AtomicUsize::new(0);
        let step = || told(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        self.execute(&step)?;
        let tasks: Vec<(&TwinVariation, &Entry)> =
            twins.iter().flat_map(|v| self.entries.iter().map(move |e| (v, e))).collect();
        let times: Vec<Result<VariedTime, String>> = tasks
            .par_iter()
            .map(|(variation, entry)| {
                let time = if variation.changes_law(&entry.case) {
                    variation.apply(&entry.case).and_then(|case| {
                        let motion = case.run().map_err(|e| format!("{}: {e}", entry.name))?;
                        Ok(varied_time(&motion, ends))
                    })
                } else {
                    Ok(self.nominal_time(entry))
                };
                step();
                time
            })
            .collect();
        let groups = times.chunks(self.entries.len().max(1));
        self.variations = twins.iter().zip(groups).map(|(twin, times)| self.variation(twin, times)).collect();
        self.own_limits = if limited { self.variations.pop() } else { None };
        if !tries.is_empty() {
            self.choices = Some(self.tried(&tries, &step));
        }
        Ok(())
    }

    /// Runs the motion of all programs on the nominal twin, as it cuts and along the programmed
    /// path; [`Self::vary`] begins with it. `step` is called for each motion.
    ///
    /// # Errors
    /// [`SimError`] when a program cannot be executed.
    pub fn execute(&mut self, step: &(dyn Fn() + Sync)) -> Result<(), SimError> {
        let nominal: Vec<Result<Motion, SimError>> = self
            .entries
            .par_iter()
            .map(|entry| {
                let motion = entry.case.run();
                step();
                motion
            })
            .collect();
        for (entry, motion) in self.entries.iter_mut().zip(nominal) {
            let motion = motion?;
            (entry.ideal, entry.motion) = (Some(motion.along_program()), Some(motion));
        }
        self.tell_gaps();
        Ok(())
    }

    /// Adds to the figures of each method how far its schedule is from the best one.
    fn tell_gaps(&mut self) {
        let all: Vec<Vec<Gap>> = self.entries.par_iter().map(|entry| self.gaps(entry)).collect();
        for (entry, mut gaps) in self.entries.iter_mut().zip(all) {
            entry.over_velocity = gaps.first_mut().map_or_else(Vec::new, |gap| std::mem::take(&mut gap.over_velocity));
            entry.bounds = gaps.iter().map(|gap| gap.bound.clone()).collect();
            for (study, Gap { figures, curves, .. }) in entry.studies.iter_mut().zip(gaps) {
                study.figures.retain(|f| !figures.iter().any(|own| own.name == f.name));
                study.figures.extend(figures);
                study.curves.retain(|c| !curves.iter().any(|own| own.name == c.name && own.axes == c.axes));
                study.curves.extend(curves);
            }
        }
    }

    /// Time, bound and gap of the stretches of a made program, and what it gains over velocity limits;
    /// nothing where there is no bound.
    fn gaps(&self, entry: &Entry) -> Vec<Gap> {
        let source = entry.made.as_ref().and_then(|(_, _, from)| self.entries.iter().find(|e| e.name == *from));
        let (Some(new), Some(old)) = (entry.motion.as_ref(), source.and_then(|s| s.motion.as_ref())) else {
            return Vec::new();
        };
        let pairs = blocks_of(&new.blocks, &entry.runs).into_iter().zip(blocks_of(&old.blocks, &entry.runs));
        let figure = |name: &str, unit: &str, value: f64| StudyFigure { name: name.into(), unit: unit.into(), value };
        let runs = entry.runs.iter().zip(pairs).map(|(run, (new, old))| {
            let found = match certify(run, |_| 0, new, old, &entry.changed_limits) {
                Ok(found) => found,
                Err(why) => {
                    let (figures, curves, over_velocity) = (Vec::new(), Vec::new(), Vec::new());
                    return Gap { bound: Err(why), figures, curves, over_velocity };
                }
            };
            // A method of two angles has no channel: its bound is about axes that stray no farther than its
            // own.
            let bound = match &found.cells {
                Some(_) => BOUNDS[1],
                None if found.joints.is_empty() => BOUNDS[2],
                None => BOUNDS[0],
            };
            let mut figures = vec![figure(GAP[0], "s", found.time_s), figure(bound, "s", found.bound_s)];
            let stray = found.cells.as_ref().map(|cells| cells.stray_deg);
            figures.extend(
                stray.map(|deg| figure("axes are within this angle of those of the program before", "deg", deg)),
            );
            figures.extend(found.gap_percent.map(|gap| figure(GAP[1], "%", gap)));
            let over_velocity = found.joints.iter().flat_map(|joint| {
                joint.over_velocity.iter().map(|row| GainAtLimit {
                    joint: joint.name.clone(),
                    velocity_deg_s: row.velocity_deg_s,
                    is: row.is,
                    saved_percent: row.saved_percent,
                    saved_at_most_percent: row.saved_at_most_percent,
                })
            });
            let over_velocity = over_velocity.collect();
            let curves = found.joints.iter().flat_map(gain_curves).collect();
            Gap { bound: Ok(ScheduleBound::of(&found)), figures, curves, over_velocity }
        });
        runs.collect()
    }

    /// The cutting stretch of a program; none before [`Self::execute`] and where there is no stretch.
    pub fn stretch_of(&self, name: &str) -> Option<Stretch> {
        self.stretch(self.entries.iter().find(|e| e.name == name)?)
    }

    fn variation(&self, twin: &TwinVariation, times: &[Result<VariedTime, String>]) -> Variation {
        let mut out = Variation {
            name: twin.name.clone(),
            parameter: twin.parameter.into(),
            kind: twin.kind,
            unchecked: times.iter().find_map(|t| t.as_ref().err().cloned()),
            acts: false,
            times: BTreeMap::new(),
            gains: BTreeMap::new(),
        };
        if out.unchecked.is_some() {
            return out;
        }
        let known: Vec<VariedTime> = times.iter().filter_map(|t| t.as_ref().ok().copied()).collect();
        let nominal: Vec<VariedTime> = self.entries.iter().map(|e| self.nominal_time(e)).collect();
        let (Some(base), Some(base_nominal)) = (known.get(self.baseline), nominal.get(self.baseline)) else {
            return out;
        };
        let other = |a: &VariedTime, b: &VariedTime| (a.stretch_s / b.stretch_s - 1.0).abs() > ACTS;
        out.acts = known.iter().zip(&nominal).any(|(a, b)| other(a, b));
        for (i, entry) in self.entries.iter().enumerate() {
            out.times.insert(entry.name.clone(), known[i]);
            if i == self.baseline {
                continue;
            }
            let gain = |of: fn(&VariedTime) -> f64| saved(of(base), of(&known[i]));
            let change = |of: fn(&VariedTime) -> f64| {
                gain(of).zip(saved(of(base_nominal), of(&nominal[i]))).map(|(varied, nominal)| varied - nominal)
            };
            let gains = VariedGains {
                cycle_time_percent: gain(|t| t.total_s),
                cycle_time_change_percent: change(|t| t.total_s),
                cutting_time_percent: gain(|t| t.cutting_s),
                cutting_time_change_percent: change(|t| t.cutting_s),
                stretch_time_percent: gain(|t| t.stretch_s),
                stretch_time_change_percent: change(|t| t.stretch_s),
            };
            out.gains.insert(entry.name.clone(), gains);
        }
        out
    }

    fn nominal_time(&self, entry: &Entry) -> VariedTime {
        entry.motion.as_ref().map_or_else(VariedTime::default, |m| varied_time(m, self.file.trimmed_ends_s))
    }

    /// Hands out a program to be run; none when it is unknown or was handed out before.
    pub fn take(&mut self, name: &str) -> Option<Prepared> {
        let place = self.entries.iter().position(|e| e.name == name)?;
        let mut prepared = self.entries[place].prepared.take()?;
        prepared.schedule = self.schedule(&self.entries[place], &prepared);
        Some(prepared)
    }

    /// A re-scheduled program compared with the one before, from the motions that were run.
    fn schedule(&self, entry: &Entry, prepared: &Prepared) -> Option<Schedule> {
        let (_, _, from) = entry.made.as_ref()?;
        let source = self.entries.iter().find(|e| e.name == *from)?;
        let motions = Motions {
            planned: [entry.motion.as_ref()?, source.motion.as_ref()?],
            ideal: [entry.ideal.as_ref()?, source.ideal.as_ref()?],
        };
        Some(Schedule::head(prepared)?.with(&entry.runs, &entry.case.machine, motions, entry.bounds.clone()))
    }

    /// Begin and end of a program's cutting stretch, and of the part of it that is shown closely, s of the
    /// program; none before [`Self::vary`] and where there is no stretch.
    pub fn windows(&self, name: &str) -> Option<[[f64; 2]; 2]> {
        let entry = self.entries.iter().find(|e| e.name == name)?;
        windows(entry.motion.as_ref()?, self.file.trimmed_ends_s, self.file.plot_window_s)
    }

    /// Name of a program's run folder: its own name where that is a plain file name, else its number in the
    /// scene.
    pub fn folder(&self, name: &str) -> String {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '+');
        if !name.is_empty() && name.len() <= 64 && !name.starts_with('.') && name.chars().all(plain) {
            return name.to_owned();
        }
        let place = self.entries.iter().position(|e| e.name == name).unwrap_or(self.entries.len());
        format!("@{}", place + 1)
    }

    /// Takes the result of a program's run and the surface that it left; the baseline comes first.
    pub fn add(&mut self, name: &str, result: RunResult, surface: &SurfaceMap) {
        let Some(index) = self.entries.iter().position(|e| e.name == name) else { return };
        let RunResult { verdict, .. } = result;
        if index == self.baseline && !surface.vertex_deviation.is_empty() {
            let (mesh, normals) = surface.whole_mesh();
            let deviation = surface.whole_deviation();
            let judged = |i: usize| deviation.get(i).is_some_and(|d| d.is_finite());
            let flat = |shape: &Shape| unrolled::of_shape(shape, &mesh.positions, judged);
            self.part = Some(PartPicture {
                unrolled: self.shape.as_ref().map_or_else(Vec::new, flat),
                mesh,
                normals,
                deviation: vec![Vec::new(); self.entries.len()],
                difference: vec![Vec::new(); self.entries.len()],
            });
        }
        let deviation = self.part.as_ref().map_or_else(Vec::new, |part| deviation_on(&part.mesh.positions, surface));
        let entry = &mut self.entries[index];
        let surface = scallop(&verdict.surface, surface, entry.judged);
        entry.run = Some(Ran { verdict, surface, deviation });
    }
}

impl Entry {
    fn new(prepared: Prepared, name: &str) -> Result<Self, SimError> {
        let case = MotionCase::new(&prepared)?;
        let entry = prepared.scene.program(Some(name));
        let made = entry.and_then(|e| e.reschedule.as_ref()).map(|r| {
            let method = r.method();
            (method.name().to_owned(), method.source().to_owned(), r.from.clone())
        });
        let runs = prepared.made.as_ref().map(|m| m.runs.as_slice()).unwrap_or_default();
        Ok(Self {
            name: name.to_owned(),
            case,
            changed_limits: prepared.changed_limits.clone(),
            made,
            studies: runs.iter().map(study_of).collect(),
            runs: runs.to_vec(),
            digests: prepared.digests.clone(),
            again: choices::Again::new(&prepared),
            judged: prepared.scene.file.part.as_ref().is_some_and(|p| p.judged_box.is_some()),
            prepared: Some(prepared),
            motion: None,
            ideal: None,
            over_velocity: Vec::new(),
            bounds: Vec::new(),
            run: None,
        })
    }
}

fn varied_time(motion: &Motion, ends: f64) -> VariedTime {
    VariedTime {
        total_s: motion.summary.total_s,
        cutting_s: motion.summary.cutting_s,
        stretch_s: motion.stretch_time(&motion.stretch(ends)),
    }
}
