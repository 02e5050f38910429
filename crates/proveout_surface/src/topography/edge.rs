//! Cutting edges: rounded corners of the teeth, with helix, run-out and rake.

use proveout_geom::Vector;
use proveout_tool::RunOut;

use super::{AT_CENTER, LARGEST};

/// The ends of an arc reach farther by this, radian: they belong to it, and rounding must not cut them off.
const ROUNDING: f64 = 1e-9;

/// The corner of one tooth: an arc in the plane of the edge.
///
/// ```text
///        z |                 point of the edge at corner angle kappa from the axis:
///          |    r               radius   center_radius + r sin kappa
///          |   .---.            height   center_height - r cos kappa
///          |  (  o  )           azimuth  azimuth + (height above the tooth's tip) * lead
///          |   '---'
///          +------|----- s   tooth direction
///             center_radius
/// ```
///
/// A ball has center radius 0 and r = R; a bull nose R - r; a round insert the radius of its nose circle,
/// with both sides of the circle cutting; a barrel a negative center radius. Radial run-out is part of the
/// center radius, axial run-out of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Distance of the arc's center from the axis, mm, along the tooth; run-out included.
    pub center_radius: f64,
    /// Height of the arc's center above the tip, mm; run-out included.
    pub center_height: f64,
    /// Radius of the arc, mm.
    pub radius: f64,
    /// Range of the corner angle, radian; 0 is the lowest point.
    pub corner: [f64; 2],
    /// Azimuth of the tooth at its lowest point from that of the cutter, radian.
    pub azimuth: f64,
    /// Azimuth for each millimeter above the lowest point of the arc, rad/mm: tan(helix) / R, positive for
    /// right-hand helices.
    pub lead: f64,
    /// Angle by which the plane of the edge is turned about the line parallel to the axis through the arc's
    /// center, radian.
    pub nose_turn: f64,
}

/// What holds for all teeth of a cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TeethCorner {
    /// Largest radius of the cutter, mm.
    pub radius: f64,
    /// Radius of the rounded corner, mm; that of the cutter for a ball.
    pub corner_radius: f64,
    /// Range of the corner angle that cuts, radian.
    pub corner: [f64; 2],
    /// Helix angle, radian, right-hand positive.
    pub helix: f64,
}

impl TeethCorner {
    /// Teeth at equal pitch, tooth `k` at azimuth `2 pi k / z`, with their run-out.
    pub fn edges(&self, run_out: &[RunOut]) -> Vec<Edge> {
        let teeth = run_out.len() as f64;
        run_out
            .iter()
            .enumerate()
            .map(|(k, off)| Edge {
                center_radius: self.radius - self.corner_radius + off.radial,
                center_height: self.corner_radius + off.axial,
                radius: self.corner_radius,
                corner: self.corner,
                azimuth: std::f64::consts::TAU * k as f64 / teeth,
                lead: self.helix.tan() / self.radius,
                nose_turn: 0.0,
            })
            .collect()
    }
}

/// Residuals of the contact of an edge with a point and their derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual {
    /// Distance from the plane of the edge, mm.
    pub plane: f64,
    /// Distance from the arc in that plane, mm, positive outside.
    pub arc: f64,
    /// Derivatives of both along a rate in housing coordinates and an azimuth rate.
    gradient_plane: Vector,
    gradient_arc: Vector,
    plane_by_azimuth: f64,
    arc_by_azimuth: f64,
    /// Point in the plane of the edge, from the arc's center.
    pub side: f64,
    /// Height from the arc's center.
    pub height: f64,
    /// Along the tooth; negative on the far side of the axis.
    pub along: f64,
    /// Across the tooth.
    pub across: f64,
}

impl Edge {
    /// Residuals of a point in housing coordinates for an azimuth of the cutter.
    ///
    /// With psi the azimuth of the tooth at the height of the point, s and w are the coordinates along and
    /// across the tooth; the plane of the edge is turned by the nose turn g about the line through the arc's
    /// center: side = (s - c) cos g + w sin g, plane = -(s - c) sin g + w cos g, arc = |(side, height)| - r.
    #[inline]
    pub(crate) fn residual(&self, q: &Vector, azimuth: f64) -> Residual {
        let height = q.z - self.center_height;
        let psi = azimuth + self.azimuth + (height + self.radius) * self.lead;
        let (sin, cos) = psi.sin_cos();
        let s = q.x * cos + q.y * sin;
        let w = -q.x * sin + q.y * cos;
        let offset = s - self.center_radius;
        let (gs, gc) = if self.nose_turn == 0.0 { (0.0, 1.0) } else { self.nose_turn.sin_cos() };
        let side = offset * gc + w * gs;
        let plane = -offset * gs + w * gc;
        let length = (side * side + height * height).sqrt().max(AT_CENTER);
        let (us, uz) = (side / length, height / length);
        // s, w by psi: w and -s.
        let (side_by, plane_by) = (w * gc - s * gs, -w * gs - s * gc);
        // side, plane by (x, y) at fixed psi.
        let side_xy = [cos * gc - sin * gs, sin * gc + cos * gs];
        let plane_xy = [-cos * gs - sin * gc, -sin * gs + cos * gc];
        Residual {
            plane,
            arc: length - self.radius,
            gradient_plane: Vector::new(plane_xy[0], plane_xy[1], plane_by * self.lead),
            gradient_arc: Vector::new(us * side_xy[0], us * side_xy[1], us * side_by * self.lead + uz),
            plane_by_azimuth: plane_by,
            arc_by_azimuth: us * side_by,
            side,
            height,
            along: s,
            across: w,
        }
    }

    /// Whether all numbers are finite and of the size of a tool's.
    pub fn is_finite(&self) -> bool {
        let numbers = [self.center_radius, self.center_height, self.radius, self.azimuth, self.lead, self.nose_turn];
        numbers.iter().chain(&self.corner).all(|v| v.abs() < LARGEST)
    }

    /// Distance from the axis within which an arc with its center beyond the axis lies on the other side of
    /// it, mm; else zero.
    pub(crate) fn behind_axis(&self) -> f64 {
        (-self.center_radius - self.radius * self.corner[0].sin()).max(0.0)
    }

    /// By how much such a part lies farther from the circle of the centers (on its own side of the axis) than
    /// the arc's radius, mm: a point at r sin kappa = s below |c| is 2 |c| - s from it across the axis, where
    /// s would be the arc.
    pub(crate) fn margin(&self) -> f64 {
        let (c, r) = (self.center_radius, self.radius);
        let s = r * self.corner[0].sin();
        if self.behind_axis() > 0.0 {
            ((r * r + 4.0 * c * c + 4.0 * c * s).max(r * r).sqrt() - r).max(0.0)
        } else {
            0.0
        }
    }

    /// Whether a point of the arc's plane lies in the range of corner angles.
    #[inline]
    pub(crate) fn holds(&self, r: &Residual) -> bool {
        let kappa = r.side.atan2(-r.height);
        kappa >= self.corner[0] - ROUNDING && kappa <= self.corner[1] + ROUNDING
    }
}

impl Residual {
    /// Derivatives of (plane, arc) along a rate of the point and of the azimuth.
    #[inline]
    pub(crate) fn along_rate(&self, q_rate: &Vector, azimuth_rate: f64) -> [f64; 2] {
        [
            self.gradient_plane.dot(q_rate) + self.plane_by_azimuth * azimuth_rate,
            self.gradient_arc.dot(q_rate) + self.arc_by_azimuth * azimuth_rate,
        ]
    }
}
