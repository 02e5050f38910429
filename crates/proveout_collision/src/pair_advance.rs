//! One pair of parts through one step: how the distance is followed, and what is noted.

use proveout_geom::{Point, Pose};
use proveout_machine::{JointValues, MAX_JOINTS};

use crate::Interference;
use crate::conservative_advancement::{AdvanceStep, next_advance};
use crate::distance::{Separation, WarmStart, gap, inside, penetration, skins};
use crate::interference::FinerPiece;
use crate::least_clearance::{BEYOND, FINE_MM, STRAIGHT_MM};
use crate::neighbors::Neighbors;
use crate::parts::chain_to;
use crate::proved_distance::{ProvedDistance, dot};
use crate::report::{Breach, LeastMeasured, Severity};
use crate::ring::RingState;
use crate::shape::PartShape;
use crate::swept::{BodyPlaces, bent, least_distance};

/// Slack for rounding, mm. Distances of tools are proved; those of two triangles may be too large by 1e-8 of
/// their edges, which is this much for edges of a meter.
const SLACK_MM: f64 = 1e-5;
/// Distance from a threshold that counts as on it, mm: ends the advancement. What passes by more than this
/// and the slack is clear.
const TOLERANCE_MM: f64 = 2e-4;
/// Motion of a colliding pair between two looks at its penetration, mm.
const CONTACT_REFRESH_MM: f64 = 0.5;
/// A pair is measured again when it may be nearer than this part of the smallest distance measured so far,
const WATCH: f64 = 0.75;
/// or than this distance, mm, as long as nothing is nearer: greater distances are of no interest.
const FAR_MM: f64 = 50.0;
/// Longest range of a query beyond what is needed, mm.
const LAST_REACH_MM: f64 = 3200.0;
/// Largest distance that is kept of a pair, mm: beyond any machine.
pub(crate) const MOST_PROVED_MM: f64 = 1e6;
/// What is left of a step is asked for at once where a part may still move by more than this, mm.
const LEAST_WAY_MM: f64 = 1e-3;
/// A pair that has come no nearer than this many times what is watched holds not the least distance of all:
/// the proof will ask little of it.
const LEAST_OF_ALL: f64 = 2.0;
/// Way ahead for which the distance of two neighbors is asked, mm.
const AHEAD_MM: f64 = 50.0;

/// Relation of a pair, or of a body and the stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PairState {
    /// Farther apart than the clearance that is wanted, or not yet known to be nearer.
    Clear,
    /// Nearer than that.
    Near,
    /// Touching or in each other.
    Contact,
}

/// What becomes of a place where two parts are too near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum NearPlace {
    /// It is a breach.
    Noted,
    /// The question was whether there is one.
    Asked,
}

/// State of one checked pair.
#[derive(Clone, Debug)]
pub(crate) struct CheckedPair {
    pub(crate) a: usize,
    pub(crate) b: usize,
    pub(crate) info: usize,
    /// Most by which they move against each other for a unit of each joint; where one is taken at all its
    /// turns, they do not count.
    pub(crate) weights: [f64; MAX_JOINTS],
    /// The same of the bodies themselves.
    pub(crate) own_weights: [f64; MAX_JOINTS],
    pub(crate) kept: ProvedDistance,
    /// One of the two at all turns of its joint.
    pub(crate) ring: Option<RingState>,
    /// In the group of the pairs nearest to what needs to be known of them.
    pub(crate) tight: bool,
    /// The distance did not reach to the end of a step; what lies between two places is asked for at once
    /// now.
    pub(crate) slides: bool,
    /// Least distance that was found of it, mm: as far as that the proof of the least clearance will ask.
    pub(crate) least_found: f64,
    pub(crate) state: PairState,
    pub(crate) reach: f64,
    /// What was nearest at the last query.
    pub(crate) warm: WarmStart,
    /// Nothing is known yet: the inside test is due.
    pub(crate) fresh: bool,
    pub(crate) near: Option<usize>,
    pub(crate) contact: Option<usize>,
    /// Two machine bodies with one joint between them.
    pub(crate) neighbors: Option<Neighbors>,
    /// Below this distance they give a near miss, mm.
    pub(crate) clearance: f64,
}

/// A straight motion of the joints under examination.
#[derive(Clone, Copy)]
pub(crate) struct JointStep {
    pub(crate) from: JointValues,
    pub(crate) to: JointValues,
    pub(crate) time: [f64; 2],
    pub(crate) slack: f64,
    /// Absolute motion of each joint.
    pub(crate) motion: [f64; MAX_JOINTS],
    /// It is all of a piece.
    pub(crate) whole: bool,
}

impl JointStep {
    pub(crate) fn joints(&self, t: f64) -> JointValues {
        self.from.interpolated(self.to, t)
    }

    pub(crate) fn time(&self, t: f64) -> f64 {
        self.time[0] + (self.time[1] - self.time[0]) * t
    }
}

impl Interference {
    /// Distance above which nothing needs to be known of a pair.
    pub(crate) fn threshold(&self, p: &CheckedPair) -> f64 {
        let level = match p.state {
            PairState::Clear => p.clearance,
            PairState::Near => 0.0,
            PairState::Contact => return 0.0,
        };
        (level + SLACK_MM).max(self.watch_distance(p))
    }

    /// Distance below which a pair may hold the smallest distance of all; neighbors are not asked for it.
    fn watch_distance(&self, p: &CheckedPair) -> f64 {
        if p.neighbors.is_some() {
            return 0.0;
        }
        WATCH * self.nearest.as_ref().map_or(FAR_MM, |n| n.distance.min(FAR_MM))
    }

    /// A step with all by which a pair may be nearer than the straight motion says.
    pub(crate) fn widened(&self, i: usize, step: &JointStep, off: &JointValues) -> JointStep {
        JointStep { slack: step.slack + dot(&self.pairs[i].weights, &off.0), ..*step }
    }

    /// Checks one pair over one step, and over its quarters where the whole step does not show that
    /// they keep apart.
    pub(crate) fn examine_in_quarters(
        &mut self,
        i: usize,
        step: &JointStep,
        off: &JointValues,
        finer: Option<&FinerPiece>,
    ) {
        let wide = self.widened(i, step, off);
        let Some(finer) = finer.filter(|_| step.whole) else { return self.examine_pair(i, &wide) };
        if self.pairs[i].state == PairState::Clear {
            let before = (self.nearest.clone(), self.lower_bound);
            if self.advance(i, &wide, NearPlace::Asked) {
                return;
            }
            // What was measured on the straight way is no place of the motion.
            (self.nearest, self.lower_bound) = before;
        }
        let [a, b, c] = finer.joints;
        let places = [step.from, a, b, c, step.to];
        for (k, ends) in places.windows(2).enumerate() {
            let part = JointStep {
                from: ends[0],
                to: ends[1],
                time: [step.time(0.25 * k as f64), step.time(0.25 * (k + 1) as f64)],
                slack: finer.slack,
                motion: std::array::from_fn(|j| (ends[1][j] - ends[0][j]).abs()),
                whole: false,
            };
            self.examine_pair(i, &self.widened(i, &part, &finer.off));
        }
    }

    /// One pair through one step; what is found is noted.
    pub(crate) fn examine_pair(&mut self, i: usize, step: &JointStep) {
        self.advance(i, step, NearPlace::Noted);
    }

    /// Conservative advancement (after Mirtich 1996) of one pair through one step. Whether the two keep apart
    /// by what is wanted; where they do not, this is noted, or left to who asked.
    fn advance(&mut self, i: usize, step: &JointStep, found: NearPlace) -> bool {
        let mu = dot(&self.pairs[i].weights, &step.motion);
        if self.pairs[i].fresh {
            self.pairs[i].fresh = false;
            if let Some(point) = self.inside_at(i, step, 0.0) {
                self.open(i, Severity::Collision, step, 0.0, 0.0, &point, true);
            }
        }
        let mut t = 0.0;
        while self.pairs[i].state != PairState::Contact {
            let level = if self.pairs[i].state == PairState::Clear { self.pairs[i].clearance } else { 0.0 };
            let floor = level + SLACK_MM + step.slack;
            let watched = self.watch_distance(&self.pairs[i]) + step.slack;
            if self.pairs[i].slides && self.pairs[i].state == PairState::Clear && mu * (1.0 - t) > LEAST_WAY_MM {
                let ends = [1.0, 0.5 * (1.0 + t)];
                match ends.into_iter().find(|&end| self.is_clear_while_sliding(i, step, [t, end], floor.max(watched))) {
                    Some(end) if end >= 1.0 => return true,
                    Some(end) => {
                        t = end;
                        continue;
                    }
                    None => self.pairs[i].slides = false,
                }
            }
            let need = floor.max(watched) + (mu * (1.0 - t)).max(TOLERANCE_MM);
            let limit = need + self.pairs[i].reach;
            match self.measure(i, step, t, [need, limit]) {
                Separation::Beyond(proved) | Separation::Between([proved, _], ..) => {
                    // A pair without triangles is infinitely far; what is kept stays a number that can be
                    // counted down.
                    let proved = proved.min(MOST_PROVED_MM);
                    self.store_distance(i, proved, step, t);
                    self.pairs[i].reach = (2.0 * self.pairs[i].reach).min(LAST_REACH_MM);
                    self.leave_near(i, proved, step, t);
                    self.prove(i, proved - mu * (1.0 - t) - step.slack);
                    return true;
                }
                Separation::Meeting(_) if found == NearPlace::Asked => return false,
                Separation::Meeting(point) => self.open(i, Severity::Collision, step, t, 0.0, &point, false),
                Separation::At(d, p, q) => {
                    let middle = nalgebra::center(&p, &q);
                    // Not down to the threshold at once: the proved bound stays near the smallest distance
                    // measured.
                    let watched = self.watch_distance(&self.pairs[i]) + step.slack;
                    let safe = floor.max(watched.min(floor + 0.9 * (d - floor)));
                    match next_advance(t, d, mu, [floor, safe], TOLERANCE_MM) {
                        _ if !d.is_finite() => self.open(i, Severity::QueryFailed, step, t, 0.0, &middle, false),
                        AdvanceStep::Reached if found == NearPlace::Asked => return false,
                        AdvanceStep::Reached => {
                            let touching = d <= SLACK_MM + step.slack + TOLERANCE_MM;
                            let severity = if touching { Severity::Collision } else { Severity::NearMiss };
                            self.open(i, severity, step, t, d, &middle, false);
                        }
                        ahead => {
                            self.pairs[i].least_found = self.pairs[i].least_found.min(d);
                            self.store_distance(i, d, step, t);
                            self.leave_near(i, d, step, t);
                            let AdvanceStep::Until(next) = ahead else {
                                self.prove(i, d - mu * (1.0 - t) - step.slack);
                                return true;
                            };
                            self.prove(i, safe - step.slack);
                            self.pairs[i].slides = true;
                            t = next;
                        }
                    }
                }
            }
        }
        self.follow_contact(i, step);
        false
    }

    /// Whether a part of the tool keeps away from a mesh on a part of a step, by the hull of both ends: for
    /// each triangle along its own normal (Tang, Kim and Manocha 2009), so that a tool that slides along a
    /// wall is asked about once, where its way would use up the distance many times.
    fn is_clear_while_sliding(&mut self, i: usize, step: &JointStep, part: [f64; 2], floor: f64) -> bool {
        let p = &self.pairs[i];
        let (a, b) = (&self.parts[p.a], &self.parts[p.b]);
        let (PartShape::Convex(_), PartShape::Mesh(_), None) = (&*a.shape, &*b.shape, &p.neighbors) else {
            return false;
        };
        let joints = &self.machine.joints;
        let turns = std::array::from_fn(|j| joints.get(j).is_some_and(proveout_machine::Joint::is_rotary));
        let carries = chain_to(&self.machine, b.attached);
        let of_b = std::array::from_fn(|j| carries.contains(&j));
        let ends = part.map(|t| step.joints(t));
        // For a whole piece the proof of the least clearance would ask the same again, up to the
        // bound found here.
        let wanted = floor + TOLERANCE_MM;
        let is_least = p.least_found <= LEAST_OF_ALL * wanted;
        let noted = is_least && step.whole && part == [0.0, 1.0] && self.proof.is_some();
        let told = if noted { wanted.max(p.least_found + FINE_MM) } else { wanted };
        let [chord, parabola] = bent(&p.weights, &turns, &of_b, &(ends[1] - ends[0]), told);
        let curved = noted && chord - parabola > STRAIGHT_MM;
        let bent = if curved { parabola } else { chord };
        let [from, to] = ends.map(|q| self.b_from_a(i, &q).0);
        let places = if curved {
            BodyPlaces::along([from, self.b_from_a(i, &ends[0].interpolated(ends[1], 0.5)).0, to])
        } else {
            BodyPlaces::between([from, to])
        };
        let limit = (told + bent) * (1.0 + BEYOND);
        let found = least_distance(&a.shape, &b.shape, &places, limit);
        self.effort.misses += 1;
        if noted && found > bent {
            self.pairs[i].least_found = self.pairs[i].least_found.min(found);
            self.note_piece(i, found.min(limit), curved);
        }
        if found < wanted + bent {
            return false;
        }
        // Both ends are in the hull.
        self.store_distance(i, found.min(MOST_PROVED_MM), step, part[1]);
        self.prove(i, found - bent - step.slack);
        true
    }

    /// Notes a distance below which no pair has come.
    pub(crate) fn prove(&mut self, i: usize, distance: f64) {
        if self.pairs[i].neighbors.is_some() {
            return;
        }
        self.lower_bound = self.lower_bound.min(distance.max(0.0));
    }

    /// Whether two neighbors keep clear of each other through a step, by what is known of their joint or can
    /// be proved now. Each distance proves a range of the joint round the place where it was measured; it is
    /// asked for some way ahead.
    pub(crate) fn neighbors_clear(&mut self, i: usize, step: &JointStep, off: &JointValues) -> bool {
        let Some(n) = self.pairs[i].neighbors.as_mut() else { return false };
        n.allow(step.slack);
        let (joint, weight, slack) = (n.joint, n.weight, n.slack);
        let threshold = self.pairs[i].clearance + SLACK_MM + slack;
        let [from, to] = [step.from[joint], step.to[joint]];
        // All the way that the joint may have been.
        let (from, to) =
            if from <= to { (from - off[joint], to + off[joint]) } else { (from + off[joint], to - off[joint]) };
        let mut at = from;
        loop {
            let Some(n) = &self.pairs[i].neighbors else { return false };
            if n.covers(from, to, slack) {
                return true;
            }
            if n.covers(from, at, slack) {
                at = if to > from { n.proved[1].min(to) } else { n.proved[0].max(to) };
            }
            let mut q = step.from;
            q[joint] = at;
            let limit = threshold + (weight * (to - at).abs()).max(AHEAD_MM);
            let here = JointStep { from: q, to: q, ..*step };
            let exact = threshold + TOLERANCE_MM;
            let distance = match self.measure(i, &here, 0.0, [exact, limit]) {
                Separation::Beyond(proved) | Separation::Between([proved, _], ..) => proved.min(MOST_PROVED_MM),
                Separation::At(d, ..) => d,
                Separation::Meeting(_) => 0.0,
            };
            let free = distance - threshold;
            if free.is_nan() || free <= TOLERANCE_MM {
                return false;
            }
            let reach = if weight > 0.0 { free / weight } else { f64::MAX };
            if let Some(n) = self.pairs[i].neighbors.as_mut() {
                n.add(at, reach);
            }
        }
    }

    /// A colliding pair at the end of a step: how deep, or apart again.
    fn follow_contact(&mut self, i: usize, step: &JointStep) {
        self.lower_bound = 0.0;
        let limit = SLACK_MM + step.slack + TOLERANCE_MM + self.pairs[i].clearance + self.pairs[i].reach;
        let measured = self.measure(i, step, 1.0, [limit, limit]);
        let distance = match measured {
            Separation::Meeting(_) => 0.0,
            Separation::At(d, ..) => d,
            Separation::Beyond(proved) | Separation::Between([proved, _], ..) => proved.min(MOST_PROVED_MM),
        };
        let within = match measured {
            Separation::Meeting(_) => None,
            _ => self.inside_at(i, step, 1.0),
        };
        let still = within.is_some() || distance <= SLACK_MM + step.slack + TOLERANCE_MM;
        if still {
            let deep = self.penetration_at(i, step, 1.0);
            if let Some(b) = self.pairs[i].contact.and_then(|k| self.breaches.get_mut(k)) {
                b.inside |= within.is_some();
                if deep > b.penetration_estimate.unwrap_or(0.0) {
                    b.penetration_estimate = Some(deep);
                }
            }
            self.store_distance(i, CONTACT_REFRESH_MM, step, 1.0);
            return;
        }
        if let Some(b) = self.pairs[i].contact.take().and_then(|k| self.breaches.get_mut(k)) {
            b.end_time = Some(step.time(1.0));
        }
        self.pairs[i].state = if self.pairs[i].near.is_some() { PairState::Near } else { PairState::Clear };
        self.store_distance(i, distance, step, 1.0);
        self.leave_near(i, distance, step, 1.0);
    }

    fn leave_near(&mut self, i: usize, distance: f64, step: &JointStep, t: f64) {
        let end = step.time(t);
        let p = &mut self.pairs[i];
        let Some(k) = p.near else { return };
        if let Some(b) = self.breaches.get_mut(k) {
            b.least_distance = b.least_distance.min(distance);
            if distance > p.clearance + SLACK_MM + step.slack + 2.0 * TOLERANCE_MM {
                b.end_time = Some(end);
                p.near = None;
                p.state = PairState::Clear;
            }
        }
    }

    pub(crate) fn store_distance(&mut self, i: usize, distance: f64, step: &JointStep, t: f64) {
        self.pairs[i].kept = ProvedDistance { distance, at: step.joints(t) };
    }

    fn b_from_a(&self, i: usize, q: &JointValues) -> (Pose, Pose) {
        let p = &self.pairs[i];
        let machine_from_b = self.parts[p.b].pose(&self.machine, q);
        (machine_from_b.inverse() * self.parts[p.a].pose(&self.machine, q), machine_from_b)
    }

    fn measure(&mut self, i: usize, step: &JointStep, t: f64, limits: [f64; 2]) -> Separation {
        let q = step.joints(t);
        let (b_from_a, machine_from_b) = self.b_from_a(i, &q);
        let pair = &mut self.pairs[i];
        let found = match &pair.neighbors {
            Some(n) => {
                let rest = skins(&n.rests.skins[0], &n.rests.skins[1], &b_from_a, limits, &mut pair.warm);
                let idle = n.rests.idle.iter().map(|[a, b]| skins(a, b, &b_from_a, limits, &mut None));
                idle.fold(rest, Separation::nearer)
            }
            None => gap(&self.parts[pair.a].shape, &self.parts[pair.b].shape, &b_from_a, limits, &mut pair.warm),
        };
        let (counts, clearance) = (pair.neighbors.is_none(), pair.clearance);
        match found {
            Separation::Beyond(_) | Separation::Between(..) => self.effort.misses += 1,
            _ => self.effort.distances += 1,
        }
        let (distance, point) = match found {
            Separation::Beyond(_) => return found,
            Separation::Meeting(p) => (0.0, p),
            Separation::At(d, p, q) | Separation::Between([_, d], p, q) => (d, nalgebra::center(&p, &q)),
        };
        let counts = counts || distance <= clearance;
        if counts && self.nearest.as_ref().is_none_or(|n| distance < n.distance) {
            let info = &self.infos[self.pairs[i].info];
            self.nearest = Some(LeastMeasured {
                distance,
                pair: self.pairs[i].info,
                bodies: info.bodies.clone(),
                time: step.time(t),
                point_in_table: self.in_table(&q, &machine_from_b.point(&point)),
            });
        }
        found
    }

    fn in_table(&self, q: &JointValues, p_in_machine: &Point) -> Point {
        self.machine.machine_from_table(q).inverse().point(p_in_machine)
    }

    pub(crate) fn inside_at(&self, i: usize, step: &JointStep, t: f64) -> Option<Point> {
        if self.pairs[i].neighbors.is_some() {
            return None;
        }
        let (b_from_a, _) = self.b_from_a(i, &step.joints(t));
        inside(&self.parts[self.pairs[i].a].shape, &self.parts[self.pairs[i].b].shape, &b_from_a)
    }

    fn penetration_at(&self, i: usize, step: &JointStep, t: f64) -> f64 {
        if self.pairs[i].neighbors.is_some() {
            return 0.0;
        }
        let (b_from_a, _) = self.b_from_a(i, &step.joints(t));
        penetration(&self.parts[self.pairs[i].a].shape, &self.parts[self.pairs[i].b].shape, &b_from_a)
    }

    #[expect(clippy::too_many_arguments, reason = "the facts of one breach, used in this file only")]
    fn open(
        &mut self,
        i: usize,
        severity: Severity,
        step: &JointStep,
        t: f64,
        distance: f64,
        point: &Point,
        inside: bool,
    ) {
        let q = step.joints(t);
        let (_, machine_from_b) = self.b_from_a(i, &q);
        let point_in_table = self.in_table(&q, &machine_from_b.point(point));
        self.push(i, severity, step.time(t), q, distance, point_in_table, inside);
        if severity != Severity::NearMiss {
            self.note_contact(i, step.time(t), point_in_table);
        }
    }

    fn note_contact(&mut self, i: usize, time: f64, point_in_table: Point) {
        self.lower_bound = 0.0;
        if self.nearest.as_ref().is_none_or(|n| n.distance > 0.0) {
            let pair = self.pairs[i].info;
            let bodies = self.infos[pair].bodies.clone();
            self.nearest = Some(LeastMeasured { distance: 0.0, pair, bodies, time, point_in_table });
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the facts of one breach, used in this file only")]
    pub(crate) fn push(
        &mut self,
        i: usize,
        severity: Severity,
        time: f64,
        joints: JointValues,
        distance: f64,
        point_in_table: Point,
        inside: bool,
    ) {
        let index = self.breaches.len();
        let pair = self.pairs[i].info;
        self.breaches.push(Breach {
            pair,
            bodies: self.infos[pair].bodies.clone(),
            kinds: self.infos[pair].kinds,
            severity,
            time,
            joints,
            distance,
            least_distance: distance,
            penetration_estimate: None,
            inside,
            point_in_table,
            end_time: None,
        });
        if let Some(b) = self.pairs[i].near.and_then(|k| self.breaches.get_mut(k)) {
            b.least_distance = b.least_distance.min(distance);
        }
        let p = &mut self.pairs[i];
        if severity == Severity::NearMiss {
            (p.near, p.state) = (Some(index), PairState::Near);
        } else {
            (p.contact, p.state) = (Some(index), PairState::Contact);
        }
    }
}
