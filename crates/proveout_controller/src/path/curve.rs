//! The spans of a run of lines whose corners are rounded together: see `fit.rs`.
//!
//! Between the places where supports begin or end the fitted path y is a polynomial of fourth degree: two
//! spans a block. A span may leave out such places that lie close together; it then is the polynomial of
//! fifth degree that has value, slope and curvature of y at its ends.
//!
//! ```text
//!   supports   |-----------|
//!                    |-----------|
//!                         |------------|
//!   spans      |-----|----|.|----|.....|      . left out: near to the last knot, as part of the half width
//! ```
//!
//! Where supports overlap, knots lie at borders of blocks rather than where supports end.
//!
//! Where places were left out, two things are looked at again, and no place is left out there if one does not
//! hold. *Distance to the exact path*: at the borders of blocks and in their middle, with h^2/8 times the
//! highest second derivative for what lies between (h: distance of the points). *Slope*: y' is a mean of the
//! slopes of the blocks that act; the control points of the span's derivative must lie between their least
//! and highest too, so that no joint reverses that the program does not reverse, and no longer than the
//! longest of them for the tip.

use proveout_machine::{JointValues, MAX_JOINTS};

use super::{
    PathCell, PathContext, PathSpan, RunPath, SpanShape, Tolerance, WayMeasure,
    cells::blend_cells,
    corner_rounding::size,
    fit::{EventKind, Fit, Kink, lift_jet},
};
use crate::{jet::JointJet, shape::Quintic};

/// Distance between knots of spans as part of the half width of the kink whose support begins or ends there.
const SPACING: f64 = 0.75;
/// The same for knots at borders of blocks, which come first.
const BORDER_SPACING: f64 = 0.4;
/// The same for a place that counts as the last knot: the lift is 1e-18 of the half width there, its
/// curvature 1e-6 of the highest.
const NOTHING: f64 = 1e-6;
/// Places nearer than this to each other are one, part of the way and of one at least.
const SAME_PLACE: f64 = 1e-9;
/// Rounding of a slope, part of the largest one.
const ROUNDING: f64 = 1e-12;

/// The fit of a run and the span under way.
#[derive(Debug, Default)]
pub(super) struct LineFit {
    fit: Fit,
    /// Number of kinks in whose support the present place lies.
    active: usize,
    /// The most of them since the last knot.
    most: usize,
    /// Kinks, from the front, that end before the last knot.
    past: usize,
    /// y at the last knot, in a support.
    start: Option<JointJet>,
    /// Places left out since.
    left_out: Vec<f64>,
}

impl LineFit {
    /// A run whose supports begin at `low` or later.
    pub(super) fn from(low: f64) -> Self {
        Self { fit: Fit::from(low), ..Self::default() }
    }
}

/// Sizes of differences of task coordinates.
fn sizes(frame: &PathContext<'_>) -> impl Fn(&JointValues) -> Tolerance {
    |difference| {
        let (tip, angle) = size(frame.kinematics.machine, difference);
        Tolerance { tip, angle }
    }
}

impl RunPath {
    /// Takes a kink into the fit, and finishes what it decides.
    pub(super) fn round(&mut self, frame: &PathContext<'_>, kink: Kink) {
        self.curve.fit.push(kink);
        self.curve.fit.settle(None, &sizes(frame));
        if let Some(limit) = self.curve.fit.known_to() {
            self.spans_to(frame, limit);
        }
    }

    /// Finishes the run of lines up to s, where no support reaches.
    pub(super) fn end_lines(&mut self, frame: &PathContext<'_>, s: f64) {
        self.curve.fit.settle(Some(s), &sizes(frame));
        self.spans_to(frame, f64::INFINITY);
        self.exact_to(frame, s);
    }

    /// Spans up to the last event at or before `limit`; exact ones up to it where no support reaches.
    fn spans_to(&mut self, frame: &PathContext<'_>, limit: f64) {
        while let Some(event) = self.curve.fit.next_event().filter(|e| e.s <= limit) {
            self.curve.fit.take(event);
            let way = event.s - self.s_done;
            let curve = &mut self.curve;
            match event.kind {
                EventKind::Border => {
                    // Where supports overlap, knots at borders of blocks spare what cuts the motion block by
                    // block the most.
                    if curve.most > 1 && curve.active > 0 && way >= BORDER_SPACING * event.half_width {
                        self.push_curve(frame, event.s);
                    }
                    continue;
                }
                _ if event.flat => continue,
                EventKind::Begin if curve.active == 0 => {
                    self.exact_to(frame, event.s);
                    self.curve.start = Some(self.fitted(event.s));
                    (self.curve.active, self.curve.most) = (1, 1);
                    continue;
                }
                EventKind::Begin => curve.active += 1,
                EventKind::End => curve.active -= 1,
            }
            curve.most = curve.most.max(curve.active);
            if way < NOTHING * event.half_width {
                continue;
            }
            if curve.active == 0 || way >= SPACING * event.half_width {
                self.push_curve(frame, event.s);
            } else {
                curve.left_out.push(event.s);
            }
        }
        if self.curve.active == 0 && limit.is_finite() {
            self.exact_to(frame, limit);
        }
        let rounding = self.curve.fit.rounding(self.s_done, &sizes(frame));
        if rounding > 0.0 {
            self.max_rounding = self.max_rounding.max(rounding + self.off_chord);
        }
        let before = self.curve.fit.kinks().len();
        self.curve.fit.forget_before(self.s_done);
        self.curve.past = self.curve.past.saturating_sub(before - self.curve.fit.kinks().len());
    }

    /// Exact spans up to s.
    fn exact_to(&mut self, frame: &PathContext<'_>, s: f64) {
        let mut i = self.blocks.partition_point(|b| b.end() <= self.s_done);
        while i < self.blocks.len() && self.blocks[i].s0 < s {
            self.finish_exact(frame, self.first_block + i as u64, self.blocks[i].end().min(s));
            i += 1;
        }
    }

    /// A span from the last knot to s.
    fn push_curve(&mut self, frame: &PathContext<'_>, s: f64) {
        let left_out = std::mem::take(&mut self.curve.left_out);
        let end = self.fitted(s);
        let Some(start) = self.curve.start.replace(end) else { return };
        let (from, overlaps) = (self.s_done, self.curve.most > 1);
        let whole = Quintic::hermite(from, s, &start, &end);
        if left_out.is_empty() || self.keeps_slopes(frame, &whole) && self.keeps_tolerance(frame, &whole) {
            self.push_span(frame, whole, overlaps);
        } else {
            // Places may coincide with each other and with the ends.
            let apart = SAME_PLACE * s.abs().max(1.0);
            let mut before = (from, start);
            for at in left_out.into_iter().filter(|at| s - at > apart) {
                if at - before.0 > apart {
                    let jet = self.fitted(at);
                    self.push_span(frame, Quintic::hermite(before.0, at, &before.1, &jet), overlaps);
                    before = (at, jet);
                }
            }
            self.push_span(frame, Quintic::hermite(before.0, s, &before.1, &end), overlaps);
        }
        let curve = &mut self.curve;
        curve.most = curve.active;
        while curve.fit.kinks().get(curve.past).is_some_and(|k| k.end() <= s) {
            curve.past += 1;
        }
    }

    fn push_span(&mut self, frame: &PathContext<'_>, quintic: Quintic, overlaps: bool) {
        let (s0, s1) = (self.s_done, quintic.u1);
        let first = self.blocks.partition_point(|b| b.end() <= s0).min(self.blocks.len() - 1);
        let number = self.first_block + first as u64;
        let feed = self.blocks[first..].iter().take_while(|b| b.s0 < s1).fold(f64::INFINITY, |m, b| m.min(b.feed));
        let tip_moves = self.blocks[first].tip_moves;
        let way = WayMeasure::of([tip_moves, tip_moves]);
        for (end, limits, joints) in blend_cells(frame, (false, feed, way), s0, &quintic) {
            self.cells.push(PathCell { s1: end, limits, block: number, exact: overlaps, joints });
        }
        self.spans.push(PathSpan { s0, s1, block: number, shape: SpanShape::Blend(Box::new(quintic)), way });
        self.s_done = s1;
    }

    /// Kinks that act between the last knot and s.
    fn acting(&self, s: f64) -> impl Iterator<Item = &Kink> {
        self.curve.fit.kinks().range(self.curve.past..).take_while(move |k| k.half_width() > 0.0 && k.begin() <= s)
    }

    /// y at s with its first two derivatives.
    fn fitted(&self, s: f64) -> JointJet {
        let i = self.blocks.partition_point(|b| b.end() < s).min(self.blocks.len() - 1);
        let (block, number) = (&self.blocks[i], self.first_block + i as u64);
        let mut jet = block.course().jet(s - block.s0);
        // The line between the moved ends of the block.
        let moved = |number: Option<u64>| self.curve.fit.numbered(number).map_or(JointValues::ZERO, |k| k.point.shift);
        let [begin, end] = [number.checked_sub(1), Some(number)].map(moved);
        let lean = (end - begin) * (1.0 / block.length);
        jet.0[0] = jet.0[0] + begin + lean * (s - block.s0);
        jet.0[1] = jet.0[1] + lean;
        for kink in self.acting(s).filter(|k| !k.is_flat()) {
            let lift = lift_jet(s - kink.s, kink.half_width(), number > kink.number);
            let slope = kink.kink();
            for (sum, part) in jet.0.iter_mut().zip(lift) {
                *sum = *sum + slope * part;
            }
        }
        jet
    }

    /// Whether the slope of a span stays between those of the blocks that act on it.
    fn keeps_slopes(&self, frame: &PathContext<'_>, span: &Quintic) -> bool {
        let machine = frame.kinematics.machine;
        let any = [f64::INFINITY; MAX_JOINTS];
        let (mut low, mut high, mut longest) = (JointValues(any), JointValues(any.map(|x| -x)), 0.0_f64);
        for kink in self.acting(span.u1) {
            for slope in kink.slopes() {
                low = low.zip_map(slope, f64::min);
                high = high.zip_map(slope, f64::max);
                longest = longest.max(size(machine, &slope).0);
            }
        }
        let rounding = ROUNDING * low.max_abs().max(high.max_abs()).min(f64::MAX);
        span.slopes().iter().all(|slope| {
            let within =
                (0..frame.limits.count).all(|i| slope[i] >= low[i] - rounding && slope[i] <= high[i] + rounding);
            within && size(machine, slope).0 <= longest + rounding
        })
    }

    /// Whether a span stays as near to the exact path as the tolerances ask for.
    fn keeps_tolerance(&self, frame: &PathContext<'_>, span: &Quintic) -> bool {
        let machine = frame.kinematics.machine;
        let inner = self.acting(span.u1).map(|k| k.s).filter(|s| *s > span.u0 && *s < span.u1);
        let Some(tolerance) = self.acting(span.u1).map(|k| k.tolerance).reduce(Tolerance::min) else { return false };
        let bend = size(machine, &span.bounds().second);
        let mut from = span.u0;
        for to in inner.chain([span.u1]) {
            let h = 0.5 * (to - from);
            let middle = from + h;
            let i = self.blocks.partition_point(|b| b.end() < middle).min(self.blocks.len() - 1);
            let block = &self.blocks[i];
            for s in [from, middle, to] {
                let off: JointValues = span.jet(s).0[0] - block.course().jet(s - block.s0).0[0];
                let (tip, angle) = size(machine, &off);
                let between = h * h / 8.0;
                if tip + between * bend.0 > tolerance.tip || angle + between * bend.1 > tolerance.angle {
                    return false;
                }
            }
            from = to;
        }
        true
    }
}
