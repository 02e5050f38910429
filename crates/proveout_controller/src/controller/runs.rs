//! Runs between two stops: blocks into the path, windows of the look-ahead, rapid motion of independent
//! joints.

use std::sync::Arc;

use proveout_machine::{JointValues, RapidMode};
use proveout_nc::Command;

use super::{Begin, Controller, bounds::WINDOW_SAMPLES, scope};
use crate::{
    emit::{PendingEntry, QueuedEntry},
    jerk_ramp::{Rates, peak_speed},
    output::{BlockKind, BlockRecord, MoveKind},
    path::{PathBlock, PathContext, RunPath},
    profile::Law,
    retime::LawEntry,
    shape::{BlockShape, DogLeg},
    stretch::{self, Outcome, PlanStretch},
};

/// A rotary joint that moves no farther than this counts as at rest, radian: rounding of the
/// inverse kinematics.
const STANDS: f64 = 1e-9;

/// The axes of the work coordinates where they are parallel to those of the table.
const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Part of a way along an axis of the program that another joint than its own may take: rounding.
const BESIDE: f64 = 1e-6;

/// Whether each axis of the work coordinates moves one linear joint and no other. With the rotary
/// joints at rest the joints are linear in the tip, so a move of 1 mm decides it.
fn axes_are_joints(frame: &PathContext<'_>, task: &JointValues, rotation: [[f64; 3]; 3]) -> bool {
    let Some(rig) = frame.kinematics.rig else { return true };
    let here = frame.kinematics.position(task);
    (0..3).all(|axis| {
        let mut there = *task;
        for (row, &slot) in rig.slots.iter().enumerate() {
            there[slot] += rotation[row][axis];
        }
        let way = frame.kinematics.position(&there) - here;
        let most = way.max_abs();
        rig.slots.iter().filter(|&&slot| way[slot].abs() > BESIDE * most).count() == 1
    })
}

/// Blocks without a way and events that may wait for the next motion.
const MOST_WAITING: usize = 10_000;

/// The record of a block without a way; its time is that at which it is released.
fn record_of(block: &PathBlock) -> BlockRecord {
    BlockRecord {
        index: block.index,
        file: block.file.clone(),
        line: block.line,
        start_time: 0.0,
        end_time: 0.0,
        length: 0.0,
        programmed_length: 0.0,
        feed: 0.0,
        coupled: false,
        programmed_end: None,
        kind: BlockKind::Move(block.kind),
    }
}

/// Time of a block at its feed, s.
fn time_of(block: &PathBlock) -> f64 {
    let time = block.length / block.feed;
    if time.is_finite() { time } else { 0.0 }
}

impl<E, I> Controller<'_, I>
where
    E: std::error::Error + 'static,
    I: Iterator<Item = Result<Command, E>>,
{
    pub(super) fn push_block(&mut self, mut block: PathBlock, from: JointValues) {
        if self.cut_short.is_some() {
            return;
        }
        if block.length <= 0.0 {
            // No way to go: a record without time, in its place in the order of blocks. In continuous-path
            // mode it is no stop.
            if block.corner.is_none() || self.out.waiting.len() >= MOST_WAITING {
                self.stop_run();
                self.record(block.index, &block.file, block.line, BlockKind::Move(block.kind), self.out.clock);
            } else {
                let before = self.path.first_block + self.path.blocks.len() as u64;
                let record = record_of(&block);
                self.out.waiting.push_back(QueuedEntry { before, what: PendingEntry::Record(Box::new(record)) });
            }
            return;
        }
        let independent = self.device.machine.control.rapid_mode == RapidMode::IndependentJoints
            && block.kind != MoveKind::Feed
            && self.in_joints(&mut block, &from);
        let time = time_of(&block);
        let frame = self.device.frame(self.mapping);
        self.out.meter.tube.block(&frame, &block);
        if independent {
            self.stop_run();
            if self.cut_short.is_none() {
                self.independent(block, from);
            }
            return;
        }
        let frame = self.device.frame(self.mapping);
        let block_copy = if self.path.is_empty() { None } else { Some(block.clone()) };
        if !self.path.push(&frame, block) {
            self.stop_run();
            if let Some(block) = block_copy.filter(|_| self.cut_short.is_none()) {
                let frame = self.device.frame(self.mapping);
                self.path.push(&frame, block);
            }
        }
        self.window_time.0 += time;
        if self.path.blocks.len() >= self.window || self.window_time.0 > self.window_time.1 {
            self.commit_window();
        }
    }

    /// Time of the known part of a run at which it is planned, whatever the number of its blocks, s.
    fn most_time(&self) -> f64 {
        WINDOW_SAMPLES * self.out.cycle
    }

    /// Plans and emits the whole run; the machine is then at rest.
    pub(super) fn stop_run(&mut self) {
        let frame = self.device.frame(self.mapping);
        self.path.finish(&frame);
        if !self.path.cells.is_empty() && !self.commit(true, false) {
            self.halt();
            if !self.path.cells.is_empty() {
                self.commit(true, false);
            }
        }
        let number = self.path.first_block + self.path.blocks.len() as u64;
        self.out.meter.rest();
        self.path = RunPath::starting_with(number);
        self.begin = Begin::default();
        self.window = self.settings.look_ahead_blocks;
        self.window_time = (0.0, self.most_time());
        self.out.release(number, self.out.clock);
    }

    /// Plans the known part of a long run and emits what the unknown part cannot change.
    pub(super) fn commit_window(&mut self) {
        if !self.commit(false, true) {
            self.halt();
        }
    }

    /// Plans and emits up to the end of the known path, or to a node before it; `open` says whether
    /// the path goes on there. Returns false if no law was found that keeps the limits; from rest
    /// to rest one is always found.
    pub(super) fn commit(&mut self, finish: bool, open: bool) -> bool {
        let frame = self.device.frame(self.mapping);
        let grid = self.out.grid();
        let begin = (&self.begin.entry, &mut self.stages);
        match stretch::plan(&mut self.path, &frame, grid, self.begin.speed, begin, finish) {
            Outcome::Planned(stretch) => self.emit(*stretch, open),
            // Tried again when there is more to see, so that the cost stays linear.
            Outcome::NotYet => {
                self.window = self.path.blocks.len() + self.path.blocks.len() / 4 + 1;
                self.window_time.1 = self.window_time.0 * 1.25;
            }
            Outcome::TooLong(time, at) => self.ends_on_the_way(time, at),
            Outcome::Failed => return false,
        }
        true
    }

    /// Brings the machine to rest where no law was found from here on: by the reserve of the
    /// previous stretch, or, if it is at rest, by running the whole known path from rest to rest.
    pub(super) fn halt(&mut self) {
        let (frame, grid) = (self.device.frame(self.mapping), self.out.grid());
        match self.begin.reserve.take() {
            Some(reserve) => {
                let stretch = reserve.stretch(&self.path, &frame, grid);
                self.emit(stretch, true);
            }
            None => {
                self.commit(true, true);
            }
        }
        self.begin.halted = true;
    }

    /// Emits a stretch; the path goes on after it.
    pub(super) fn emit(&mut self, stretch: PlanStretch, open: bool) {
        let scope = scope(&self.device, &self.settings, self.mapping);
        // A halt is the plan's, not the path's: the lower bound does not count it.
        self.out.stretch(&scope, &self.path, &stretch, [self.begin.speed > 0.0 || self.begin.halted, open]);
        self.path.drop_before(stretch.s_end, stretch.cells);
        self.begin = Begin { speed: stretch.v_end, entry: stretch.entry, reserve: stretch.reserve, halted: false };
        self.window = self.settings.look_ahead_blocks;
        self.window_time = (self.path.blocks.iter().map(time_of).sum(), self.most_time());
        self.ready = true;
    }

    /// Makes a straight motion one of the joints, where it is or may be: without tool center point control,
    /// and on a plane whose axes are those of the machine while no rotary joint turns. Elsewhere a coordinate
    /// of the program takes several joints, which must keep the tip on its line.
    fn in_joints(&mut self, block: &mut PathBlock, from: &JointValues) -> bool {
        if self.mapping.tcp_length.is_none() {
            return true;
        }
        let frame = self.device.frame(self.mapping);
        let to = frame.kinematics.position(&block.shape.jet(block.length).0[0]);
        let way = to - *from;
        let rotation = self.state.frame.map_or(UPRIGHT, |(rotation, _)| rotation);
        if !axes_are_joints(&frame, &block.shape.jet(0.0).0[0], rotation) {
            return false;
        }
        if self.device.machine.rotary_joints().iter().any(|&joint| way[joint].abs() > STANDS) || !way.is_finite() {
            return false;
        }
        self.stop_run();
        let frame = self.device.frame(self.mapping);
        self.out.meter.tube.remap(&frame);
        self.mapping = self.mapping_with(None);
        block.shape = BlockShape::Line { from: *from, slope: way * (1.0 / block.length) };
        true
    }

    /// A rapid motion with every joint at its own speed.
    pub(super) fn independent(&mut self, mut block: PathBlock, from: JointValues) {
        let to = block.shape.jet(block.length).0[0];
        let l = &self.device.limits;
        let mut joints = Vec::new();
        let mut duration = 0.0_f64;
        for i in 0..l.count {
            let distance = (to[i] - from[i]).abs();
            if distance > 0.0 {
                let rates = Rates { acceleration: l.acceleration[i], jerk: l.jerk[i] };
                let fastest = l.rapid[i].min(crate::limits::UNLIMITED_SPEED);
                let peak = peak_speed(0.0, 0.0, distance, fastest, rates, rates);
                let mut law = Law::default();
                law.push_move([0.0, distance], [0.0, peak, 0.0], rates, rates);
                duration = duration.max(law.duration);
                joints.push((i, (to[i] - from[i]).signum(), law));
            }
        }
        let length = block.length;
        // The program says where the joints end, not how they come there.
        block.told = None;
        let counts = |i: &usize| self.device.machine.joints[*i].is_rotary() != block.tip_moves;
        let per = if block.tip_moves { 1.0 } else { 1.0_f64.to_degrees() };
        let counted = (0..l.count).filter(counts).map(|i| (i, per)).collect();
        block.shape = BlockShape::Timed(Box::new(DogLeg { from, joints, counted }));
        block.length = duration;
        let number = self.path.first_block;
        self.path = RunPath::single(number, block);
        let frame = self.device.frame(self.mapping);
        let law = Law::uniform(0.0, duration);
        if self.out.grid().takes_too_many(&law) {
            return self.ends_on_the_way(duration, 0.0);
        }
        let samples = stretch::measure(&self.path, &frame, self.out.grid(), &law, 0);
        let s = PlanStretch {
            law,
            cells: 0,
            s_end: duration,
            v_end: 0.0,
            entry: LawEntry::default(),
            samples,
            reserve: None,
        };
        let scope = scope(&self.device, &self.settings, self.mapping);
        self.out.stretch(&scope, &self.path, &s, [false, false]);
        if let Some(record) = self.out.chunk.blocks.last_mut() {
            record.programmed_length = length;
        }
        self.out.meter.rest();
        self.path = RunPath::starting_with(number + 1);
        self.ready = true;
    }

    pub(super) fn record(&mut self, index: u32, file: &Arc<str>, line: u32, kind: BlockKind, start_time: f64) {
        self.out.meter.summary.blocks += 1;
        self.out.chunk.blocks.push(BlockRecord {
            index,
            file: file.clone(),
            line,
            start_time,
            end_time: self.out.clock,
            length: 0.0,
            programmed_length: 0.0,
            feed: 0.0,
            coupled: false,
            programmed_end: None,
            kind,
        });
    }
}
