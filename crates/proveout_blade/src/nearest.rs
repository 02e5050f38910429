//! The point of a blade that is nearest to a given one, on its closed form, wherever it lies.
//!
//! The solid is a stack of sections: at height `x'` the points within `d` of the section, turned by `w x'`.
//! With the signed distance g from the section (`discs`) and `p = (x, q)`, the outline of a slice is
//!
//! ```text
//!     sqrt((x - x')^2 + N^2)      N = G(x') - d(x')      G(x') = g(R(-w x') q)
//! ```
//!
//! away from p, and p lies in the material where `N < 0` at its own height. The platform is not turned: its
//! slices all have one G, and its faces (bottom, top, rim) follow from it without a search. There remain the
//! airfoil (`d = 0`, run by x') and the fillet, run by the angle b at its center: `x' = f (1 - cos b)`, `d =
//! f (1 - sin b)`.
//!
//! *Outside* the nearest point of the solid is that of the nearest disc (x', s): `N = F(x', s) - d`, zero
//! where it is below, and both x' and s are searched. *Inside* the nearest face counts; there `N = d - G >=
//! d - F(x', s)` for any s, so that x' alone is searched, with the s of the middle of an interval.
//!
//! Both searches use branch and bound, with the bounds of `bounds`: an interval that contains nothing
//! nearer by [`NEAREST_ERROR_MM`] is dropped. The error is at most this distance, plus rounding.

mod bounds;

use proveout_geom::{Point, Vector};

use super::{
    body::{Blade, Platform},
    discs::{DiscView, Discs, STARTS, cut, look_at},
};

/// The distance of [`Blade::nearest`] is not larger than the true one by more than this, mm.
pub const NEAREST_ERROR_MM: f64 = 1e-7;
/// Coordinates beyond this have no nearest point, mm: their squares round too much.
const FARTHEST_MM: f64 = 1e7;
/// Nearer than this the normal is that of the face, mm; farther away it is the direction from the nearest
/// point.
const CLOSE_MM: f64 = 1e-3;
/// A place that is nearer by more than this is gone down from at once, so that no search goes round the
/// border of what is nearer by [`NEAREST_ERROR_MM`], mm.
const LOWER_MM: f64 = 1e-11;
/// Nearer to the center of a disc than this, it gives no direction, mm.
const CENTER_MM: f64 = 1e-6;
/// Steps of the search for a minimum nearby.
const STEPS: usize = 30;
/// A step below this ends that search, mm: the distance is too coarse to show a change.
const LAST_STEP_MM: f64 = 1e-9;
/// An interval that is shorter is a place, mm.
const NARROW_MM: f64 = 1e-12;

/// The nearest point of a blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnBlade {
    /// The point of its surface.
    pub point: Point,
    /// Signed distance, mm: below zero inside of the material.
    pub distance: f64,
    /// Outward unit normal; outside of an edge the direction from there.
    pub normal: Vector,
}

/// A face that is searched, with the bounds of its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BladeFace {
    /// Run by height.
    Airfoil([f64; 2]),
    /// Radius; run by its angle, 0 at the platform, a right angle at the airfoil.
    Fillet(f64),
}

impl BladeFace {
    fn height(self, b: f64) -> f64 {
        match self {
            Self::Airfoil(_) => b,
            Self::Fillet(f) => f * (1.0 - b.cos()),
        }
    }

    fn offset(self, b: f64) -> f64 {
        match self {
            Self::Airfoil(_) => 0.0,
            Self::Fillet(f) => f * (1.0 - b.sin()),
        }
    }

    fn parameter(self, height: f64) -> f64 {
        match self {
            Self::Airfoil(_) => height,
            Self::Fillet(f) => (1.0 - height / f).clamp(0.0, 1.0).acos(),
        }
    }

    /// Its part within `range` mm of a height.
    fn within(self, height: f64, range: f64) -> Option<[f64; 2]> {
        let [low, high] = match self {
            Self::Airfoil(bounds) => bounds,
            Self::Fillet(f) => [0.0, f],
        };
        let (lo, hi) = (low.max(height - range), high.min(height + range));
        (lo <= hi).then(|| [self.parameter(lo), self.parameter(hi)])
    }
}

/// A place that may be the nearest.
#[derive(Clone, Copy, Debug)]
enum NearestCandidate {
    /// On a plane face or the rim, with its normal.
    Known(Point, Vector),
    /// In a slice of a searched face.
    Slice(BladeFace, SliceNode),
}

/// A slice and a disc, seen from the point.
#[derive(Clone, Copy, Debug)]
struct SliceNode {
    b: f64,
    s: f64,
    x: f64,
    seen: DiscView,
    /// `N` there, of this disc.
    n: f64,
    /// Change of F along x and the part across.
    rise: f64,
    drift: f64,
    distance: f64,
}

struct NearestSearch<'a> {
    blade: &'a Blade,
    p: Point,
    twist: f64,
    /// Distance from the X axis.
    radius: f64,
    inside: bool,
    best: f64,
    place: NearestCandidate,
}

impl Blade {
    /// The point of the solid's surface nearest to a point, of all that there are; its distance is found to
    /// [`NEAREST_ERROR_MM`]. None for coordinates that are no numbers or beyond ten kilometers. It takes some
    /// microseconds, far more where the twist is so strong that sides lean by more than 60 degrees.
    pub fn nearest(&self, p: &Point) -> Option<NearestOnBlade> {
        if !p.iter().all(|v| v.abs() <= FARTHEST_MM) {
            return None;
        }
        let spec = self.spec();
        let foot = [p.y, p.z];
        let (at, height) = (p.x.clamp(0.0, spec.length), spec.length);
        let face = self.face_at(at);
        let mut search = NearestSearch {
            blade: self,
            p: *p,
            twist: spec.twist,
            radius: p.y.hypot(p.z),
            inside: false,
            best: f64::INFINITY,
            place: NearestCandidate::Known(*p, Vector::x()),
        };
        let own = search.slice(face, face.parameter(at));
        // At the platform's height or next to its rim the platform may be nearer than the slice.
        let platform = spec.platform.filter(|_| p.x < own.distance.max(own.n.abs()));
        let base = platform.map(|platform| (platform, self.discs().nearest(foot)));
        let in_blade = (0.0..=height).contains(&p.x) && own.n <= 0.0;
        let in_base = base.is_some_and(|(b, g)| (-b.thickness..=0.0).contains(&p.x) && g.1.value <= b.margin);
        search.inside = in_blade || in_base;
        if let Some((platform, seen)) = base {
            search.platform(&platform, seen);
        }
        if search.inside {
            search.plane(height, &search.slice_at(height), 1.0);
            if spec.platform.is_none() {
                search.plane(0.0, &search.slice_at(0.0), -1.0);
            }
            search.faces_inside(face, own);
        } else {
            search.faces_outside(face, own);
        }
        Some(search.finish())
    }

    fn faces(&self) -> impl Iterator<Item = BladeFace> {
        let fillet = self.spec().platform.map(|platform| BladeFace::Fillet(platform.fillet_radius));
        fillet.into_iter().chain([BladeFace::Airfoil([self.airfoil_start(), self.spec().length])])
    }

    fn face_at(&self, height: f64) -> BladeFace {
        match self.spec().platform {
            Some(platform) if height < platform.fillet_radius => BladeFace::Fillet(platform.fillet_radius),
            _ => BladeFace::Airfoil([self.airfoil_start(), self.spec().length]),
        }
    }
}

impl NearestSearch<'_> {
    /// y and z in the section at a height.
    fn turned_back(&self, x: f64) -> [f64; 2] {
        let (s, c) = (self.twist * x).sin_cos();
        [c * self.p.y + s * self.p.z, c * self.p.z - s * self.p.y]
    }

    fn node(&self, face: BladeFace, b: f64, s: f64, seen: DiscView, q: [f64; 2]) -> SliceNode {
        let x = face.height(b);
        let n = seen.value - face.offset(b);
        // d/dx R(-w x) q = -w (-q_z, q_y).
        let turn = [self.twist * q[1], -self.twist * q[0]];
        let away = self.p.x - x;
        // Inside any outline counts; outside a disc that reaches over the point.
        let part = if self.inside { n } else { n.max(0.0) };
        SliceNode {
            b,
            s,
            x,
            seen,
            n,
            rise: seen.away[0] * turn[0] + seen.away[1] * turn[1],
            drift: seen.away[0] * turn[1] - seen.away[1] * turn[0],
            distance: away.hypot(part),
        }
    }

    /// A slice with its nearest disc.
    fn slice(&self, face: BladeFace, b: f64) -> SliceNode {
        let q = self.turned_back(face.height(b));
        let (s, seen) = self.blade.discs().nearest(q);
        self.node(face, b, s, seen, q)
    }

    fn slice_at(&self, height: f64) -> DiscView {
        self.blade.discs().nearest(self.turned_back(height)).1
    }

    fn take(&mut self, distance: f64, place: NearestCandidate) {
        if distance < self.best {
            (self.best, self.place) = (distance, place);
        }
    }

    /// Tip, or foot of a blade without a platform, from inside.
    fn plane(&mut self, x: f64, seen: &DiscView, sense: f64) {
        if seen.value <= 0.0 {
            self.take(
                (self.p.x - x).abs(),
                NearestCandidate::Known(Point::new(x, self.p.y, self.p.z), Vector::new(sense, 0.0, 0.0)),
            );
        }
    }

    /// Bottom, rim and top of the platform. `seen`: the disc of the section at the platform's height.
    fn platform(&mut self, platform: &Platform, (s, seen): (f64, DiscView)) {
        let (p, g) = (self.p, seen.value);
        let away = touching(self.blade.discs(), &seen, s);
        // The point moved along its normal to a distance from the outline, at a height.
        let moved = |x: f64, to: f64| Point::new(x, p.y + (to - g) * away[0], p.z + (to - g) * away[1]);
        let (out, up) = (Vector::new(0.0, away[0], away[1]), Vector::x());
        let (low, margin) = (-platform.thickness, platform.margin);
        let faces = [
            (moved(low, g.min(margin)), -up),
            (moved(0.0, g.clamp(platform.fillet_radius, margin)), up),
            (moved(p.x.clamp(low, 0.0), margin), out),
        ];
        for (point, normal) in faces {
            self.take((p - point).norm(), NearestCandidate::Known(point, normal));
        }
    }

    /// The step along the face to the least of the parabola at a node.
    fn step(&self, face: BladeFace, node: &SliceNode) -> f64 {
        let x = self.p.x - node.x;
        let (a, b, sign) = if self.inside { (-node.n, -node.rise, -1.0) } else { (node.n, node.rise, 1.0) };
        match face {
            BladeFace::Airfoil(_) => (x - a * b) / (1.0 + b * b),
            BladeFace::Fillet(f) => {
                let (s, c) = node.b.sin_cos();
                let slope = f * ((a * b - x) * s + sign * a * c);
                // Half of U'' at the node, with i' = f s, i'' = f c, j' = +-f c, j'' = -+f s.
                let climb = b * f * s + sign * f * c;
                let bend = f * f * s * s - x * f * c + climb * climb + a * f * (b * c - sign * s);
                if bend > 0.0 { -slope / bend } else { -0.1 * slope.signum() }
            }
        }
    }

    /// Goes down from a node on its face; takes what it finds.
    fn polish(&mut self, face: BladeFace, mut node: SliceNode) {
        let Some([low, high]) = face.within(0.0, f64::INFINITY) else { return };
        self.take(node.distance, NearestCandidate::Slice(face, node));
        for _ in 0..STEPS {
            let mut step = (node.b + self.step(face, &node)).clamp(low, high) - node.b;
            node = loop {
                if step.abs() < LAST_STEP_MM {
                    return;
                }
                let b = node.b + step;
                let next = if self.inside {
                    self.slice(face, b)
                } else {
                    let q = self.turned_back(face.height(b));
                    let (s, seen) = self.blade.discs().settle(q, node.s);
                    self.node(face, b, s, seen, q)
                };
                if next.distance < node.distance {
                    break next;
                }
                step *= 0.25;
            };
            self.take(node.distance, NearestCandidate::Slice(face, node));
        }
    }

    /// The best place known, where it lies on this face.
    fn best_on(&self, face: BladeFace) -> Option<SliceNode> {
        match self.place {
            NearestCandidate::Slice(on, node) if on == face => Some(node),
            _ => None,
        }
    }

    fn faces_outside(&mut self, face: BladeFace, own: SliceNode) {
        self.polish(face, own);
        let width = self.blade.discs().length / STARTS as f64;
        let mut turned = (f64::NAN, [0.0; 2]);
        let mut open = Vec::with_capacity(4 * STARTS);
        for face in self.blade.faces() {
            let Some(heights) = face.within(self.p.x, self.best) else { continue };
            open.extend((0..STARTS).map(|k| (heights, [k as f64 * width, (k + 1) as f64 * width])));
            while let Some((heights, way)) = open.pop() {
                let best = self.best_on(face);
                let (b, s) = (look_at(heights, best.map(|n| n.b)), look_at(way, best.map(|n| n.s)));
                // Most intervals at the start share their height.
                let x = face.height(b);
                if turned.0 != x {
                    turned = (x, self.turned_back(x));
                }
                let q = turned.1;
                let node = self.node(face, b, s, self.blade.discs().see(q, s), q);
                if node.distance < self.best - LOWER_MM {
                    self.polish(face, node);
                }
                let sides = [heights[0] - b, heights[1] - b];
                let climb = (face.height(heights[1]) - node.x).max(node.x - face.height(heights[0]));
                let (bound, fall) = self.bound_outside(&node, climb, [way[0] - s, way[1] - s]);
                let (lower, lost) = self.lower(face, &node, &bound, sides);
                let tiny = way[1] - way[0] < NARROW_MM && heights[1] - heights[0] < NARROW_MM;
                if lower >= self.best - NEAREST_ERROR_MM || tiny {
                    continue;
                }
                let best = self.best_on(face);
                if fall >= lost && way[1] - way[0] >= NARROW_MM {
                    let at = cut(way, best.map(|n| n.s));
                    open.push((heights, [way[0], at]));
                    open.push((heights, [at, way[1]]));
                } else {
                    let at = cut(heights, best.map(|n| n.b));
                    open.push(([heights[0], at], way));
                    open.push(([at, heights[1]], way));
                }
            }
        }
    }

    fn faces_inside(&mut self, face: BladeFace, own: SliceNode) {
        // Its distance was that of the solid.
        let own = self.node(face, own.b, own.s, own.seen, self.turned_back(own.x));
        if own.n <= 0.0 {
            self.polish(face, own);
        }
        let mut open = Vec::with_capacity(16);
        for face in self.blade.faces() {
            open.extend(face.within(self.p.x, self.best));
            while let Some(heights) = open.pop() {
                let best = self.best_on(face);
                let b = look_at(heights, best.map(|n| n.b));
                let node = best.filter(|n| n.b == b).unwrap_or_else(|| self.slice(face, b));
                if node.distance < self.best - LOWER_MM {
                    self.polish(face, node);
                }
                let climb = (face.height(heights[1]) - node.x).max(node.x - face.height(heights[0]));
                let bound = self.bound_inside(&node, climb);
                let (lower, _) = self.lower(face, &node, &bound, [heights[0] - b, heights[1] - b]);
                if lower >= self.best - NEAREST_ERROR_MM || heights[1] - heights[0] < NARROW_MM {
                    continue;
                }
                let at = cut(heights, self.best_on(face).map(|n| n.b));
                open.push([heights[0], at]);
                open.push([at, heights[1]]);
            }
        }
    }

    fn finish(&self) -> NearestOnBlade {
        let (point, face_normal) = match self.place {
            NearestCandidate::Known(point, normal) => (point, normal),
            NearestCandidate::Slice(face, node) => self.foot(face, &node),
        };
        let away = self.p - point;
        let outward = if self.inside { -away } else { away };
        let normal = if self.best > CLOSE_MM { outward.try_normalize(0.0) } else { None };
        NearestOnBlade {
            point,
            distance: if self.inside { -self.best } else { self.best },
            normal: normal.unwrap_or(face_normal),
        }
    }

    /// The point of the surface in a slice, and the normal there. With `S = x' e + P + d n`, `S_b = x'_b (e +
    /// w e x S) + d_b n` and the tangent of the section, the normal is `n + a e` with `a = -w n . (e x S) -
    /// d_b / x'_b`.
    fn foot(&self, face: BladeFace, node: &SliceNode) -> (Point, Vector) {
        if node.n < 0.0 && !self.inside {
            // Over the tip, or under the foot.
            let sense = if self.p.x > node.x { 1.0 } else { -1.0 };
            return (Point::new(node.x, self.p.y, self.p.z), Vector::new(sense, 0.0, 0.0));
        }
        let [ny, nz] = touching(self.blade.discs(), &node.seen, node.s);
        let out = node.seen.disc.radius + face.offset(node.b);
        let [y, z] = [node.seen.disc.center[0] + out * ny, node.seen.disc.center[1] + out * nz];
        let lean = -self.twist * (nz * y - ny * z);
        let (along, part) = match face {
            BladeFace::Airfoil(_) => (lean, 1.0),
            BladeFace::Fillet(_) => {
                let (s, c) = node.b.sin_cos();
                (c + s * lean, s)
            }
        };
        let (s, c) = (self.twist * node.x).sin_cos();
        let turn = |v: [f64; 2]| [c * v[0] - s * v[1], s * v[0] + c * v[1]];
        let ([y, z], [ny, nz]) = (turn([y, z]), turn([ny, nz]));
        let normal = Vector::new(along, part * ny, part * nz);
        (Point::new(node.x, y, z), normal.try_normalize(0.0).unwrap_or_else(Vector::x))
    }
}

/// Direction from the center of a disc to where it touches the outline on the side of the point; at the ends
/// of the camber line that to the point, since the whole arc belongs to one disc.
fn touching(discs: &Discs, seen: &DiscView, s: f64) -> [f64; 2] {
    let [y, z] = seen.disc.along;
    let end = if s <= 0.0 {
        Some(-1.0)
    } else if s >= discs.length {
        Some(1.0)
    } else {
        None
    };
    if let Some(sense) = end {
        return if seen.far > CENTER_MM { seen.away } else { [sense * y, sense * z] };
    }
    // n . c' + r' = 0.
    let along = -seen.disc.widens;
    let across = (1.0 - along * along).max(0.0).sqrt() * if seen.across > 0.0 { -1.0 } else { 1.0 };
    [along * y - across * z, along * z + across * y]
}
