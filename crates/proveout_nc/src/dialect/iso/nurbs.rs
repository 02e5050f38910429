//! G5.2 and G5.3 of a `LinuxCNC`: a NURBS in the XY plane, from the place of the tool to the last control
//! point.
//!
//! Words, order and knots are those of its interpreter (`convert_nurbs`, `knot_vector_creator`): order 3 or
//! what L says above it, knots at whole numbers, as many times at both ends as the order, so that the curve
//! begins at the first and ends at the last control point. Where all weights are equal and the order is 3 or
//! 4 every piece is a cubic Bezier curve, and is given exactly; other pieces are given as chords.

use super::modal::FeedMode;
use super::pending::Pending;
use super::run_state::{ControlPoints, Interpreter};
use super::technology::LINEAR;
use super::words::Group;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::g_code::{G5_3, G80};
use crate::spline::{self, CHORD_TOLERANCE_MM, Homogeneous};
use crate::{CompSide, Op, SplineMotion};

/// Highest order: far above what programs use.
const MAX_ORDER: f64 = 16.0;
/// Most control points of one curve.
const MAX_POINTS: usize = 10_000;

impl Interpreter {
    pub(crate) fn nurbs_block(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        if p.g(Group::Motion) == Some(G5_3) {
            return self.nurbs_end(p, span);
        }
        let wrong = |message: &str, help: &str| Err(Fault::new(codes::ARC_GEOMETRY, span, message).help(help));
        if p.axes() & !0b011 != 0 {
            return wrong("G5.2 takes X and Y", "program the other axes in a block of their own");
        }
        let named = [p.has(b'X'), p.has(b'Y')];
        let weight = p.take(b'P');
        let order = p.take(b'L');
        if named == [false; 2] && weight.is_none() && order.is_none() {
            return Ok(());
        }
        if named[0] != named[1] {
            return wrong("a control point has X and Y", "write both");
        }
        if let Some(weight) = weight
            && !(weight > 0.0 && weight.is_finite())
        {
            let message = format!("the weight P of a control point must be above zero and is {weight}");
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write P1"));
        }
        if self.own.nurbs.is_none() {
            let start = self.start_in_plane("the NURBS", span)?;
            // P without a point is the weight of the start.
            let own = if named[0] { None } else { weight };
            self.own.nurbs = Some(ControlPoints { points: vec![[start[0], start[1], own.unwrap_or(1.0)]], order: 3 });
        } else if !named[0] && weight.is_some() {
            return wrong("P without X and Y is allowed at the first control point only", "write X, Y and P");
        }
        let point = if named[0] {
            let Some(weight) = weight else {
                return Err(
                    Fault::new(codes::MISSING_VALUE, span, "the control point has no weight P").help("write P1")
                );
            };
            let (end, _) = self.targets(p, span)?;
            Some([end.get(0).unwrap_or(0.0), end.get(1).unwrap_or(0.0), weight])
        } else {
            None
        };
        let Some(curve) = &mut self.own.nurbs else { return Ok(()) };
        if let Some(order) = order {
            if order.fract() != 0.0 || !(3.0..=MAX_ORDER).contains(&order) {
                let message = format!("the order L of a NURBS is a whole number from 3 to {MAX_ORDER} and is {order}");
                return Err(Fault::new(codes::BAD_VALUE, span, message).help("write L3"));
            }
            curve.order = order as usize;
        }
        if let Some(point) = point {
            if curve.points.len() >= MAX_POINTS {
                let message = format!("the NURBS has more than {MAX_POINTS} control points");
                return Err(Fault::new(codes::LOOP_LIMIT, span, message).help("write G5.3, and G5.2 again"));
            }
            curve.points.push(point);
        }
        Ok(())
    }

    fn nurbs_end(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        self.modal.motion = None;
        self.modal.motion_code = G80;
        let wrong = |message: String, help: &str| Err(Fault::new(codes::ARC_GEOMETRY, span, message).help(help));
        let Some(curve) = self.own.nurbs.take() else {
            return Err(Fault::new(codes::STRUCTURE, span, "G5.3 has no G5.2 before it").help("write G5.2"));
        };
        if p.axes() != 0 {
            return wrong("axis words in the block of G5.3".to_owned(), "write them in a block of their own");
        }
        let (count, order) = (curve.points.len(), curve.order);
        if count < order {
            let message =
                format!("a NURBS of order {order} needs {order} control points with the start, and has {count}");
            return wrong(message, "write more control points, or a lower L");
        }
        if self.modal.comp != CompSide::Off || self.modal.feed_mode == FeedMode::InverseTime {
            return wrong(
                "a NURBS cannot be run with cutter compensation or inverse time feed".to_owned(),
                "write G40 and G94 before it",
            );
        }
        let degree = order - 1;
        let knots: Vec<f64> =
            (0..count + order).map(|i| (i.saturating_sub(degree)).min(count - degree) as f64).collect();
        let z = self.position.work.get(2);
        let points: Vec<Homogeneous> =
            curve.points.iter().map(|&[x, y, w]| [x * w, y * w, z.unwrap_or(0.0) * w, w]).collect();
        self.need_feed(LINEAR, span)?;
        let mut chords = 0;
        for piece in spline::bezier_pieces(degree, &knots, &points) {
            match spline::cubic(&piece).filter(|_| z.is_some()) {
                Some(cubic) => self.nurbs_cubic(cubic, span)?,
                None => {
                    let ends = spline::chords(&piece, CHORD_TOLERANCE_MM).ok_or_else(|| spline::too_long(span))?;
                    for point in ends {
                        let mut end = self.position.work;
                        end.put(0, point[0]);
                        end.put(1, point[1]);
                        let motion = self.complete(end, 0b011, false, span)?;
                        self.go(motion, false);
                        chords += 1;
                    }
                }
            }
        }
        if chords > 0 {
            self.note(format!("the NURBS is given as {chords} chords within {CHORD_TOLERANCE_MM} mm of the curve"));
        }
        Ok(())
    }

    fn nurbs_cubic(&mut self, [_, first, second, to]: [[f64; 3]; 4], span: Span) -> Result<(), Fault> {
        let mut end = self.position.work;
        for (axis, value) in to.into_iter().enumerate().take(2) {
            end.put(axis, value);
        }
        let motion = self.complete(end, 0b011, false, span)?;
        let control = [first, second];
        let control_base = control.map(|point| self.position.point_in_base(point));
        self.position.move_to(motion.end, motion.end_base);
        self.begin_motion();
        self.emit(Op::Spline(SplineMotion { motion, control, control_base }));
        Ok(())
    }

    fn start_in_plane(&self, what: &str, span: Span) -> Result<[f64; 2], Fault> {
        match (self.position.work.get(0), self.position.work.get(1)) {
            (Some(x), Some(y)) => Ok([x, y]),
            _ => Err(Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                format!("the start of {what} is not known to the program"),
            )
            .help("program X and Y before it")),
        }
    }
}
