//! The forms of G68.2: how the words of one or several blocks define a tilted working plane.
//!
//! Each form with its words and its frame:
//!
//! - **P0**, `X Y Z I J K`: `T(X Y Z) Rz(I) Rx(J) Rz(K)`, Euler angles
//! - **P1**, `Q X Y Z I J K`: roll I, pitch J, yaw K about the fixed axes, in the order of Q; Q123 is
//!   `Rz(K) Ry(J) Rx(I)`
//! - **P2**, `Q0 X Y Z R`, `Q1 X Y Z`, `Q2 X Y Z`, `Q3 X Y Z`: +x from the first point to the second, the
//!   third on the side of +y
//! - **P3**, `Q1 X Y Z I J K`, `Q2 I J K`: +x along the first vector, +z along the second
//! - **P4**, `X Y Z I J K`: a = `Ry(I) ex`, b = `Rx(J) ey`; +z along a x b, +x along a turned about it by K
//!
//! Source of the words: Fanuc, *Series 30i operator's manual*, "Tilted working plane indexing".
//! That the axes of P1 are fixed ones agrees with a public post-processor, which writes the plane
//! of Euler angles 60, 90, 0 as `P1 I90 J0 K60`. The origin of P2 and the signs of P4 could not be
//! compared with the manual: the run reports them as assumptions.

use super::pending::Pending;
use super::run_state::{Interpreter, PlaneParts};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};

/// Two directions that should be square may miss it by this sine: vectors are written with three decimals.
const SQUARE: f64 = 2e-3;

/// How a word gives a plane by turns about X, Y and Z.
pub(super) struct Turns {
    word: &'static str,
    /// Order of the axes where Q is left out.
    usual: f64,
    /// The axes stay where they are; else each turn is about an axis as the turns before have left it.
    fixed: bool,
    assumed: &'static str,
    /// Number of angles other than zero from which on this is assumed.
    assumed_from: usize,
}

const FIXED_AXES: Turns = Turns {
    word: "G68.2 P1",
    usual: 123.0,
    fixed: true,
    assumed: "the angles of G68.2 P1 turn about the axes before it, which stay where they are, in the order of Q (123 without it)",
    assumed_from: 2,
};
/// G268 of a Haas.
pub(super) const FEATURE: Turns = Turns {
    word: "G268",
    usual: 321.0,
    fixed: false,
    assumed: "the angles I, J, K of G268 turn about X, Y and Z as the turns before have left them, in the order of Q (321 without it)",
    assumed_from: 1,
};

impl Interpreter {
    /// Frame of a block G68.2 in the coordinates before it; none where further blocks complete the plane.
    pub(super) fn plane_of_block(&mut self, p: &mut Pending, span: Span) -> Result<Option<Frame>, Fault> {
        let form = p.take(b'P').unwrap_or(0.0);
        if let Some(parts) = &self.own.plane_parts
            && f64::from(parts.form) != form
        {
            return Err(self.plane_is_open(span).unwrap_or_else(|| unknown_form(form, span)));
        }
        match form {
            0.0 => {
                let [i, j, k] = angles(p);
                let turned = Frame::turned([(2, i), (0, j), (2, k)]);
                Ok(Some(Frame::translation(self.plane_origin(p)).then(&turned)))
            }
            1.0 => self.plane_of_turns(p, &FIXED_AXES, span).map(Some),
            2.0 => self.three_points(p, span),
            3.0 => self.two_vectors(p, span),
            4.0 => self.projection_angles(p, span).map(Some),
            _ => Err(unknown_form(form, span)),
        }
    }

    /// The fault of a block between those that define a plane.
    pub(super) fn plane_is_open(&self, span: Span) -> Option<Fault> {
        let parts = self.own.plane_parts.as_ref()?;
        let last = if parts.form == 2 { "Q3" } else { "Q2" };
        let message = format!("the plane of G68.2 P{} is not complete: {last} is missing", parts.form);
        Some(Fault::new(codes::STRUCTURE, span, message).help("write its blocks one after the other"))
    }

    fn plane_origin(&self, p: &mut Pending) -> [f64; 3] {
        [b'X', b'Y', b'Z'].map(|letter| self.length_of(p, letter).unwrap_or(0.0))
    }

    /// Turns by I, J, K about X, Y, Z, in the order of the digits of Q.
    pub(super) fn plane_of_turns(&mut self, p: &mut Pending, form: &Turns, span: Span) -> Result<Frame, Fault> {
        let order = p.take(b'Q').unwrap_or(form.usual);
        let Some(axes) = order_of(order) else {
            let message = format!("{} Q{order}: Q names the axes 1, 2 and 3 in the order of their turns", form.word);
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write Q123, Q132, Q213, Q231, Q312 or Q321"));
        };
        let origin = self.plane_origin(p);
        let given = angles(p);
        if given.iter().filter(|angle| **angle != 0.0).count() >= form.assumed_from {
            self.assume(form.assumed);
        }
        let mut turns = axes.map(|axis| (axis, given[axis]));
        if form.fixed {
            // Turns about fixed axes: the later one is the left factor.
            turns.reverse();
        }
        Ok(Frame::translation(origin).then(&Frame::turned(turns)))
    }

    fn three_points(&mut self, p: &mut Pending, span: Span) -> Result<Option<Frame>, Fault> {
        let which = p.take(b'Q').unwrap_or(0.0);
        let point = self.plane_origin(p);
        let parts = self.own.plane_parts.get_or_insert_with(|| PlaneParts { form: 2, ..PlaneParts::default() });
        match which {
            0.0 => {
                parts.origin = Some((point, p.take(b'R').unwrap_or(0.0)));
                return Ok(None);
            }
            1.0 | 2.0 | 3.0 => parts.points[which as usize - 1] = Some(point),
            _ => {
                let message = format!("G68.2 P2 Q{which}: there are three points and an origin");
                return Err(Fault::new(codes::BAD_VALUE, span, message).help("write Q0 to Q3"));
            }
        }
        if which != 3.0 {
            return Ok(None);
        }
        let parts = self.own.plane_parts.take().unwrap_or_default();
        let [Some(first), Some(second), Some(third)] = parts.points else {
            let missing = 1 + parts.points.iter().position(Option::is_none).unwrap_or(0);
            return Err(Fault::new(codes::MISSING_VALUE, span, format!("G68.2 P2 has no point Q{missing}"))
                .help("write Q1, Q2 and Q3 one after the other"));
        };
        let x = frame::unit(frame::sub(second, first));
        let z = x.and_then(|x| frame::unit(frame::cross(x, frame::sub(third, first))));
        let (Some(x), Some(z)) = (x, z) else {
            return Err(Fault::new(codes::BAD_VALUE, span, "the three points of G68.2 P2 lie on a line")
                .help("write points that span a plane"));
        };
        let (origin, turn) = parts.origin.unwrap_or((first, 0.0));
        self.assume(if parts.origin.is_some() {
            "the origin of G68.2 P2 is that of Q0, in the coordinates before it"
        } else {
            "the origin of G68.2 P2 without Q0 is the first point"
        });
        Ok(Some(upright(origin, x, z).then(&Frame::rotation(2, turn))))
    }

    fn two_vectors(&mut self, p: &mut Pending, span: Span) -> Result<Option<Frame>, Fault> {
        let which = p.take(b'Q').unwrap_or(1.0);
        let vector = frame::unit(angles(p)).ok_or_else(|| {
            Fault::new(codes::MISSING_VALUE, span, "the vector of G68.2 P3 has no length").help("write I, J and K")
        })?;
        if which == 1.0 {
            let points = [Some(self.plane_origin(p)), Some(vector), None];
            self.own.plane_parts = Some(PlaneParts { form: 3, origin: None, points });
            return Ok(None);
        }
        let Some(PlaneParts { points: [Some(origin), Some(x), _], .. }) = self.own.plane_parts.take() else {
            return Err(Fault::new(codes::STRUCTURE, span, "G68.2 P3 Q2 has no Q1 before it")
                .help("write G68.2 P3 Q1 X Y Z I J K, then G68.2 P3 Q2 I J K"));
        };
        if which != 2.0 {
            let message = format!("G68.2 P3 Q{which}: there are two vectors");
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write Q1 and Q2"));
        }
        let along = frame::dot(x, vector);
        if along.abs() > SQUARE {
            let angle = along.clamp(-1.0, 1.0).acos().to_degrees();
            let message =
                format!("the vectors of G68.2 P3 are {angle:.3} degrees apart, and must be square to each other");
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write vectors at 90 degrees"));
        }
        let x = frame::unit(frame::add_scaled(x, vector, -along)).unwrap_or(x);
        Ok(Some(upright(origin, x, vector)))
    }

    fn projection_angles(&mut self, p: &mut Pending, span: Span) -> Result<Frame, Fault> {
        let origin = self.plane_origin(p);
        let [i, j, k] = angles(p);
        let a = Frame::rotation(1, i).apply_vector([1.0, 0.0, 0.0]);
        let b = Frame::rotation(0, j).apply_vector([0.0, 1.0, 0.0]);
        let Some(z) = frame::unit(frame::cross(a, b)) else {
            return Err(Fault::new(codes::BAD_VALUE, span, "the projection angles of G68.2 P4 span no plane")
                .help("write angles of less than 90 degrees"));
        };
        self.assume("I of G68.2 P4 turns the x direction about Y, J the y direction about X, both counter-clockwise about the axes before it");
        Ok(upright(origin, a, z).then(&Frame::rotation(2, k)))
    }
}

fn angles(p: &mut Pending) -> [f64; 3] {
    [b'I', b'J', b'K'].map(|letter| p.take(letter).unwrap_or(0.0))
}

fn unknown_form(form: f64, span: Span) -> Fault {
    Fault::new(codes::BAD_VALUE, span, format!("G68.2 P{form} is not a way to define a plane")).help("write P0 to P4")
}

/// The frame with this origin and these directions of x and z, which are square to each other.
fn upright(origin: [f64; 3], x: [f64; 3], z: [f64; 3]) -> Frame {
    Frame::of_axes(origin, [x, frame::cross(z, x), z])
}

/// Axes in the order of the digits of Q: 1 is X.
fn order_of(order: f64) -> Option<[usize; 3]> {
    Some(match order {
        123.0 => [0, 1, 2],
        132.0 => [0, 2, 1],
        213.0 => [1, 0, 2],
        231.0 => [1, 2, 0],
        312.0 => [2, 0, 1],
        321.0 => [2, 1, 0],
        _ => return None,
    })
}
