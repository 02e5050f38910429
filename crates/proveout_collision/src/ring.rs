//! A body that turns, at all of its turns at once.
//!
//! What a body reaches while it turns about an axis is a body of revolution. Every point of a triangle is a
//! mean of its corners; the distance from the axis is convex and the height along it linear, so that the
//! triangle at every turn lies in the convex body of revolution about the hull of its corners in the half
//! plane of r and z:
//!
//! ```text
//!    r ^     C              the corners A, B, C of a triangle at (r, z); at any turn it lies below the hull
//!      |    /|\_            of these and their feet on the axis
//!      |   / | _\ B
//!      |  A--'   |          triangles that overlap along z share a hull; a body is cut between them where
//!      +--+------+---> z    that leaves less: a disk and the hub below it are two
//! ```
//!
//! Against such a hull the turns of the joint do not count at all: a table that has turned a hundred times
//! below a beam is as far from it as its hull is. Where that is too near, the body itself is asked, turn by
//! turn.

use std::sync::Arc;

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{Attachment, JointValues, Machine};
use proveout_tool::{Profile, Segment};

use crate::Interference;
use crate::distance::{Separation, WarmStart, gap};
use crate::pair_advance::{JointStep, MOST_PROVED_MM, PairState};
use crate::parts::{CollisionPart, chain_to};
use crate::proved_distance::{ProvedDistance, dot};
use crate::shape::{PartShape, Revolved};

/// Hulls of one body at most: each is one more question.
const MOST_HULLS: usize = 8;
/// A body is cut where this part of the volume of its hull is saved.
const SAVED: f64 = 0.1;
/// Pieces of a mesh and places where a cut is tried, at most: what a body of many triangles may cost.
const MOST_UNITS: usize = 1024;
const MOST_CUTS: usize = 64;
/// Corners that are nearer than this to each other or to a straight line count as one or none, mm: rounding
/// of the drawing.
const SAME_MM: f64 = 1e-9;
/// Looks at the bodies themselves before their hulls are tried again.
const LOOKS_BETWEEN: u32 = 64;
/// A joint with less travel is followed turn by turn, radian: half a turn.
const WIDE_RAD: f64 = std::f64::consts::PI;

/// One of a pair at all turns of the joint that carries it.
#[derive(Clone, Debug)]
pub(crate) struct Ring {
    /// In place of the first or of the second of the pair.
    pub(crate) side: usize,
    pub(crate) joint: usize,
    /// The hulls, carried by the joint.
    pub(crate) part: Arc<CollisionPart>,
}

/// A pair in which one is taken at all turns of its joint, as long as that is far enough.
#[derive(Clone, Debug)]
pub(crate) struct RingState {
    pub(crate) of: Ring,
    /// The turns do not count now.
    pub(crate) live: bool,
    warm: WarmStart,
    /// Looks at the bodies themselves since the hulls were too near.
    since: u32,
}

impl RingState {
    pub(crate) fn new(of: Ring) -> Self {
        Self { of, live: true, warm: None, since: 0 }
    }
}

impl Interference {
    /// Whether the hulls of a pair keep away through a step. Where they do not, the pair is followed turn by
    /// turn from now on, and the hulls are tried again after some looks.
    pub(crate) fn ring_keeps(&mut self, i: usize, step: &JointStep) -> bool {
        let p = &mut self.pairs[i];
        let Some(ring) = &mut p.ring else { return false };
        let joint = ring.of.joint;
        if !ring.live {
            ring.since += 1;
            if ring.since < LOOKS_BETWEEN || p.state != PairState::Clear || p.fresh {
                return false;
            }
            ring.since = 0;
        } else if p.state != PairState::Clear {
            self.turn_by_turn(i);
            return false;
        }
        // Skins alone do not reveal a body wholly inside of another; nor do those of hulls show the
        // bodies in them.
        if self.pairs[i].fresh {
            if self.inside_at(i, step, 0.0).is_some() {
                self.turn_by_turn(i);
                return false;
            }
            self.pairs[i].fresh = false;
        }
        let p = &self.pairs[i];
        let mut weights = p.own_weights;
        weights[joint] = 0.0;
        let need = self.threshold(p) + step.slack + dot(&weights, &step.motion);
        let proved = self.ring_distance(i, &step.from, need + p.reach);
        let p = &mut self.pairs[i];
        if proved > need {
            if let Some(ring) = &mut p.ring {
                ring.live = true;
            }
            p.weights = weights;
            self.store_distance(i, proved, step, 0.0);
            self.prove(i, proved - dot(&weights, &step.motion) - step.slack);
            self.effort.misses += 1;
            return true;
        }
        self.turn_by_turn(i);
        false
    }

    fn turn_by_turn(&mut self, i: usize) {
        let p = &mut self.pairs[i];
        let Some(ring) = p.ring.as_mut().filter(|r| r.live) else { return };
        (ring.live, ring.since) = (false, 0);
        (p.weights, p.kept) = (p.own_weights, ProvedDistance::NONE);
    }

    /// Distance of the hulls from the other body at some joints, that of the turning joint aside, as far as
    /// below a limit, mm.
    fn ring_distance(&mut self, i: usize, q: &JointValues, limit: f64) -> f64 {
        let p = &mut self.pairs[i];
        let (first, second) = (&self.parts[p.a], &self.parts[p.b]);
        let Some(ring) = &mut p.ring else { return 0.0 };
        let pair = if ring.of.side == 0 { [&*ring.of.part, second] } else { [first, &*ring.of.part] };
        let b_from_a = pair[1].pose(&self.machine, q).inverse() * pair[0].pose(&self.machine, q);
        match gap(&pair[0].shape, &pair[1].shape, &b_from_a, [limit; 2], &mut ring.warm) {
            Separation::Beyond(proved) | Separation::Between([proved, _], ..) => proved.min(MOST_PROVED_MM),
            Separation::At(d, ..) if d.is_finite() => d,
            Separation::At(..) | Separation::Meeting(_) => 0.0,
        }
    }
}

/// The joint whose turns a part may be taken at all at once.
pub(crate) fn turning_joint(machine: &Machine, part: &CollisionPart) -> Option<usize> {
    let PartShape::Mesh(_) = &*part.shape else { return None };
    let joint = *chain_to(machine, part.attached).last()?;
    let j = &machine.joints[joint];
    let wide = j.endless || j.travel.is_none_or(|[low, high]| high - low >= WIDE_RAD);
    (j.is_rotary() && j.turn_shift.is_none() && wide).then_some(joint)
}

/// A part as the body that it reaches at all turns of a joint that carries it; none for one without extent.
pub(crate) fn ring_of(machine: &Machine, part: &CollisionPart, joint: usize) -> Option<CollisionPart> {
    let PartShape::Mesh(mesh) = &*part.shape else { return None };
    let j = &machine.joints[joint];
    let zero_from_ring = along_z(&j.point, &j.direction);
    let ring_from_local = zero_from_ring.inverse() * part.zero_from_local;
    let corners = |t: &[Point; 3]| {
        t.map(|p| {
            let p = ring_from_local.point(&p);
            [p.x.hypot(p.y), p.z]
        })
    };
    let hulls = hulls(mesh.boxes.triangles().iter().map(corners).collect());
    let bodies: Option<Vec<Revolved>> = hulls.iter().map(|h| profile(h).map(|p| Revolved::new(&p))).collect();
    Some(CollisionPart {
        name: part.name.clone(),
        kind: part.kind,
        attached: Attachment::Joint(joint),
        zero_from_local: zero_from_ring,
        shape: Arc::new(PartShape::Convex(bodies?)),
        excluded: part.excluded,
        bears: part.bears,
    })
}

/// A frame with its origin at a point and its z axis along a direction.
fn along_z(origin: &Point, z: &Vector) -> Pose {
    let helper = if z.x.abs() < 0.9 { Vector::x() } else { Vector::y() };
    let x = (helper - z * z.dot(&helper)).normalize();
    Pose { rotation: Matrix3::from_columns(&[x, z.cross(&x), *z]), translation: origin.coords }
}

/// Some triangles that stay together: the hull of their corners.
struct Unit {
    points: Vec<[f64; 2]>,
    low: f64,
    high: f64,
}

/// Hulls of triangles, each within one of them.
fn hulls(mut triangles: Vec<[[f64; 2]; 3]>) -> Vec<Vec<[f64; 2]>> {
    let low = |t: &[[f64; 2]; 3]| t.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let high = |t: &[[f64; 2]; 3]| t.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    triangles.sort_by(|a, b| low(a).total_cmp(&low(b)).then(high(a).total_cmp(&high(b))));
    // A fine mesh is taken in pieces, so that its hulls cost no more than those of a coarse one.
    let together = triangles.len().div_ceil(MOST_UNITS).max(1);
    let unit = |some: &[[[f64; 2]; 3]]| {
        let points = hull(some.as_flattened());
        let (low, high) = (points[0][1], points[points.len() - 1][1]);
        Unit { points, low, high }
    };
    let units: Vec<Unit> = triangles.chunks(together).map(unit).collect();
    cut(&units, MOST_HULLS)
}

fn hull_of(units: &[Unit]) -> Vec<[f64; 2]> {
    let points: Vec<[f64; 2]> = units.iter().flat_map(|u| &u.points).copied().collect();
    hull(&points)
}

/// Hulls of units in the order of their lower ends, cut between them where it pays.
fn cut(units: &[Unit], most: usize) -> Vec<Vec<[f64; 2]>> {
    let whole = hull_of(units);
    if most < 2 || units.len() < 2 {
        return vec![whole];
    }
    let mut until = f64::NEG_INFINITY;
    let mut gaps: Vec<usize> = Vec::new();
    for (k, pair) in units.windows(2).enumerate() {
        until = until.max(pair[0].high);
        if until <= pair[1].low + SAME_MM {
            gaps.push(k + 1);
        }
    }
    let every = gaps.len().div_ceil(MOST_CUTS).max(1);
    let both = |k: usize| volume(&hull_of(&units[..k])) + volume(&hull_of(&units[k..]));
    let best = gaps.into_iter().step_by(every).map(|k| (both(k), k)).min_by(|a, b| a.0.total_cmp(&b.0));
    match best.filter(|(left, _)| *left < (1.0 - SAVED) * volume(&whole)) {
        None => vec![whole],
        Some((_, k)) => {
            let mut all = cut(&units[..k], most / 2);
            all.extend(cut(&units[k..], most - most / 2));
            all
        }
    }
}

/// Convex hull of points (r, z) and their feet on the axis: from the lowest place of the axis outward and up
/// to the highest (Andrew 1979).
fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let [low, high] = points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p[1]), h.max(p[1])]);
    let mut all: Vec<[f64; 2]> = points.iter().copied().chain([[0.0, low]]).collect();
    all.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
    all.dedup_by(|a, b| (a[0] - b[0]).abs() <= SAME_MM && (a[1] - b[1]).abs() <= SAME_MM);
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for p in all.into_iter().chain([[0.0, high]]) {
        while let [.., a, b] = chain[..] {
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
            // b is not outside of the line from a to p.
            if u[0] * v[1] - u[1] * v[0] <= SAME_MM * v[0].hypot(v[1]) {
                chain.pop();
            } else {
                break;
            }
        }
        chain.push(p);
    }
    chain
}

/// Volume of the body of revolution below a chain of points, over pi, mm3.
fn volume(hull: &[[f64; 2]]) -> f64 {
    let cone = |w: &[[f64; 2]]| {
        let ([a, z], [b, y]) = (w[0], w[1]);
        (y - z) * (a * a + a * b + b * b) / 3.0
    };
    hull.windows(2).map(cone).sum()
}

fn profile(hull: &[[f64; 2]]) -> Option<Profile> {
    let line = |w: &[[f64; 2]]| Segment::Line { from: w[0], to: w[1] };
    Profile::new(hull.windows(2).map(line).collect()).ok()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proveout_geom::{TriMesh, revolved_mesh};

    use super::*;

    fn rings(mesh: &TriMesh, axis: &Pose) -> Vec<Vec<[f64; 2]>> {
        let of = |t: usize| {
            mesh.corners(t).map(|p| {
                let p = axis.point(&p);
                [p.x.hypot(p.y), p.z]
            })
        };
        hulls((0..mesh.triangles.len()).map(of).collect())
    }

    /// A disk with a hub below and a post above, about its own axis: three hulls, with the volume of a body
    /// of revolution through the corners of the mesh.
    #[test]
    fn a_body_of_revolution_is_its_own_hull() {
        let outline = [
            [0.0, -60.0],
            [15.0, -60.0],
            [15.0, 0.0],
            [100.0, 0.0],
            [100.0, 20.0],
            [8.0, 20.0],
            [8.0, 90.0],
            [0.0, 90.0],
        ];
        let found = rings(&revolved_mesh(&outline, 72), &Pose::identity());
        // A mesh of revolution may reach outside of its outline, so that it contains it.
        let radius = |at: f64, r: f64| {
            let of = found.iter().filter(|h| h[0][1] <= at && at <= h[h.len() - 1][1]);
            let most = of.flatten().map(|p| p[0]).fold(0.0, f64::max);
            assert!(most >= r - 1e-9 && most <= r / (PI / 72.0).cos() + 1e-9, "{at}: {most}");
        };
        assert_eq!(found.len(), 3, "{found:?}");
        radius(-30.0, 15.0);
        radius(10.0, 100.0);
        radius(50.0, 8.0);
        for hull in &found {
            assert!(profile(hull).is_some(), "{hull:?}");
        }
    }

    /// Random triangles about an askew axis: at any turn each of their points lies in one of the hulls.
    #[test]
    fn every_turn_lies_in_the_hulls() {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = |low: f64, high: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut parted = 0;
        for case in 0..60 {
            let n = 1 + case % 12;
            let spread = if case % 2 == 0 { 200.0 } else { 20.0 };
            let mut positions = Vec::new();
            for _ in 0..n {
                let z = random(-spread, spread);
                positions.extend(
                    (0..3).map(|_| Point::new(random(-40.0, 40.0), random(-40.0, 40.0), z + random(-9.0, 9.0))),
                );
            }
            let triangles = (0..n).map(|k| [3 * k as u32, 3 * k as u32 + 1, 3 * k as u32 + 2]).collect();
            let mesh = TriMesh { positions, triangles };
            let axis =
                Pose::from_rpy(Vector::new(random(-9.0, 9.0), 3.0, 1.0), random(-1.0, 1.0), random(-1.0, 1.0), 0.4);
            let found = rings(&mesh, &axis);
            assert!((1..=MOST_HULLS).contains(&found.len()));
            parted += usize::from(found.len() > 1);
            let bodies: Vec<Revolved> = found.iter().map(|h| Revolved::new(&profile(h).expect("a profile"))).collect();
            for _ in 0..200 {
                let t = (random(0.0, n as f64 - 1e-9)) as usize;
                let [a, b, c] = mesh.corners(t);
                let (u, v) = (random(0.0, 1.0), random(0.0, 1.0));
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let turn = Pose::from_axis_angle(&Vector::z(), random(-PI, PI));
                let p = turn.point(&axis.point(&(a + (b - a) * u + (c - a) * v)));
                let depth = bodies.iter().map(|b| b.signed_distance(&p)).fold(f64::INFINITY, f64::min);
                assert!(depth <= 1e-7, "case {case}: {depth} mm outside");
            }
        }
        assert!(parted > 10, "{parted}");
    }
}
