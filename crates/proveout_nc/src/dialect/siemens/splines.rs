//! Splines and polynomials: BSPLINE, CSPLINE, ASPLINE, POLY.
//!
//! ```text
//!   BSPLINE   points are control points, PW their weights, SD the degree; the curve begins at the tool
//!             position and ends at the last point, so the end knots repeat degree + 1 times. The
//!             intervals between the other knots are PL = 1
//!   CSPLINE   through all points, continuous in direction and curvature
//!   ASPLINE   through all points, directions from two neighbors on either side
//!             (H. Akima, J. ACM 17, 1970, eq. 1)
//!   POLY      x(p) = x0 + a1 p + a2 p^2 + .. + a5 p^5, p from 0 to PL; PO[X]=(end, a2, a3, a4, a5);
//!             a1 follows from the end
//! ```
//!
//! After Siemens, *NC programming, Job planning*, "Spline interpolation" and "Polynomial
//! interpolation". The parameter of C and A splines is the length of the chords. BAUTO and EAUTO
//! are not-a-knot ends, BNAT and ENAT have no curvature, BTAN and ETAN continue from the block
//! before and into the one after: the manual says no more, and a note reports what is assumed. A
//! curve ends at a block that is more than a point. Curves of X, Y and Z are read. Where the
//! program does not know one of the three, and the curve does not use it, the curve is emitted as
//! chords of the other two: a Bezier curve needs all three.

use super::modal::{FeedMode, Interpolation, SplineEnd, SplineKind};
use super::parser::{SiemensBlock, WordKind};
use super::pending::Pending;
use super::run_state::{Interpreter, SplineCurve, SplinePoint};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame;
use crate::spline::{self, CHORD_TOLERANCE_MM, Homogeneous};
use crate::{CompSide, Motion, Op, SplineMotion};

/// Most points of one curve.
const MAX_POINTS: usize = 100_000;
/// Most commands of one curve: they are kept until they are emitted.
const MAX_COMMANDS: usize = 200_000;
/// Highest degree of a polynomial.
const MAX_DEGREE: usize = 5;
/// Points nearer than this in each axis are one, mm.
const SAME_POINT_MM: f64 = 1e-9;
/// Changes of slope whose sum is no more than this are none: the slopes weigh the same.
const SAME_SLOPE: f64 = 1e-15;

type Vector = [f64; 3];

fn plus(a: Vector, b: Vector, by: f64) -> Vector {
    std::array::from_fn(|i| a[i] + by * b[i])
}

impl Interpreter {
    /// A block that is only a point of the curve: axes, F, PW, PL, SD.
    fn is_point(block: &SiemensBlock) -> bool {
        block.statement.is_none()
            && block.words.iter().all(|word| match &word.kind {
                WordKind::Address {
                    letter: b'X'..=b'Z' | b'F' | b'A'..=b'C' | b'U'..=b'W', extension: None, ..
                } => true,
                WordKind::Assign { name, .. } => matches!(name.as_str(), "PW" | "PL" | "SD" | "AX"),
                _ => false,
            })
    }

    /// Before a block is executed: a curve ends if the block is more than a point. With ETAN it
    /// waits for the words of the block.
    pub(super) fn curve_before(&mut self, block: &SiemensBlock) -> Result<(), Fault> {
        if self.own.curve.is_none() || Self::is_point(block) || self.modal.spline_end == SplineEnd::Tangent {
            return Ok(());
        }
        self.end_curve(None)
    }

    /// The direction in which ETAN continues: that of a straight block.
    pub(super) fn curve_into(&mut self, p: &Pending, block: &SiemensBlock, span: Span) -> Result<(), Fault> {
        if self.own.curve.is_none() || Self::is_point(block) {
            return Ok(());
        }
        let straight = matches!(self.modal.interpolation, Interpolation::Linear | Interpolation::Rapid) && p.has_axis();
        let into = match (straight, self.position.work.xyz(), self.targets(p, span)?.xyz()) {
            (true, Some(from), Some(to)) => frame::unit(frame::sub(to, from)),
            _ => None,
        };
        self.end_curve(into)
    }

    /// Takes a point of a spline.
    pub(super) fn spline_point(&mut self, kind: SplineKind, p: &Pending, span: Span) -> Result<(), Fault> {
        let refused = |what: &str, remedy: &str| Err(super::block::refused(what, span, remedy));
        if self.modal.compensation.side != CompSide::Off {
            return refused("a spline with G41 or G42", "write G40 before it");
        }
        if p.programmed & !super::block::LINEAR != 0 || p.has_orientation() {
            return refused("a spline of other axes than X, Y and Z", "program the path with G1");
        }
        if p.has_center() || p.radius.is_some() || p.opening.is_some() || !p.polynomial.iter().all(Option::is_none) {
            return Err(
                Fault::new(codes::CONFLICT, span, "words of an arc or a polynomial in a spline").help("remove them")
            );
        }
        if p.chamfer.is_some() || p.chamfer_leg.is_some() || p.corner_radius.is_some() {
            return refused("a chamfer or rounding in a spline", "remove it");
        }
        if !p.has_axis() {
            return Ok(());
        }
        let start = self.curve_start(p, "the spline", span)?;
        let end = self.targets(p, span)?;
        let motion = self.complete(p, end, p.programmed, span)?;
        let weight = p.weight.unwrap_or(1.0);
        if !(weight > 0.0 && weight.is_finite()) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("the weight PW must be above zero and is {weight}"),
            )
            .help("write PW=1"));
        }
        if kind != SplineKind::Basis && (p.weight.is_some() || p.interval.is_some()) {
            return Err(Fault::new(codes::CONFLICT, span, "PW and PL belong to BSPLINE").help("remove them"));
        }
        if p.interval.is_some_and(|interval| !(interval >= 0.0 && interval.is_finite())) {
            return Err(Fault::new(codes::BAD_VALUE, span, "the interval PL must not be negative").help("write PL=1"));
        }
        self.need_feed(span)?;
        let at = std::array::from_fn(|axis| motion.end.get(axis).unwrap_or(0.0));
        if self.modal.feed_mode == FeedMode::InverseTime {
            return refused("a spline with G93", "write G94 before it");
        }
        let (before, degree) = (self.own.tangent, self.modal.spline_degree);
        let fresh = || Box::new(SplineCurve { kind, degree, start, before, points: Vec::new() });
        let curve = self.own.curve.get_or_insert_with(fresh);
        if curve.points.len() >= MAX_POINTS {
            return Err(Fault::new(codes::LOOP_LIMIT, span, format!("the spline has more than {MAX_POINTS} points"))
                .help("write G1 between two of its points"));
        }
        let location = self.location.clone();
        self.position.move_to(motion.end, motion.end_base);
        let feed = self.technology.feed;
        curve.points.push(SplinePoint { at, weight, interval: p.interval, motion, feed, location, span });
        Ok(())
    }

    /// Emits the curve. `into`: direction of the block after it.
    pub(super) fn end_curve(&mut self, into: Option<Vector>) -> Result<(), Fault> {
        let Some(curve) = self.own.curve.take() else { return Ok(()) };
        let here = self.location.clone();
        let feed = self.technology.feed;
        let result = match curve.kind {
            SplineKind::Basis => self.basis_spline(&curve),
            kind => self.spline_through(kind, &curve, into),
        };
        self.location = here;
        self.technology.feed = feed;
        if std::mem::take(&mut self.own.curve_torn) {
            // After a fault in its blocks the curve is not the intended one.
            return Ok(());
        }
        // A fault that follows from an earlier one must not hide a fault of the block that ends the
        // curve.
        result.or_else(|fault| if self.recovery.faults.doubt.hides_shape(fault.code) { Ok(()) } else { Err(fault) })
    }

    fn take_place(&mut self, point: &SplinePoint) {
        self.location = point.location.clone();
        self.technology.feed = point.feed;
        self.tell_feed();
    }

    fn basis_spline(&mut self, curve: &SplineCurve) -> Result<(), Fault> {
        let degree = curve.degree;
        let count = curve.points.len();
        let last = &curve.points[count - 1];
        if count < degree {
            let message = format!("a BSPLINE of degree {degree} needs {degree} points after its start and has {count}");
            self.location = last.location.clone();
            return Err(Fault::new(codes::ARC_GEOMETRY, last.span, message).help("write more points, or SD=2"));
        }
        if curve.points.iter().any(|point| point.interval.is_some()) {
            self.assume("PL of a BSPLINE is the interval that ends at the knot of its point; those of the last points, which the degree takes up, are not used");
        }
        let mut knots = vec![0.0; degree + 1];
        for point in &curve.points[..=count - degree] {
            let end = knots.last().copied().unwrap_or(0.0);
            knots.push(end + point.interval.unwrap_or(1.0));
        }
        let end = knots.last().copied().unwrap_or(0.0);
        knots.extend(std::iter::repeat_n(end, degree));
        // A knot with a multiplicity above the degree tears the curve.
        let torn = |run: &[f64]| run.iter().all(|knot| *knot == run[0]);
        if knots[1..knots.len() - 1].windows(degree + 1).any(torn) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                last.span,
                "too many consecutive intervals PL of the BSPLINE are zero",
            )
            .help("leave PL out, or write PL=1"));
        }
        if end <= 0.0 {
            return Err(Fault::new(codes::BAD_VALUE, last.span, "all intervals PL of the BSPLINE are zero")
                .help("leave PL out, or write PL=1"));
        }
        let mut points: Vec<Homogeneous> = vec![[curve.start[0], curve.start[1], curve.start[2], 1.0]];
        points.extend(
            curve.points.iter().map(|p| [p.at[0] * p.weight, p.at[1] * p.weight, p.at[2] * p.weight, p.weight]),
        );
        let pieces = spline::bezier_pieces(degree, &knots, &points);
        let mut chords = 0;
        for (i, piece) in pieces.into_iter().enumerate() {
            // The last of the points that shape this piece.
            let point = &curve.points[(i + degree - 1).min(count - 1)];
            self.take_place(point);
            chords += self.bezier(&piece, point)?;
        }
        self.told_chords("BSPLINE", chords);
        Ok(())
    }

    fn told_chords(&mut self, word: &str, chords: usize) {
        if chords > 0 {
            self.note(format!("the {word} is given as {chords} chords within {CHORD_TOLERANCE_MM} mm of the curve"));
        }
    }

    /// Emits a Bezier piece as a cubic, or as chords; returns the number of chords.
    fn bezier(&mut self, piece: &[Homogeneous], point: &SplinePoint) -> Result<usize, Fault> {
        let flat = point.motion.end.xyz().is_none();
        if let Some([_, first, second, to]) = spline::cubic(piece).filter(|_| !flat) {
            let control = [first, second];
            let motion = self.motion_on(point, to, true);
            let control_base = control.map(|p| self.position.point_in_base(p));
            self.own.tangent = frame::unit(frame::sub(to, second)).or(self.own.tangent);
            self.position.move_to(motion.end, motion.end_base);
            <super::run_state::Siemens as crate::channel::Language>::moving(self);
            self.emit(Op::Spline(SplineMotion { motion, control, control_base }));
            return Ok(0);
        }
        if self.queue.len() > MAX_COMMANDS {
            let message = format!("the curve gives more than {MAX_COMMANDS} chords");
            return Err(Fault::new(codes::LOOP_LIMIT, point.span, message).help("write G1 between two of its points"));
        }
        let ends = spline::chords(piece, CHORD_TOLERANCE_MM).ok_or_else(|| spline::too_long(point.span))?;
        if let [.., before, last] = piece {
            let way = frame::sub(spline::projected(last), spline::projected(before));
            self.own.tangent = frame::unit(way).or(self.own.tangent);
        }
        for end in &ends {
            let motion = self.motion_on(point, *end, false);
            self.go(motion, false);
        }
        Ok(ends.len())
    }

    /// The motion of a point, with another end.
    fn motion_on(&self, point: &SplinePoint, to: Vector, keep: bool) -> Motion {
        let mut motion = point.motion.clone();
        if keep && (0..3).all(|i| motion.end.get(i) == Some(to[i])) {
            return motion;
        }
        let base = self.position.point_in_base(to);
        for axis in (0..3).filter(|&axis| point.motion.end.get(axis).is_some()) {
            motion.end.put(axis, to[axis]);
            motion.end_base.put(axis, base[axis]);
        }
        motion
    }

    fn spline_through(&mut self, kind: SplineKind, curve: &SplineCurve, into: Option<Vector>) -> Result<(), Fault> {
        let mut at = vec![curve.start];
        let mut of: Vec<&SplinePoint> = Vec::new();
        for point in &curve.points {
            // A point twice is one point.
            if frame::sub(point.at, at[at.len() - 1]).iter().any(|d| d.abs() > SAME_POINT_MM) {
                at.push(point.at);
                of.push(point);
            }
        }
        let Some(last) = curve.points.last() else { return Ok(()) };
        if of.is_empty() {
            return Ok(());
        }
        let chord: Vec<f64> =
            at.windows(2).map(|w| frame::sub(w[1], w[0]).iter().map(|d| d * d).sum::<f64>().sqrt()).collect();
        let ends =
            [(self.modal.spline_begin, curve.before, "BTAN", "before"), (self.modal.spline_end, into, "ETAN", "after")];
        let mut fixed = [None; 2];
        for (slot, (end, direction, word, side)) in fixed.iter_mut().zip(ends) {
            if end == SplineEnd::Tangent {
                let Some(direction) = direction else {
                    self.location = last.location.clone();
                    let message = format!("{word} needs a straight block {side} the spline");
                    return Err(
                        Fault::new(codes::ARC_GEOMETRY, last.span, message).help("write one, or BAUTO and EAUTO")
                    );
                };
                *slot = Some(direction);
            }
        }
        let natural = [self.modal.spline_begin, self.modal.spline_end].map(|end| end == SplineEnd::Natural);
        let word = if kind == SplineKind::Cubic { "CSPLINE" } else { "ASPLINE" };
        self.assume(format!(
            "{word}: the parameter is the length of the chords, and free ends (BAUTO, EAUTO) {}",
            if kind == SplineKind::Cubic { "are not-a-knot ends" } else { "go on as Akima's continuation" }
        ));
        let slopes: Vec<Vector> = {
            let mut columns = [const { Vec::new() }; 3];
            for (axis, column) in columns.iter_mut().enumerate() {
                let values: Vec<f64> = at.iter().map(|p| p[axis]).collect();
                let ends = [0, 1].map(|i| match (fixed[i], natural[i]) {
                    (Some(direction), _) => EndSlope::Slope(direction[axis]),
                    (None, true) => EndSlope::Natural,
                    (None, false) => EndSlope::Free,
                });
                *column = if kind == SplineKind::Cubic {
                    cubic_slopes(&chord, &values, ends)
                } else {
                    akima_slopes(&chord, &values, ends)
                };
            }
            (0..at.len()).map(|i| [columns[0][i], columns[1][i], columns[2][i]]).collect()
        };
        let mut chords = 0;
        for (i, point) in of.iter().enumerate() {
            self.take_place(point);
            let first = plus(at[i], slopes[i], chord[i] / 3.0);
            let second = plus(at[i + 1], slopes[i + 1], -chord[i] / 3.0);
            let piece = [at[i], first, second, at[i + 1]].map(|p| [p[0], p[1], p[2], 1.0]);
            chords += self.bezier(&piece, point)?;
        }
        self.told_chords(word, chords);
        Ok(())
    }

    /// Where a curve begins. An axis that the program does not know is zero and has no meaning: the
    /// curve must not use it, and the frame must not mix it with the others.
    fn curve_start(&self, p: &Pending, what: &str, span: Span) -> Result<Vector, Fault> {
        let work = self.position.work;
        let linear = &self.position.frame().linear;
        let alone = |axis: usize| {
            p.axes[axis].is_none()
                && (0..3).filter(|&i| i != axis).all(|i| linear[i][axis] == 0.0 && linear[axis][i] == 0.0)
        };
        if (0..3).all(|axis| work.get(axis).is_some() || alone(axis)) {
            return Ok(std::array::from_fn(|axis| work.get(axis).unwrap_or(0.0)));
        }
        self.start_point(what, span)
    }

    /// A block under POLY.
    pub(super) fn polynomial(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        if self.modal.compensation.side != CompSide::Off {
            return Err(super::block::refused("POLY with G41 or G42", span, "write G40 before it"));
        }
        if p.programmed & !super::block::LINEAR != 0 || p.has_orientation() || p.has_center() || p.radius.is_some() {
            return Err(super::block::refused("POLY of other axes than X, Y and Z", span, "program the path with G1"));
        }
        if !p.has_axis() {
            return Ok(());
        }
        let length = p.interval.unwrap_or(1.0);
        if !(length > 0.0 && length.is_finite()) {
            return Err(Fault::new(
                codes::BAD_VALUE,
                span,
                format!("the interval PL must be above zero and is {length}"),
            )
            .help("write PL=1"));
        }
        self.need_feed(span)?;
        let start = self.curve_start(p, "the polynomial", span)?;
        let end = self.targets(p, span)?;
        let motion = self.complete(p, end, p.programmed, span)?;
        let to: Vector = std::array::from_fn(|axis| end.get(axis).unwrap_or(0.0));
        let unit = self.modal.units.length();
        // Coefficients of powers of the parameter that runs from 0 to 1.
        let mut powers = [[0.0; 3]; MAX_DEGREE + 1];
        let mut degree = 1;
        for axis in 0..3 {
            powers[0][axis] = start[axis];
            powers[1][axis] = to[axis] - start[axis];
            for (i, a) in p.polynomial[axis].iter().flatten().enumerate() {
                let scaled = a * unit * length.powi(i as i32 + 2);
                powers[i + 2][axis] = scaled;
                powers[1][axis] -= scaled;
                if *a != 0.0 {
                    degree = degree.max(i + 2);
                }
            }
        }
        let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
        let mut piece: Vec<Homogeneous> = (0..=degree)
            .map(|j| {
                let mut point = [0.0, 0.0, 0.0, 1.0];
                for (k, power) in powers.iter().enumerate().take(j + 1) {
                    let factor = choose(j, k) / choose(degree, k);
                    for axis in 0..3 {
                        point[axis] += factor * power[axis];
                    }
                }
                point
            })
            .collect();
        piece[degree] = [to[0], to[1], to[2], 1.0];
        if degree == 1 {
            self.own.tangent = frame::unit(frame::sub(to, start)).or(self.own.tangent);
            self.go(motion, false);
            return Ok(());
        }
        let location = self.location.clone();
        let feed = self.technology.feed;
        let point = SplinePoint { at: to, weight: 1.0, interval: None, motion, feed, location, span };
        let chords = self.bezier(&piece, &point)?;
        self.told_chords("polynomial", chords);
        Ok(())
    }
}

/// Condition at an end of a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
enum EndSlope {
    Free,
    Natural,
    Slope(f64),
}

/// Slopes of the cubic spline through values at chord lengths `h` apart, continuous in the second
/// derivative (C. de Boor, *A Practical Guide to Splines*, 1978, chapter IV): three in a row, and a
/// condition at either end; not-a-knot where it is free.
fn cubic_slopes(h: &[f64], y: &[f64], ends: [EndSlope; 2]) -> Vec<f64> {
    let n = y.len();
    let d: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
    if n == 2 && ends == [EndSlope::Free; 2] {
        return vec![d[0]; 2];
    }
    // Rows of lower, middle, upper, right; two points leave nothing free, three make a parabola.
    let mut rows = vec![[0.0, 1.0, 0.0, 0.0]; n];
    for i in 1..n - 1 {
        rows[i] = [h[i], 2.0 * (h[i - 1] + h[i]), h[i - 1], 3.0 * (h[i] * d[i - 1] + h[i - 1] * d[i])];
    }
    let boundary = |end: EndSlope, h0: f64, h1: Option<f64>, d0: f64, d1: f64| -> [f64; 3] {
        // Middle, neighbor, right.
        match (end, h1) {
            (EndSlope::Slope(slope), _) => [1.0, 0.0, slope],
            (EndSlope::Natural, _) => [2.0, 1.0, 3.0 * d0],
            (EndSlope::Free, None) => [1.0, 1.0, 2.0 * d0],
            (EndSlope::Free, Some(h1)) => {
                let sum = h0 + h1;
                [h1, sum, (h1 * (3.0 * h0 + 2.0 * h1) * d0 + h0 * h0 * d1) / sum]
            }
        }
    };
    // With three points both not-a-knot conditions are the same: a parabola.
    let wide = |i: usize| (n > 3 || ends[1 - i] != EndSlope::Free).then_some(()).filter(|()| n > 2);
    let [middle, neighbor, right] = boundary(ends[0], h[0], wide(0).map(|()| h[1]), d[0], d[1.min(n - 2)]);
    rows[0] = [0.0, middle, neighbor, right];
    let m = n - 1;
    let [middle, neighbor, right] =
        boundary(ends[1], h[m - 1], wide(1).map(|()| h[m - 2]), d[m - 1], d[(m - 1).saturating_sub(1)]);
    rows[m] = [neighbor, middle, 0.0, right];
    for i in 1..n {
        let factor = rows[i][0] / rows[i - 1][1];
        rows[i][1] -= factor * rows[i - 1][2];
        rows[i][3] -= factor * rows[i - 1][3];
    }
    let mut s = vec![0.0; n];
    for i in (0..n).rev() {
        let next = if i + 1 < n { rows[i][2] * s[i + 1] } else { 0.0 };
        s[i] = (rows[i][3] - next) / rows[i][1];
    }
    s
}

/// Slopes of Akima's spline: between the chords before and after, each weighted by the change of
/// direction beyond the other.
fn akima_slopes(h: &[f64], y: &[f64], ends: [EndSlope; 2]) -> Vec<f64> {
    let n = y.len();
    let d: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
    // Two chords are added at either end, on the parabola through the last three points.
    let at = |i: i64| -> f64 {
        let last = d.len() as i64 - 1;
        let get = |k: i64| d[k.clamp(0, last) as usize];
        match i {
            -1 => 2.0 * get(0) - get(1),
            -2 => 3.0 * get(0) - 2.0 * get(1),
            i if i == last + 1 => 2.0 * get(last) - get(last - 1),
            i if i == last + 2 => 3.0 * get(last) - 2.0 * get(last - 1),
            i => get(i),
        }
    };
    (0..n as i64)
        .map(|i| {
            let end = if i == 0 { Some(ends[0]) } else { (i == n as i64 - 1).then_some(ends[1]) };
            if let Some(EndSlope::Slope(slope)) = end {
                return slope;
            }
            let (a, b, c, e) = (at(i - 2), at(i - 1), at(i), at(i + 1));
            let (before, behind) = ((e - c).abs(), (b - a).abs());
            if before + behind > SAME_SLOPE { (before * b + behind * c) / (before + behind) } else { 0.5 * (b + c) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_spline() {
        let f = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.1 * x * x * x;
        let g = |x: f64| -2.0 + x - 0.3 * x * x;
        let x = [0.0, 0.7, 2.0, 2.4, 5.0];
        let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let y: Vec<f64> = x.iter().map(|&x| f(x)).collect();
        for ends in [
            [EndSlope::Free; 2],
            [EndSlope::Slope(g(0.0)), EndSlope::Free],
            [EndSlope::Slope(g(0.0)), EndSlope::Slope(g(5.0))],
        ] {
            for (s, x) in cubic_slopes(&h, &y, ends).iter().zip(x) {
                assert!((s - g(x)).abs() < 1e-9, "{ends:?} {x}: {s} {}", g(x));
            }
        }
    }

    #[test]
    fn natural_ends_have_no_curvature_and_curvature_is_continuous() {
        let h = [1.0, 0.5, 2.0];
        let y = [0.0, 3.0, -1.0, 4.0];
        let s = cubic_slopes(&h, &y, [EndSlope::Natural; 2]);
        let second = |i: usize, at_end: bool| {
            let d = (y[i + 1] - y[i]) / h[i];
            if at_end {
                (2.0 * s[i] + 4.0 * s[i + 1] - 6.0 * d) / h[i]
            } else {
                (6.0 * d - 4.0 * s[i] - 2.0 * s[i + 1]) / h[i]
            }
        };
        assert!(second(0, false).abs() < 1e-12 && second(2, true).abs() < 1e-12);
        for i in 0..2 {
            assert!((second(i, true) - second(i + 1, false)).abs() < 1e-12);
        }
    }

    #[test]
    fn few_points_make_a_line_and_a_parabola() {
        assert_eq!(cubic_slopes(&[2.0], &[1.0, 5.0], [EndSlope::Free; 2]), [2.0, 2.0]);
        let s = cubic_slopes(&[1.0, 2.0], &[0.0, 1.0, 9.0], [EndSlope::Free; 2]);
        for (s, x) in s.iter().zip([0.0, 1.0, 3.0]) {
            assert!((s - 2.0 * x).abs() < 1e-12, "{s}");
        }
    }

    #[test]
    fn akima_follows_lines_and_parabolas() {
        let h = [1.0; 5];
        assert_eq!(akima_slopes(&h, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [EndSlope::Free; 2]), [1.0; 6]);
        let y: Vec<f64> = (0..6).map(|x| f64::from(x * x)).collect();
        for (x, s) in akima_slopes(&h, &y, [EndSlope::Free; 2]).iter().enumerate() {
            assert!((s - 2.0 * x as f64).abs() < 1e-12, "{x} {s}");
        }
        // A step: the flat pieces stay flat, as Akima's figure shows.
        let s = akima_slopes(&h, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], [EndSlope::Free; 2]);
        assert_eq!([s[0], s[1], s[2], s[3], s[4]], [0.0; 5]);
    }
}
