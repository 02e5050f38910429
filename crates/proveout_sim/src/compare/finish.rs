//! Puts the results of all programs together.

use std::collections::BTreeMap;

use proveout_geom::deg;
use proveout_machine::{JointValues, Machine};

use super::{
    AxisGain, ChangedLimit, Compared, Comparing, Comparison, DemandRow, Entry, Gain, JointPicture, Made, Pictures,
    ProgramFigures, ProgramPicture, Ran, RotaryDemand, SCHEMA_VERSION, Stretch, StretchAxis, VariedGains, VariedTime,
    depth::depth_of,
    judge,
    surface::{SCALLOP_RULE, difference},
    uncertainty::{VariedGain, saved, time_gain},
};
use crate::{
    prepare::motion_only::{self, Extremes, Motion},
    units::UM_PER_MM,
    verdict::{
        finding::Severity,
        gate::Gate,
        gates,
        verdict_file::{GateVerdict, State, Time},
    },
};

impl Comparing {
    /// Puts everything together; none when a program was not run.
    pub fn finish(mut self) -> Option<Compared> {
        let alone = self.file.motion_only;
        let base_run = self.entries[self.baseline].run.as_ref();
        let baseline = if alone { Vec::new() } else { base_run?.deviation.clone() };
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
            let figures = match &entry.run {
                Some(run) => self.figures(i, run, &differences[i]),
                None if alone => self.motion_figures(entry)?,
                None => return None,
            };
            programs.insert(entry.name.clone(), figures);
        }
        let base = &self.entries[self.baseline];
        let mut comparison = Comparison {
            schema_version: SCHEMA_VERSION,
            scene: self.scene.clone(),
            description: self.description.clone(),
            experiment: self.file.experiment.clone(),
            machine: base.case.machine.name.clone(),
            joint_limits: self.joint_limits(),
            baseline: base.name.clone(),
            cells_mm: self.cells,
            scene_cells: self.scene_cells,
            motion_only: alone,
            order: self.entries.iter().map(|e| e.name.clone()).collect(),
            verdict: State::Unchecked,
            gains: self.gains(&programs),
            programs,
            variations: std::mem::take(&mut self.variations),
            own_limits: self.own_limits.take(),
            choices: self.choices.as_ref().map(|tried| tried.told.clone()),
            null_program: self.file.null_program.clone(),
            must_pass: self.file.must_pass.clone(),
            published: Vec::new(),
            expectations: Vec::new(),
            rules: rules(self.file.run_ends_s),
        };
        if comparison.programs.values().any(|p| p.stretch.as_ref().is_some_and(|s| s.depth.is_some())) {
            comparison.rules.insert("depth".to_owned(), DEPTH_RULE.to_owned());
        }
        comparison.published = judge::published(&self.file, &comparison);
        if let Some(tried) = &self.choices {
            tried.judge(&self.file, &mut comparison);
        }
        comparison.expectations = judge::expectations(&self.file, &comparison);
        comparison.verdict = overall(&comparison, self.file.must_pass.as_deref());
        // What an equally good choice would give was not looked at.
        if self.without_choices && !self.file.choice.is_empty() && comparison.verdict == State::Pass {
            comparison.verdict = State::Unchecked;
        }
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
            made: self.made_figures(entry),
            time: v.time.clone(),
            axes: v.axes.clone(),
            stretch: self.stretch(entry),
            deviation: v.deviation.clone(),
            surface: run.surface.clone(),
            difference: compared.then(|| difference(difference_to)),
            clearance: v.clearance.clone(),
        }
    }

    pub(super) fn made_figures(&self, entry: &Entry) -> Option<Made> {
        entry.made.as_ref().map(|(method, source, from)| Made {
            method: method.clone(),
            source: source.clone(),
            from: from.clone(),
            center_shift_mm: self.center_shift(entry, from),
            figures: entry.studies.first().map_or_else(Vec::new, |s| s.figures.clone()),
            over_velocity: entry.over_velocity.clone(),
        })
    }

    /// A program whose motion alone was run: no gate was checked.
    fn motion_figures(&self, entry: &Entry) -> Option<ProgramFigures> {
        let summary = &entry.motion.as_ref()?.summary;
        let open =
            |gate| GateVerdict { gate, state: State::Unchecked, reason: "the scene compares motion alone".to_owned() };
        let stretch = self.stretch(entry);
        Some(ProgramFigures {
            gates: Gate::ALL.map(open).into(),
            digests: entry.digests.clone(),
            ..ProgramFigures::of_motion(self.folder(&entry.name), time_of(summary), self.made_figures(entry), stretch)
        })
    }

    /// Limits that the scene sets, once for every machine of the programs.
    fn joint_limits(&self) -> Vec<ChangedLimit> {
        let mut all: Vec<ChangedLimit> = Vec::new();
        for limit in self.entries.iter().flat_map(|e| &e.changed_limits) {
            if !all.contains(limit) {
                all.push(limit.clone());
            }
        }
        all
    }

    fn center_shift(&self, entry: &Entry, from: &str) -> Option<f64> {
        let source = self.entries.iter().find(|e| e.name == from)?;
        entry.ideal.as_ref()?.center_shift(source.ideal.as_ref()?)
    }

    pub(super) fn stretch(&self, entry: &Entry) -> Option<Stretch> {
        stretch_of(self.file.run_ends_s, &entry.case.machine, entry.motion.as_ref()?, entry.ideal.as_ref()?)
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
                let row = |d: &motion_only::DemandPoint| DemandRow {
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

/// Times of a motion without stock.
pub(super) fn time_of(summary: &proveout_controller::Summary) -> Time {
    Time {
        total_s: summary.total_s,
        cutting_s: summary.cutting_s,
        rapid_s: summary.rapid_s,
        dwell_s: summary.dwell_s,
        tool_change_s: summary.tool_change_s,
        lower_bound_s: summary.lower_bound_s,
        path_bound_s: summary.path_bound_s,
    }
}

/// What a motion is over its cutting stretch; `ideal` is the programmed path.
pub(super) fn stretch_of(ends: f64, machine: &Machine, motion: &Motion, ideal: &Motion) -> Option<Stretch> {
    let ranges = motion.stretch(ends);
    let blocks = ranges.iter().map(|r| r.len() as u64).sum();
    if blocks == 0 {
        return None;
    }
    let demand = ideal.demand(&ideal.stretch(ends));
    let largest = |of: &dyn Fn(&motion_only::DemandPoint) -> Option<f64>| {
        demand.iter().filter_map(of).map(f64::abs).reduce(f64::max)
    };
    let programmed_ranges = ideal.stretch(ends);
    let (travel, range) = (ideal.travel(&programmed_ranges), ideal.range(&programmed_ranges));
    let rotary = |values: &JointValues| {
        let squares = machine.rotary_joints().iter().map(|&j| values[j] * values[j]).sum::<f64>();
        deg(squares.sqrt())
    };
    let rotary = (!machine.rotary_joints().is_empty()).then(|| RotaryDemand {
        velocity: largest(&|d| Some(rotary(&d.velocity))),
        acceleration: largest(&|d| d.acceleration.as_ref().map(rotary)),
    });
    let joints = machine.joints.iter().zip(motion.extremes(&ranges)).enumerate();
    let axes = joints.map(|(j, (joint, Extremes { velocity, acceleration, jerk, reversals }))| {
        let factor = joint.kind.unit_factor();
        let axis = StretchAxis {
            unit: joint.kind.unit().into(),
            max_velocity: velocity * factor,
            max_acceleration: acceleration * factor,
            max_jerk: jerk * factor,
            reversals: reversals.into(),
            travel: travel[j] * factor,
            range: range[j] * factor,
            demand_velocity: largest(&|d| Some(d.velocity[j])).map(|v| v * factor),
            demand_acceleration: largest(&|d| d.acceleration.map(|a| a[j])).map(|a| a * factor),
        };
        (joint.name.clone(), axis)
    });
    let programmed = ranges.iter().flat_map(|r| motion.blocks[r.clone()].iter()).map(|b| b.programmed).sum();
    Some(Stretch {
        blocks,
        time_s: motion.stretch_time(&ranges),
        programmed_s: programmed,
        axes: axes.collect(),
        rotary,
        straight_joints_tip_um: ideal.straight_joints(machine, &programmed_ranges).map(|mm| UM_PER_MM * mm),
        from_turning: ideal.motion_from_turning(machine, &programmed_ranges),
        depth: depth_of(motion, &ranges),
    })
}

pub(super) fn windows(motion: &Motion, ends: f64, shown: Option<[f64; 2]>) -> Option<[[f64; 2]; 2]> {
    let ranges = motion.stretch(ends);
    let blocks: Vec<&motion_only::FeedBlock> = ranges.iter().flat_map(|r| motion.blocks[r.clone()].iter()).collect();
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

fn joints_of(machine: &Machine) -> Vec<JointPicture> {
    let joint = |j: &proveout_machine::Joint| {
        let (unit, factor) = (j.kind.unit(), j.kind.unit_factor());
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

/// Fail beats unchecked beats pass, over the programs (those that must pass, where the scene lists them), the
/// criteria, and the published values that the scene gives a band: a value without one is shown and not
/// judged.
pub(super) fn overall(comparison: &Comparison, must_pass: Option<&[String]>) -> State {
    let counts = |name: &String| must_pass.is_none_or(|names| names.contains(name));
    let programs = comparison.programs.iter().filter(|(name, _)| counts(name)).map(|(_, p)| p.verdict);
    let banded = comparison.published.iter().filter(|p| p.band.is_some()).map(|p| p.state);
    let states = programs.chain(comparison.expectations.iter().map(|e| e.state)).chain(banded);
    gates::overall(states)
}

const DEPTH_RULE: &str = "Depth of cut: allowance of the raw blade over the design, minus what the ball leaves \
                          (distance of its center from the nearest point of the closed form, minus its radius), at \
                          the end of every piece of the motion that cuts the part, weighted by the path of the tip. \
                          Deviation: standard deviation along a line about the line's own mean, the largest of the \
                          lines. A line is a run in feed. Motion from turning: motion of the linear joints that holds \
                          the tip while the rotary joints turn, per length of the tip path, largest over the blocks";

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
            "Demand: differences of joint positions between block ends, divided by the programmed times; the limits \
             of the joints are ignored. One step is one block of the program"
                .to_owned(),
        ),
        (
            "straight joints",
            "Tip from its chord: largest distance of the tip from the straight line between its positions at both \
             ends of a block of the stretch, at 39 places between them, with the joints interpolated linearly: the \
             error of a control without tool center point control"
                .to_owned(),
        ),
        (
            "rotary",
            "Demand of `rotary`: root of the sum of squares over the rotary joints, in degrees".to_owned(),
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
            "Deviation of this program minus that of the baseline, at the vertices of the baseline's cut part; each \
             is the mean of the exact points in the cells around the vertex"
                .to_owned(),
        ),
    ];
    rules.into_iter().map(|(name, words)| (name.to_owned(), words)).collect()
}
