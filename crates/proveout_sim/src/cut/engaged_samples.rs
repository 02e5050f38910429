//! Engagement along the path: short stretches of feed motion with the slices of the cutter in material.
//!
//! The stock sorts what a motion took into steps and slices ([`SliceContact`]); pieces of motion are as long
//! as their tolerance allows, from micrometers to many cells. Here both become samples of one length: steps
//! that follow each other in one block are joined until the sample is full.

use std::collections::BTreeMap;

use proveout_controller::{Chunk, MoveKind};
use proveout_geom::{ToolPose, Vector};
use proveout_nc::SpindleDirection;
use proveout_stock::{SliceContact, SlicePlan, SweepMotion};
use proveout_tool::Tool;

use crate::cut::tool_sweeps::CuttingState;

/// Part of a length by which sums of steps may pass it: rounding.
const ROUNDING: f64 = 1e-9;
/// Most by which the way of a sample is taken to be longer than its chord: beyond, it turns back.
const MOST_BENT: f64 = 2.0;

/// A slice of the cutter in material, over a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngagedSlice {
    /// Number of the slice, from 0 at the tip.
    pub slice: u32,
    /// Lowest and highest touch above the tip, mm.
    pub height: [f64; 2],
    /// Angles at which a tooth enters and leaves material in the sense of the spindle, radian: 0 on one side,
    /// a quarter turn in front. None where only the end of the tool goes down.
    pub range: Option<[f64; 2]>,
    /// The cutter goes down: material is met all around.
    pub around: bool,
    /// Touches across the feed, right (negative) and left of the axis, mm; low above high where there is
    /// none.
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

    /// Takes a stretch. `contacts` are those of its pieces, by number; `volumes` is what each piece took,
    /// mm³.
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
            // Steps of another count fall where their begin lies.
            let at = |c: &SliceContact| u64::from(c.step) * u64::from(steps) / u64::from(c.steps.max(1));
            let mut left: Vec<&SliceContact> = own.iter().collect();
            left.sort_by_key(|c| at(c));
            let mut left = left.into_iter().peekable();
            let mut pose = from;
            for step in 0..steps {
                let last = f64::from(step + 1) / n;
                let next = if step + 1 == steps { to } else { from.interpolated(&to, last) };
                let time = [f64::from(step) / n, last].map(|t| piece.time[0] + t * (piece.time[1] - piece.time[0]));
                self.extend(piece.block, tool, state, time, [pose, next], way / n);
                while let Some(contact) = left.next_if(|c| at(c) <= u64::from(step)) {
                    self.add(contact, scale);
                }
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

#[cfg(test)]
mod tests {
    use super::*;
    use proveout_controller::Piece;
    use proveout_geom::Point;
    use proveout_machine::JointValues;

    const STATE: CuttingState = CuttingState { tool: Some(0), spindle: SpindleDirection::Clockwise, speed_rpm: 3000.0 };

    fn pose(x: f64, lean: f64) -> ToolPose {
        ToolPose { tip: Point::new(x, 0.0, 0.0), axis: Vector::new(lean.sin(), 0.0, lean.cos()) }
    }

    fn piece(block: u32, time: [f64; 2], pose: [ToolPose; 2]) -> Piece {
        Piece {
            time,
            block,
            kind: MoveKind::Feed,
            joints: [JointValues::ZERO; 2],
            pose,
            deviation: 0.0,
            edge_deviation: 0.0,
            joint_deviation: JointValues::ZERO,
            finer: None,
        }
    }

    fn contact(id: u32, step: u32, steps: u32, angle: [f64; 2]) -> SliceContact {
        SliceContact {
            id,
            step,
            steps,
            slice: 1,
            height: [1.0, 2.0],
            across: [-1.0, 1.0],
            angle,
            around: false,
            volume_mm3: 2.0,
        }
    }

    fn tool() -> Tool {
        let text = "[[tool]]\nnumber = 1\nname = \"F\"\nkind = \"flat\"\ndiameter_mm = 10\nflute_length_mm = 20\ngauge_length_mm = 60\n";
        let library = proveout_tool::ToolLibrary::from_text("t.toml".as_ref(), text);
        library.unwrap_or_else(|e| panic!("{e}")).tools.remove(0)
    }

    fn samples(pieces: Vec<Piece>, contacts: &[SliceContact], volumes: &[f64]) -> Vec<EngagedSample> {
        let plan = SlicePlan::new(0.5, 1.0).unwrap_or_else(|| panic!("usable"));
        let mut maker = SampleMaker::new(plan, 0.5);
        let states = vec![STATE; pieces.len()];
        let chunk = Chunk { pieces, ..Chunk::default() };
        maker.stretch(&chunk, (&states, &[tool()]), 0, contacts, volumes);
        maker.take(true)
    }

    #[test]
    fn small_pieces_are_joined_and_long_ones_are_divided() {
        // Ten pieces of 0.1 mm, then one of 2 mm in steps of 0.5, then one of another block.
        let mut pieces: Vec<Piece> = (0..10)
            .map(|k| {
                let x = 0.1 * f64::from(k);
                piece(3, [x, x + 0.1], [pose(x, 0.0), pose(x + 0.1, 0.0)])
            })
            .collect();
        pieces.push(piece(3, [1.0, 3.0], [pose(1.0, 0.0), pose(3.0, 0.0)]));
        pieces.push(piece(4, [3.0, 3.2], [pose(3.0, 0.0), pose(3.2, 0.0)]));
        let mut contacts: Vec<SliceContact> = (0..10).map(|k| contact(k, 0, 1, [0.1 * f64::from(k), 1.0])).collect();
        contacts.extend((0..4).map(|k| contact(10, k, 4, [0.5, 2.0])));
        contacts.push(contact(11, 0, 1, [0.5, 2.0]));
        let volumes: Vec<f64> = (0..12).map(|k| if k == 10 { 40.0 } else { 1.0 }).collect();
        let all = samples(pieces, &contacts, &volumes);
        assert_eq!(all.len(), 2 + 4 + 1);
        assert!(
            all.iter().all(|s| s.path[1] - s.path[0] < 0.5 + 1e-9 && (s.tip_speed() - 1.0).abs() < 1e-9),
            "{all:?}"
        );
        assert_eq!(all[0].slices[0].range, Some([0.0, 1.0]));
        let volume = |range: std::ops::Range<usize>| all[range].iter().map(EngagedSample::volume_mm3).sum::<f64>();
        assert!(
            (volume(0..2) - 10.0).abs() < 1e-9
                && (volume(2..6) - 40.0).abs() < 1e-9
                && (volume(6..7) - 1.0).abs() < 1e-9
        );
        assert_eq!(all.last().map(|s| s.block), Some(4));
    }

    #[test]
    fn a_turn_of_the_axis_about_the_tip_moves_each_slice_by_its_height() {
        let lean = 0.02;
        let all = samples(
            vec![piece(0, [0.0, 0.5], [pose(0.0, 0.0), pose(0.0, lean)])],
            &[contact(0, 0, 1, [0.5, 1.0])],
            &[1.0],
        );
        // The chord of the turn, over half a second.
        let rate = 2.0 * (lean / 2.0).sin() / 0.5;
        for z in [0.0, 5.0, 20.0] {
            let [across, down] = all[0].feed_at(z);
            assert!((across - rate * z).abs() < 1e-9 && down.abs() < 1e-9, "{z}: {across} {down}");
        }
        // Down along a leaning axis.
        let axis = pose(0.0, 0.3).axis;
        let [from, to] = [0.0, -2.0].map(|s| ToolPose { tip: Point::from(axis * s), axis });
        let all = samples(vec![piece(0, [0.0, 0.5], [from, to])], &[contact(0, 0, 1, [0.5, 1.0])], &[1.0]);
        let [across, down] = all[0].feed_at(3.0);
        assert!(across.abs() < 1e-9 && (down - 4.0).abs() < 1e-9, "{across} {down}");
    }

    #[test]
    fn a_spindle_that_turns_the_other_way_meets_the_mirrored_angles() {
        let contact = contact(0, 0, 1, [0.2, 1.0]);
        let clockwise = contact.entry_and_exit(true);
        let other = contact.entry_and_exit(false);
        let pi = std::f64::consts::PI;
        assert_eq!((clockwise, other), (Some([0.2, 1.0]), Some([pi - 1.0, pi - 0.2])));
    }
}
