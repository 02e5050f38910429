//! Turns planned stretches into pieces, samples, events and block records.

use std::collections::VecDeque;

use proveout_geom::ToolPose;
use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::{
    limits::{CellLimits, JointLimits, bound_time},
    mapping::ActiveKinematics,
    meter::Meter,
    output::{BlockKind, BlockRecord, Chunk, Event, LimitKind, MoveKind, Piece, Sample},
    path::{PathBlock, PathCursor, RunPath, reaches},
    pieces::{JointPose, PieceCutter},
    profile::{Cursor, Law},
    settings::{Dynamics, Settings},
    straightness::{self, Straightness},
    stretch::{Clock, PlanSample, PlanStretch, grid_number},
    watch::{LimitReciprocals, REACH, broken},
};

/// Rounding of places on the path, part of the block.
const ROUNDING: f64 = 1e-9;

/// An entry to be emitted before the block `before`.
pub(crate) struct QueuedEntry {
    /// Running number of the path block.
    pub(crate) before: u64,
    pub(crate) what: PendingEntry,
}

/// An event, or the record of a block without a way.
pub(crate) enum PendingEntry {
    Event(Event),
    Record(Box<BlockRecord>),
}

/// Worst over-travel of a joint in the block under way.
#[derive(Clone, Copy, Debug)]
struct OverTravel {
    time: f64,
    value: f64,
    limit: f64,
}

/// Collects the output and keeps what reaches over the border of two chunks.
pub(crate) struct Emitter {
    pub(crate) chunk: Chunk,
    pub(crate) meter: Meter,
    pub(crate) clock: f64,
    pub(crate) cycle: f64,
    /// Way on the path that was run so far.
    pub(crate) way: f64,
    /// That of the block under way.
    block_way: f64,
    pub(crate) waiting: VecDeque<QueuedEntry>,
    /// Start of the block under way, when it began in an earlier stretch.
    block_start: Option<f64>,
    /// Highest steady speed that joints allow in the block under way, and the joint that limits.
    steady: Option<(f64, Option<usize>)>,
    over_travel: [Option<OverTravel>; MAX_JOINTS],
    /// Set points at the last times of the grid, whether emitted or left out of a standstill.
    before: [JointValues; REACH],
    limits: JointLimits,
    parts: LimitReciprocals,
    /// Worst excess of the set points over a limit of a joint in the block under way, with its time and what
    /// it is.
    broken: Option<(f64, (usize, usize, f64, f64))>,
}

/// What does not change while a stretch is emitted.
#[derive(Clone, Copy)]
pub(crate) struct Scope<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) settings: &'a Settings,
    pub(crate) kinematics: ActiveKinematics<'a>,
}

impl Emitter {
    pub(crate) fn new(cycle: f64, start: &JointValues, limits: JointLimits) -> Self {
        Self {
            chunk: Chunk::default(),
            meter: Meter::new(start),
            clock: 0.0,
            cycle,
            way: 0.0,
            block_way: 0.0,
            waiting: VecDeque::new(),
            block_start: None,
            steady: None,
            over_travel: [None; MAX_JOINTS],
            before: [*start; REACH],
            limits,
            parts: LimitReciprocals::new(&limits),
            broken: None,
        }
    }

    pub(crate) fn grid(&self) -> Clock {
        Clock { cycle: self.cycle, start: self.clock, before: self.before }
    }

    /// Emits a stretch that begins at the path's `s_begin` at the present time; `open` says whether
    /// it begins and ends in motion.
    pub(crate) fn stretch(&mut self, scope: &Scope<'_>, path: &RunPath, stretch: &PlanStretch, open: [bool; 2]) {
        let start = self.clock;
        let bounds: Vec<CellLimits> = path.cells[..stretch.cells].iter().map(|c| c.limits).collect();
        self.meter.bound_s += if bounds.is_empty() { stretch.law.duration } else { bound_time(&bounds, open) };
        self.meter.summary.planned_contour_error_mm =
            self.meter.summary.planned_contour_error_mm.max(path.max_rounding);
        if scope.settings.dynamics != Dynamics::Ideal {
            self.meter.summary.max_contour_error_mm = self.meter.summary.max_contour_error_mm.max(path.max_rounding);
        }
        self.samples(scope, path, &stretch.samples);
        let mut phase = Cursor::default();
        let mut cell = 0;
        let (mut walk, mut at) = (PathCursor::default(), 0);
        for (k, block) in path.blocks.iter().enumerate() {
            if block.s0 >= stretch.s_end && stretch.s_end > path.s_begin {
                break;
            }
            let number = path.first_block + k as u64;
            let (a, b) = (block.s0.max(path.s_begin), block.end().min(stretch.s_end));
            let way = path.way(scope.machine, [a, b], &mut at);
            self.way += way;
            self.block_way += way;
            let t0 = start + stretch.law.time_at(a, &mut phase);
            let begin = *self.block_start.get_or_insert(t0);
            self.release(number, begin);
            while cell < stretch.cells && path.cells[cell].block <= number {
                let c = &path.cells[cell];
                let better = self.steady.is_none_or(|(v, _)| c.limits.steady > v);
                if better && c.exact {
                    self.steady = Some((c.limits.steady, c.limits.steady_joint));
                }
                if c.s1 > block.end() {
                    break; // the cell goes on in the next block
                }
                cell += 1;
            }
            let t1 = if scope.settings.dynamics == Dynamics::Servo {
                self.span(scope, path, block, stretch, [a, b], start, (&mut phase, &mut walk))
            } else {
                self.pieces(scope, path, block, &stretch.law, [a, b], start, (&mut phase, &mut walk))
            };
            self.meter.motion(block.kind, t1 - t0);
            if reaches(stretch.s_end, block.end()) {
                self.end_block(scope, block, b, [begin, t1]);
            }
        }
        self.clock = start + stretch.law.duration;
    }

    fn samples(&mut self, scope: &Scope<'_>, path: &RunPath, samples: &[PlanSample]) {
        let (mut at, mut span) = (0, 0);
        let (mut way, mut from) = (self.way, path.s_begin);
        // Some room for the samples of following standstills, so that one more sample does not move
        // all of them.
        self.chunk.samples.reserve(samples.len() + samples.len() / 16 + 8);
        for m in samples {
            let block = &path.blocks[path.block_at(m.state.s, &mut at)];
            if m.state.s > from {
                way += path.way(scope.machine, [from, m.state.s], &mut span);
                from = m.state.s;
            }
            let actual = match scope.settings.dynamics {
                Dynamics::Planned | Dynamics::Servo => m.q,
                Dynamics::Ideal => programmed(scope, block, m.state.s),
            };
            let sample = Sample {
                time: m.time,
                block: block.index,
                path_length: way,
                commanded: m.q,
                velocity: m.velocity,
                acceleration: m.acceleration,
                jerk: m.jerk,
                actual,
                pose: scope.kinematics.pose(&actual),
                feed_programmed: block.feed_programmed,
                feed: m.state.v * m.rate[usize::from(!block.tip_moves)],
                kind: block.kind,
                drive: None,
            };
            self.meter.sample(&sample);
            if sample.kind != MoveKind::Feed || path.changes_kind(m.state.s, &mut span) {
                self.meter.rest();
            } else {
                self.meter.feed(sample.feed, sample.feed_programmed);
            }
            self.chunk.samples.push(sample);
            self.judge(m);
            self.set_point(&m.q, 1.0);
        }
    }

    /// Keeps the worst excess over a limit. The plan should leave none; any limit that it fails to
    /// keep must be reported.
    fn judge(&mut self, m: &PlanSample) {
        let Some(found) = broken((&self.limits, &self.parts), self.cycle, &self.before, m) else { return };
        let part = |b: &(usize, usize, f64, f64)| b.2 / b.3;
        if self.broken.is_none_or(|(_, worst)| part(&found) > part(&worst)) {
            self.broken = Some((m.time, found));
        }
    }

    /// Takes note of a set point that holds at some times of the grid.
    fn set_point(&mut self, q: &JointValues, times: f64) {
        for _ in 0..times.clamp(0.0, REACH as f64) as usize {
            self.before = [self.before[1], self.before[2], *q];
        }
    }

    /// Pieces of a block over a range of the path parameter; returns the time of its end.
    #[expect(clippy::too_many_arguments, reason = "cursors into path and law go together with them")]
    fn pieces(
        &mut self,
        scope: &Scope<'_>,
        path: &RunPath,
        block: &PathBlock,
        law: &Law,
        [a, b]: [f64; 2],
        start: f64,
        (phase, walk): (&mut Cursor, &mut PathCursor),
    ) -> f64 {
        let cursor = std::cell::Cell::new(*walk);
        let stance = |s: f64| {
            let q = match scope.settings.dynamics {
                Dynamics::Ideal => programmed(scope, block, s),
                Dynamics::Planned | Dynamics::Servo => {
                    let mut at = cursor.get();
                    let q = path.position(&scope.kinematics, s, &mut at);
                    cursor.set(at);
                    q
                }
            };
            JointPose { s, q, pose: scope.kinematics.pose(&q) }
        };
        let mut places = vec![a];
        if scope.settings.dynamics != Dynamics::Ideal {
            // Knots of a fit that lie on the border of the block but for rounding are none.
            let rounding = ROUNDING * (b - a);
            let first = path.spans.partition_point(|p| p.s1 <= a + rounding);
            places.extend(path.spans[first..].iter().map(|p| p.s1).take_while(|s| *s < b - rounding));
        }
        places.push(b);
        let cutter = PieceCutter {
            machine: scope.machine,
            settings: scope.settings,
            lengths: [scope.kinematics.mapping.edge_length, scope.kinematics.mapping.tool_length],
            stance,
        };
        for u in block.shape.knots(a - block.s0, b - block.s0) {
            let x = (cutter.stance)(block.s0 + u);
            self.meter.off_program(block.off(scope.machine, x.s, &x.q));
        }
        let mut time = start + law.time_at(a, phase);
        let (chunk, meter, over) = (&mut self.chunk, &mut self.meter, &mut self.over_travel);
        let mut begun = false;
        cutter.cut(&places, &mut |from, to, off, quarters| {
            let end = start + law.time_at(to.s, phase);
            let at = |part: f64| (cutter.stance)(from.s + (to.s - from.s) * part);
            let [first, middle, last] = quarters.copied().unwrap_or_else(|| [0.25, 0.5, 0.75].map(at));
            // The begin of a piece is the end of the one before.
            for x in std::iter::once(from).filter(|_| !begun).chain([&middle, to]) {
                meter.off_program(block.off(scope.machine, x.s, &x.q));
            }
            begun = true;
            let mut straightness = Straightness::new(scope.machine, &from.q, &to.q);
            [&middle, &first, &last].into_iter().for_each(|x| straightness.look(&x.q));
            let mut turns = false;
            for s in places.iter().copied().filter(|s| from.s < *s && *s < to.s) {
                straightness.look(&(cutter.stance)(s).q);
                turns = true;
            }
            let bound = straightness.bound();
            let finer = (!turns)
                .then(|| {
                    let quarters = [&first.q, &middle.q, &last.q];
                    straightness::finer(scope.machine, [&from.q, &to.q], quarters, &bound, |part| at(part).q)
                })
                .flatten();
            meter.position(&to.q);
            meter.summary.max_chord_error_mm = meter.summary.max_chord_error_mm.max(off.edges);
            watch_travel(scope, over, &from.q, time);
            watch_travel(scope, over, &to.q, end);
            chunk.pieces.push(Piece {
                time: [time, end],
                block: block.index,
                kind: block.kind,
                joints: [from.q, to.q],
                pose: [from.pose, to.pose],
                deviation: off.tool,
                edge_deviation: off.edges,
                joint_deviation: bound,
                finer,
            });
            time = end;
        });
        *walk = cursor.get();
        time
    }

    /// One piece that only gives the time of a block's motion: the drives' stage cuts the pieces
    /// along the actual motion. Travel is checked at the ends, at the control samples, and where a
    /// joint turns back between two of them (there by the parabola through the velocities, within
    /// jerk times cycle cubed over 12: 0.1 um on fast machines).
    #[expect(clippy::too_many_arguments, reason = "cursors into path and law go together with them")]
    fn span(
        &mut self,
        scope: &Scope<'_>,
        path: &RunPath,
        block: &PathBlock,
        stretch: &PlanStretch,
        [a, b]: [f64; 2],
        start: f64,
        (phase, walk): (&mut Cursor, &mut PathCursor),
    ) -> f64 {
        let times = [a, b].map(|s| start + stretch.law.time_at(s, phase));
        let ends = [a, b].map(|s| path.position(&scope.kinematics, s, walk));
        for ((q, time), s) in ends.iter().zip(times).zip([a, b]) {
            self.meter.off_program(block.off(scope.machine, s, q));
            self.meter.position(q);
            watch_travel(scope, &mut self.over_travel, q, time);
        }
        for u in block.shape.knots(a - block.s0, b - block.s0) {
            let q = path.position(&scope.kinematics, block.s0 + u, walk);
            self.meter.off_program(block.off(scope.machine, block.s0 + u, &q));
        }
        let first = stretch.samples.partition_point(|m| m.state.s < a);
        let last = stretch.samples.partition_point(|m| m.state.s <= b);
        let within = &stretch.samples[first.min(last)..last];
        for (k, m) in within.iter().enumerate() {
            watch_travel(scope, &mut self.over_travel, &m.q, m.time);
            self.meter.off_program(block.off(scope.machine, m.state.s, &m.q));
            let Some(next) = within.get(k + 1) else { break };
            let mut turned = m.q;
            let mut turns = false;
            for j in 0..scope.machine.joints.len().min(MAX_JOINTS) {
                let (v0, v1) = (m.velocity[j], next.velocity[j]);
                if v0 * v1 < 0.0 {
                    turned[j] += 0.5 * v0 * (next.time - m.time) * v0 / (v0 - v1);
                    turns = true;
                }
            }
            if turns {
                self.meter.position(&turned);
                watch_travel(scope, &mut self.over_travel, &turned, m.time);
            }
        }
        let pose = ends.map(|q| scope.kinematics.pose(&q));
        self.chunk.pieces.push(Piece {
            time: times,
            block: block.index,
            kind: block.kind,
            joints: ends,
            pose,
            deviation: 0.0,
            edge_deviation: 0.0,
            joint_deviation: JointValues::ZERO,
            finer: None,
        });
        times[1]
    }

    fn end_block(&mut self, scope: &Scope<'_>, block: &PathBlock, s: f64, [begin, end]: [f64; 2]) {
        if let (Some((steady, joint)), MoveKind::Feed) = (self.steady, block.kind) {
            let ratio = (steady / block.feed).min(1.0);
            self.meter.feed_ratio(ratio);
            if ratio < scope.settings.feed_reduced_below {
                self.chunk.events.push(Event::FeedReduced { time: begin, block: block.index, ratio, joint });
            }
        }
        for (joint, over) in self.over_travel.iter_mut().enumerate() {
            if let Some(OverTravel { time, value, limit }) = over.take() {
                let kind = LimitKind::Travel;
                let event = Event::Limit { time, block: block.index, joint: Some(joint), value, limit, kind };
                self.chunk.events.push(event);
            }
        }
        if let Some((time, (joint, order, value, limit))) = self.broken.take() {
            let kind = [LimitKind::Velocity, LimitKind::Acceleration, LimitKind::Jerk][order];
            self.chunk.events.push(Event::Limit { time, block: block.index, joint: Some(joint), value, limit, kind });
        }
        self.meter.summary.blocks += 1;
        let length = std::mem::take(&mut self.block_way);
        if block.tip_moves {
            self.meter.summary.length_mm += length;
        }
        let programmed = programmed(scope, block, s);
        self.chunk.blocks.push(BlockRecord {
            index: block.index,
            file: block.file.clone(),
            line: block.line,
            start_time: begin,
            end_time: end,
            length,
            programmed_length: block.length,
            feed: block.feed_programmed,
            coupled: block.coupled,
            programmed_end: Some((programmed, scope.kinematics.pose(&programmed))),
            kind: BlockKind::Move(block.kind),
        });
        self.block_start = None;
        self.steady = None;
    }

    /// Emits what waits for this path block or an earlier one.
    pub(crate) fn release(&mut self, number: u64, time: f64) {
        while self.waiting.front().is_some_and(|w| w.before <= number) {
            match self.waiting.pop_front().map(|w| w.what) {
                Some(PendingEntry::Event(event)) => self.chunk.events.push(at_time(event, time)),
                Some(PendingEntry::Record(record)) => {
                    self.meter.summary.blocks += 1;
                    self.chunk.blocks.push(BlockRecord { start_time: time, end_time: time, ..*record });
                }
                None => {}
            }
        }
    }

    /// Stays at rest for a while; emits its first and its last control sample.
    pub(crate) fn stand(&mut self, scope: &Scope<'_>, q: &JointValues, block: u32, duration: f64) {
        let (start, end) = (self.clock, self.clock + duration);
        let first = grid_number(start, self.cycle);
        let last = grid_number(end, self.cycle) - 1.0;
        self.set_point(q, last - first + 1.0);
        if last >= first {
            self.still_sample(scope, q, block, first * self.cycle);
            if last > first {
                self.still_sample(scope, q, block, last * self.cycle);
            }
        }
        self.clock = end;
    }

    pub(crate) fn still_sample(&mut self, scope: &Scope<'_>, q: &JointValues, block: u32, time: f64) {
        let zero = JointValues::ZERO;
        let pose: ToolPose = scope.kinematics.pose(q);
        let sample = Sample {
            time,
            block,
            path_length: self.way,
            commanded: *q,
            velocity: zero,
            acceleration: zero,
            jerk: zero,
            actual: *q,
            pose,
            feed_programmed: 0.0,
            feed: 0.0,
            kind: MoveKind::Handling,
            drive: None,
        };
        self.meter.sample(&sample);
        self.chunk.samples.push(sample);
    }

    /// Puts events and samples of the chunk into the order of time and hands it out.
    pub(crate) fn take(&mut self) -> Chunk {
        let mut chunk = std::mem::take(&mut self.chunk);
        chunk.events.sort_by(|a, b| a.time().total_cmp(&b.time()));
        chunk
    }
}

/// Joints on the programmed path at a place of a block.
fn programmed(scope: &Scope<'_>, block: &PathBlock, s: f64) -> JointValues {
    scope.kinematics.position(&block.shape.jet((s - block.s0).clamp(0.0, block.length)).0[0])
}

fn watch_travel(scope: &Scope<'_>, over: &mut [Option<OverTravel>; MAX_JOINTS], q: &JointValues, time: f64) {
    for (i, joint) in scope.machine.joints.iter().enumerate() {
        let Some(limit) = joint.travel_violation(q[i]) else { continue };
        let excess = (q[i] - limit).abs();
        if over[i].is_none_or(|o| excess > (o.value - o.limit).abs()) {
            over[i] = Some(OverTravel { time, value: q[i], limit });
        }
    }
}

fn at_time(event: Event, at: f64) -> Event {
    let mut event = event;
    match &mut event {
        Event::ToolChange { time, .. }
        | Event::Spindle { time, .. }
        | Event::Coolant { time, .. }
        | Event::Message { time, .. }
        | Event::Note { time, .. }
        | Event::Overcut { time, .. }
        | Event::Dwell { time, .. }
        | Event::Stop { time, .. }
        | Event::End { time, .. }
        | Event::Ended { time, .. }
        | Event::Limit { time, .. }
        | Event::UnreachablePose { time, .. }
        | Event::LeavesCircle { time, .. }
        | Event::Probe { time, .. }
        | Event::FeedReduced { time, .. } => *time = at,
    }
    event
}
