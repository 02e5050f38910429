//! Design surfaces in closed form, so that a cut part can be compared with the exact shape without facet
//! error.

use proveout_geom::{Point, Vector};

use crate::{DesignSurface, NearestOnDesign};

/// Half space: material below the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpaceDesign {
    /// A point of the plane, mm.
    pub point: Point,
    /// Outward unit normal.
    pub normal: Vector,
}

impl DesignSurface for HalfSpaceDesign {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let distance = (p - self.point).dot(&self.normal);
        (distance.abs() <= range).then_some(NearestOnDesign { distance, normal: self.normal })
    }
}

/// Sphere of material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Center, mm.
    pub center: Point,
    /// Radius, mm.
    pub radius: f64,
}

impl DesignSurface for Sphere {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let from_center = p - self.center;
        let r = from_center.norm();
        let distance = r - self.radius;
        let normal = if r > 0.0 { from_center / r } else { Vector::z() };
        (distance.abs() <= range).then_some(NearestOnDesign { distance, normal })
    }
}

/// Frustum of a cone (a cylinder when both radii are equal), mm.
///
/// ```text
///        axis ^
///             |__ top_radius
///             |  \
///      height |   \  flank
///             |____\
///        base   base_radius
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeFrustum {
    /// Center of the base.
    pub base: Point,
    /// Unit vector from base to top.
    pub axis: Vector,
    /// Radius at the base.
    pub base_radius: f64,
    /// Radius at the top.
    pub top_radius: f64,
    /// Distance from base to top, above zero.
    pub height: f64,
}

impl ConeFrustum {
    /// Radius and height of a point, and the unit vector outward from the axis.
    fn cylindrical(&self, p: &Point) -> ([f64; 2], Vector) {
        let from_base = p - self.base;
        let z = from_base.dot(&self.axis);
        let across = from_base - self.axis * z;
        let r = across.norm();
        let out = if r > 0.0 { across / r } else { any_across(&self.axis) };
        ([r, z], out)
    }
}

fn any_across(axis: &Vector) -> Vector {
    let helper = if axis.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
    let across = axis.cross(&helper);
    across / across.norm()
}

/// The solid with its two end faces.
impl DesignSurface for ConeFrustum {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let (q, out) = self.cylindrical(p);
        let corners = [[0.0, 0.0], [self.base_radius, 0.0], [self.top_radius, self.height], [0.0, self.height]];
        let mut best: Option<(f64, [f64; 2], [f64; 2])> = None; // distance, foot, outward normal of the side
        let mut inside = true;
        for side in corners.windows(2) {
            let (from, to) = (side[0], side[1]);
            let d = [to[0] - from[0], to[1] - from[1]];
            let length = d[0].hypot(d[1]);
            if length == 0.0 {
                continue;
            }
            let normal = [d[1] / length, -d[0] / length];
            inside &= (q[0] - from[0]) * normal[0] + (q[1] - from[1]) * normal[1] <= 0.0;
            let t = (((q[0] - from[0]) * d[0] + (q[1] - from[1]) * d[1]) / (length * length)).clamp(0.0, 1.0);
            let foot = [from[0] + t * d[0], from[1] + t * d[1]];
            let distance = (q[0] - foot[0]).hypot(q[1] - foot[1]);
            if best.is_none_or(|b| distance < b.0) {
                best = Some((distance, foot, normal));
            }
        }
        let (distance, foot, face) = best?;
        if distance.is_nan() || distance > range {
            return None;
        }
        // Outside of an edge the normal is the direction to the point.
        let n =
            if !inside && distance > 0.0 { [(q[0] - foot[0]) / distance, (q[1] - foot[1]) / distance] } else { face };
        let normal = out * n[0] + self.axis * n[1];
        Some(NearestOnDesign { distance: if inside { -distance } else { distance }, normal })
    }
}

/// The flank of a frustum alone: it answers only for points whose foot lies on the flank, at least
/// `end_margin` (mm, along the flank) from its two ends. So the floor below the frustum and the run-out of
/// the cutter do not count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeFlank {
    /// The frustum.
    pub frustum: ConeFrustum,
    /// Part of the flank at each end that is left out, mm.
    pub end_margin: f64,
}

impl DesignSurface for ConeFlank {
    fn nearest(&self, p: &Point, range: f64) -> Option<NearestOnDesign> {
        let f = &self.frustum;
        let (q, out) = f.cylindrical(p);
        let d = [f.top_radius - f.base_radius, f.height];
        let length = d[0].hypot(d[1]);
        let along = ((q[0] - f.base_radius) * d[0] + q[1] * d[1]) / length;
        if !(along >= self.end_margin && along <= length - self.end_margin) {
            return None;
        }
        let normal = [d[1] / length, -d[0] / length];
        let distance = (q[0] - f.base_radius) * normal[0] + q[1] * normal[1];
        (distance.abs() <= range).then(|| NearestOnDesign { distance, normal: out * normal[0] + f.axis * normal[1] })
    }
}
