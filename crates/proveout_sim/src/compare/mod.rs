//! All programs of a scene on the same twin, side by side.
//!
//! ```text
//! Comparing::read ──► vary ──► take, run::run, add (baseline first, then each program) ──► finish ──► Compared
//!   scene, texts      motion     whole prove-outs: stock, bodies, cut part                            compare.json, pictures
//!   nothing written   of all programs, nominal and with one parameter changed; no stock
//! ```
//!
//! The gain of a program is a difference of two times on the same twin; its error comes from running the motion of all
//! programs again with one parameter changed at a time ([`Variation`], [`TimeGain`]). Motion needs no stock, so that this costs little, and
//! a program that the control cannot execute is refused before the first stock is cut.
//!
//! Everything in [`Comparison`] follows from the inputs: same inputs, same bytes at any thread count.

mod judge;
mod markdown;
mod motion;
mod pictures;
mod result;
mod surface;
mod uncertainty;
mod unrolled;
mod variation;

use std::{
    collections::BTreeMap,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use proveout_controller::Dynamics;
use proveout_geom::blade::Blade;
use proveout_machine::{JointKind, JointValues, Machine};
use rayon::prelude::*;

pub use self::{
    markdown::markdown,
    pictures::{DemandRow, JointPicture, PartPicture, Pictures, ProgramPicture, Role, Study, StudyCurve},
    result::*,
    uncertainty::{TimeGain, VariationKind},
};
use self::{
    motion::{Extremes, Motion, MotionCase},
    surface::{SCALLOP_RULE, difference, scallop},
    uncertainty::{VariedGain, saved, time_gain},
    variation::{TwinVariation, variations},
};
use crate::{
    config::ConfigError,
    design::deviation_on,
    error::SimError,
    finding::Severity,
    gates,
    prepare::{Choice, Prepared},
    run::RunResult,
    scene::{CompareFile, DynamicsFile, Scene},
    verdict::{Gate, State, Verdict},
};

/// What the call chooses.
#[derive(Clone, Debug, Default)]
pub struct CompareChoice {
    /// Program that the others are compared with, instead of the scene's.
    pub baseline: Option<String>,
    /// Distance of the stock's rays instead of the scene's, mm.
    pub resolution_mm: Option<f64>,
    /// Dynamics of all programs instead of those of the scene.
    pub dynamics: Option<DynamicsFile>,
}

/// A comparison under way.
#[derive(Debug)]
pub struct Comparing {
    file: CompareFile,
    scene: String,
    description: String,
    blade: Option<Blade>,
    baseline: usize,
    entries: Vec<Entry>,
    variations: Vec<Variation>,
    part: Option<PartPicture>,
}

/// A program of the comparison.
#[derive(Debug)]
struct Entry {
    name: String,
    /// Until it is taken to be run.
    prepared: Option<Prepared>,
    case: MotionCase,
    /// Method, paper, source program.
    made: Option<(String, String, String)>,
    studies: Vec<Study>,
    judged: bool,
    motion: Option<Motion>,
    ideal: Option<Motion>,
    run: Option<Ran>,
}

/// What is kept of a prove-out.
#[derive(Debug)]
struct Ran {
    verdict: Verdict,
    surface: crate::verdict::Surface,
    deviation: Vec<f64>,
}

/// A complete comparison.
#[derive(Clone, Debug)]
pub struct Compared {
    /// `compare.json`.
    pub comparison: Comparison,
    /// What a page shows beside it.
    pub pictures: Pictures,
}

impl Comparing {
    /// Reads a scene and all its programs; nothing is run yet.
    ///
    /// # Errors
    /// [`SimError`] with place and remedy: nothing to compare, an unknown baseline, or what keeps a program from being read.
    pub fn read(path: &Path, choice: &CompareChoice) -> Result<Self, SimError> {
        let scene = Scene::read(path)?;
        let names: Vec<String> = scene.file.program.iter().map(|p| p.name.clone()).collect();
        if names.len() < 2 {
            let message = format!("the scene has {} program: there is nothing to compare", names.len());
            let help = "name another [[program]] in the scene, or prove this one out with `proveout run`";
            return Err(ConfigError::file(&scene.path, message, help).into());
        }
        let file = scene.file.compare.clone().unwrap_or_default();
        let wanted = choice.baseline.as_ref().or(file.baseline.as_ref()).unwrap_or(&names[0]);
        let Some(baseline) = names.iter().position(|n| n == wanted) else {
            let message = format!("there is no program {wanted:?} to compare with");
            let help = format!("programs of the scene: {}", names.join(", "));
            return Err(ConfigError::file(&scene.path, message, help).into());
        };
        let read = |name: &String| -> Result<Entry, SimError> {
            let choice = Choice {
                program: Some(name.clone()),
                nc: None,
                resolution_mm: choice.resolution_mm,
                dynamics: choice.dynamics,
                plant: None,
            };
            Entry::new(Prepared::read(path, &choice)?, name)
        };
        let entries = names.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let blade = scene.file.part.as_ref().and_then(|p| p.blade).and_then(|b| b.blade(0.0).ok());
        Ok(Self {
            file,
            blade,
            scene: scene.file.name,
            description: scene.file.description,
            baseline,
            entries,
            variations: Vec::new(),
            part: None,
        })
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

    /// Runs the motion of all programs, nominal and in every variation; `told` hears how many of how many are done.
    ///
    /// # Errors
    /// [`SimError`] when a program cannot be executed on the nominal twin.
    pub fn vary(&mut self, told: &(dyn Fn(usize, usize) + Sync)) -> Result<(), SimError> {
        let ends = self.file.run_ends_s;
        // The dynamics of the twin are those of the baseline; another program may have its own.
        let twins = variations(self.entries[self.baseline].case.settings.dynamics);
        let total = self.entries.len() * (twins.len() + 2);
        let done = AtomicUsize::new(0);
        let step = || told(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        let nominal: Vec<Result<(Motion, Motion), SimError>> = self
            .entries
            .par_iter()
            .map(|entry| {
                let motion = entry.case.run()?;
                step();
                let ideal = match entry.case.settings.dynamics {
                    Dynamics::Ideal => motion.clone(),
                    Dynamics::Planned | Dynamics::Servo => entry.case.ideal().run()?,
                };
                step();
                Ok((motion, ideal))
            })
            .collect();
        for (entry, result) in self.entries.iter_mut().zip(nominal) {
            let (motion, ideal) = result?;
            (entry.motion, entry.ideal) = (Some(motion), Some(ideal));
        }
        let tasks: Vec<(&TwinVariation, &Entry)> =
            twins.iter().flat_map(|v| self.entries.iter().map(move |e| (v, e))).collect();
        let times: Vec<Result<VariedTime, String>> = tasks
            .par_iter()
            .map(|(variation, entry)| {
                let time = variation.apply(&entry.case).and_then(|case| {
                    let motion = case.run().map_err(|e| format!("{}: {e}", entry.name))?;
                    Ok(varied_time(&motion, ends))
                });
                step();
                time
            })
            .collect();
        let groups = times.chunks(self.entries.len().max(1));
        self.variations = twins.iter().zip(groups).map(|(twin, times)| self.variation(twin, times)).collect();
        Ok(())
    }

    fn variation(&self, twin: &TwinVariation, times: &[Result<VariedTime, String>]) -> Variation {
        let mut out = Variation {
            name: twin.name.clone(),
            parameter: twin.parameter.into(),
            kind: twin.kind,
            unchecked: times.iter().find_map(|t| t.as_ref().err().cloned()),
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
        entry.motion.as_ref().map_or_else(VariedTime::default, |m| varied_time(m, self.file.run_ends_s))
    }

    /// Hands out a program to be run; none when it is unknown or was handed out before.
    pub fn take(&mut self, name: &str) -> Option<Prepared> {
        self.entries.iter_mut().find(|e| e.name == name)?.prepared.take()
    }

    /// Begin and end of a program's cutting stretch, and of the part of it that is shown closely, s of the program; none
    /// before [`Self::vary`] and where there is no stretch.
    pub fn windows(&self, name: &str) -> Option<[[f64; 2]; 2]> {
        let entry = self.entries.iter().find(|e| e.name == name)?;
        windows(entry.motion.as_ref()?, self.file.run_ends_s, self.file.shown_s)
    }

    /// Name of a program's run folder: its own name where that is a plain file name, else its number in the scene.
    pub fn folder(&self, name: &str) -> String {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | '+');
        if !name.is_empty() && name.len() <= 64 && !name.starts_with('.') && name.chars().all(plain) {
            return name.to_owned();
        }
        let place = self.entries.iter().position(|e| e.name == name).unwrap_or(self.entries.len());
        format!("@{}", place + 1)
    }

    /// Takes the result of a program's run; the baseline comes first.
    pub fn add(&mut self, name: &str, result: RunResult) {
        let Some(index) = self.entries.iter().position(|e| e.name == name) else { return };
        let RunResult { verdict, surface, .. } = result;
        if index == self.baseline && !surface.vertex_deviation.is_empty() {
            let (mesh, normals) = surface.whole_mesh();
            let deviation = surface.whole_deviation();
            let judged = |i: usize| deviation.get(i).is_some_and(|d| d.is_finite());
            let flat = |blade: &Blade| unrolled::unrolled(blade, &mesh.positions, judged);
            self.part = Some(PartPicture {
                unrolled: self.blade.as_ref().map_or_else(Vec::new, flat),
                mesh,
                normals,
                deviation: vec![Vec::new(); self.entries.len()],
                difference: vec![Vec::new(); self.entries.len()],
            });
        }
        let deviation = self.part.as_ref().map_or_else(Vec::new, |part| deviation_on(&part.mesh.positions, &surface));
        let entry = &mut self.entries[index];
        let surface = scallop(&verdict.surface, &surface, entry.judged);
        entry.run = Some(Ran { verdict, surface, deviation });
    }

    /// Puts everything together; none when a program was not run.
    pub fn finish(mut self) -> Option<Compared> {
        let baseline = self.entries[self.baseline].run.as_ref()?.deviation.clone();
        let differences: Vec<Vec<f64>> = self
            .entries
            .iter()
            .enumerate()
            .map(|(i, entry)| {
                let own = entry.run.as_ref().filter(|_| i != self.baseline);
                own.map_or_else(Vec::new, |run| run.deviation.iter().zip(&baseline).map(|(a, b)| a - b).collect())
            })
            .collect();
        let mut programs = BTreeMap::new();
        for (i, entry) in self.entries.iter().enumerate() {
            programs.insert(entry.name.clone(), self.figures(i, entry.run.as_ref()?, &differences[i]));
        }
        let base = &self.entries[self.baseline];
        let mut comparison = Comparison {
            schema_version: SCHEMA_VERSION,
            scene: self.scene.clone(),
            description: self.description.clone(),
            experiment: self.file.experiment.clone(),
            machine: base.case.machine.name.clone(),
            baseline: base.name.clone(),
            order: self.entries.iter().map(|e| e.name.clone()).collect(),
            verdict: State::Unchecked,
            gains: self.gains(&programs),
            programs,
            variations: std::mem::take(&mut self.variations),
            published: Vec::new(),
            expectations: Vec::new(),
            rules: rules(self.file.run_ends_s),
        };
        comparison.published = judge::published(&self.file, &comparison);
        comparison.expectations = judge::expectations(&self.file, &comparison);
        comparison.verdict = overall(&comparison);
        let pictures = self.pictures(differences);
        Some(Compared { comparison, pictures })
    }

    fn figures(&self, index: usize, run: &Ran, difference_to: &[f64]) -> ProgramFigures {
        let (entry, v) = (&self.entries[index], &run.verdict);
        let errors = v.findings.iter().filter(|f| f.severity == Severity::Error).count() as u64;
        let compared = index != self.baseline && self.part.is_some();
        ProgramFigures {
            folder: self.folder(&entry.name),
            verdict: v.verdict,
            gates: v.gates.clone(),
            errors,
            digests: v.digests.clone(),
            made: entry.made.as_ref().map(|(method, source, from)| Made {
                method: method.clone(),
                source: source.clone(),
                from: from.clone(),
                center_shift_mm: self.center_shift(entry, from),
                figures: entry.studies.first().map_or_else(Vec::new, |s| s.figures.clone()),
            }),
            time: v.time.clone(),
            axes: v.axes.clone(),
            stretch: self.stretch(entry),
            deviation: v.deviation.clone(),
            surface: run.surface.clone(),
            difference: compared.then(|| difference(difference_to)),
            clearance: v.clearance.clone(),
        }
    }

    fn center_shift(&self, entry: &Entry, from: &str) -> Option<f64> {
        let source = self.entries.iter().find(|e| e.name == from)?;
        entry.ideal.as_ref()?.center_shift(source.ideal.as_ref()?)
    }

    fn stretch(&self, entry: &Entry) -> Option<Stretch> {
        let (motion, ideal) = (entry.motion.as_ref()?, entry.ideal.as_ref()?);
        let ranges = motion.stretch(self.file.run_ends_s);
        let blocks = ranges.iter().map(|r| r.len() as u64).sum();
        if blocks == 0 {
            return None;
        }
        let demand = ideal.demand(&ideal.stretch(self.file.run_ends_s));
        let largest = |of: &dyn Fn(&motion::DemandPoint) -> Option<f64>| {
            demand.iter().filter_map(of).map(f64::abs).reduce(f64::max)
        };
        let joints = entry.case.machine.joints.iter().zip(motion.extremes(&ranges)).enumerate();
        let axes = joints.map(|(j, (joint, Extremes { velocity, acceleration, jerk, reversals }))| {
            let (unit, factor) = unit_of(joint.kind);
            let axis = StretchAxis {
                unit: unit.into(),
                max_velocity: velocity * factor,
                max_acceleration: acceleration * factor,
                max_jerk: jerk * factor,
                reversals: reversals.into(),
                demand_velocity: largest(&|d| Some(d.velocity[j])).map(|v| v * factor),
                demand_acceleration: largest(&|d| d.acceleration.map(|a| a[j])).map(|a| a * factor),
            };
            (joint.name.clone(), axis)
        });
        let programmed = ranges.iter().flat_map(|r| motion.blocks[r.clone()].iter()).map(|b| b.programmed).sum();
        Some(Stretch { blocks, time_s: motion.stretch_time(&ranges), programmed_s: programmed, axes: axes.collect() })
    }

    fn gains(&self, programs: &BTreeMap<String, ProgramFigures>) -> BTreeMap<String, Gain> {
        let base = &self.entries[self.baseline];
        let base_time = self.nominal_time(base);
        let Some(base_figures) = programs.get(&base.name) else { return BTreeMap::new() };
        let mut out = BTreeMap::new();
        for entry in self.entries.iter().filter(|e| e.name != base.name) {
            let Some(figures) = programs.get(&entry.name) else { continue };
            let time = self.nominal_time(entry);
            let gain = |of: fn(&VariedTime) -> f64, varied: fn(&VariedGains) -> Option<f64>| {
                let all: Vec<VariedGain<'_>> = self
                    .variations
                    .iter()
                    .filter_map(|v| {
                        let percent = varied(v.gains.get(&entry.name)?)?;
                        Some(VariedGain { parameter: &v.parameter, kind: v.kind, percent })
                    })
                    .collect();
                time_gain(of(&base_time), of(&time), &all)
            };
            let cycle_time = gain(|t| t.total_s, |g| g.cycle_time_percent);
            let change =
                |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| 100.0 * (a / b - 1.0)).filter(|p| p.is_finite());
            out.insert(
                entry.name.clone(),
                Gain {
                    cycle_time_percent: cycle_time.percent,
                    error_percent: cycle_time.error_percent,
                    cycle_time,
                    cutting_time: gain(|t| t.cutting_s, |g| g.cutting_time_percent),
                    stretch_time: gain(|t| t.stretch_s, |g| g.stretch_time_percent),
                    axes: axis_gains(base_figures, figures),
                    scallop_max_change_percent: change(
                        figures.surface.scallop_max_um,
                        base_figures.surface.scallop_max_um,
                    ),
                    scallop_mean_change_percent: change(
                        figures.surface.scallop_mean_um,
                        base_figures.surface.scallop_mean_um,
                    ),
                },
            );
        }
        out
    }

    fn pictures(mut self, differences: Vec<Vec<f64>>) -> Pictures {
        let joints: Vec<JointPicture> = joints_of(&self.entries[self.baseline].case.machine);
        let (ends, shown) = (self.file.run_ends_s, self.file.shown_s);
        if let Some(part) = &mut self.part {
            part.difference = differences;
            for (values, entry) in part.deviation.iter_mut().zip(&mut self.entries) {
                *values = entry.run.take().map_or_else(Vec::new, |r| r.deviation);
            }
        }
        let picture = |entry: &mut Entry| {
            let demand = entry.ideal.as_ref().map_or_else(Vec::new, |m| m.demand(&m.stretch(ends)));
            let row = |j: usize, joint: &JointPicture| {
                let f = joint.factor;
                let of = |q: &JointValues| q[j] * f;
                let row = |d: &motion::DemandPoint| DemandRow {
                    time_s: d.time,
                    position: of(&d.position),
                    velocity: of(&d.velocity),
                    acceleration: d.acceleration.as_ref().map_or(f64::NAN, of),
                };
                demand.iter().map(row).collect()
            };
            ProgramPicture {
                name: entry.name.clone(),
                windows: entry.motion.as_ref().and_then(|m| windows(m, ends, shown)),
                demand: joints.iter().enumerate().map(|(j, joint)| row(j, joint)).collect(),
                studies: std::mem::take(&mut entry.studies),
            }
        };
        let programs = self.entries.iter_mut().map(picture).collect();
        Pictures { programs, joints, part: self.part, shown_s: shown }
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
            made,
            studies: runs.iter().map(pictures::study_of).collect(),
            judged: prepared.scene.file.part.as_ref().is_some_and(|p| p.judged.is_some()),
            prepared: Some(prepared),
            motion: None,
            ideal: None,
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

fn windows(motion: &Motion, ends: f64, shown: Option<[f64; 2]>) -> Option<[[f64; 2]; 2]> {
    let ranges = motion.stretch(ends);
    let blocks: Vec<&motion::FeedBlock> = ranges.iter().flat_map(|r| motion.blocks[r.clone()].iter()).collect();
    let whole = [blocks.first()?.time[0], blocks.last()?.time[1]];
    let Some([from, to]) = shown else { return Some([whole; 2]) };
    let mut close: Option<[f64; 2]> = None;
    let mut time = 0.0;
    for block in blocks {
        if time + block.programmed > from && time < to {
            close = Some([close.map_or(block.time[0], |c| c[0]), block.time[1]]);
        }
        time += block.programmed;
    }
    Some([whole, close.unwrap_or(whole)])
}

fn unit_of(kind: JointKind) -> (&'static str, f64) {
    if kind == JointKind::Rotary { ("deg", 1_f64.to_degrees()) } else { ("mm", 1.0) }
}

fn joints_of(machine: &Machine) -> Vec<JointPicture> {
    let joint = |j: &proveout_machine::Joint| {
        let (unit, factor) = unit_of(j.kind);
        let limits = [j.max_velocity, j.max_acceleration, j.max_jerk].map(|l| l.map(|l| l * factor));
        JointPicture { name: j.name.clone(), unit, factor, limits }
    };
    machine.joints.iter().map(joint).collect()
}

fn axis_gains(base: &ProgramFigures, own: &ProgramFigures) -> BTreeMap<String, AxisGain> {
    let (Some(base), Some(own)) = (&base.stretch, &own.stretch) else { return BTreeMap::new() };
    let pairs = own.axes.iter().filter_map(|(name, axis)| Some((name, axis, base.axes.get(name)?)));
    let gain = |(name, own, base): (&String, &StretchAxis, &StretchAxis)| {
        let axis = AxisGain {
            velocity_percent: saved(base.max_velocity, own.max_velocity),
            acceleration_percent: saved(base.max_acceleration, own.max_acceleration),
            jerk_percent: saved(base.max_jerk, own.max_jerk),
            demand_velocity_percent: base.demand_velocity.zip(own.demand_velocity).and_then(|(b, o)| saved(b, o)),
            demand_acceleration_percent: base
                .demand_acceleration
                .zip(own.demand_acceleration)
                .and_then(|(b, o)| saved(b, o)),
        };
        (name.clone(), axis)
    };
    pairs.map(gain).collect()
}

/// Fail beats unchecked beats pass, over the programs and the criteria.
fn overall(comparison: &Comparison) -> State {
    let programs = comparison.programs.values().map(|p| p.verdict);
    let states = programs.chain(comparison.expectations.iter().map(|e| e.state));
    let gates: Vec<Gate> = states.map(|state| Gate { name: String::new(), state, reason: String::new() }).collect();
    gates::overall(&gates)
}

fn rules(ends: f64) -> BTreeMap<String, String> {
    let rules = [
        (
            "gain",
            "100 (1 - time / time of the baseline); both times from the same twin, which differs in the program alone".to_owned(),
        ),
        (
            "error",
            "Sum over the numerical parameters of the largest change of the gain, plus 2 times the root of a third of the sum of \
             squares of the largest changes of the model parameters (bounds as rectangular distributions, independent, \
             coverage factor 2: JCGM 100:2008, 4.3.7, 5.1.2, 6.3.3)"
                .to_owned(),
        ),
        (
            "stretch",
            format!(
                "Cutting stretch: blocks in feed without those within {ends} s of programmed time from both ends of their run"
            ),
        ),
        (
            "demand",
            "Demand: differences of joint positions at the ends of the program's blocks over their programmed times: what the \
             program asks for, whatever the joint can do. The step is the block of the program"
                .to_owned(),
        ),
        (
            "reversals",
            "Over the cutting stretch a joint reverses where it turns back by more than 0.001 mm or 1e-6 rad; over the whole \
             program, as in the verdict, wherever its speed changes sign"
                .to_owned(),
        ),
        ("scallop", SCALLOP_RULE.to_owned()),
        (
            "difference",
            "Deviation of this program less that of the baseline at the vertices of the baseline's cut part, each the mean of the \
             exact points in the cells round the vertex"
                .to_owned(),
        ),
    ];
    rules.into_iter().map(|(name, words)| (name.to_owned(), words)).collect()
}
