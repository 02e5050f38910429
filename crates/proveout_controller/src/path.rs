//! The path of a run between two stops: exact blocks, corner blends, and cells with limits.
//!
//! All lives on one parameter s. Block i runs over `s0..s0 + length`; a blend of half width d around a border replaces
//! `s - d ..= s + d` of both blocks, so that rounded and exact path have the same parameter:
//!
//! ```text
//!      block a            |            block b
//!   ---------------x......|......x--------------      x: C2 joints of exact parts and blend
//!                 s - d   s    s + d                  the border s lies in the middle of the blend
//! ```
//!
//! *Blend.* A polynomial of fifth degree in task coordinates that takes value, first and second derivative from both
//! exact paths at its ends. Between two lines with slopes u and w it has x' with Bezier points u, u, (u + w)/2, w, w:
//! |x'| <= max(|u|, |w|), so that the tip is never faster than the feed; it leaves the corner by 3/16 d |w - u|, its
//! largest second derivative is 3/4 |w - u| / d (middle) and its largest third derivative 3/2 |w - u| / d^2 (ends).
//!
//! *Width.* No wider than the joints need at the programmed feed, nor than the tolerances of tip and orientation
//! allow, nor than half of either block. Where a neighbor is no line the deviation is measured at points, and d shrinks
//! until it fits.

use proveout_machine::{JointKind, JointValues, Machine};

use crate::{
    jet::JointJet,
    limits::{CellLimits, JointLimits, cell_limits},
    mapping::Kinematics,
    output::MoveKind,
    shape::{DerivativeBounds, Quintic, Shape},
};

/// Half width of a blend below which the control stops in the corner, as part of the shorter block: the blend would be
/// a stop in all but name.
const NARROWEST: f64 = 1e-6;
/// Largest turn of a rotary joint in one cell, radian: 3 degrees change the direction of the linear axes by 5 percent.
const CELL_TURN: f64 = 0.052;
/// Largest angle of an arc in one cell, radian.
const CELL_ARC: f64 = 0.2;
/// Surcharge on derivatives that are known only at points of a cell.
const POINT_SURCHARGE: f64 = 1.02;
/// Points of a cell at which curved paths are looked at.
const POINTS: usize = 5;
/// Part of the joint limits that a blend may use at the programmed feed when its width is chosen.
const BLEND_SHARE: f64 = 0.5;

/// How far corners may be rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tolerance {
    /// Tip (with tool center point control) or linear joints (without), mm.
    pub(crate) tip: f64,
    /// Rotary joints, radian.
    pub(crate) angle: f64,
}

/// One block of a run.
#[derive(Clone, Debug)]
pub(crate) struct PathBlock {
    /// Index of the block record.
    pub(crate) index: u32,
    pub(crate) shape: Shape,
    pub(crate) length: f64,
    /// Begin on the parameter of the run.
    pub(crate) s0: f64,
    pub(crate) kind: MoveKind,
    /// Speed along the path that the program asks for; infinite for rapid motion.
    pub(crate) feed: f64,
    /// Feed for the record, mm/s; zero for rapid motion.
    pub(crate) feed_programmed: f64,
    /// Rounding at its end; none: exact stop.
    pub(crate) corner: Option<Tolerance>,
    /// False when the parameter is in degrees since the tip stands.
    pub(crate) tip_moves: bool,
    pub(crate) file: std::sync::Arc<str>,
    pub(crate) line: u32,
}

impl PathBlock {
    pub(crate) fn end(&self) -> f64 {
        self.s0 + self.length
    }

    fn is_rapid(&self) -> bool {
        self.kind != MoveKind::Feed
    }
}

#[derive(Clone, Debug)]
pub(crate) enum SpanShape {
    /// The exact path of the block.
    Exact,
    Blend(Box<Quintic>),
}

/// A stretch of the rounded path.
#[derive(Clone, Debug)]
pub(crate) struct Span {
    pub(crate) s0: f64,
    pub(crate) s1: f64,
    /// Running number of the block (of the first of two for a blend).
    pub(crate) block: u64,
    pub(crate) shape: SpanShape,
}

/// A cell with its limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathCell {
    pub(crate) s1: f64,
    pub(crate) limits: CellLimits,
    /// Running number of the block.
    pub(crate) block: u64,
    /// False in blends.
    pub(crate) exact: bool,
}

/// The known part of a run.
#[derive(Default)]
pub(crate) struct Path {
    pub(crate) blocks: Vec<PathBlock>,
    /// Running number of the first block in `blocks`.
    pub(crate) first_block: u64,
    pub(crate) spans: Vec<Span>,
    pub(crate) cells: Vec<PathCell>,
    /// Begin of the first cell.
    pub(crate) s_begin: f64,
    /// End of the finished spans.
    s_done: f64,
    /// Largest rounding of the tip or linear joints, mm.
    pub(crate) max_rounding: f64,
}

/// What the geometry of a path needs to know about machine and control.
#[derive(Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub(crate) kinematics: Kinematics<'a>,
    pub(crate) limits: &'a JointLimits,
}

impl Path {
    /// An empty path whose first block gets this running number.
    pub(crate) fn starting_with(first_block: u64) -> Self {
        Self { first_block, ..Self::default() }
    }

    /// A path of one block that has its own law over the path parameter.
    pub(crate) fn single(first_block: u64, block: PathBlock) -> Self {
        let s1 = block.length;
        let span = Span { s0: 0.0, s1, block: first_block, shape: SpanShape::Exact };
        Self { first_block, s_done: s1, spans: vec![span], blocks: vec![block], ..Self::default() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Begin of the next block.
    pub(crate) fn end(&self) -> f64 {
        self.blocks.last().map_or(self.s_done, PathBlock::end)
    }

    pub(crate) fn block(&self, number: u64) -> &PathBlock {
        let i = (number - self.first_block) as usize;
        &self.blocks[i.min(self.blocks.len() - 1)]
    }

    /// Appends a block with a rounded corner before it. False, and nothing is changed, where the corner has no room for
    /// a blend: the control must stop there first.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, mut block: PathBlock) -> bool {
        block.s0 = self.end();
        if let Some(before) = self.blocks.last() {
            let Some(tolerance) = before.corner else { return false };
            let corner = corner(frame, before, &block, tolerance);
            let number = self.first_block + self.blocks.len() as u64 - 1;
            match corner {
                Corner::Stop => return false,
                Corner::Smooth => self.finish_exact(frame, number, block.s0),
                Corner::Blend { half_width, rounding, quintic } => {
                    self.finish_exact(frame, number, block.s0 - half_width);
                    self.max_rounding = self.max_rounding.max(rounding);
                    self.push_blend(frame, number, &block, quintic);
                }
            }
        }
        self.blocks.push(block);
        true
    }

    /// Finishes the last block: the path ends with a stop.
    pub(crate) fn finish(&mut self, frame: &Frame<'_>) {
        if let Some(last) = self.blocks.last() {
            let (end, number) = (last.end(), self.first_block + self.blocks.len() as u64 - 1);
            self.finish_exact(frame, number, end);
        }
    }

    fn finish_exact(&mut self, frame: &Frame<'_>, number: u64, s1: f64) {
        let s0 = self.s_done;
        if s1 - s0 > 1e-12 * s1.abs().max(1.0) {
            let block = self.block(number);
            let cells = exact_cells(frame, block, s0, s1);
            for (end, limits) in cells {
                self.cells.push(PathCell { s1: end, limits, block: number, exact: true });
            }
            self.spans.push(Span { s0, s1, block: number, shape: SpanShape::Exact });
            self.s_done = s1;
        }
    }

    fn push_blend(&mut self, frame: &Frame<'_>, number: u64, next: &PathBlock, quintic: Box<Quintic>) {
        let before = self.block(number);
        let rapid = before.is_rapid() && next.is_rapid();
        let feed = before.feed.min(next.feed);
        let s0 = self.s_done;
        let s1 = quintic.u1;
        let mut cells: Vec<(f64, CellLimits)> = Vec::with_capacity(2);
        if frame.kinematics.is_tcp() {
            let b = point_bounds(frame, |s| quintic.jet(s), s0, s1, POINTS);
            cells.push((s1, cell_limits(frame.limits, rapid, feed, s1 - s0, &b)));
        } else {
            for half in quintic.halves() {
                cells.push((half.u1, cell_limits(frame.limits, rapid, feed, half.u1 - half.u0, &half.bounds())));
            }
        }
        for (end, limits) in cells {
            self.cells.push(PathCell { s1: end, limits, block: number, exact: false });
        }
        self.spans.push(Span { s0, s1, block: number, shape: SpanShape::Blend(quintic) });
        self.s_done = s1;
    }

    /// Task coordinates of the rounded path at s; the cursor `hint` (a span) makes a forward walk linear.
    pub(crate) fn rounded(&self, s: f64, hint: &mut usize) -> JointJet {
        let mut i = (*hint).min(self.spans.len().saturating_sub(1));
        while i > 0 && self.spans[i].s0 > s {
            i -= 1;
        }
        while i + 1 < self.spans.len() && self.spans[i].s1 < s {
            i += 1;
        }
        *hint = i;
        let span = &self.spans[i];
        match &span.shape {
            SpanShape::Exact => {
                let block = self.block(span.block);
                block.shape.jet((s - block.s0).clamp(0.0, block.length))
            }
            SpanShape::Blend(q) => q.jet(s.clamp(q.u0, q.u1)),
        }
    }

    /// Position in `blocks` of the block at s, on the exact path; at a border, the earlier one.
    pub(crate) fn block_at(&self, s: f64, hint: &mut usize) -> usize {
        let mut i = (*hint).min(self.blocks.len().saturating_sub(1));
        while i > 0 && self.blocks[i].s0 >= s {
            i -= 1;
        }
        while i + 1 < self.blocks.len() && self.blocks[i].end() < s {
            i += 1;
        }
        *hint = i;
        i
    }

    /// Drops all that lies before s (a border of cells), keeping the blocks and spans that reach beyond it.
    pub(crate) fn drop_before(&mut self, s: f64, cells: usize) {
        self.cells.drain(..cells);
        let spans = self.spans.partition_point(|p| p.s1 <= s);
        self.spans.drain(..spans);
        let blocks = self.blocks.partition_point(|b| b.end() <= s).min(self.blocks.len().saturating_sub(1));
        self.blocks.drain(..blocks);
        self.first_block += blocks as u64;
        self.s_begin = s;
    }
}

enum Corner {
    /// Value, slope and curvature agree: nothing to do.
    Smooth,
    Blend {
        half_width: f64,
        rounding: f64,
        quintic: Box<Quintic>,
    },
    Stop,
}

/// Rounding of the corner between two blocks.
fn corner(frame: &Frame<'_>, a: &PathBlock, b: &PathBlock, tolerance: Tolerance) -> Corner {
    let (end, start) = (a.shape.jet(a.length), b.shape.jet(0.0));
    let slope = start.first() - end.first();
    let bend = start.second() - end.second();
    let lines = a.shape.is_line() && b.shape.is_line();
    let scale = end.first().max_abs().max(start.first().max_abs());
    let kinked = slope.max_abs() > 1e-9 * scale;
    if !kinked && (lines || bend.max_abs() < 1e-9 * end.second().max_abs().max(start.second().max_abs())) {
        return Corner::Smooth;
    }
    let machine = frame.kinematics.machine;
    let room = 0.5 * a.length.min(b.length);
    let feed = a.feed.min(b.feed);
    let need = needed_half_width(frame, &end, &start, feed, a.is_rapid() && b.is_rapid());
    let mut d = room.min(need);
    if kinked {
        let (tip, angle) = size(machine, &(slope * (3.0 / 16.0)));
        d = d.min(tolerance.tip / tip).min(tolerance.angle / angle);
    }
    if lines {
        if d.is_nan() || d <= NARROWEST * room {
            return Corner::Stop;
        }
        let quintic = Box::new(blend(a, b, d));
        let (tip, _) = size(machine, &(slope * (3.0 / 16.0 * d)));
        return Corner::Blend { half_width: d, rounding: tip, quintic };
    }
    for _ in 0..12 {
        if d.is_nan() || d <= NARROWEST * room {
            return Corner::Stop;
        }
        let quintic = Box::new(blend(a, b, d));
        let (tip, angle) = blend_deviation(frame, a, b, &quintic, d);
        let excess = (tip / tolerance.tip).max(angle / tolerance.angle);
        if excess <= 1.0 {
            return Corner::Blend { half_width: d, rounding: tip, quintic };
        }
        // Deviation grows with d (kink) or with its square (curvature): the step of the first kind is always enough.
        d *= (0.98 / excess).max(0.1);
    }
    Corner::Stop
}

fn blend(a: &PathBlock, b: &PathBlock, d: f64) -> Quintic {
    Quintic::hermite(b.s0 - d, b.s0 + d, &a.shape.jet(a.length - d), &b.shape.jet(d))
}

/// Largest distance between blend and exact path at equal parameter, tip (or linear joints) and rotary joints.
fn blend_deviation(frame: &Frame<'_>, a: &PathBlock, b: &PathBlock, quintic: &Quintic, d: f64) -> (f64, f64) {
    const STEPS: i32 = 16;
    let mut worst = (0.0_f64, 0.0_f64);
    for i in 1..STEPS {
        let x = d * (2.0 * f64::from(i) / f64::from(STEPS) - 1.0);
        let exact = if x < 0.0 { a.shape.jet(a.length + x) } else { b.shape.jet(x) };
        let difference = quintic.jet(b.s0 + x).0[0] - exact.0[0];
        let (tip, angle) = size(frame.kinematics.machine, &difference);
        worst = (worst.0.max(tip), worst.1.max(angle));
    }
    (worst.0 * 1.02, worst.1 * 1.02) // between the points: at most 2 percent for a fifth degree
}

/// Euclidean size of the linear part (mm) and largest rotary part (radian) of a difference of task coordinates.
fn size(machine: &Machine, difference: &JointValues) -> (f64, f64) {
    let (mut linear, mut angle) = (0.0_f64, 0.0_f64);
    for (i, joint) in machine.joints.iter().enumerate() {
        match joint.kind {
            JointKind::Linear => linear += difference[i] * difference[i],
            JointKind::Rotary => angle = angle.max(difference[i].abs()),
        }
    }
    (linear.sqrt(), angle)
}

/// Half width at which the joints can take the corner at the feed, or at the highest speed of both blocks if that is
/// lower: with the largest second and third derivative of the blend from the table above.
fn needed_half_width(frame: &Frame<'_>, end: &JointJet, start: &JointJet, feed: f64, rapid: bool) -> f64 {
    let (qa, qb) = (frame.kinematics.joints(end), frame.kinematics.joints(start));
    let l = frame.limits;
    let velocity = if rapid { &l.rapid } else { &l.velocity };
    let mut speed = feed;
    for i in 0..l.count {
        let most = qa.first()[i].abs().max(qb.first()[i].abs());
        if most > 0.0 {
            speed = speed.min(velocity[i] / most);
        }
    }
    if !speed.is_finite() {
        return f64::INFINITY;
    }
    let mut d = 0.0_f64;
    for i in 0..l.count {
        let kink = (qb.first()[i] - qa.first()[i]).abs();
        let bend = (qb.second()[i] - qa.second()[i]).abs();
        let (a, j) = (BLEND_SHARE * l.acceleration[i], BLEND_SHARE * l.jerk[i]);
        d = d.max(0.75 * kink * speed * speed / a).max((1.5 * kink * speed.powi(3) / j).sqrt());
        // A step of curvature is spread over 2 d: third derivative about 1.5 bend / (2 d).
        d = d.max(0.75 * bend * speed.powi(3) / j);
    }
    // Some width in any case: a kink that needs no rounding at the feed still must not jump in velocity.
    d.max(1e-3 * end.first().max_abs().max(1e-3))
}

/// Cells of the exact path of a block over s0..s1: end and limits of each.
fn exact_cells(frame: &Frame<'_>, block: &PathBlock, s0: f64, s1: f64) -> Vec<(f64, CellLimits)> {
    let rapid = block.is_rapid();
    let tcp = frame.kinematics.is_tcp();
    let machine = frame.kinematics.machine;
    let (u0, u1) = (s0 - block.s0, s1 - block.s0);
    let turn = |slope: &JointValues| {
        let rotary = machine.joints.iter().enumerate().filter(|(_, j)| j.kind == JointKind::Rotary);
        rotary.fold(0.0_f64, |m, (i, _)| m.max(slope[i].abs())) * (u1 - u0)
    };
    let limits = |a: f64, b: f64, bounds: &DerivativeBounds| {
        (block.s0 + b, cell_limits(frame.limits, rapid, block.feed, b - a, bounds))
    };
    let cut = |n: usize| {
        (0..n).map(move |i| {
            let at = |k: usize| if k == n { u1 } else { u0 + (u1 - u0) * k as f64 / n as f64 };
            (at(i), at(i + 1))
        })
    };
    match &block.shape {
        Shape::Line { slope, .. } => {
            let turn = turn(slope);
            if !tcp || turn == 0.0 {
                let q = frame.kinematics.joints(&block.shape.jet(u0)).first().map(f64::abs);
                let zero = JointValues::ZERO;
                return vec![limits(u0, u1, &DerivativeBounds { first: q, first_low: q, second: zero, third: zero })];
            }
            let n = (turn / CELL_TURN).ceil().max(1.0) as usize;
            cut(n).map(|(a, b)| limits(a, b, &point_bounds(frame, |u| block.shape.jet(u), a, b, 3))).collect()
        }
        // Independent joints: their own laws keep the limits, the parameter is time.
        Shape::Timed(_) => Vec::new(),
        Shape::Arc(arc) => {
            let n = (arc.omega.abs() * (u1 - u0) / CELL_ARC).max(turn(&arc.slope) / CELL_TURN).ceil().max(1.0) as usize;
            cut(n)
                .map(|(a, b)| {
                    let bounds =
                        if tcp { point_bounds(frame, |u| block.shape.jet(u), a, b, POINTS) } else { arc.bounds(a, b) };
                    limits(a, b, &bounds)
                })
                .collect()
        }
        Shape::Spline(pieces) => {
            let mut cells = Vec::with_capacity(pieces.len());
            for piece in pieces {
                let (a, b) = (piece.u0.max(u0), piece.u1.min(u1));
                if b - a > 1e-12 * block.length {
                    cells.push(limits(a, b, &point_bounds(frame, |u| piece.jet(u), a, b, POINTS)));
                }
            }
            if let Some(last) = cells.last_mut() {
                last.0 = s1;
            }
            cells
        }
    }
}

/// Bounds of the joints' derivatives from points of a cell, with a surcharge for what lies between them.
fn point_bounds(frame: &Frame<'_>, task: impl Fn(f64) -> JointJet, a: f64, b: f64, points: usize) -> DerivativeBounds {
    let mut bounds = DerivativeBounds {
        first: JointValues::ZERO,
        first_low: JointValues([f64::INFINITY; proveout_machine::MAX_JOINTS]),
        second: JointValues::ZERO,
        third: JointValues::ZERO,
    };
    let mut sign = JointValues::ZERO;
    for i in 0..points {
        let u = a + (b - a) * i as f64 / (points - 1) as f64;
        let q = frame.kinematics.joints(&task(u));
        let high = |m: f64, v: f64| m.max(v.abs());
        bounds.first = bounds.first.zip_map(q.first(), high);
        bounds.second = bounds.second.zip_map(q.second(), high);
        bounds.third = bounds.third.zip_map(q.third(), high);
        for k in 0..frame.limits.count {
            let v = q.first()[k];
            bounds.first_low[k] = if v * sign[k] < 0.0 { 0.0 } else { bounds.first_low[k].min(v.abs()) };
            sign[k] = v;
        }
    }
    bounds.second = bounds.second * POINT_SURCHARGE;
    bounds.third = bounds.third * POINT_SURCHARGE;
    // A function passes its values at points of distance h by at most h^2/8 times its second derivative.
    let h = (b - a) / (points - 1) as f64;
    let between = bounds.third * (h * h / 8.0);
    bounds.first = bounds.first + between;
    bounds.first_low = bounds.first_low.zip_map(between, |low, e| (low - e).max(0.0));
    bounds
}
