//! Corners of a polyline in the S-theta plane, smoothed by two cubic Bezier pieces with continuous curvature.
//!
//! ```text
//!                      joint (S2, theta2 + eps)
//!                  .---*---.
//!              .-'   P2     '-.
//!           B_i0    / \      B_j3
//!            /     /   \       \
//!          P1                   P3
//! ```
//!
//! The corner P1 P2 P3 has the slope angles alpha and gamma; beta = (alpha + gamma) / 2 is the tangent at the
//! joint above or below the corner. Each piece has its two inner control points at one place (`B_i1` on the
//! first segment, `B_j1` on the second), so curvature vanishes at both ends and the joint: G2 with the
//! straight segments.
//!
//! Li et al. 2022, equations (6) to (13), corrected as in the specification (errata ST-1 to ST-5). The
//! vertical distance of a piece from the polyline is `eps t^3`, so |eps| is the largest one. Bisector and
//! equal lengths depend on the unit of theta against that of S, which is not published: [`ThetaUnit`] is a
//! parameter. [`CornerRule::UnitFree`] takes the mean of the slopes and equal abscissa lengths instead.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Deserialize;

/// Step of t at which the search on a piece ends.
const FOUND: f64 = 1e-15;
/// Bend of a polyline below which a corner is its rounding error, radian.
const STRAIGHT: f64 = 1e-12;

/// Unit of theta.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ThetaUnit {
    /// Degrees.
    #[default]
    Degree,
    /// Radian.
    Radian,
    /// Turns and layers.
    Normalized,
    /// A rule that does not depend on units.
    UnitFree,
}

impl ThetaUnit {
    /// Every unit with its name.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("degree", Self::Degree),
        ("radian", Self::Radian),
        ("normalized", Self::Normalized),
        ("unit-free", Self::UnitFree),
    ];

    /// Factors of S (mm) and theta (radian) for a layer of this arc length, mm.
    pub fn scale(self, layer: f64) -> [f64; 2] {
        match self {
            Self::Degree => [1.0, 360.0 / TAU],
            Self::Radian | Self::UnitFree => [1.0, 1.0],
            Self::Normalized => [1.0 / layer, 1.0 / TAU],
        }
    }

    /// The rule for its corners.
    pub fn rule(self) -> CornerRule {
        if self == Self::UnitFree { CornerRule::UnitFree } else { CornerRule::Bisector }
    }
}

/// How the joint's tangent and the lengths of the two pieces are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornerRule {
    /// Bisector of the slope angles, equal leg lengths within each piece (the paper).
    Bisector,
    /// Mean of the slopes, equal abscissa lengths.
    UnitFree,
}

/// A smoothed corner. Points are (S, theta) in the scaled plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BezierCorner {
    /// Signed vertical offset of the joint.
    pub eps: f64,
    /// Slope angles of the first segment, the joint and the second segment, radian.
    pub angles: [f64; 3],
    /// `B_i0`, `B_i1 = B_i2`, joint, `B_j1 = B_j2`, `B_j3`.
    pub control: [[f64; 2]; 5],
    /// Lengths along the segments that the curve takes, `d_1` and `d_2`.
    pub supports: [f64; 2],
}

impl BezierCorner {
    /// Largest |eps| that keeps the curve within half of each segment, first and second.
    pub fn eps_bounds(p: [[f64; 2]; 3], rule: CornerRule) -> [f64; 2] {
        let lengths = [distance(p[0], p[1]), distance(p[1], p[2])];
        let [d1, d2] = support_for_one(p, rule);
        [0.5 * lengths[0] / d1, 0.5 * lengths[1] / d2]
    }

    /// The corner with this |eps|; its sign follows from the bend. None where the segments are in line.
    pub fn new(p: [[f64; 2]; 3], size: f64, rule: CornerRule) -> Option<Self> {
        let [alpha, beta, gamma] = angles(p, rule);
        if alpha == gamma || size.is_nan() || size <= 0.0 {
            return None;
        }
        let eps = if gamma > alpha { size } else { -size };
        let corner = p[1];
        let along = |angle: f64, length: f64| [corner[0] + length * angle.cos(), corner[1] + length * angle.sin()];
        // B_i1 and B_j1: where the tangent of the joint meets the segments.
        let meet = |slope: f64| {
            let x = eps / (slope - beta.tan());
            [corner[0] + x, corner[1] + x * slope]
        };
        let [d1, d2] = support_for_one(p, rule).map(|d| d * size);
        Some(Self {
            eps,
            angles: [alpha, beta, gamma],
            control: [
                along(alpha, -d1),
                meet(alpha.tan()),
                [corner[0], corner[1] + eps],
                meet(gamma.tan()),
                along(gamma, d2),
            ],
            supports: [d1, d2],
        })
    }

    /// Abscissas from and to which the corner replaces the polyline.
    pub fn range(&self) -> [f64; 2] {
        [self.control[0][0], self.control[4][0]]
    }

    /// Ordinate at an abscissa of its range.
    pub fn at(&self, s: f64) -> f64 {
        let c = &self.control;
        if s <= c[2][0] { on_piece([c[0], c[1], c[2]], s) } else { on_piece([c[2], c[3], c[4]], s) }
    }

    /// Largest |d2 theta / d S2| of the left and the right piece.
    ///
    /// On the left piece with a, b the abscissa lengths before and after `B_i1` the second
    /// derivative is `2 eps a t (1-t) / (3 ((1-t)^2 a + t^2 b)^3)`; its only maximum in 0..1 is
    /// found by golden section.
    pub fn curvature_peaks(&self) -> [f64; 2] {
        let c = &self.control;
        let peak = |a: f64, b: f64| {
            let value =
                |t: f64| 2.0 * self.eps.abs() * a * t * (1.0 - t) / (3.0 * ((1.0 - t).powi(2) * a + t * t * b).powi(3));
            let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..80 {
                let (x, y) = (high - ratio * (high - low), low + ratio * (high - low));
                if value(x) > value(y) { high = y } else { low = x }
            }
            value(0.5 * (low + high))
        };
        [peak(c[1][0] - c[0][0], c[2][0] - c[1][0]), peak(c[4][0] - c[3][0], c[3][0] - c[2][0])]
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn angles(p: [[f64; 2]; 3], rule: CornerRule) -> [f64; 3] {
    let alpha = (p[1][1] - p[0][1]).atan2(p[1][0] - p[0][0]);
    let gamma = (p[2][1] - p[1][1]).atan2(p[2][0] - p[1][0]);
    let beta = match rule {
        CornerRule::Bisector => 0.5 * (alpha + gamma),
        CornerRule::UnitFree => (0.5 * (alpha.tan() + gamma.tan())).atan(),
    };
    [alpha, beta, gamma]
}

/// Lengths along the two segments for |eps| = 1.
fn support_for_one(p: [[f64; 2]; 3], rule: CornerRule) -> [f64; 2] {
    let [alpha, beta, gamma] = angles(p, rule);
    match rule {
        CornerRule::Bisector => [alpha, gamma].map(|a: f64| (a.cos() + beta.cos()) / (beta - a).sin().abs()),
        CornerRule::UnitFree => [alpha, gamma].map(|a: f64| 2.0 / ((beta.tan() - a.tan()).abs() * a.cos())),
    }
}

/// Ordinate on a cubic piece with a double inner control point: `S(t) = S0 (1-t)^3 + 3 S1 t (1-t) + S3 t^3`,
/// rising in t.
fn on_piece(c: [[f64; 2]; 3], s: f64) -> f64 {
    let value = |t: f64, k: usize| {
        let r = 1.0 - t;
        c[0][k] * r * r * r + 3.0 * c[1][k] * t * r + c[2][k] * t * t * t
    };
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    let mut t = ((s - c[0][0]) / (c[2][0] - c[0][0])).clamp(0.0, 1.0);
    for _ in 0..60 {
        let error = value(t, 0) - s;
        if error > 0.0 {
            high = t
        } else {
            low = t
        }
        let r = 1.0 - t;
        let rate = -3.0 * c[0][0] * r * r + 3.0 * c[1][0] * (1.0 - 2.0 * t) + 3.0 * c[2][0] * t * t;
        let newton = t - error / rate;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() < FOUND {
            break;
        }
        t = next;
    }
    value(t, 1)
}

/// A polyline with smoothed corners, in the plane of S (mm) and theta (radian).
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothedPolyline {
    /// Corners of the polyline, both ends included.
    pub points: Vec<[f64; 2]>,
    /// The corners, in the scaled plane; none where the polyline goes straight on.
    pub corners: Vec<Option<BezierCorner>>,
    scale: [f64; 2],
}

impl SmoothedPolyline {
    /// Smooths every inner corner with the largest |eps| (radian) that `room` allows for it: called with the
    /// index of the corner and whether the curve passes above it.
    pub fn new(points: Vec<[f64; 2]>, unit: ThetaUnit, layer: f64, room: impl Fn(usize, bool) -> f64) -> Self {
        let scale = unit.scale(layer);
        let rule = unit.rule();
        let scaled: Vec<[f64; 2]> = points.iter().map(|p| [p[0] * scale[0], p[1] * scale[1]]).collect();
        let corners = (0..points.len())
            .map(|i| {
                if i == 0 || i + 1 == points.len() {
                    return None;
                }
                let p = [scaled[i - 1], scaled[i], scaled[i + 1]];
                let slopes = angles(p, rule);
                // Below this bend the corner is a rounding error of the polyline.
                if (slopes[2] - slopes[0]).abs() < STRAIGHT {
                    return None;
                }
                let [first, second] = BezierCorner::eps_bounds(p, rule);
                let size = (room(i, slopes[2] > slopes[0]) * scale[1]).min(first).min(second);
                BezierCorner::new(p, size, rule)
            })
            .collect();
        Self { points, corners, scale }
    }

    /// Theta, radian, at an arc length within the polyline; at its ends outside.
    pub fn at(&self, s: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else { return 0.0 };
        if s <= first[0] {
            return first[1];
        }
        if s >= last[0] {
            return last[1];
        }
        let k = self.points.partition_point(|p| p[0] <= s).clamp(1, self.points.len() - 1);
        for i in [k - 1, k] {
            if let Some(corner) = &self.corners[i] {
                let [from, to] = corner.range();
                let x = s * self.scale[0];
                if x > from && x < to {
                    return corner.at(x) / self.scale[1];
                }
            }
        }
        let (a, b) = (self.points[k - 1], self.points[k]);
        a[1] + (b[1] - a[1]) * (s - a[0]) / (b[0] - a[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_stays_within_eps_of_the_polyline_and_is_smooth() {
        for unit in [ThetaUnit::Degree, ThetaUnit::Radian, ThetaUnit::Normalized, ThetaUnit::UnitFree] {
            let points = vec![[0.0, 0.0], [30.0, 0.7], [75.0, 3.8], [120.0, 4.0], [185.0, 6.2]];
            let smoothed = SmoothedPolyline::new(points.clone(), unit, 185.0, |_, _| 0.09);
            let straight = SmoothedPolyline { corners: vec![None; points.len()], ..smoothed.clone() };
            let h = 1e-3;
            let mut largest: f64 = 0.0;
            let mut bend_before: Option<f64> = None;
            let mut jump: f64 = 0.0;
            for i in 1..184_999 {
                let s = f64::from(i) * 1e-3;
                let difference = smoothed.at(s) - straight.at(s);
                largest = largest.max(difference.abs());
                assert!(smoothed.at(s + h) >= smoothed.at(s) - 1e-12, "{unit:?} falls at {s}");
                let bend = (smoothed.at(s + h) - 2.0 * smoothed.at(s) + smoothed.at(s - h)) / (h * h);
                jump = bend_before.map_or(0.0, |b| jump.max((bend - b).abs()));
                bend_before = Some(bend);
            }
            // |eps| is the smaller of 0.09 and what half a segment allows; rounding of the second difference
            // is 1e-9.
            assert!(largest <= 0.09 + 1e-9 && largest > 0.005, "{unit:?} {largest}");
            // A continuous second derivative changes by little from one micrometer to the next; a kink would
            // give slope / h.
            assert!(jump < 0.02, "{unit:?} {jump}");
        }
    }

    #[test]
    fn the_published_example_of_unit_dependence() {
        // Specification 3.5: corner (0,0) (30,40) (75,220) deg, eps 5 deg: half supports in S.
        let corner = |scale: [f64; 2], rule| {
            let p = [[0.0, 0.0], [30.0, 40.0], [75.0, 220.0]].map(|p: [f64; 2]| [p[0] * scale[0], p[1] * scale[1]]);
            let c = BezierCorner::new(p, 5.0 * scale[1], rule).unwrap();
            [(c.control[2][0] - c.control[0][0]) / scale[0], (c.control[4][0] - c.control[2][0]) / scale[0]]
        };
        let close = |got: [f64; 2], want: [f64; 2]| got.iter().zip(want).all(|(g, w)| (g - w).abs() < 0.06);
        assert!(close(corner([1.0, 1.0], CornerRule::Bisector), [15.6, 4.1]));
        assert!(close(corner([1.0, 1.0_f64.to_radians()], CornerRule::Bisector), [7.5, 7.5]));
        assert!(close(corner([1.0 / 185.0, 1.0 / 360.0], CornerRule::Bisector), [12.2, 4.8]));
        let free = corner([1.0, 1.0], CornerRule::UnitFree);
        assert!((free[0] - free[1]).abs() < 1e-12, "{free:?}");
    }
}
