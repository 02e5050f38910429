//! Geometric errors: what the actual machine does differently from the one that the control believes in.
//!
//! Names follow ISO 230-7 and ISO 230-1: `E`, the component (X, Y, Z a shift; A, B, C a turn about it), a 0
//! for errors that do not depend on the position, and the joint. Components are along and about the machine
//! axes, with all joints at zero. They describe the physical motion of what the joint carries, whatever its
//! sense in programs.
//!
//! * Position-independent: the line of a rotary joint is shifted (`EX0C`) or tilted about its point (`EA0C`),
//!   its zero is turned (`EC0C`, the part along the axis); a slide's direction is turned (`EC0Y`: squareness
//!   of Y to X) or its zero shifted (the part along it). The lines are those at zero: an error of one joint
//!   does not shift the line of the next, and a workpiece set at zero positions stays where it was set (zero
//!   errors apart).
//! * Against the position: six components, linear between the positions of a table, its end values beyond
//!   them. The shifts are those of the reference point. With N the nominal motion and E the error about the
//!   reference point, a slide moves by N E (the point travels along), a rotary joint by E N (components in
//!   resting axes).

use proveout_geom::{Point, Pose, Vector};

/// Letters of the six components.
pub(crate) const COMPONENTS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];

/// Whose error it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorOf {
    /// A joint, by index.
    Joint(usize),
    /// The spindle: shift and tilt of the gauge line.
    Spindle,
}

/// Position-independent errors of one joint or of the spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantErrors {
    /// Whose.
    pub of: ErrorOf,
    /// X, Y, Z in mm and A, B, C in radian.
    pub components: [f64; 6],
}

/// Errors of one joint against its position.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorTable {
    /// The joint.
    pub joint: usize,
    /// Point that the shifts are given at, in M with all joints at zero, mm.
    pub reference: Point,
    /// Growing positions, mm or radian.
    pub at: Vec<f64>,
    /// X, Y, Z in mm and A, B, C in radian at each position.
    pub components: Vec<[f64; 6]>,
}

/// All geometric errors of a machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeometricErrors {
    /// Position-independent ones.
    pub constant: Vec<ConstantErrors>,
    /// Those against the position.
    pub tables: Vec<ErrorTable>,
}

impl GeometricErrors {
    /// True when no error is stated, or all are zero.
    pub fn is_zero(&self) -> bool {
        let constant = self.constant.iter().flat_map(|c| &c.components);
        let tables = self.tables.iter().flat_map(|t| t.components.iter().flatten());
        constant.chain(tables).all(|v| *v == 0.0)
    }
}

impl GeometricErrors {
    /// The most by which the errors move any point of the machine, mm, no line or reference point being
    /// farther than `reach` (mm) from any point that it moves, and no slide being farther out. Zero where
    /// there are none.
    ///
    /// A shift moves all points by its length, a turn by w those at the distance r by at most w r (a slide
    /// whose direction is turned: by w times its way); joint after joint these add up. That the errors of one
    /// joint turn those of the next, by 0.02 rad at most, is in the factor.
    pub fn bound(&self, reach: f64) -> f64 {
        let size = |[shift, turn]: [f64; 2]| shift + turn * reach;
        let constant = self.constant.iter().map(|c| {
            let (shift, rotation) = c.parts();
            size([shift.norm(), rotation.norm()])
        });
        1.05 * (constant.sum::<f64>() + self.tables.iter().map(|t| size(t.largest())).sum::<f64>())
    }
}

impl ConstantErrors {
    /// Shift (mm) and rotation vector (radian).
    pub fn parts(&self) -> (Vector, Vector) {
        parts(&self.components)
    }
}

fn parts(c: &[f64; 6]) -> (Vector, Vector) {
    (Vector::new(c[0], c[1], c[2]), Vector::new(c[3], c[4], c[5]))
}

/// The turn by a rotation vector: exact, so that no order of the three small turns is implied.
pub(crate) fn turn(rotation: &Vector) -> Pose {
    let angle = rotation.norm();
    if angle > 0.0 { Pose::from_axis_angle(&(rotation / angle), angle) } else { Pose::identity() }
}

impl ErrorTable {
    /// The six components at a position; those of an endless joint repeat with each turn.
    pub fn at(&self, value: f64, endless: bool) -> [f64; 6] {
        let (Some(&first), Some(&last)) = (self.at.first(), self.at.last()) else { return [0.0; 6] };
        let value = if endless { first + (value - first).rem_euclid(std::f64::consts::TAU) } else { value };
        let value = value.max(first).min(last);
        let next = self.at.partition_point(|p| *p <= value).clamp(1, self.at.len().max(2) - 1);
        let (Some(&low), Some(&high)) = (self.at.get(next - 1), self.at.get(next)) else { return [0.0; 6] };
        let (Some(a), Some(b)) = (self.components.get(next - 1), self.components.get(next)) else { return [0.0; 6] };
        let t = (value - low) / (high - low);
        std::array::from_fn(|k| a[k] * (1.0 - t) + b[k] * t)
    }

    /// Positions of the table strictly between two others, at which the errors change their slope.
    pub(crate) fn bends(&self, from: f64, to: f64, endless: bool) -> usize {
        let (low, high) = (from.min(to), from.max(to));
        if !endless {
            return self.at.iter().filter(|p| low < **p && **p < high).count();
        }
        // Each position but the last, which is the first one again, comes once a turn.
        let turns = |p: f64, up_to: f64| ((up_to - p) / std::f64::consts::TAU).floor();
        let once = self.at.split_last().map_or(&[][..], |(_, rest)| rest);
        once.iter().map(|p| (turns(*p, high) - turns(*p, low)).max(0.0) as usize).sum()
    }

    /// Largest shift (mm) and turn (radian) at any position.
    fn largest(&self) -> [f64; 2] {
        let sizes = self.components.iter().map(|c| {
            let (shift, rotation) = parts(c);
            [shift.norm(), rotation.norm()]
        });
        sizes.fold([0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
    }

    /// The error motion at a position, about the reference point.
    pub fn motion(&self, value: f64, endless: bool) -> Pose {
        let (shift, rotation) = parts(&self.at(value, endless));
        let turn = turn(&rotation);
        let translation = self.reference.coords - turn.rotation * self.reference.coords + shift;
        Pose { translation, ..turn }
    }
}
