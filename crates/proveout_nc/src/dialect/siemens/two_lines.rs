//! Two straight lines by their angles: the corner between them is not written, and follows from the end of
//! the second one.
//!
//! ```text
//!                 end (X Y)      N10 G1 ANG=a           the first line: its angle, and a corner CHR= or RND=
//!                  /             N20 X Y ANG=b          the second one: its angle and its end
//!    start -------+ corner
//!            a     b             start + s (cos a, sin a) = corner = end - t (cos b, sin b),   s, t >= 0
//! ```
//!
//! After Siemens, *NC programming, Fundamentals*, "Contour definitions: two straight lines": the
//! second line follows in the next block and its end is written in Cartesian coordinates. The first
//! line waits here for it, with what was in force in its block. No other block may come between the
//! two, so nothing changes on the way to the corner.

use super::modal::{Interpolation, Modal};
use super::pending::{Coordinate, Pending, Reference};
use super::run_state::{FirstLine, Interpreter};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;

/// Sine of the smallest angle between the two lines; below it rounding determines the position of
/// the corner.
const LEAST_SINE: f64 = 1e-6;

impl Interpreter {
    /// Keeps a line that has only its angle; the words other than its motion are executed at once.
    pub(super) fn hold_first_line(&mut self, p: &mut Pending, angle: f64, span: Span) -> Result<(), Fault> {
        let plane = self.modal.plane_axes();
        let refuse = |message: &str, help: &str| Err(Fault::new(codes::CONFLICT, span, message).help(help));
        if !angle.is_finite() {
            return Err(
                Fault::new(codes::BAD_VALUE, span, format!("ANG={angle} is not a valid angle")).help("write degrees")
            );
        }
        let circle =
            p.has_center() || p.intermediate.iter().any(Option::is_some) || p.radius.is_some() || p.opening.is_some();
        let curve = p.weight.is_some() || p.interval.is_some() || p.polynomial.iter().any(Option::is_some);
        let other = p.has_axis() || p.has_orientation() || p.turns.is_some() || p.positioning || p.tapping_feed;
        if circle || curve || other || p.frame.is_some() || p.dwell || p.block_feed.is_some() {
            return refuse(
                "the block with ANG= of the first of two lines takes only G0 or G1, F, a chamfer or a rounding",
                "write the other axes, words of a circle or a curve, FB=, frames and dwells in a block of their own",
            );
        }
        if p.functions.iter().any(|m| !matches!(m, 3 | 4 | 7 | 8)) || p.call.is_some() || p.numbered_call.is_some() {
            return refuse(
                "the block with ANG= of the first of two lines has an M word or a call that acts after the motion",
                "write it after the second line",
            );
        }
        if self.own.modal_call.is_some() {
            return refuse("MCALL is in force at the first of two lines", "write MCALL alone before it");
        }
        for axis in [plane[0], plane[1]] {
            self.known(axis, span)?;
        }
        let words = Pending {
            chamfer: p.chamfer.take(),
            chamfer_leg: p.chamfer_leg.take(),
            corner_radius: p.corner_radius.take(),
            corner_feed: p.corner_feed.take(),
            exact_stop: p.exact_stop,
            ..Pending::default()
        };
        self.own.first_line = Some(Box::new(FirstLine {
            words,
            angle,
            location: self.location.clone(),
            plane,
            interpolation: self.modal.interpolation,
            modal_rounding: self.modal.modal_rounding,
            corner_feed: self.modal.corner_feed,
        }));
        Ok(())
    }

    /// The fault when no second line follows the first one.
    pub(super) fn no_second_line(&mut self, span: Span) -> Fault {
        let line = self.own.first_line.take().map_or(0, |first| first.location.line);
        Fault::new(
            codes::MISSING_VALUE,
            span,
            format!("line {line} has ANG= alone, and its corner needs the second line in the next block"),
        )
        .help("write the second line there with its angle and both coordinates of its end")
    }

    /// The block after the first line: gives the first line to the corner, and leaves the second
    /// one as a line to its end.
    pub(super) fn second_line(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let plane = self.modal.plane_axes();
        let [u, v, _] = plane;
        let straight = matches!(self.modal.interpolation, Interpolation::Linear | Interpolation::Rapid);
        let (Some(angle), true) = (p.angle, straight && p.axes[u].is_some() && p.axes[v].is_some()) else {
            return Err(self.no_second_line(span));
        };
        let Some(first) = self.own.first_line.take() else { return Ok(()) };
        let changes = first.plane != plane
            || p.machine
            || p.frame.is_some()
            || p.offset.is_some()
            || p.transformation.is_some()
            || p.compensation.is_some()
            || p.polar_angle.is_some()
            || p.polar_radius.is_some();
        if changes {
            return Err(Fault::new(
                codes::CONFLICT,
                span,
                "the second of two lines changes the plane, the offset, the frame or the compensation",
            )
            .help("write that before the first line"));
        }
        let counts_on = |reference: Reference| match reference {
            Reference::Modal => self.modal.incremental,
            other => other == Reference::Incremental,
        };
        if [u, v].iter().any(|axis| p.axes[*axis].is_some_and(|c| counts_on(c.reference))) {
            return Err(Fault::new(codes::CONFLICT, span, "the end of the second of two lines is an increment")
                .help("write it with G90 or AC()"));
        }
        let end = self.targets(p, span)?;
        let from = [self.known(u, span)?, self.known(v, span)?];
        let to = [end.get(u).unwrap_or(0.0), end.get(v).unwrap_or(0.0)];
        let corner = corner(from, first.angle, to, angle).map_err(|message| {
            Fault::new(codes::BAD_VALUE, span, message)
                .help("check both angles: they count counter-clockwise from the first axis of the plane")
        })?;
        let length = self.modal.units.length();
        let absolute = |value: f64| Some(Coordinate { value: value / length, reference: Reference::Absolute });
        p.angle = None;
        let mut words = first.words;
        (words.axes[u], words.axes[v]) = (absolute(corner[0]), absolute(corner[1]));
        words.programmed = 1 << u | 1 << v;
        let here = std::mem::replace(&mut self.location, first.location);
        let now = (self.modal.interpolation, self.modal.modal_rounding, self.modal.corner_feed);
        let set = |modal: &mut Modal, to: (Interpolation, Option<f64>, Option<f64>)| {
            (modal.interpolation, modal.modal_rounding, modal.corner_feed) = to;
        };
        set(&mut self.modal, (first.interpolation, first.modal_rounding, first.corner_feed));
        let moved = self.motion_with_corner(&words, span);
        set(&mut self.modal, now);
        self.location = here;
        moved
    }
}

/// The corner of two lines: from `from` under `a` degrees, into `to` under `b` degrees.
fn corner(from: [f64; 2], a: f64, to: [f64; 2], b: f64) -> Result<[f64; 2], String> {
    let ((sa, ca), (sb, cb)) = (sin_cos_degrees(a), sin_cos_degrees(b));
    let sine = ca * sb - sa * cb;
    if !sine.is_finite() || sine.abs() < LEAST_SINE {
        return Err(format!("the lines under ANG={a} and ANG={b} are parallel and have no corner"));
    }
    let way = [to[0] - from[0], to[1] - from[1]];
    let s = (way[0] * sb - way[1] * cb) / sine;
    let t = (ca * way[1] - sa * way[0]) / sine;
    if s < 0.0 || t < 0.0 {
        let (which, angle) = if s < 0.0 { ("first", a) } else { ("second", b) };
        return Err(format!("the {which} line would run against its angle ANG={angle} to meet the other one"));
    }
    Ok([from[0] + s * ca, from[1] + s * sa])
}
