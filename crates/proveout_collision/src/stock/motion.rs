//! The bodies through one motion after the other: how their distance from the stock is followed, and what is
//! noted.

use proveout_geom::{Point, Pose};
use proveout_machine::{JointValues, MAX_JOINTS};
use proveout_stock::TriDexel;

use super::distance::{NearRay, Rays, material_inside, nearest, penetration};
use super::{JointMotion, StockBreach, StockCheck};
use crate::distance::{Separation, gap};
use crate::pair_advance::{MOST_PROVED_MM, PairState};
use crate::parts::{CollisionPart, motion_weights};
use crate::proved_distance::{ProvedDistance, Turns, dot};
use crate::report::Severity;
use crate::shape::{MeshShape, PartShape};
use crate::triangle_tree::TriangleTree;

/// Slack for the distance of the box of the raw stock, which is iterated, mm.
const SLACK_MM: f64 = 2e-4;
/// Distance from a threshold that counts as on it, mm: ends the advancement.
const TOLERANCE_MM: f64 = 5e-3;
/// Motion of a body in contact with the stock between two measurements of its penetration, mm.
const CONTACT_REFRESH_MM: f64 = 0.5;
/// Range of the first query of a body beyond what is needed, mm; doubled where nothing is found, up to the
/// last. Short: a search among the rays that ends nearby is cheap, and one that finds the very nearest of far
/// ones is not.
const FIRST_REACH_MM: f64 = 20.0;
const LAST_REACH_MM: f64 = 80.0;
/// Where the box of the raw stock is farther than the wanted clearance and this, mm, the rays are not asked:
/// it is almost as near.
const BOX_ENOUGH_MM: f64 = 10.0;
/// Queries of the stock at its actual turn before it is taken at all its turns again.
const LOOKS_BETWEEN: u32 = 64;
/// A jump between motions up to this length counts as rounding, mm.
const JOIN_MM: f64 = 1e-3;

/// What is known of a body by now.
#[derive(Clone, Copy, Debug)]
struct BodyProgress {
    /// Most by which body and stock move against each other for a unit of each joint; where the stock is
    /// taken at all turns, they do not count.
    weights: [f64; MAX_JOINTS],
    /// The same of the stock at its actual turn.
    own_weights: [f64; MAX_JOINTS],
    kept: ProvedDistance,
    /// The stock is taken at all turns of its joint now, and looks since that was too near.
    all_turns: bool,
    since: u32,
    state: PairState,
    reach: f64,
    /// Nothing is known yet: whether material lies inside is to be asked.
    fresh: bool,
    near: Option<usize>,
    contact: Option<usize>,
    /// Least distance that was proved so far, mm, but for what is kept now.
    proved: f64,
    /// Least distance of material on a ray that was seen, mm.
    seen: f64,
}

/// A body that is followed.
#[derive(Clone, Debug)]
pub(super) struct FollowedBody {
    pub(super) part: CollisionPart,
    /// The layer of material on the table's face counts for nothing against what of it is no higher than the
    /// face.
    pub(super) flush: bool,
    /// The part of such a body above the face: all material counts against it.
    pub(super) raised: Option<TriangleTree>,
    known: BodyProgress,
}

impl FollowedBody {
    /// None for a body that is no mesh: parts of the tool are swept through the stock instead.
    pub(super) fn new(part: CollisionPart) -> Option<Self> {
        let PartShape::Mesh(_) = &*part.shape else { return None };
        let known = BodyProgress {
            weights: [0.0; MAX_JOINTS],
            own_weights: [0.0; MAX_JOINTS],
            kept: ProvedDistance::NONE,
            all_turns: false,
            since: LOOKS_BETWEEN,
            state: PairState::Clear,
            reach: FIRST_REACH_MM,
            fresh: true,
            near: None,
            contact: None,
            proved: f64::INFINITY,
            seen: f64::INFINITY,
        };
        Some(Self { part, flush: false, raised: None, known })
    }

    pub(super) fn mesh(&self) -> Option<&MeshShape> {
        match &*self.part.shape {
            PartShape::Mesh(mesh) => Some(mesh),
            PartShape::Convex(_) => None,
        }
    }

    /// Least distance so far: proved, and seen of material on a ray, mm. Since all bodies were last looked
    /// at, at the place `reference`, none has come nearer than there by more than `roamed`.
    pub(super) fn least(&self, turns: &Turns, reference: &JointValues, roamed: f64) -> [f64; 2] {
        let k = &self.known;
        let now = if k.fresh || !k.kept.is_known() {
            f64::INFINITY
        } else {
            k.kept.along(turns, &k.weights, [reference; 2]) - roamed
        };
        [k.proved.min(now).max(0.0), k.seen]
    }
}

/// Distance of a body from the stock.
#[derive(Clone, Copy, Debug)]
pub(super) struct StockGap {
    /// What is proved, mm.
    lower: f64,
    near: NearRay,
    /// Of material on a ray; otherwise of the box of the raw stock.
    on_ray: bool,
}

/// A motion under examination.
struct StockStep<'a> {
    stock: &'a TriDexel,
    motion: &'a JointMotion,
    /// Absolute motion of each joint.
    way: [f64; MAX_JOINTS],
    /// The stock is the one at the begin of this motion.
    exact: bool,
}

impl StockStep<'_> {
    fn joints(&self, t: f64) -> JointValues {
        self.motion.joints[0].interpolated(self.motion.joints[1], t)
    }

    fn time(&self, t: f64) -> f64 {
        self.motion.time[0] + (self.motion.time[1] - self.motion.time[0]) * t
    }
}

impl StockCheck {
    /// Follows motions in their order; `stock` is the stock at the begin of the first, or an earlier one.
    /// Gives how many are done: all, or those before one in which a body would come too near to material that
    /// may be cut by then. The caller cuts what is done and calls again with the rest. The first motion is
    /// always done.
    pub fn follow(&mut self, stock: &TriDexel, motions: &[JointMotion]) -> usize {
        self.tree.refresh(stock);
        let late = motions.iter().enumerate().position(|(k, motion)| !self.one(stock, motion, k == 0));
        late.unwrap_or(motions.len())
    }

    fn one(&mut self, stock: &TriDexel, motion: &JointMotion, exact: bool) -> bool {
        let [from, to] = motion.joints;
        if !(from.is_finite() && to.is_finite() && motion.off.is_finite() && motion.slack.is_finite()) {
            self.fail_all(motion.time[0]);
            self.motions += 1;
            return true;
        }
        self.join(&from);
        let low = from.zip_map(to, f64::min).zip_map(motion.off, |q, e| q - e);
        let high = from.zip_map(to, f64::max).zip_map(motion.off, |q, e| q + e);
        let grown = self.envelope.include(&self.machine, &low);
        if self.envelope.include(&self.machine, &high) || grown {
            self.recompute_weights();
        }
        let way = std::array::from_fn(|j| (to[j] - from[j]).abs());
        let away = self.turns.farthest_offsets(&self.reference, [&from, &to]);
        let used = dot(&self.largest_weights, &away) + motion.slack + dot(&self.largest_weights, &motion.off.0);
        if used < self.budget {
            self.roamed = self.roamed.max(used);
        } else if !self.examine(&StockStep { stock, motion, way, exact }) {
            return false;
        }
        (self.last, self.last_time) = (Some(to), motion.time[1]);
        self.motions += 1;
        true
    }

    /// All bodies through one motion; false, and nothing noted, where the stock is too old for it.
    fn examine(&mut self, step: &StockStep<'_>) -> bool {
        self.settle();
        let mut before: Vec<(usize, BodyProgress)> = Vec::new();
        let [from, to] = &step.motion.joints;
        for i in 0..self.bodies.len() {
            let known = self.bodies[i].known;
            let left = known.kept.along(&self.turns, &known.weights, [from, to]) - self.slack(i, step);
            before.push((i, known));
            if left > self.threshold(i) {
                let known = &mut self.bodies[i].known;
                known.proved = known.proved.min(left);
                continue;
            }
            if !self.follow_body(i, step) {
                for (k, known) in before {
                    self.bodies[k].known = known;
                }
                return false;
            }
        }
        self.reference = *to;
        let left = |i: usize| {
            let known = &self.bodies[i].known;
            known.kept.along(&self.turns, &known.weights, [to; 2]) - self.threshold(i)
        };
        self.budget = (0..self.bodies.len()).map(left).fold(f64::INFINITY, f64::min);
        true
    }

    /// Notes what was proved of each body since all were last looked at.
    fn settle(&mut self) {
        for body in &mut self.bodies {
            body.known.proved = body.least(&self.turns, &self.reference, self.roamed)[0];
        }
        self.roamed = 0.0;
    }

    /// By how much a body may be nearer than the straight motion of the joints says, mm: with weights w (how
    /// far it moves against the stock for a unit of each joint) joints that are off by e bring it nearer by
    /// at most `sum w_j e_j`.
    fn slack(&self, i: usize, step: &StockStep<'_>) -> f64 {
        step.motion.slack + dot(&self.bodies[i].known.weights, &step.motion.off.0)
    }

    /// Distance above which nothing needs to be known of a body, mm.
    fn threshold(&self, i: usize) -> f64 {
        match self.bodies[i].known.state {
            PairState::Clear => self.clearance + SLACK_MM,
            PairState::Near => SLACK_MM,
            PairState::Contact => 0.0,
        }
    }

    /// Conservative advancement (after Mirtich 1996) of one body; false where it would come too near to a
    /// stock that is too old.
    fn follow_body(&mut self, i: usize, step: &StockStep<'_>) -> bool {
        if self.bodies[i].known.fresh {
            if let Some(point) = self.inside(i, step, 0.0) {
                if !step.exact {
                    return false;
                }
                let near = NearRay { distance: 0.0, on_body: point, on_ray: point };
                self.open(i, Severity::Collision, step, 0.0, StockGap { lower: 0.0, near, on_ray: true }, true);
            }
            self.bodies[i].known.fresh = false;
        }
        if self.all_turns_keep(i, step) {
            return true;
        }
        let mu = dot(&self.bodies[i].known.weights, &step.way);
        let slack = self.slack(i, step);
        let mut t = 0.0;
        while self.bodies[i].known.state != PairState::Contact {
            let level = if self.bodies[i].known.state == PairState::Clear { self.clearance } else { 0.0 };
            let floor = level + SLACK_MM + slack;
            let limit = floor + (mu * (1.0 - t)).max(TOLERANCE_MM) + self.bodies[i].known.reach;
            let Some(found) = self.gap(i, step.stock, &step.joints(t), limit) else {
                self.store_distance(i, limit, step, t);
                self.prove(i, limit - mu * (1.0 - t) - slack);
                let reach = &mut self.bodies[i].known.reach;
                *reach = (2.0 * *reach).min(LAST_REACH_MM);
                self.leave_near(i, limit, step, t);
                return true;
            };
            self.bodies[i].known.reach = FIRST_REACH_MM;
            // The box of the raw stock is not actual material.
            if step.exact && found.on_ray {
                let known = &mut self.bodies[i].known;
                known.seen = known.seen.min(found.near.distance);
            }
            if found.lower > floor + TOLERANCE_MM {
                self.store_distance(i, found.lower, step, t);
                self.leave_near(i, found.lower, step, t);
                let advance = (found.lower - floor) / mu;
                if mu <= 0.0 || t + advance >= 1.0 {
                    self.prove(i, found.lower - mu * (1.0 - t) - slack);
                    return true;
                }
                self.prove(i, floor - slack);
                t += advance;
                continue;
            }
            if !step.exact {
                return false;
            }
            let touching = found.lower <= SLACK_MM + slack + TOLERANCE_MM;
            let severity = if touching { Severity::Collision } else { Severity::NearMiss };
            self.open(i, severity, step, t, found, false);
        }
        self.follow_contact(i, step);
        true
    }

    /// A body in the stock at the end of a motion: how deep, or apart again.
    fn follow_contact(&mut self, i: usize, step: &StockStep<'_>) {
        let touching = SLACK_MM + self.slack(i, step) + TOLERANCE_MM;
        let limit = touching + self.clearance + self.bodies[i].known.reach;
        let q = step.joints(1.0);
        let distance = self.gap(i, step.stock, &q, limit).map_or(limit, |g| g.lower);
        let within = distance > 0.0 && self.inside(i, step, 1.0).is_some();
        if within || distance <= touching {
            // Material of an older stock may be gone, and would make it too deep.
            let deep = if step.exact { self.penetration(i, step.stock, &q) } else { 0.0 };
            if let Some(b) = self.bodies[i].known.contact.and_then(|k| self.breaches.get_mut(k)) {
                b.inside |= within;
                if deep > b.penetration_estimate.unwrap_or(0.0) {
                    b.penetration_estimate = Some(deep);
                }
            }
            self.store_distance(i, CONTACT_REFRESH_MM, step, 1.0);
            return;
        }
        let known = &mut self.bodies[i].known;
        if let Some(b) = known.contact.take().and_then(|k| self.breaches.get_mut(k)) {
            b.end_time = Some(step.time(1.0));
        }
        known.state = if known.near.is_some() { PairState::Near } else { PairState::Clear };
        self.store_distance(i, distance, step, 1.0);
        self.leave_near(i, distance, step, 1.0);
    }

    fn leave_near(&mut self, i: usize, distance: f64, step: &StockStep<'_>, t: f64) {
        let apart = distance > self.clearance + SLACK_MM + self.slack(i, step) + 2.0 * TOLERANCE_MM;
        let known = &mut self.bodies[i].known;
        let Some(b) = known.near.and_then(|k| self.breaches.get_mut(k)) else { return };
        if apart {
            b.end_time = Some(step.time(t));
            (known.near, known.state) = (None, PairState::Clear);
        } else if step.exact {
            b.least_distance = b.least_distance.min(distance);
        }
    }

    /// Whether the stock at all its turns keeps away from a body through a motion. Where it does not, it is
    /// followed turn by turn from now on, and all turns are tried again after some looks.
    fn all_turns_keep(&mut self, i: usize, step: &StockStep<'_>) -> bool {
        let Some((joint, ring)) = self.ring.clone() else { return false };
        let known = &mut self.bodies[i].known;
        if !known.all_turns {
            known.since += 1;
            if known.since < LOOKS_BETWEEN || known.state != PairState::Clear {
                return false;
            }
            known.since = 0;
        }
        let mut weights = known.own_weights;
        weights[joint] = 0.0;
        let mu = dot(&weights, &step.way);
        let slack = step.motion.slack + dot(&weights, &step.motion.off.0);
        let need = self.threshold(i) + slack + mu;
        let q = &step.motion.joints[0];
        let body = &self.bodies[i];
        let ring_from_body = ring.pose(&self.machine, q).inverse() * body.part.pose(&self.machine, q);
        let proved = if body.known.state != PairState::Clear || body.flush {
            0.0
        } else {
            match gap(&body.part.shape, &ring.shape, &ring_from_body, [need + LAST_REACH_MM; 2], &mut None) {
                Separation::Beyond(proved) | Separation::Between([proved, _], ..) => proved.min(MOST_PROVED_MM),
                Separation::At(d, ..) if d.is_finite() => d,
                Separation::At(..) | Separation::Meeting(_) => 0.0,
            }
        };
        self.queries += 1;
        let known = &mut self.bodies[i].known;
        if proved > need {
            (known.all_turns, known.weights) = (true, weights);
            known.proved = known.proved.min(proved - mu - slack);
            self.store_distance(i, proved, step, 0.0);
            return true;
        }
        if known.all_turns {
            (known.all_turns, known.weights, known.kept) = (false, known.own_weights, ProvedDistance::NONE);
            self.largest_weights[joint] = self.largest_weights[joint].max(known.weights[joint]);
        }
        false
    }

    fn store_distance(&mut self, i: usize, distance: f64, step: &StockStep<'_>, t: f64) {
        self.bodies[i].known.kept = ProvedDistance { distance, at: step.joints(t) };
    }

    /// Notes a distance below which a body has not come.
    fn prove(&mut self, i: usize, distance: f64) {
        let known = &mut self.bodies[i].known;
        known.proved = known.proved.min(distance.max(0.0));
    }

    fn open(&mut self, i: usize, severity: Severity, step: &StockStep<'_>, t: f64, found: StockGap, inside: bool) {
        let breach = StockBreach {
            body: self.bodies[i].part.name.clone(),
            kind: self.bodies[i].part.kind,
            severity,
            time: step.time(t),
            joints: step.joints(t),
            distance: found.lower,
            ray_distance: found.near.distance,
            least_distance: found.lower,
            penetration_estimate: None,
            inside,
            point_in_work: nalgebra::center(&found.near.on_body, &found.near.on_ray),
            end_time: None,
        };
        self.push(i, breach);
    }

    fn push(&mut self, i: usize, breach: StockBreach) {
        let (index, near) = (self.breaches.len(), breach.severity == Severity::NearMiss);
        let known = &mut self.bodies[i].known;
        if let Some(b) = known.near.and_then(|k| self.breaches.get_mut(k)) {
            b.least_distance = b.least_distance.min(breach.distance);
        }
        known.proved = known.proved.min(breach.distance);
        if near {
            (known.near, known.state) = (Some(index), PairState::Near);
        } else {
            (known.proved, known.seen) = (0.0, 0.0);
            (known.contact, known.state) = (Some(index), PairState::Contact);
        }
        self.breaches.push(breach);
    }

    /// Joints that are not numbers: nothing is proved clear.
    fn fail_all(&mut self, time: f64) {
        for i in 0..self.bodies.len() {
            let body = &self.bodies[i];
            if body.known.state != PairState::Contact {
                let breach = StockBreach {
                    body: body.part.name.clone(),
                    kind: body.part.kind,
                    severity: Severity::QueryFailed,
                    time,
                    joints: self.last.unwrap_or_default(),
                    distance: 0.0,
                    ray_distance: 0.0,
                    least_distance: 0.0,
                    penetration_estimate: None,
                    inside: false,
                    point_in_work: Point::origin(),
                    end_time: None,
                };
                self.push(i, breach);
            }
            (self.bodies[i].known.kept, self.bodies[i].known.fresh) = (ProvedDistance::NONE, true);
        }
        self.budget = f64::NEG_INFINITY;
        self.last = None;
    }

    /// Accounts for a gap between motions: rounding is motion, a jump forgets what was proved.
    fn join(&mut self, from: &JointValues) {
        let Some(last) = self.last.replace(*from) else { return };
        if last == *from {
            return;
        }
        let way = last.zip_map(*from, |a, b| (b - a).abs());
        if dot(&self.largest_weights, &way.0) > JOIN_MM {
            self.settle();
            for body in &mut self.bodies {
                (body.known.kept, body.known.fresh) = (ProvedDistance::NONE, true);
            }
            self.budget = f64::NEG_INFINITY;
        }
    }

    pub(super) fn recompute_weights(&mut self) {
        self.settle();
        self.largest_weights = [0.0; MAX_JOINTS];
        for body in &mut self.bodies {
            let weights = motion_weights(&self.machine, &body.part, &self.raw, &self.envelope);
            let known = &mut body.known;
            // What was proved is carried along with the bounds that held until now.
            if let Some(last) = self.last.filter(|_| known.kept.is_known()) {
                known.kept =
                    ProvedDistance { distance: known.kept.along(&self.turns, &known.weights, [&last; 2]), at: last };
            }
            (known.own_weights, known.weights) = (weights, weights);
            if let Some((joint, _)) = self.ring.as_ref().filter(|_| known.all_turns) {
                known.weights[*joint] = 0.0;
            }
            for (largest, w) in self.largest_weights.iter_mut().zip(known.weights) {
                *largest = largest.max(w);
            }
        }
        self.budget = f64::NEG_INFINITY;
    }

    fn work_from_body(&self, i: usize, q: &JointValues) -> Pose {
        let machine_from_work = self.machine.machine_from_table(q) * self.table_from_work;
        machine_from_work.inverse() * self.bodies[i].part.pose(&self.machine, q)
    }

    fn rays<'a>(&'a self, i: usize, stock: &'a TriDexel) -> Rays<'a> {
        Rays { stock, tree: &self.tree, counts: self.bodies[i].flush.then_some(self.above_layer) }
    }

    /// Distance of a body from the stock at some joints, where it may be below `limit` (mm).
    pub(super) fn gap(&mut self, i: usize, stock: &TriDexel, q: &JointValues, limit: f64) -> Option<StockGap> {
        self.queries += 1;
        let pose = self.work_from_body(i, q);
        let body = &self.bodies[i];
        // The box of a layer cut off is not known to be one; the rays do alone.
        let from_box = if body.flush { 0.0 } else { self.box_gap(i, &pose, limit)? };
        if from_box > self.clearance + BOX_ENOUGH_MM {
            let middle = pose.point(&body.part.shape.ball().0);
            let near = NearRay { distance: from_box, on_body: middle, on_ray: middle };
            return (from_box < limit).then_some(StockGap { lower: from_box, near, on_ray: false });
        }
        let limit_of_rays = limit + self.unseen;
        let near = nearest(&body.mesh()?.boxes, &pose, &self.rays(i, stock), limit_of_rays);
        let near = match &body.raised {
            None => near,
            Some(skin) => {
                let within = near.map_or(limit_of_rays, |n| n.distance);
                nearest(skin, &pose, &Rays { counts: None, ..self.rays(i, stock) }, within).or(near)
            }
        }?;
        let lower = (near.distance - self.unseen).max(from_box).max(0.0);
        (lower < limit).then_some(StockGap { lower, near, on_ray: true })
    }

    /// Distance of a body from the box of the raw stock as a solid, where it is below `limit`.
    fn box_gap(&self, i: usize, work_from_body: &Pose, limit: f64) -> Option<f64> {
        let body = &self.bodies[i];
        let mesh = body.mesh()?;
        if mesh.shells.iter().any(|p| self.raw_box.contains(&work_from_body.point(p))) {
            return Some(0.0);
        }
        match gap(&body.part.shape, &self.raw.shape, work_from_body, [limit; 2], &mut None) {
            Separation::Beyond(_) | Separation::Between(..) => None,
            Separation::At(d, ..) if d.is_finite() => Some((d - SLACK_MM).max(0.0)),
            Separation::At(..) | Separation::Meeting(_) => Some(0.0),
        }
    }

    fn inside(&self, i: usize, step: &StockStep<'_>, t: f64) -> Option<Point> {
        let mesh = self.bodies[i].mesh()?;
        let body_from_work = self.work_from_body(i, &step.joints(t)).inverse();
        material_inside(mesh, &body_from_work, &self.rays(i, step.stock))
    }

    fn penetration(&self, i: usize, stock: &TriDexel, q: &JointValues) -> f64 {
        let Some(mesh) = self.bodies[i].mesh() else { return 0.0 };
        penetration(mesh, &self.work_from_body(i, q), &self.rays(i, stock))
    }
}
