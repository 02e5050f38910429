//! The point of a blade with its ends that is nearest to a given one.
//!
//! Each face answers for itself, where its own nearest point is a part of it; the nearest of them counts:
//!
//! * the airfoil, trimmed: the nearest point of the whole surface (`cells`). Where that one is cut off, the way to it from outside goes through
//!   a fillet, a platform or a flat end, which is nearer than any part that is left: nothing is missed. From inside the material, near an end, the
//!   part that is left may be the nearest face; then the search is among the rows that are left all round.
//! * a fillet: the center of the ball nearest to the point; the arc from the blade to the platform round it holds the nearest point or not.
//! * plane faces: the point below, if it is in the face and not in the foot of the blade; else the rim.

use super::{
    flat,
    solid::{BladeSolid, Plate},
};
use crate::{Point, Vector};

/// Steps of the golden section: a step of half a degree is narrowed to a millionth.
const SECTIONS: usize = 30;
/// A direction that leans out of an arc by this part still belongs to it: rounding where faces join.
const JOINED: f64 = 1e-9;

/// The nearest point of a blade with its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnSolid {
    /// Signed distance, mm: below zero inside of the material.
    pub distance: f64,
    /// Outward unit normal; outside of an edge the direction from there.
    pub normal: Vector,
}

impl NearestOnSolid {
    fn nearer(self, other: Option<Self>) -> Self {
        other.filter(|o| o.distance.abs() < self.distance.abs()).unwrap_or(self)
    }
}

impl BladeSolid {
    /// The nearest of all faces; the distance to the closed form, within [`super::FOOT_ERROR_MM`] on the airfoil and 1e-9 mm elsewhere.
    pub fn nearest(&self, p: &Point) -> NearestOnSolid {
        let mut best = NearestOnSolid { distance: f64::INFINITY, normal: Vector::x() };
        let airfoil = self.airfoil(p);
        best = best.nearer(airfoil);
        for end in 0..2 {
            // The faces of an end lie between its plane and the top of the fillet, or behind it.
            let beyond = (p.x - self.ends()[end].x) * Self::sense(end) - 2.0 * self.fillet(end) - self.allowance();
            if beyond <= best.distance.abs() {
                best = best.nearer(self.on_end(end, p));
            }
        }
        best
    }

    /// On the airfoil, where the nearest point is left by both ends.
    fn airfoil(&self, p: &Point) -> Option<NearestOnSolid> {
        let [u, v] = self.surface().nearest(p);
        let left = (0..2).all(|end| {
            let trim = self.trim(end, u).map_or(v, |t| t.v);
            if end == 0 { v >= trim - JOINED } else { v <= trim + JOINED }
        });
        let at = self.surface().local(u, v);
        let out = p - at.point;
        let distance = out.norm();
        left.then(|| {
            let signed = if out.dot(&at.normal) >= 0.0 { distance } else { -distance };
            NearestOnSolid { distance: signed - self.allowance(), normal: at.normal }
        })
    }

    fn on_end(&self, end: usize, p: &Point) -> Option<NearestOnSolid> {
        match self.ends()[end].plate {
            Some(plate) => {
                let block = self.on_block(end, &plate, p);
                match (self.on_fillet(end, p), block) {
                    (Some(a), b) => Some(a.nearer(b)),
                    (None, b) => b,
                }
            }
            None => self.on_flat(end, p),
        }
    }

    /// Parameter of the ball's center nearest to a point.
    fn nearest_center(&self, end: usize, p: &Point, project: impl Fn(&Point) -> Point) -> Option<(f64, Point)> {
        let domain = self.surface().domain();
        let wide = domain.u[1] - domain.u[0];
        let center = |u: f64| self.trim(end, u).ok().map(|t| project(&t.center));
        let far = |u: f64| center(u).map_or(f64::INFINITY, |c| (c - p).norm());
        // The feet are the centers, seen along X; only their order in u matters here.
        let feet = &self.feet[end];
        let step = wide / feet.len() as f64;
        let flat = |k: usize| (feet[k][0] - p.y).hypot(feet[k][1] - p.z);
        let mut starts: Vec<usize> = (0..feet.len())
            .filter(|&k| {
                let here = flat(k);
                here <= flat((k + 1) % feet.len()) && here <= flat((k + feet.len() - 1) % feet.len())
            })
            .collect();
        starts.sort_by(|a, b| flat(*a).total_cmp(&flat(*b)));
        let mut best: Option<(f64, f64)> = None;
        for k in starts.into_iter().take(2) {
            // Golden section over both neighbors (Kiefer 1953).
            let (mut low, mut high) = (domain.u[0] + step * (k as f64 - 1.0), domain.u[0] + step * (k as f64 + 1.0));
            let part = 0.5 * (5.0_f64.sqrt() - 1.0);
            let (mut a, mut b) = (high - part * (high - low), low + part * (high - low));
            let (mut fa, mut fb) = (far(a), far(b));
            for _ in 0..SECTIONS {
                if fa < fb {
                    (high, b, fb) = (b, a, fa);
                    a = high - part * (high - low);
                    fa = far(a);
                } else {
                    (low, a, fa) = (a, b, fb);
                    b = low + part * (high - low);
                    fb = far(b);
                }
            }
            let u = 0.5 * (low + high);
            let d = far(u);
            if best.is_none_or(|o| d < o.1) {
                best = Some((u, d));
            }
        }
        let (u, _) = best?;
        Some((u, center(u)?))
    }

    fn on_fillet(&self, end: usize, p: &Point) -> Option<NearestOnSolid> {
        let (u, center) = self.nearest_center(end, p, |c| *c)?;
        let normal = self.trim(end, u).ok()?.at.normal;
        let out = p - center;
        let far = out.norm();
        let direction = out.try_normalize(1e-12)?;
        // As a sum of the ways to blade and platform, both of which an arc between them has forward.
        let (blade, plane) = (-normal, Vector::x() * -Self::sense(end));
        let cosine = blade.dot(&plane);
        let (a, b) = (direction.dot(&blade), direction.dot(&plane));
        let det = 1.0 - cosine * cosine;
        let parts = [(a - cosine * b) / det, (b - cosine * a) / det];
        let radius = self.fillet(end) - self.allowance();
        parts.iter().all(|x| *x >= -JOINED).then(|| NearestOnSolid { distance: radius - far, normal: -direction })
    }

    fn on_block(&self, end: usize, plate: &Plate, p: &Point) -> Option<NearestOnSolid> {
        let (sense, x) = (Self::sense(end), self.ends()[end].x);
        let face = x + sense * self.allowance();
        let back = x - sense * plate.thickness;
        let (low, high) =
            (Vector::new(face.min(back), plate.y[0], plate.z[0]), Vector::new(face.max(back), plate.y[1], plate.z[1]));
        let inside = (0..3).all(|k| p[k] > low[k] && p[k] < high[k]);
        let footed = |q: &Point| flat::contains(&self.feet[end], [q.y, q.z]);
        let toward = Vector::x() * sense;
        if !inside {
            let q = Point::from(p.coords.sup(&low).inf(&high));
            let on_face = q.x == face && (p.x - face) * sense >= 0.0;
            if on_face && footed(&q) {
                return None;
            }
            let out = p - q;
            let normal = out.try_normalize(0.0).unwrap_or(toward);
            return Some(NearestOnSolid { distance: out.norm(), normal });
        }
        let mut best: Option<NearestOnSolid> = None;
        for k in 0..3 {
            for (bound, normal) in [(low[k], -1.0), (high[k], 1.0)] {
                if k == 0 && bound == face && footed(p) {
                    continue;
                }
                let mut out = Vector::zeros();
                out[k] = normal;
                let here = NearestOnSolid { distance: -(p[k] - bound).abs(), normal: out };
                best = Some(best.map_or(here, |b| b.nearer(Some(here))));
            }
        }
        best
    }

    /// A flat end: its face, or its rim.
    fn on_flat(&self, end: usize, p: &Point) -> Option<NearestOnSolid> {
        let x = self.ends()[end].x;
        let outward = Vector::x() * -Self::sense(end);
        if flat::contains(&self.feet[end], [p.y, p.z]) {
            let far = (p - Point::new(x, p.y, p.z)).dot(&outward);
            return Some(NearestOnSolid { distance: far, normal: outward });
        }
        let (_, rim) = self.nearest_center(end, p, |c| Point::new(x, c.y, c.z))?;
        let out = p - rim;
        Some(NearestOnSolid { distance: out.norm(), normal: out.try_normalize(0.0).unwrap_or(outward) })
    }
}
