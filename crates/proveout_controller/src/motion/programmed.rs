//! What the program says of a block's way: tip and tool axis, straight from its words.
//!
//! Nothing of the control's own path enters here, neither its branches nor its polynomials, so that
//! its path can be measured against the program. Both run over one parameter, the share of the way
//! of the tip (of the turn, if the tip does not move). The distance at equal shares is never below
//! the distance to the nearest point of the programmed way.

use nalgebra::SVector;
use proveout_geom::{Point, ToolPose, Vector};
use proveout_machine::{JointKind, JointValues, Machine};

/// Parts of the table of lengths of a Bezier curve; Simpson's rule over 1/512 of a cubic is exact to 1e-11 of
/// its length.
const PARTS: usize = 512;
/// Sine of the angle between the ends of a circle below which it has no direction.
const SAME_AXIS: f64 = 1e-12;

/// Way of the tip, or of the three linear joints X, Y and Z.
#[derive(Clone, Debug)]
pub(crate) enum TipWay {
    Line {
        from: Vector,
        to: Vector,
    },
    /// Circle, helix or spiral: radius and height in proportion to the angle.
    Arc {
        center: Vector,
        /// Unit vectors from the center to the begin, ahead, and along the axis.
        basis: [Vector; 3],
        radii: [f64; 2],
        heights: [f64; 2],
        sweep: f64,
    },
    /// Cubic by its length: control points, and the length up to each part.
    Bezier {
        control: [Vector; 4],
        lengths: Vec<f64>,
    },
}

/// Way of the tool axis.
#[derive(Clone, Debug)]
pub(crate) enum AxisWay {
    /// Great circle, in proportion.
    Circle([Vector; 2]),
    /// That of rotary joints in proportion.
    Joints(Box<[JointValues; 2]>),
}

/// What the program says of a block.
#[derive(Clone, Debug)]
pub(crate) enum ProgrammedMotion {
    /// With tool center point control, for a tool of this length, in K. In step: both at equal shares of
    /// their ways; otherwise the axis anywhere on its own, as in a rapid motion that brings the tip first.
    Tool { length: f64, tip: TipWay, axis: AxisWay, in_step: bool },
    /// Without: joints in proportion, but the linear joints in `slots` on their own way.
    Joints { ends: Box<[JointValues; 2]>, tip: Option<([usize; 3], TipWay)> },
}

impl TipWay {
    pub(crate) fn line(from: Vector, to: Vector) -> Self {
        Self::Line { from, to }
    }

    /// An arc about the line through `center` along the unit vector `normal`, by about `sweep`, in its sense.
    pub(crate) fn arc(from: Vector, to: Vector, center: Vector, normal: Vector, sweep: f64) -> Self {
        let (a, b) = (from - center, to - center);
        let heights = [a.dot(&normal), b.dot(&normal)];
        let (a, b) = (a - normal * heights[0], b - normal * heights[1]);
        let radii = [a.norm(), b.norm()];
        let ahead = normal.cross(&a);
        // The end gives the angle, the program the full turns.
        let sweep = proveout_geom::wrap_near(b.dot(&ahead).atan2(b.dot(&a)), sweep);
        let unit = |v: Vector| v.try_normalize(0.0).unwrap_or_default();
        Self::Arc { center, basis: [unit(a), unit(ahead), normal], radii, heights, sweep }
    }

    pub(crate) fn bezier(control: [Vector; 4]) -> Self {
        let mut lengths = vec![0.0];
        let speed = |t: f64| bezier_rate(&control, t).norm();
        for k in 0..PARTS {
            let at = |part: f64| (k as f64 + part) / PARTS as f64;
            let part = (speed(at(0.0)) + 4.0 * speed(at(0.5)) + speed(at(1.0))) / (6.0 * PARTS as f64);
            lengths.push(lengths[k] + part);
        }
        Self::Bezier { control, lengths }
    }

    fn at(&self, share: f64) -> Vector {
        let mix = |[a, b]: [f64; 2]| a + (b - a) * share;
        match self {
            Self::Line { from, to } => from + (to - from) * share,
            Self::Arc { center, basis: [out, ahead, normal], radii, heights, sweep } => {
                let (s, c) = (sweep * share).sin_cos();
                center + (out * c + ahead * s) * mix(*radii) + normal * mix(*heights)
            }
            Self::Bezier { control, lengths } => {
                let length = share * lengths[PARTS];
                let k = lengths.partition_point(|l| *l <= length).clamp(1, PARTS) - 1;
                // Within a part the speed is linear but for its bend: solved twice over.
                let (t0, rest) = (k as f64 / PARTS as f64, length - lengths[k]);
                let begin = bezier_rate(control, t0).norm();
                let mut step = rest * (PARTS as f64).recip() / (lengths[k + 1] - lengths[k]);
                for _ in 0..3 {
                    let (middle, end) =
                        (bezier_rate(control, t0 + 0.5 * step).norm(), bezier_rate(control, t0 + step).norm());
                    let reached = step * (begin + 4.0 * middle + end) / 6.0;
                    if end > 0.0 {
                        step += (rest - reached) / end;
                    }
                }
                let t = t0 + step;
                let r = 1.0 - t;
                control[0] * (r * r * r)
                    + control[1] * (3.0 * r * r * t)
                    + control[2] * (3.0 * r * t * t)
                    + control[3] * (t * t * t)
            }
        }
    }
}

fn bezier_rate(c: &[Vector; 4], t: f64) -> Vector {
    let r = 1.0 - t;
    ((c[1] - c[0]) * (r * r) + (c[2] - c[1]) * (2.0 * r * t) + (c[3] - c[2]) * (t * t)) * 3.0
}

impl AxisWay {
    pub(crate) fn circle(from: Vector, to: Vector) -> Self {
        Self::Circle([from, to])
    }

    pub(crate) fn joints(from: JointValues, to: JointValues) -> Self {
        Self::Joints(Box::new([from, to]))
    }

    /// The share of a circle that is nearest to a unit vector; all of the way of joints.
    fn nearest(&self, axis: &Vector) -> f64 {
        let Self::Circle([a, b]) = self else { return 1.0 };
        let normal = a.cross(b);
        let angle = normal.norm().atan2(a.dot(b));
        let Some(ahead) = normal.cross(a).try_normalize(SAME_AXIS) else { return 1.0 };
        (axis.dot(&ahead).atan2(axis.dot(a)) / angle).clamp(0.0, 1.0)
    }

    fn at(&self, machine: &Machine, share: f64) -> Vector {
        match self {
            Self::Circle(ends) => {
                let [a, b] = ends.map(|axis| ToolPose { tip: Point::origin(), axis });
                a.interpolated(&b, share).axis
            }
            Self::Joints(ends) => machine.forward(&ends[0].interpolated(ends[1], share), 0.0).axis,
        }
    }
}

impl ProgrammedMotion {
    pub(crate) fn tool(length: f64, tip: TipWay, axis: AxisWay, in_step: bool) -> Self {
        Self::Tool { length, tip, axis, in_step }
    }

    pub(crate) fn joints(from: JointValues, to: JointValues, tip: Option<([usize; 3], TipWay)>) -> Self {
        Self::Joints { ends: Box::new([from, to]), tip }
    }

    /// Tip and tool axis at the end, with tool center point control.
    pub(crate) fn end(&self, machine: &Machine) -> Option<ToolPose> {
        let Self::Tool { tip, axis, .. } = self else { return None };
        Some(ToolPose { tip: Point::from(tip.at(1.0)), axis: axis.at(machine, 1.0) })
    }

    /// How far joints are from the way at a share of it: tip or linear joints, mm, and the tool axis, radian.
    pub(crate) fn off(&self, machine: &Machine, share: f64, q: &JointValues) -> (f64, f64) {
        match self {
            Self::Tool { length, tip, axis, in_step } => {
                let pose = machine.forward(q, *length);
                let of_axis = if *in_step { share } else { axis.nearest(&pose.axis) };
                let told = ToolPose { tip: Point::from(tip.at(share)), axis: axis.at(machine, of_axis) };
                ((pose.tip - told.tip).norm(), pose.angle_to(&told))
            }
            Self::Joints { ends, tip } => {
                let mut told = ends[0].interpolated(ends[1], share);
                if let Some((slots, way)) = tip {
                    let place = way.at(share);
                    for (k, &slot) in slots.iter().enumerate() {
                        told[slot] = place[k];
                    }
                }
                let linear = SVector::<f64, { proveout_machine::MAX_JOINTS }>::from_fn(|i, _| {
                    let moves = machine.joints.get(i).is_some_and(|j| j.kind == JointKind::Linear);
                    if moves { q[i] - told[i] } else { 0.0 }
                });
                (linear.norm(), machine.forward(q, 0.0).angle_to(&machine.forward(&told, 0.0)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_begin_and_end_where_the_program_says() {
        let (from, to) = (Vector::new(10.0, 0.0, 1.0), Vector::new(0.0, 10.5, 3.0));
        let center = Vector::new(0.0, 0.0, -4.0);
        let control = [from, Vector::new(12.0, 9.0, 0.0), Vector::new(-3.0, 14.0, 5.0), to];
        for sweep in [0.5, 2.5, -1.5] {
            let quarter = std::f64::consts::FRAC_PI_2;
            let normal = if sweep > 0.0 { Vector::z() } else { -Vector::z() };
            let stated = if sweep > 0.0 { quarter + (sweep / 2.0_f64).floor() * 4.0 * quarter } else { 3.0 * quarter };
            for way in
                [TipWay::line(from, to), TipWay::arc(from, to, center, normal, stated + 0.01), TipWay::bezier(control)]
            {
                assert!((way.at(0.0) - from).norm() < 1e-12 && (way.at(1.0) - to).norm() < 1e-12, "{way:?}");
            }
        }
    }

    #[test]
    fn every_way_is_run_in_proportion() {
        let control =
            [Vector::zeros(), Vector::new(12.0, 9.0, 0.0), Vector::new(-3.0, 14.0, 5.0), Vector::new(4.0, 4.0, 4.0)];
        let ways = [
            TipWay::arc(Vector::x() * 3.0, Vector::y() * 3.0 + Vector::z(), Vector::zeros(), Vector::z(), 1.5),
            TipWay::bezier(control),
        ];
        for way in ways {
            // A thousand equal shares are equal chords, but for the bend of each.
            let chords: Vec<f64> =
                (0..1000).map(|k| (way.at((f64::from(k) + 1.0) / 1e3) - way.at(f64::from(k) / 1e3)).norm()).collect();
            let mean = chords.iter().sum::<f64>() / 1e3;
            assert!(chords.iter().all(|c| (c - mean).abs() < 1e-4 * mean), "{way:?}");
        }
    }

    #[test]
    fn the_nearest_share_of_a_circle_is_its_own() {
        let way = AxisWay::circle(Vector::z(), Vector::new(0.6, 0.0, 0.8));
        let angle = 0.6_f64.asin();
        for share in [0.0, 0.3, 1.0] {
            let (s, c) = (share * angle).sin_cos();
            let beside = Vector::new(s, 0.01, c).normalize();
            assert!((way.nearest(&beside) - share).abs() < 1e-12, "{share}");
        }
        assert_eq!(way.nearest(&Vector::new(-0.6, 0.0, 0.8)), 0.0);
        assert_eq!(way.nearest(&Vector::x()), 1.0);
    }

    #[test]
    fn full_turns_come_from_the_program() {
        let start = Vector::new(5.0, 0.0, 0.0);
        let way = TipWay::arc(start, start, Vector::zeros(), Vector::z(), std::f64::consts::TAU);
        assert!((way.at(0.25) - Vector::new(0.0, 5.0, 0.0)).norm() < 1e-12);
        assert!((way.at(0.5) + start).norm() < 1e-12);
    }
}
