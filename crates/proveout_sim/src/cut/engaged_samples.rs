//! Engagement along the path: short stretches of feed motion with the slices of the cutter in material.
//!
//! The stock sorts what a motion took into steps and slices ([`SliceContact`]); pieces of motion are as long as
//! their tolerance allows, from micrometers to many cells. Here both become samples of one length: steps that
//! follow each other in one block are joined until the sample is full.

use std::collections::BTreeMap;

use proveout_controller::{Chunk, MoveKind};
use proveout_geom::{ToolPose, Vector};
use proveout_nc::SpindleDirection;
use proveout_stock::{SliceContact, SlicePlan, SweepMotion};
use proveout_tool::Tool;

use crate::cut::tool_sweeps::CuttingState;

/// Part of a length by which sums of steps may pass it: rounding.
const ROUNDING: f64 = 1e-9;

/// A slice of the cutter in material, over a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngagedSlice {
    /// Number of the slice, from 0 at the tip.
    pub slice: u32,
    /// Lowest and highest touch above the tip, mm.
    pub height: [f64; 2],
    /// Angles at which a tooth enters and leaves material in the sense of the spindle, radian: 0 on one side, a
    /// quarter turn in front. None where only the end of the tool goes down.
    pub range: Option<[f64; 2]>,
    /// The cutter goes down: material is met all around.
    pub around: bool,
    /// Touches across the feed, right (negative) and left of the axis, mm; low above high where there is none.
    pub across: [f64; 2],
    /// Material that was taken, mm³.
    pub volume_mm3: f64,
}

impl EngagedSlice {
    /// Both as one slice.
    pub(crate) fn join(&mut self, other: &Self) {
        let join = |a: &mut [f64; 2], b: [f64; 2]| *a = [a[0].min(b[0]), a[1].max(b[1])];
        join(&mut self.height, other.height);
        join(&mut self.across, other.across);
        self.range = match (self.range, other.range) {
            (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
            (a, b) => a.or(b),
        };
        self.around |= other.around;
        self.volume_mm3 += other.volume_mm3;
    }
}

/// A short stretch of feed motion in which material was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct EngagedSample {
    /// Index of the executed block.
    pub block: u32,
    /// Place of the tool in the library.
    pub tool: usize,
    /// Speed of the spindle, 1/min; 0 while it does not turn.
    pub speed_rpm: f64,
    /// Begin and end, s.
    pub time: [f64; 2],
    /// Way of the cutter from the begin of the program, mm: at the begin and at the end.
    pub path: [f64; 2],
    /// Way of the tip along its path, mm.
    pub tip_way: f64,
    /// Velocity of the tip, mm/s, and of the tool axis, 1/s, in the table frame.
    pub velocity: [Vector; 2],
    /// Tool axis in the middle, from tip to holder.
    pub axis: Vector,
    /// The slices in material, from the tip up.
    pub slices: Vec<EngagedSlice>,
}

impl EngagedSample {
    /// Feed across the axis, and down along it, of the point of the axis at a height above the tip, mm/s.
    pub fn feed_at(&self, height: f64) -> [f64; 2] {
        let v = self.velocity[0] + self.velocity[1] * height;
        let up = v.dot(&self.axis);
        [(v - self.axis * up).norm(), -up]
    }

    /// Speed of the tip along its path, mm/s.
    pub fn tip_speed(&self) -> f64 {
        let duration = self.time[1] - self.time[0];
        if duration > 0.0 { self.tip_way / duration } else { 0.0 }
    }

    /// Material that was taken, mm³.
    pub fn volume_mm3(&self) -> f64 {
        self.slices.iter().map(|s| s.volume_mm3).sum()
    }
}

/// The sample at work.
#[derive(Debug)]
struct OpenSample {
    block: u32,
    state: CuttingState,
    tool: usize,
    time: [f64; 2],
    path: [f64; 2],
    tip_way: f64,
    from: ToolPose,
    to: ToolPose,
    slices: BTreeMap<u32, EngagedSlice>,
}

/// Makes samples of a run, in order of time.
#[derive(Debug)]
pub(crate) struct SampleMaker {
    plan: SlicePlan,
    step: f64,
    path: f64,
    open: Option<OpenSample>,
    done: Vec<EngagedSample>,
}

impl SampleMaker {
    /// `step` is the longest sample, mm: that of the plan.
    pub(crate) fn new(plan: SlicePlan, step: f64) -> Self {
        Self { plan, step, path: 0.0, open: None, done: Vec::new() }
    }

    /// Takes a stretch. `contacts` are those of its pieces, by number; `volumes` is what each piece took, mm³.
    pub(crate) fn stretch(
        &mut self,
        chunk: &Chunk,
        (states, tools): (&[CuttingState], &[Tool]),
        first_id: u32,
        contacts: &[SliceContact],
        volumes: &[f64],
    ) {
        let mut rest = contacts;
        for (i, (piece, state)) in chunk.pieces.iter().zip(states).enumerate() {
            let id = first_id + i as u32;
            let begin = rest.partition_point(|c| c.id < id);
            let end = rest.partition_point(|c| c.id <= id);
            let own = &rest[begin..end];
            rest = &rest[end..];
            let [from, to] = piece.pose;
            let tool = state.tool.and_then(|t| Some((t, tools.get(t)?)));
            let reach = tool.map_or(0.0, |(_, tool)| tool.flute_length);
            let (travel, turn) = (to.tip - from.tip, to.axis - from.axis);
            let way = travel.norm().max((travel + turn * reach).norm());
            let Some((tool, _)) = tool.filter(|_| piece.kind == MoveKind::Feed) else {
                self.close();
                self.path += way;
                continue;
            };
            if own.is_empty() && way > self.step {
                self.close();
                self.path += way;
                continue;
            }
            let motion = SweepMotion { from, to };
            let steps = own.iter().map(|c| c.steps).max().unwrap_or_else(|| self.plan.steps(&motion, [0.0, reach]));
            let sum: f64 = own.iter().map(|c| c.volume_mm3).sum();
            let scale = if sum > 0.0 { volumes.get(i).copied().unwrap_or(0.0) / sum } else { 0.0 };
            let n = f64::from(steps.max(1));
            let mut left = own;
            let mut pose = from;
            for step in 0..steps {
                // Steps of another count fall where their begin lies.
                let at = |c: &SliceContact| u64::from(c.step) * u64::from(steps) / u64::from(c.steps.max(1));
                let last = f64::from(step + 1) / n;
                let next = if step + 1 == steps { to } else { from.interpolated(&to, last) };
                let time = [f64::from(step) / n, last].map(|t| piece.time[0] + t * (piece.time[1] - piece.time[0]));
                self.extend(piece.block, tool, state, time, [pose, next], way / n);
                let here: Vec<&SliceContact> = left.iter().take_while(|c| at(c) <= u64::from(step)).collect();
                left = left.get(here.len()..).unwrap_or(&[]);
                here.into_iter().for_each(|c| self.add(c, scale));
                pose = next;
            }
        }
    }

    /// Lets the open sample go on over a step, or begins a new one.
    fn extend(
        &mut self,
        block: u32,
        tool: usize,
        state: &CuttingState,
        time: [f64; 2],
        [from, to]: [ToolPose; 2],
        way: f64,
    ) {
        let fits = |open: &OpenSample| {
            let length = open.path[1] - open.path[0] + way;
            (open.block, open.state) == (block, *state) && length <= self.step * (1.0 + ROUNDING)
        };
        if !self.open.as_ref().is_some_and(fits) {
            self.close();
        }
        let path = self.path;
        let open = self.open.get_or_insert_with(|| OpenSample {
            block,
            state: *state,
            tool,
            time,
            path: [path; 2],
            tip_way: 0.0,
            from,
            to: from,
            slices: BTreeMap::new(),
        });
        open.time[1] = time[1];
        open.tip_way += (to.tip - open.to.tip).norm();
        open.to = to;
        self.path += way;
        open.path[1] = self.path;
    }

    /// Adds a contact to the open sample.
    fn add(&mut self, contact: &SliceContact, scale: f64) {
        let Some(open) = &mut self.open else { return };
        let clockwise = open.state.spindle != SpindleDirection::CounterClockwise;
        let slice = EngagedSlice {
            slice: contact.slice,
            height: contact.height,
            range: contact.entry_and_exit(clockwise),
            around: contact.around,
            across: contact.across,
            volume_mm3: scale * contact.volume_mm3,
        };
        open.slices.entry(contact.slice).and_modify(|known| known.join(&slice)).or_insert(slice);
    }

    /// Ends the open sample; one without material is dropped.
    fn close(&mut self) {
        let Some(open) = self.open.take().filter(|open| !open.slices.is_empty()) else { return };
        let duration = open.time[1] - open.time[0];
        let chord = open.to.tip - open.from.tip;
        let middle = open.from.interpolated(&open.to, 0.5);
        let per_s = if duration > 0.0 { 1.0 / duration } else { 0.0 };
        // Along an arc the way is longer than its chord.
        let longer = if chord.norm() > 0.0 { (open.tip_way / chord.norm()).min(MOST_BENT) } else { 1.0 };
        let turning = open.state.spindle != SpindleDirection::Off;
        self.done.push(EngagedSample {
            block: open.block,
            tool: open.tool,
            speed_rpm: if turning { open.state.speed_rpm } else { 0.0 },
            time: open.time,
            path: open.path,
            tip_way: open.tip_way,
            velocity: [chord * (per_s * longer), (open.to.axis - open.from.axis) * per_s],
            axis: middle.axis,
            slices: open.slices.into_values().collect(),
        });
    }

    /// The samples that are complete; with `end`, all of them.
    pub(crate) fn take(&mut self, end: bool) -> Vec<EngagedSample> {
        if end {
            self.close();
        }
        std::mem::take(&mut self.done)
    }
}

/// Most by which the way of a sample is taken to be longer than its chord: beyond, it turns back.
const MOST_BENT: f64 = 2.0;
