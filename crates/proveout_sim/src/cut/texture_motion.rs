//! The motion that comes near a patch, kept while the run goes on.
//!
//! # Time
//!
//! Heights of the envelope do not depend on time. Teeth leave their marks where they are when they are there,
//! so that a piece of motion has to run at its own speed:
//!
//! * `ideal`: a motion in feed takes its programmed length over its programmed feed, without ramps;
//!   everything else (rapid motion, dwell, tool changes) takes the time that the control plans for it.
//! * `planned`, `servo`: the time of the samples. A piece along which they do not run evenly is cut
//!   at samples until the tip is nowhere more than [`UNEVEN_MM`] off its place in time.
//!
//! # Spindle
//!
//! It turns with the speed of its S word, M3 negative and M4 positive about the axis from tip to holder,
//! without ramps, and goes on turning over stops, so that one unknown angle is left for each tool. Zero of
//! the angle is the x axis of the spindle's housing.
//!
//! # Memory
//!
//! Pieces are kept when the cutter comes near a patch: its cylinder against a ball round the patch, in steps
//! along the piece. A kept piece takes some 250 bytes; beyond [`MOST_PIECES`] no more are kept, and no patch
//! is evaluated.

use std::collections::VecDeque;

use proveout_controller::{BlockRecord, Chunk, Dynamics, MoveKind, Piece};
use proveout_geom::{Point, Pose, ToolPose, Vector, rad};
use proveout_nc::SpindleDirection;
use proveout_surface::topography::{CutterPiece, phase_zero};

use crate::{
    cut::tool_sweeps::CuttingState,
    prepare::{
        prepared::Prepared,
        texture_plan::{Area, MOST_PIECES},
    },
    scene::{SpindlePhaseFile, surface::SurfaceModelFile},
};

/// Largest distance along the path of the tip from its place in time, mm.
const UNEVEN_MM: f64 = 1e-5;
/// Longest kept piece, mm: with short pieces those that do not come near a node can be left out. No
/// height depends on it.
const LONGEST_MM: f64 = 2.0;
/// A phase is known from a place that the tip passes within this, mm.
pub(crate) const PASSED_MM: f64 = 0.01;
/// Run-out and rounding by which a cutter may reach beyond its nominal body, mm.
const BEYOND_MM: f64 = 1.0;
/// The tip of a shorter motion is at rest, mm.
const AT_REST_MM: f64 = 1e-9;
/// An axis that turns by less is at rest, radian.
const NO_TURN: f64 = 1e-12;
/// Most places of a motion at which it is looked whether the cutter comes near an area.
const MOST_STEPS: f64 = 1e4;
/// A motion is nearer to a stated phase from this on, mm: of equal ones the first counts.
const NEARER_MM: f64 = 1e-6;
/// Part of a part that one more would have to cover: rounding adds none.
const ROUNDING: f64 = 1e-9;
/// Most parts of a stretch.
const MOST_PARTS: f64 = 1e6;
/// Smaller turns have no direction, radian.
const SMALLEST_TURN: f64 = 1e-15;

/// A kept piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    /// Its azimuth counts from the begin of the program.
    pub(crate) piece: CutterPiece,
    pub(crate) tool: usize,
    pub(crate) block: u32,
    pub(crate) kind: MoveKind,
}

/// The nearest passage of a place with a known phase.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    pub(crate) distance: f64,
    pub(crate) tool: usize,
    pub(crate) block: u32,
    /// To be added to the azimuth of kept pieces, radian.
    pub(crate) offset: f64,
}

/// What was kept.
#[derive(Debug, Default)]
pub(crate) struct Tracks {
    pub(crate) pieces: Vec<Kept>,
    /// Pieces near each area, in order of time.
    pub(crate) of_area: Vec<Vec<u32>>,
    /// For each phase of the scene.
    pub(crate) passages: Vec<Option<Passage>>,
    /// There were too many pieces.
    pub(crate) lost: bool,
}

/// The cylinder round the cutting parts of a tool.
#[derive(Clone, Copy, Debug)]
struct Cylinder {
    radius: f64,
    height: f64,
}

/// A sample of the motion: how a piece is run through.
#[derive(Clone, Copy, Debug)]
struct Mark {
    time: f64,
    pose: ToolPose,
}

pub(crate) struct Recorder<'a> {
    prepared: &'a Prepared,
    work_from_table: Pose,
    teeth: bool,
    ideal: bool,
    areas: Vec<Area>,
    cylinders: Vec<Option<Cylinder>>,
    phases: Vec<&'a SpindlePhaseFile>,
    waiting: VecDeque<(Piece, CuttingState)>,
    marks: VecDeque<Mark>,
    /// Planned end of the last piece, time and azimuth of the spindle now.
    planned: f64,
    clock: f64,
    azimuth: f64,
    rate: f64,
    tracks: Tracks,
}

impl<'a> Recorder<'a> {
    pub(crate) fn new(prepared: &'a Prepared, areas: Vec<Area>) -> Self {
        let surface = prepared.scene.file.surface.as_ref();
        let cylinder = |t: &proveout_tool::Tool| {
            let size = |f: fn(&proveout_tool::Profile) -> f64| t.cutting().map(|b| f(&b.profile)).reduce(f64::max);
            Some(Cylinder { radius: size(|p| p.max_radius())?, height: size(|p| p.z_max())? })
        };
        let phases: Vec<&SpindlePhaseFile> = surface.into_iter().flat_map(|s| &s.phase).map(|p| p.get_ref()).collect();
        Self {
            work_from_table: prepared.table_from_work.inverse(),
            teeth: surface.is_some_and(|s| s.model == SurfaceModelFile::Teeth),
            ideal: prepared.dynamics == Dynamics::Ideal,
            cylinders: prepared.tools.tools.iter().map(cylinder).collect(),
            tracks: Tracks {
                of_area: vec![Vec::new(); areas.len()],
                passages: vec![None; phases.len()],
                ..Tracks::default()
            },
            areas,
            phases,
            prepared,
            waiting: VecDeque::new(),
            marks: VecDeque::new(),
            planned: 0.0,
            clock: 0.0,
            azimuth: 0.0,
            rate: 0.0,
        }
    }

    /// Takes a stretch of motion.
    pub(crate) fn take(&mut self, chunk: &Chunk, states: &[CuttingState]) {
        let pieces = chunk.pieces.iter().copied().zip(states.iter().copied());
        if !self.teeth {
            pieces.for_each(|(piece, state)| self.run(&piece, &state, piece.time[1] - piece.time[0]));
            return;
        }
        self.waiting.extend(pieces);
        if self.ideal {
            chunk.blocks.iter().for_each(|b| self.close_block(b));
        } else {
            self.marks.extend(chunk.samples.iter().map(|s| Mark { time: s.time, pose: s.pose }));
            let known = self.marks.back().map_or(f64::NEG_INFINITY, |m| m.time);
            while let Some((piece, state)) = self.waiting.pop_front_if(|(p, _)| p.time[1] <= known) {
                self.run(&piece, &state, piece.time[1] - piece.time[0]);
            }
        }
    }

    /// What was kept, at the end of the program.
    pub(crate) fn finish(mut self) -> Tracks {
        while let Some((piece, state)) = self.waiting.pop_front() {
            self.run(&piece, &state, piece.time[1] - piece.time[0]);
        }
        self.tracks
    }

    /// Runs the pieces of a block at its programmed feed.
    fn close_block(&mut self, block: &BlockRecord) {
        while let Some((piece, state)) = self.waiting.pop_front_if(|(p, _)| p.block < block.index) {
            self.run(&piece, &state, piece.time[1] - piece.time[0]);
        }
        let own = self.waiting.iter().take_while(|(p, _)| p.block == block.index);
        let way = |p: &Piece| (p.pose[1].tip - p.pose[0].tip).norm();
        let (count, length) = own.fold((0, 0.0), |(n, l), (p, _)| (n + 1, l + way(p)));
        // Where the tip is at rest, the feed is that of the rotary joints: the plan knows.
        let even = block.feed > 0.0 && block.programmed_length > 0.0 && length > AT_REST_MM;
        for _ in 0..count {
            let Some((piece, state)) = self.waiting.pop_front() else { return };
            let share = if even { way(&piece) / length } else { 0.0 };
            let planned = piece.time[1] - piece.time[0];
            let time = if even && piece.kind == MoveKind::Feed {
                share * block.programmed_length / block.feed
            } else {
                planned
            };
            self.run(&piece, &state, time);
        }
    }

    /// Runs a piece in a time (s).
    fn run(&mut self, piece: &Piece, state: &CuttingState, duration: f64) {
        let rate = match state.spindle {
            SpindleDirection::Off => 0.0,
            SpindleDirection::Clockwise => -1.0,
            SpindleDirection::CounterClockwise => 1.0,
        } * state.speed_rpm
            * std::f64::consts::TAU
            / 60.0;
        let wait = (piece.time[0] - self.planned).max(0.0);
        self.clock += wait;
        self.azimuth += self.rate * wait;
        self.rate = rate;
        self.planned = piece.time[1];
        let begin = (self.clock, self.azimuth);
        self.clock += duration;
        self.azimuth += rate * duration;
        let Some(tool) = state.tool else { return };
        let [from, to] = piece.pose.map(|p| p.transformed(&self.work_from_table));
        if !self.is_near(tool, &from, &to) && self.phases.is_empty() {
            return;
        }
        let frames = [0, 1].map(|k| {
            let pose = self.work_from_table * self.prepared.machine.actual_table_from_spindle(&piece.joints[k]);
            housing(&pose.rotation.column(0).into(), &[from, to][k].axis)
        });
        let whole = Whole { tips: [from.tip, to.tip], frame: frames[0], turn: turn(&frames[0], &frames[1]) };
        let longest = self.cylinders[tool].map_or(LONGEST_MM, |c| (0.25 * c.radius).clamp(0.5, LONGEST_MM));
        let way = (to.tip - from.tip).norm();
        for [(t0, s0), (t1, s1)] in self.parts(piece).into_iter().flat_map(|part| short_parts(part, way / longest)) {
            let time = [begin.0 + t0 * duration, begin.0 + t1 * duration];
            let azimuth = begin.1 + rate * (t0 * duration);
            let part = whole.part([s0, s1], time, azimuth, rate, self.tracks.pieces.len() as u32);
            let kept = Kept { piece: part, tool, block: piece.block, kind: piece.kind };
            self.pass(&kept);
            self.keep(kept);
        }
    }

    /// Stretches of a piece, each as parts of its time and of its way: one where the samples run through it
    /// evenly.
    fn parts(&mut self, piece: &Piece) -> Vec<[(f64, f64); 2]> {
        let whole = vec![[(0.0, 0.0), (1.0, 1.0)]];
        let [from, to] = piece.pose;
        let (span, way) = (piece.time[1] - piece.time[0], to.tip - from.tip);
        while self.marks.front().is_some_and(|m| m.time <= piece.time[0]) {
            self.marks.pop_front();
        }
        if self.ideal || !self.teeth || span <= 0.0 {
            return whole;
        }
        let (length, angle) = (way.norm(), from.angle_to(&to));
        let place = |p: &ToolPose| {
            if length > AT_REST_MM {
                ((p.tip - from.tip).dot(&way) / (length * length)).clamp(0.0, 1.0)
            } else if angle > NO_TURN {
                (from.angle_to(p) / angle).clamp(0.0, 1.0)
            } else {
                0.0
            }
        };
        // Where the tip is at rest, the way of the flank counts.
        let size = if length > AT_REST_MM { length } else { angle * 100.0 };
        let within = self.marks.iter().take_while(|m| m.time < piece.time[1]);
        let mut nodes = vec![(0.0, 0.0)];
        nodes.extend(within.map(|m| ((m.time - piece.time[0]) / span, place(&m.pose))));
        nodes.push((1.0, 1.0));
        let mut parts = Vec::new();
        let mut i = 0;
        while i + 1 < nodes.len() {
            let mut j = i + 1;
            while j + 1 < nodes.len() {
                let ((t0, s0), (t1, s1)) = (nodes[i], nodes[j + 1]);
                let even = nodes[i + 1..=j]
                    .iter()
                    .all(|(t, s)| (s - s0 - (s1 - s0) * (t - t0) / (t1 - t0)).abs() * size <= UNEVEN_MM);
                if !even {
                    break;
                }
                j += 1;
            }
            parts.push([nodes[i], nodes[j]]);
            i = j;
        }
        parts
    }

    fn is_near(&self, tool: usize, from: &ToolPose, to: &ToolPose) -> bool {
        (0..self.areas.len()).any(|a| self.reaches(a, tool, from, to))
    }

    /// Whether the cutter comes near an area.
    fn reaches(&self, area: usize, tool: usize, from: &ToolPose, to: &ToolPose) -> bool {
        let Some(cylinder) = self.cylinders.get(tool).copied().flatten() else { return false };
        let area = &self.areas[area];
        let (way, angle) = ((to.tip - from.tip).norm(), from.angle_to(to));
        let steps =
            ((way + angle * cylinder.height) / (area.radius + cylinder.radius + 1.0)).ceil().clamp(1.0, MOST_STEPS);
        let room = area.radius + BEYOND_MM;
        (0..steps as usize).any(|k| {
            let at = from.interpolated(to, (k as f64 + 0.5) / steps);
            let q = area.middle - at.tip;
            let z = q.dot(&at.axis);
            let r = (q - at.axis * z).norm();
            let (beside, above) = ((r - cylinder.radius).max(0.0), (z - cylinder.height).max(-z).max(0.0));
            beside.hypot(above) <= room + 0.5 * (way + angle * (q.norm() + cylinder.height)) / steps
        })
    }

    fn keep(&mut self, kept: Kept) {
        let pose = |k: usize| {
            let p = &kept.piece;
            let axis = if k == 0 { p.housing[2] } else { rotated(&p.housing[2], &p.turn) };
            ToolPose { tip: p.tip[k], axis }
        };
        let (from, to) = (pose(0), pose(1));
        let near: Vec<usize> = (0..self.areas.len()).filter(|a| self.reaches(*a, kept.tool, &from, &to)).collect();
        if near.is_empty() || self.tracks.lost {
            return;
        }
        if self.tracks.pieces.len() >= MOST_PIECES {
            self.tracks.lost = true;
            return;
        }
        let index = self.tracks.pieces.len() as u32;
        near.into_iter().for_each(|a| self.tracks.of_area[a].push(index));
        self.tracks.pieces.push(kept);
    }

    /// Looks whether the tip passes a place with a known phase nearer than before.
    fn pass(&mut self, kept: &Kept) {
        let piece = &kept.piece;
        if piece.azimuth_rate == 0.0 || kept.kind != MoveKind::Feed {
            return;
        }
        for (known, best) in self.phases.iter().zip(&mut self.tracks.passages) {
            let name = self.prepared.tools.tools.get(kept.tool).map(|t| t.name.as_str());
            if known.tool.as_deref().is_some_and(|wanted| Some(wanted) != name) {
                continue;
            }
            let (at, way) = (Point::from(known.at_mm), piece.tip[1] - piece.tip[0]);
            let length2 = way.norm_squared();
            let s = if length2 > 0.0 { ((at - piece.tip[0]).dot(&way) / length2).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (piece.tip[0] + way * s - at).norm();
            if best.is_some_and(|b| distance >= b.distance - NEARER_MM) {
                continue;
            }
            let frame = piece.housing.map(|v| rotated(&v, &(piece.turn * s)));
            let zero = phase_zero(&frame, &way);
            let turned = piece.azimuth + piece.azimuth_rate * s * (piece.time[1] - piece.time[0]);
            let offset = rad(known.tooth_deg) + zero - turned;
            *best = Some(Passage { distance, tool: kept.tool, block: kept.block, offset });
        }
    }
}

/// Equal parts of a stretch, so many for the whole way.
fn short_parts([(t0, s0), (t1, s1)]: [(f64, f64); 2], lengths: f64) -> impl Iterator<Item = [(f64, f64); 2]> {
    let count = ((s1 - s0) * lengths - ROUNDING).ceil().clamp(1.0, MOST_PARTS) as usize;
    let at = move |k: usize| {
        let part = k as f64 / count as f64;
        if k == count { (t1, s1) } else { (t0 + (t1 - t0) * part, s0 + (s1 - s0) * part) }
    };
    (0..count).map(move |k| [at(k), at(k + 1)])
}

/// A whole piece in the workpiece frame.
struct Whole {
    tips: [Point; 2],
    frame: [Vector; 3],
    turn: Vector,
}

impl Whole {
    fn part(&self, [s0, s1]: [f64; 2], time: [f64; 2], azimuth: f64, azimuth_rate: f64, motion: u32) -> CutterPiece {
        let way = self.tips[1] - self.tips[0];
        let tip = |s: f64| if s >= 1.0 { self.tips[1] } else { self.tips[0] + way * s };
        CutterPiece {
            time,
            tip: [tip(s0), tip(s1)],
            housing: self.frame.map(|v| rotated(&v, &(self.turn * s0))),
            turn: self.turn * (s1 - s0),
            azimuth,
            azimuth_rate,
            motion,
        }
    }
}

/// Frame of the housing from its x axis and the axis of the tool, at right angles to rounding.
fn housing(x: &Vector, z: &Vector) -> [Vector; 3] {
    let x = (x - z * x.dot(z)).normalize();
    [x, z.cross(&x), *z]
}

/// The rotation that takes one frame to another: unit direction times angle. For R = B A^T, its antisymmetric
/// part is the direction times the sine, its trace 1 + 2 cos.
fn turn(a: &[Vector; 3], b: &[Vector; 3]) -> Vector {
    let twice_sine: Vector = (0..3).map(|k| a[k].cross(&b[k])).sum();
    let trace: f64 = (0..3).map(|k| a[k].dot(&b[k])).sum();
    let sine = 0.5 * twice_sine.norm();
    if sine < SMALLEST_TURN {
        return Vector::zeros();
    }
    twice_sine * (sine.atan2(0.5 * (trace - 1.0)) / (2.0 * sine))
}

/// Rodrigues 1840.
pub(crate) fn rotated(v: &Vector, turn: &Vector) -> Vector {
    let angle = turn.norm();
    if angle < SMALLEST_TURN {
        return *v;
    }
    let u = turn / angle;
    let (sin, cos) = angle.sin_cos();
    v * cos + u.cross(v) * sin + u * (u.dot(v) * (1.0 - cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_between_two_frames_takes_one_to_the_other() {
        let frame = housing(&Vector::new(0.3, 1.0, 0.2), &Vector::new(0.1, -0.2, 1.0).normalize());
        for wanted in
            [Vector::zeros(), Vector::new(1e-9, 2e-9, 0.0), Vector::new(0.01, -0.02, 0.4), Vector::new(1.5, 1.5, -1.0)]
        {
            let to = frame.map(|v| rotated(&v, &wanted));
            let found = turn(&frame, &to);
            assert!((found - wanted).norm() < 1e-12, "{found:?} for {wanted:?}");
        }
    }
}
