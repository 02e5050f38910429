//! The stream of the planned run turned into the actual one.
//!
//! ```text
//!   planned chunk ──► set points ──► drives and plant, cycle by cycle ──► trail of the actual motion
//!        │                                                                     │
//!        └──► blocks, events, spans of motion: wait until the trail has ───────┴──► chunk
//!             come that far
//! ```
//!
//! A chunk has samples with actual joints, pieces along the trail, and events.
//!
//! The trail ends at the last control sample, so anything later waits for the next chunk; memory
//! holds one chunk. Set points between samples are the cubic with positions and velocities of both,
//! as a drive's fine interpolator makes it. While the set point does not move, the drives go on
//! until they rest; that motion belongs to the block under way.

use std::collections::VecDeque;

use proveout_geom::ToolPose;
use proveout_machine::{JointValues, MAX_JOINTS, Machine, PlatformError};
use proveout_nc::Location;
use proveout_tool::Tool;

use super::{
    contour::Contour,
    legs::Motion,
    plant_run::Bank,
    step::SetPointRates,
    trail::{ServoKnot, SpanOf, Trail, cubic_bound},
};
use crate::{
    error::ControlError,
    output::{BlockRecord, Chunk, DriveSample, Event, LimitKind, MoveKind, Sample},
    settings::Settings,
    summary::{DriveUse, LoadTrust, Summary},
};

/// Drives that have not come to rest within this time of standstill (s) go on; the others are taken as
/// resting. Ten time constants of a slow position loop (Kv 20/s).
const SETTLING: f64 = 0.5;
/// Velocities below this (mm/s, rad/s) count as rest.
const RESTS: f64 = 1e-8;
/// Longest time (s) after the program's end in which the machine may come to rest.
const LAST_SETTLING: f64 = 1.0;
/// Farthest that a rotary joint can move a tool for a radian, mm: a crude bound used while it is good enough.
const FARTHEST: f64 = 4000.0;
/// N mm/s make W.
const TO_WATT: f64 = 1e-3;

/// A stretch of planned motion of one block.
#[derive(Clone, Copy, Debug)]
struct BlockSpan {
    time: [f64; 2],
    block: u32,
    kind: MoveKind,
}

/// Worst saturation of a drive in the block under way.
#[derive(Clone, Copy, Debug)]
struct WorstSaturation {
    time: f64,
    block: u32,
    demand: f64,
}

/// The servo stage of a run.
#[derive(Debug)]
pub(crate) struct ServoStage<'m> {
    machine: &'m Machine,
    tools: &'m [Tool],
    settings: Settings,
    cycle: f64,
    bank: Bank,
    trail: Trail,
    last: Option<Sample>,
    loads: JointValues,
    /// Positions and velocities of the joints, and of the drives where legs replace joints.
    actual: Motion,
    driven: Motion,
    /// Work drawn at the joints of platforms, J, and the power (W) at the last sample.
    of_platforms: [JointValues; 2],
    /// Pose of the tool at the last knot.
    pose: ToolPose,
    spans: VecDeque<BlockSpan>,
    blocks: VecDeque<BlockRecord>,
    events: VecDeque<Event>,
    lengths: VecDeque<(f64, f64)>,
    tool_length: f64,
    sample_length: f64,
    sample_lengths: VecDeque<(f64, f64)>,
    /// Pieces are out up to here, s.
    done: f64,
    kind: MoveKind,
    block: u32,
    saturated: [Option<WorstSaturation>; MAX_JOINTS],
    uses: [DriveUse; MAX_JOINTS],
    low: JointValues,
    high: JointValues,
    contour: Contour,
    chord: f64,
}

impl<'m> ServoStage<'m> {
    /// Drives at rest at home.
    pub(crate) fn new(
        machine: &'m Machine,
        tools: &'m [Tool],
        settings: &Settings,
        cycle: f64,
    ) -> Result<Self, Box<ControlError>> {
        let bank = Bank::new(machine, cycle, settings.plant)?;
        let home = machine.home();
        let loads = bank.loads(&home, &JointValues::ZERO, &JointValues::ZERO);
        let driven = bank.legs.of_joints(&home, &JointValues::ZERO);
        Ok(Self {
            machine,
            tools,
            settings: settings.clone(),
            cycle,
            bank,
            trail: Trail::default(),
            last: None,
            loads,
            actual: [home, JointValues::ZERO],
            driven,
            of_platforms: [JointValues::ZERO; 2],
            pose: machine.actual_forward(&home, 0.0),
            spans: VecDeque::new(),
            blocks: VecDeque::new(),
            events: VecDeque::new(),
            lengths: VecDeque::new(),
            tool_length: 0.0,
            sample_length: 0.0,
            sample_lengths: VecDeque::new(),
            done: 0.0,
            kind: MoveKind::Rapid,
            block: 0,
            saturated: [None; MAX_JOINTS],
            uses: [DriveUse::default(); MAX_JOINTS],
            low: home,
            high: home,
            contour: Contour::default(),
            chord: 0.0,
        })
    }

    /// Follows a planned chunk; `end` marks the last one of the run.
    pub(crate) fn follow(&mut self, mut chunk: Chunk, end: bool) -> Result<Chunk, Box<ControlError>> {
        self.take_in(&mut chunk);
        let mut samples = std::mem::take(&mut chunk.samples);
        for sample in &mut samples {
            self.sample(sample)?;
        }
        let mut out = Chunk { samples, ..Chunk::default() };
        if end {
            self.come_to_rest()?;
            let until = self.trail_end();
            self.pieces(until, &mut out);
            for j in 0..MAX_JOINTS {
                self.close(j);
            }
            out.blocks.extend(self.blocks.drain(..));
            out.events.extend(self.events.drain(..));
        } else {
            let until = self.trail_end();
            self.pieces(until, &mut out);
            while self.blocks.front().is_some_and(|b| b.end_time <= self.done) {
                out.blocks.extend(self.blocks.pop_front());
            }
            let done = self.done;
            let (now, later): (Vec<Event>, Vec<Event>) = self.events.drain(..).partition(|e| e.time() <= done);
            self.events = later.into();
            out.events = now;
        }
        out.events.sort_by(|a, b| a.time().total_cmp(&b.time()));
        Ok(out)
    }

    /// Writes what the drives did into the summary.
    pub(crate) fn complete(&self, summary: &mut Summary) {
        for (j, joint) in summary.joints.iter_mut().enumerate().take(self.bank.models.len()) {
            let mut used = self.uses[j];
            if self.bank.legs.leg(j).is_some() {
                used.energy = self.of_platforms[0][j];
            } else {
                used.energy = self.bank.states[j].energy();
                used.force_utilisation = self.bank.models[j].max_force().map(|f| used.max_force / f);
            }
            joint.drive = Some(used);
            joint.min = joint.min.min(self.low[j]);
            joint.max = joint.max.max(self.high[j]);
        }
        summary.max_chord_error_mm = self.chord;
        summary.max_servo_contour_error_mm = Some(self.contour.worst);
        summary.max_contour_error_mm += self.contour.worst;
        summary.max_axis_error += self.contour.worst_axis;
        let joint = |j: usize| self.machine.joints.get(j).map_or_else(String::new, |joint| joint.name.clone());
        let name = |j: usize| self.bank.legs.names(j).unwrap_or_else(|| joint(j));
        let report = self.bank.tree.report();
        let unlimited = self.bank.models.iter().enumerate().filter(|(_, m)| m.max_force().is_none());
        summary.loads = Some(LoadTrust {
            estimated: report.estimated.clone(),
            unknown: report.unknown.iter().map(|(j, reason)| (joint(*j), reason.clone())).collect(),
            no_force_limit: unlimited.map(|(j, _)| name(j)).collect(),
        });
    }

    /// Spans, blocks and events of a planned chunk join those that wait.
    fn take_in(&mut self, chunk: &mut Chunk) {
        for piece in chunk.pieces.drain(..) {
            match self.spans.back_mut() {
                Some(s) if s.block == piece.block && s.kind == piece.kind && s.time[1] == piece.time[0] => {
                    s.time[1] = piece.time[1];
                }
                _ => self.spans.push_back(BlockSpan { time: piece.time, block: piece.block, kind: piece.kind }),
            }
        }
        self.blocks.extend(chunk.blocks.drain(..));
        for event in chunk.events.drain(..) {
            if let Event::ToolChange { time, tool, .. } = &event {
                let length = tool.and_then(|t| self.tools.get(t)).map_or(0.0, |t| t.gauge_length);
                self.lengths.push_back((*time, length));
                self.sample_lengths.push_back((*time, length));
            }
            self.events.push_back(event);
        }
    }

    fn trail_end(&self) -> f64 {
        self.last.map_or(self.done, |s| s.time)
    }

    /// Brings the drives to the time of a planned sample and fills in what they do.
    fn sample(&mut self, sample: &mut Sample) -> Result<(), Box<ControlError>> {
        let planned = [&sample.commanded, &sample.velocity, &sample.acceleration];
        if !(sample.time.is_finite() && planned.iter().all(|v| v.is_finite())) {
            return Err(self.not_a_number("the set point is not a number", sample.block));
        }
        while self.sample_lengths.front().is_some_and(|(t, _)| *t <= sample.time) {
            if let Some((_, length)) = self.sample_lengths.pop_front() {
                self.sample_length = length;
                self.contour.restart();
            }
        }
        match self.last {
            None => {
                self.states_at(&sample.commanded, sample.block)?;
                self.push_knot(sample.time, sample.block, 0.0, JointValues::ZERO);
            }
            Some(last) => self.run_to(&last, sample)?,
        }
        sample.actual = self.actual[0];
        // Both with the machine's geometric errors: what is measured here is what the drives add.
        let planned = self.machine.actual_forward(&sample.commanded, self.sample_length);
        sample.pose = self.pose;
        // A rapid leaves its line by the lag of its joints, and cuts nothing: collision and removal follow
        // the actual motion.
        let counts = sample.kind == MoveKind::Feed;
        self.contour.push(planned, &sample.pose, self.sample_length, counts);
        let gap = self.last.map_or(0.0, |last| sample.time - last.time);
        sample.drive = Some(self.drives(sample, gap));
        self.last = Some(*sample);
        Ok(())
    }

    /// What the drives do at a sample, a time `gap` after the last one; of a platform's joints what its legs
    /// do to them.
    fn drives(&mut self, sample: &Sample, gap: f64) -> DriveSample {
        let mut d = DriveSample { velocity: self.actual[1], ..DriveSample::default() };
        let mut most = JointValues::ZERO;
        for (j, (model, s)) in self.bank.models.iter().zip(&self.bank.states).enumerate() {
            (d.force[j], d.power[j], d.energy[j]) = (model.force(s), s.power(), s.energy());
            most[j] = model.max_force().map_or(0.0, |f| d.force[j].abs() / f);
        }
        d.force = self.bank.legs.joint_forces(&d.force, &self.actual[0]);
        for j in 0..self.bank.models.len() {
            let used = &mut self.uses[j];
            if let Some((platform, _)) = self.bank.legs.leg(j) {
                let power = d.force[j] * self.actual[1][j] * TO_WATT;
                let [energy, before] = &mut self.of_platforms;
                energy[j] += (0.5 * (power + before[j])).max(0.0) * gap;
                before[j] = power;
                (d.power[j], d.energy[j]) = (power, energy[j]);
                if platform.legs.iter().all(|leg| leg.drive.as_ref().is_some_and(|d| d.max_force.is_some())) {
                    let worst = most[platform.heave].max(most[platform.tilt]);
                    used.force_utilisation = Some(used.force_utilisation.unwrap_or(0.0).max(worst));
                }
            }
            used.max_following_error = used.max_following_error.max((sample.actual[j] - sample.commanded[j]).abs());
            used.max_force = used.max_force.max(d.force[j].abs());
            used.max_power = used.max_power.max(d.power[j].abs());
        }
        self.low = self.low.zip_map(sample.actual, f64::min);
        self.high = self.high.zip_map(sample.actual, f64::max);
        d
    }

    /// Runs the drives from one planned sample to the next.
    fn run_to(&mut self, last: &Sample, next: &Sample) -> Result<(), Box<ControlError>> {
        let gap = next.time - last.time;
        let cycles = (gap / self.cycle).round().max(1.0);
        if cycles <= 1.0 {
            let loads = self.bank.loads(&next.commanded, &next.velocity, &next.acceleration);
            let mean = (self.loads + loads) * 0.5;
            self.loads = loads;
            let references = std::array::from_fn(self.bank.legs.references(last, next, gap));
            return self.cycle(&last.commanded, &references, &mean, next);
        }
        // A standstill: only its first and last sample are there.
        let hold = Sample { velocity: JointValues::ZERO, acceleration: JointValues::ZERO, ..*last };
        let loads = self.bank.loads(&last.commanded, &JointValues::ZERO, &JointValues::ZERO);
        let mut k = 1.0;
        while k < cycles {
            let now = Sample { time: last.time + k * self.cycle, block: next.block, ..hold };
            self.cycle(&last.commanded, &[SetPointRates::default(); MAX_JOINTS], &loads, &now)?;
            k += 1.0;
            if k * self.cycle > SETTLING && self.rests() {
                break;
            }
        }
        // Drives at rest stay there: the trail goes on to the cycle before the next sample.
        let before = next.time - self.cycle;
        if last.time + (k - 0.5) * self.cycle < before {
            self.push_knot(before, next.block, 0.0, JointValues::ZERO);
        }
        let now = Sample { commanded: next.commanded, time: next.time, block: next.block, ..hold };
        let references = std::array::from_fn(self.bank.legs.references(&hold, &now, self.cycle));
        self.loads = self.bank.loads(&next.commanded, &next.velocity, &next.acceleration);
        self.cycle(&last.commanded, &references, &loads, &now)
    }

    fn rests(&self) -> bool {
        self.bank.states.iter().all(|s| s.velocity().abs() <= RESTS && s.motor_velocity().abs() <= RESTS)
    }

    fn come_to_rest(&mut self) -> Result<(), Box<ControlError>> {
        let Some(last) = self.last else { return Ok(()) };
        let loads = self.bank.loads(&last.commanded, &JointValues::ZERO, &JointValues::ZERO);
        let zero = JointValues::ZERO;
        let mut now = Sample { velocity: zero, acceleration: zero, ..last };
        while now.time - last.time < LAST_SETTLING && !self.rests() {
            now.time += self.cycle;
            self.cycle(&last.commanded, &[SetPointRates::default(); MAX_JOINTS], &loads, &now)?;
        }
        self.last = Some(now);
        Ok(())
    }

    /// One control cycle that ends at the set point `to`.
    fn cycle(
        &mut self,
        begin: &JointValues,
        references: &[SetPointRates; MAX_JOINTS],
        loads: &JointValues,
        to: &Sample,
    ) -> Result<(), Box<ControlError>> {
        self.bank.cycle(begin, references, loads);
        let (before, driven_before) = (self.actual, self.driven);
        self.states_at(&to.commanded, to.block)?;
        if !(self.actual[0].is_finite() && self.bank.states.iter().all(|s| s.is_finite())) {
            return Err(self.not_a_number("the drives ran away to positions that are not numbers", to.block));
        }
        let mut bounds = JointValues::ZERO;
        for j in 0..self.bank.states.len() {
            let s = &mut self.bank.states[j];
            let (way, extremes) = (self.driven[0][j] - driven_before[0][j], s.take_accelerations());
            bounds[j] = cubic_bound(self.cycle, way, [driven_before[1][j], self.driven[1][j]], extremes);
            let excess = s.take_excess();
            if excess != 0.0 {
                let demand = self.bank.models[j].to_newton(excess);
                self.saturation(j, demand, to);
            }
        }
        let driven = [&driven_before, &self.driven];
        let bounds = self.bank.legs.joint_bounds(&bounds, self.cycle, driven, [&before, &self.actual]);
        let bounds = bounds.map_err(|e| self.open_legs(&e, to.block))?;
        let farthest = |j: usize| if self.machine.joints[j].is_rotary() { FARTHEST } else { 1.0 };
        let mut bound: f64 = (0..self.bank.states.len()).map(|j| bounds[j] * farthest(j)).sum();
        // The crude bound is enough while it is small against the pieces' tolerance.
        if bound > 0.1 * self.settings.piece_tolerance {
            let jacobian = self.machine.jacobian(&self.actual[0], self.sample_length);
            let column = |j: usize| {
                let c = jacobian.column(j);
                c.fixed_rows::<3>(0).norm() + self.sample_length * c.fixed_rows::<3>(3).norm()
            };
            bound = (0..self.bank.models.len()).map(|j| bounds[j] * column(j)).sum();
        }
        self.push_knot(to.time, to.block, bound, bounds);
        Ok(())
    }

    /// Loads' positions and velocities from the set point and the states.
    fn states_at(&mut self, set: &JointValues, block: u32) -> Result<(), Box<ControlError>> {
        let set = self.bank.legs.of_joints(set, &JointValues::ZERO)[0];
        for (j, s) in self.bank.states.iter().enumerate() {
            self.driven[0][j] = set[j] - s.error();
            self.driven[1][j] = s.velocity();
        }
        let joints = self.bank.legs.to_joints(&self.driven, &self.actual[0]);
        self.actual = joints.map_err(|e| self.open_legs(&e, block))?;
        Ok(())
    }

    fn open_legs(&self, fault: &PlatformError, block: u32) -> Box<ControlError> {
        self.not_a_number(
            &format!("the drives bring the legs of a platform to lengths that have no pose: {fault}"),
            block,
        )
    }

    fn push_knot(&mut self, time: f64, block: u32, bound: f64, joint_bound: JointValues) {
        self.pose = self.machine.actual_forward(&self.actual[0], self.sample_length);
        let (tool_length, pose) = (self.sample_length, self.pose);
        let [q, v] = [self.actual[0], self.actual[1]];
        self.trail.push(ServoKnot { time, q, v, block, bound, joint_bound, tool_length, pose });
    }

    fn saturation(&mut self, joint: usize, demand: f64, at: &Sample) {
        if self.saturated[joint].is_some_and(|s| s.block != at.block) {
            self.close(joint);
        }
        let worst = self.saturated[joint].get_or_insert(WorstSaturation { time: at.time, block: at.block, demand });
        if demand.abs() > worst.demand.abs() {
            (worst.time, worst.demand) = (at.time, demand);
        }
        // The demand of a step counts where it is largest; the first sample of the cycle names the block.
    }

    /// The saturation of a joint in its block becomes an event.
    fn close(&mut self, joint: usize) {
        let Some(s) = self.saturated[joint].take() else { return };
        let limit = self.bank.models[joint].max_force().unwrap_or(f64::INFINITY);
        self.events.push_back(Event::Limit {
            time: s.time,
            block: s.block,
            joint: Some(joint),
            value: s.demand,
            limit: limit.copysign(s.demand),
            kind: LimitKind::DriveForce,
        });
    }

    /// Pieces along the trail up to a time.
    fn pieces(&mut self, until: f64, out: &mut Chunk) {
        while self.done < until {
            while self.lengths.front().is_some_and(|(t, _)| *t <= self.done) {
                if let Some((_, length)) = self.lengths.pop_front() {
                    self.tool_length = length;
                }
            }
            let mut end = until;
            if let Some((t, _)) = self.lengths.front() {
                end = end.min(*t);
            }
            let span = self.spans.front().copied();
            match span {
                Some(s) if s.time[1] <= self.done => {
                    self.spans.pop_front();
                    continue;
                }
                Some(s) if s.time[0] <= self.done => {
                    (self.block, self.kind) = (s.block, s.kind);
                    end = end.min(s.time[1]);
                }
                other => {
                    let mut block = self.trail.block_after(self.done).unwrap_or(self.block).max(self.block);
                    if let Some(s) = other {
                        end = end.min(s.time[0]);
                        block = block.min(s.block);
                    }
                    self.block = block;
                }
            }
            let of = SpanOf {
                machine: self.machine,
                settings: &self.settings,
                tool_length: self.tool_length,
                block: self.block,
                kind: self.kind,
            };
            let (chord, pieces) = (&mut self.chord, &mut out.pieces);
            self.trail.cut(self.done, end, of, &mut |piece| {
                *chord = chord.max(piece.deviation);
                pieces.push(piece);
            });
            self.done = end;
        }
        self.trail.forget(self.done);
    }

    fn not_a_number(&self, what: &str, block: u32) -> Box<ControlError> {
        let place = self.blocks.iter().find(|b| b.index == block);
        Box::new(ControlError {
            code: "control-not-a-number",
            message: format!("block {block}: {what}"),
            location: place.map(|b| Location { file: b.file.clone(), line: b.line, column: 1, length: 1, depth: 0 }),
            help: Some("check the programmed values, the limits and the drives of the machine".to_owned()),
        })
    }
}
