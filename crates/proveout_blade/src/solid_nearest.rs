//! The point of a blade with its ends that is nearest to a given one.
//!
//! Each face answers for itself, where its own nearest point is a part of it; the nearest of them counts:
//!
//! * the airfoil, trimmed: the nearest point of the whole surface (`cells`). Where that one is cut off, no
//!   part that is left is nearer than it; only where the faces of the ends are all farther (deep inside the
//!   material) the parts that are left are searched, from a net of places.
//! * a fillet: every center of the ball that is nearest to the point among its neighbors; the arc from the
//!   blade to the platform round it holds the nearest point, or its end does, where the next face goes on
//!   with the same normal.
//! * plane faces: the point below, if it is in the face and not in the foot of the blade; else the rim.

use proveout_geom::{Point, Vector};

use super::{
    FOOT_ERROR_MM, LEAST_PART, flat,
    solid::{BladeSolid, Plate},
};

/// Steps of the golden section: a step of half a degree is narrowed to a millionth.
const SECTIONS: usize = 30;

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

/// Rows of the net from which what is left of the airfoil is searched.
const ROWS: usize = 8;
/// Places of the net from which the search starts, the nearest among their neighbors.
const STARTS: usize = 6;
/// The way from a foot may lean by this part, or mm, from the normal.
const ABREAST: f64 = 1e-6;
/// Steps of Newton's method.
const STEPS: usize = 30;
/// Part of the determinant by the first derivatives below which that by the second ones is not used: there is
/// no minimum nearby.
const LEAST_DETERMINANT: f64 = 1e-6;
/// Nearer to the center of a fillet's ball than this, no direction leads away from it, mm.
const CENTER_MM: f64 = 1e-12;

impl BladeSolid {
    /// The nearest of all faces; the distance to the closed form, within [`super::FOOT_ERROR_MM`]. Deep
    /// inside of the material, where the nearest face of the blade without ends is cut off, the depth is that
    /// of the nearest foot that a search from a net of places finds.
    pub fn nearest(&self, p: &Point) -> NearestOnSolid {
        let nothing = NearestOnSolid { distance: f64::INFINITY, normal: Vector::x() };
        // The faces of an end lie between its plane and the top of the fillet, or beyond the plane.
        let beyond =
            [0, 1].map(|end| (p.x - self.ends()[end].x) * Self::sense(end) - 2.0 * self.fillet(end) - self.allowance());
        // Next to a platform or beyond an end, the faces of the end are mostly nearer than all of the
        // airfoil. A few cells of the airfoil are enough to prove that. The foot on the airfoil would lie
        // on its rim, where a proof takes longest.
        let mut known = [0, 1].map(|end| (beyond[end] <= 0.0).then(|| self.on_end(end, p)));
        let mut with_ends = |mut best: NearestOnSolid| {
            for end in 0..2 {
                if beyond[end] <= best.distance.abs() {
                    best = best.nearer(*known[end].get_or_insert_with(|| self.on_end(end, p)));
                }
            }
            best
        };
        if beyond.iter().any(|b| *b <= 0.0) {
            let ends = with_ends(nothing);
            let reach = ends.distance.abs() + self.allowance().abs() + FOOT_ERROR_MM;
            if reach.is_finite() && self.surface().is_beyond(p, reach) {
                return ends;
            }
        }
        let [u, v] = self.surface().nearest(p);
        let left = self.leaves(u, v);
        let mut best = with_ends(if left { self.beside(p, [u, v]) } else { nothing });
        // No part of the airfoil is nearer than the nearest point of the whole surface.
        let whole = (p - self.surface().local(u, v).point).norm() - self.allowance();
        if !left && best.distance.abs() > whole.max(0.0) {
            best = best.nearer(self.on_what_is_left(p));
        }
        best
    }

    /// From the airfoil at parameters.
    fn beside(&self, p: &Point, [u, v]: [f64; 2]) -> NearestOnSolid {
        let at = self.surface().local(u, v);
        let out = p - at.point;
        let signed = if out.dot(&at.normal) >= 0.0 { out.norm() } else { -out.norm() };
        NearestOnSolid { distance: signed - self.allowance(), normal: at.normal }
    }

    /// The nearest place of the airfoil between its ends.
    fn on_what_is_left(&self, p: &Point) -> Option<NearestOnSolid> {
        let domain = self.surface().domain();
        let count = self.ended[0].len();
        let wide = domain.u[1] - domain.u[0];
        let place = |k: usize, row: usize| {
            let [low, high] = [self.ended[0][k], self.ended[1][k]];
            [domain.u[0] + wide * k as f64 / count as f64, low + (high - low) * row as f64 / ROWS as f64]
        };
        // The nearest row of each column, then the columns that are nearer than their neighbors.
        let far = |[u, v]: [f64; 2]| (self.surface().local(u, v).point - p).norm();
        let columns: Vec<(f64, [f64; 2])> = (0..count)
            .map(|k| {
                let rows = (0..=ROWS).map(|row| (far(place(k, row)), place(k, row)));
                rows.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, place(k, 0)))
            })
            .collect();
        let mut starts: Vec<(f64, [f64; 2])> = (0..count)
            .filter(|&k| {
                columns[k].0 <= columns[(k + 1) % count].0 && columns[k].0 <= columns[(k + count - 1) % count].0
            })
            .map(|k| columns[k])
            .collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let found = starts.into_iter().take(STARTS).filter_map(|(_, start)| {
            let foot = self.foot_left(p, start);
            let at = self.surface().local(foot[0], foot[1]);
            // A foot that was stopped by an end belongs to the faces there.
            let out = p - at.point;
            (out.cross(&at.normal).norm() <= ABREAST * (1.0 + out.norm())).then(|| self.beside(p, foot))
        });
        found.reduce(|a, b| a.nearer(Some(b)))
    }

    /// The foot near a start, kept between the ends: Newton's method, or Gauss's where the distance has no
    /// minimum nearby; shortened until it comes nearer.
    fn foot_left(&self, p: &Point, start: [f64; 2]) -> [f64; 2] {
        let surface = self.surface();
        let keep = |[u, v]: [f64; 2]| {
            let end = |k: usize| self.trim(k, u).map_or(v, |t| t.v);
            [u, v.max(end(0)).min(end(1))]
        };
        let mut here = keep(start);
        for _ in 0..STEPS {
            let at = surface.local(here[0], here[1]);
            let f = at.point - p;
            let g = [f.dot(&at.first[0]), f.dot(&at.first[1])];
            let gauss = [at.first[0].norm_squared(), at.first[0].dot(&at.first[1]), at.first[1].norm_squared()];
            let full: [f64; 3] = std::array::from_fn(|k| gauss[k] + f.dot(&at.second[k]));
            let of = |[a, b, c]: [f64; 3]| a * c - b * b;
            let [a, b, c] = if full[0] > 0.0 && of(full) > LEAST_DETERMINANT * of(gauss) { full } else { gauss };
            let step = [(c * g[0] - b * g[1]) / of([a, b, c]), (a * g[1] - b * g[0]) / of([a, b, c])];
            let mut part = 1.0;
            let nearer = loop {
                let next = keep([here[0] - part * step[0], here[1] - part * step[1]]);
                if (surface.local(next[0], next[1]).point - p).norm() < f.norm() {
                    break Some(next);
                }
                part *= 0.25;
                if part < LEAST_PART {
                    break None;
                }
            };
            let Some(next) = nearer else { break };
            here = next;
        }
        here
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

    /// Parameters of the ball's centers that are nearest to a point among their neighbors, the nearest first.
    /// All centers lie in one plane of constant X, so that the distance in Y and Z decides.
    fn near_centers(&self, end: usize, p: &Point) -> Vec<f64> {
        let domain = self.surface().domain();
        let wide = domain.u[1] - domain.u[0];
        let far = |u: f64| {
            let center = self.trim(end, u).ok().map(|t| t.center);
            center.map_or(f64::INFINITY, |c| (c.y - p.y).hypot(c.z - p.z))
        };
        let feet = &self.feet[end];
        let step = wide / feet.len() as f64;
        let flat = |k: usize| (feet[k][0] - p.y).hypot(feet[k][1] - p.z);
        let starts = (0..feet.len()).filter(|&k| {
            let here = flat(k);
            here <= flat((k + 1) % feet.len()) && here <= flat((k + feet.len() - 1) % feet.len())
        });
        let narrowed = |k: usize| {
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
            (far(u), u)
        };
        let mut found: Vec<(f64, f64)> = starts.map(narrowed).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, u)| u).collect()
    }

    /// Whether a place lies within the outline of an end: by its polygon, and next to that by the nearest
    /// place of the outline itself, where the normal of the blade, seen along X, is at right angles to the
    /// outline.
    fn footed(&self, end: usize, p: &Point) -> bool {
        let feet = &self.feet[end];
        let (mut longest, mut nearest) = (0.0_f64, f64::INFINITY);
        for (k, a) in feet.iter().enumerate() {
            let b = feet[(k + 1) % feet.len()];
            longest = longest.max((a[0] - b[0]).hypot(a[1] - b[1]));
            nearest = nearest.min((a[0] - p.y).hypot(a[1] - p.z));
        }
        if nearest > 2.0 * longest {
            return flat::contains(feet, [p.y, p.z]);
        }
        let near = self.near_centers(end, p).first().and_then(|u| self.trim(end, *u).ok());
        near.is_some_and(|t| (p.y - t.center.y) * t.at.normal.y + (p.z - t.center.z) * t.at.normal.z < 0.0)
    }

    fn on_fillet(&self, end: usize, p: &Point) -> Option<NearestOnSolid> {
        let all = self.near_centers(end, p).into_iter().filter_map(|u| self.on_arc(end, u, p));
        all.reduce(|a, b| a.nearer(Some(b)))
    }

    /// On the arc round the center at u.
    fn on_arc(&self, end: usize, u: f64, p: &Point) -> Option<NearestOnSolid> {
        let trim = self.trim(end, u).ok()?;
        let out = p - trim.center;
        let far = out.norm();
        let direction = out.try_normalize(CENTER_MM)?;
        // As a sum of the ways to blade and platform, both of which an arc between them has forward.
        let (blade, plane) = (-trim.at.normal, Vector::x() * -Self::sense(end));
        let cosine = blade.dot(&plane);
        let (a, b) = (direction.dot(&blade), direction.dot(&plane));
        let radius = self.fillet(end) - self.allowance();
        if a - cosine * b >= 0.0 && b - cosine * a >= 0.0 {
            return Some(NearestOnSolid { distance: radius - far, normal: -direction });
        }
        // An end of the arc, where blade or platform go on.
        let last = if a > b { blade } else { plane };
        let out = p - (trim.center + last * radius);
        let distance = if out.dot(&last) <= 0.0 { out.norm() } else { -out.norm() };
        Some(NearestOnSolid { distance, normal: -last })
    }

    fn on_block(&self, end: usize, plate: &Plate, p: &Point) -> Option<NearestOnSolid> {
        let (sense, x) = (Self::sense(end), self.ends()[end].x);
        let face = x + sense * self.allowance();
        let back = x - sense * plate.thickness;
        let (low, high) =
            (Vector::new(face.min(back), plate.y[0], plate.z[0]), Vector::new(face.max(back), plate.y[1], plate.z[1]));
        let inside = (0..3).all(|k| p[k] > low[k] && p[k] < high[k]);
        let footed = |q: &Point| self.footed(end, q);
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
        if self.footed(end, p) {
            let far = (p - Point::new(x, p.y, p.z)).dot(&outward);
            return Some(NearestOnSolid { distance: far, normal: outward });
        }
        let rim = self.trim(end, *self.near_centers(end, p).first()?).ok()?.center;
        let out = p - Point::new(x, rim.y, rim.z);
        Some(NearestOnSolid { distance: out.norm(), normal: out.try_normalize(0.0).unwrap_or(outward) })
    }
}
