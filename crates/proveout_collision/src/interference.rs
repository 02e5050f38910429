//! The check of a motion.

use std::sync::Arc;

use proveout_geom::{Point, Pose};
use proveout_machine::{JointValues, MAX_JOINTS, Machine};
use proveout_tool::Tool;

use crate::distance::{Gap, gap, inside, penetration};
use crate::parts::{Envelope, Fixture, Part, fixture_part, machine_parts, motion_weights, relation, tool_parts};
use crate::report::{Breach, Clearance, CollisionError, Nearest, PairInfo, Severity};

/// Slack for the over-estimate of iterated distances near contact, mm (1e-4 was measured for curved bodies).
const SLACK_MM: f64 = 2e-4;
/// Distance from a threshold that counts as on it, mm: ends the advancement, and hides in no machine's accuracy.
const TOLERANCE_MM: f64 = 5e-3;
/// Motion of a colliding pair between two looks at its penetration, mm.
const CONTACT_REFRESH_MM: f64 = 0.5;
/// A pair is measured again when it may be nearer than this part of the smallest distance measured so far,
const WATCH: f64 = 0.75;
/// or of this distance, mm, as long as nothing is nearer: what is further away is nobody's concern.
const FAR_MM: f64 = 50.0;
/// Range of the first query of a pair beyond what is needed, mm; doubled when nothing is found.
const FIRST_REACH_MM: f64 = 100.0;
/// Longest range of a query beyond what is needed, mm.
const LAST_REACH_MM: f64 = 3200.0;
/// A jump between pieces up to this motion counts as rounding, mm.
const JOIN_MM: f64 = 1e-3;
/// Largest turn of a rotary joint in one step of the check, radian (10 degrees).
const STEP_RAD: f64 = std::f64::consts::PI / 18.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Clear,
    Near,
    Contact,
}

/// State of one checked pair.
#[derive(Clone, Debug)]
struct Pair {
    a: usize,
    b: usize,
    info: usize,
    weights: [f64; MAX_JOINTS],
    /// Proved distance, mm, when the path of the joints was `at`.
    kept: f64,
    /// Summed motion of each joint when `kept` was proved.
    at: [f64; MAX_JOINTS],
    state: State,
    reach: f64,
    /// Nothing is known yet: the inside test is due.
    fresh: bool,
    near: Option<usize>,
    contact: Option<usize>,
}

/// Interference of the parts of a machine, the tool and the fixtures while the joints move.
///
/// See the crate's text for the method. The check is sequential: pieces must come in the order of the motion.
#[derive(Clone, Debug)]
pub struct Interference {
    machine: Machine,
    parts: Vec<Part>,
    fixed_parts: usize,
    allowed: Vec<(String, String)>,
    clearance: f64,
    infos: Vec<PairInfo>,
    fixed_infos: usize,
    pairs: Vec<Pair>,
    envelope: Envelope,
    /// Summed absolute motion of each joint.
    path: [f64; MAX_JOINTS],
    last: Option<JointValues>,
    last_time: f64,
    largest_weights: [f64; MAX_JOINTS],
    budget: f64,
    spent: f64,
    breaches: Vec<Breach>,
    nearest: Option<Nearest>,
    lower_bound: f64,
    queries: u64,
    pieces: u64,
}

/// A straight motion of the joints under examination.
struct Step {
    from: JointValues,
    to: JointValues,
    time: [f64; 2],
    slack: f64,
    /// Absolute motion of each joint.
    motion: [f64; MAX_JOINTS],
}

impl Step {
    fn joints(&self, t: f64) -> JointValues {
        self.from.interpolated(self.to, t)
    }

    fn time(&self, t: f64) -> f64 {
        self.time[0] + (self.time[1] - self.time[0]) * t
    }
}

fn dot(a: &[f64; MAX_JOINTS], b: &[f64; MAX_JOINTS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

impl Interference {
    /// Takes the bodies of a machine and the fixtures, without a tool. Below `clearance_mm` two parts give a near miss.
    ///
    /// # Errors
    /// A mesh that does not bound a solid, or a clearance that is no length.
    pub fn new(machine: &Machine, fixtures: &[Fixture], clearance_mm: f64) -> Result<Self, CollisionError> {
        if !(0.0..f64::INFINITY).contains(&clearance_mm) {
            return Err(CollisionError::Clearance { value: clearance_mm });
        }
        let mut parts = machine_parts(machine)?;
        for fixture in fixtures {
            parts.push(fixture_part(machine, fixture)?);
        }
        let mut without_meshes = machine.clone();
        without_meshes.bodies.clear();
        let mut all = Self {
            envelope: Envelope::new(machine),
            machine: without_meshes,
            fixed_parts: parts.len(),
            parts,
            allowed: Vec::new(),
            clearance: clearance_mm,
            infos: Vec::new(),
            fixed_infos: 0,
            pairs: Vec::new(),
            path: [0.0; MAX_JOINTS],
            last: None,
            last_time: 0.0,
            largest_weights: [0.0; MAX_JOINTS],
            budget: f64::NEG_INFINITY,
            spent: 0.0,
            breaches: Vec::new(),
            nearest: None,
            lower_bound: f64::INFINITY,
            queries: 0,
            pieces: 0,
        };
        all.pair_fixed_parts();
        Ok(all)
    }

    /// The same, with two parts (by name) that may touch; call it before the first tool and piece.
    #[must_use]
    pub fn allow(mut self, one: &str, other: &str) -> Self {
        self.allowed.push((one.into(), other.into()));
        self.pair_fixed_parts();
        self
    }

    fn pair_fixed_parts(&mut self) {
        self.parts.truncate(self.fixed_parts);
        self.infos.clear();
        self.pairs.clear();
        for b in 1..self.fixed_parts {
            for a in 0..b {
                self.add_pair(a, b);
            }
        }
        self.fixed_infos = self.infos.len();
        self.recompute_weights();
    }

    /// Changes the tool in the spindle; none empties it. Open breaches of the old tool end.
    pub fn set_tool(&mut self, tool: Option<&Tool>) {
        let fixed = self.fixed_parts;
        self.lower_bound = self.clearance().lower_bound;
        for p in self.pairs.iter().filter(|p| p.a >= fixed || p.b >= fixed) {
            for k in [p.near, p.contact].into_iter().flatten() {
                if let Some(b) = self.breaches.get_mut(k) {
                    b.end_time = Some(self.last_time);
                }
            }
        }
        self.pairs.retain(|p| p.a < fixed && p.b < fixed);
        self.parts.truncate(fixed);
        self.parts.extend(tool.map(|t| tool_parts(&self.machine, t)).unwrap_or_default());
        for a in fixed..self.parts.len() {
            for b in 0..fixed {
                self.add_pair(a, b);
            }
        }
        self.recompute_weights();
    }

    fn add_pair(&mut self, a: usize, b: usize) {
        let (x, y) = (&self.parts[a], &self.parts[b]);
        let Some(unchecked) = relation(&self.machine, x, y, &self.allowed) else { return };
        let info = PairInfo { bodies: [x.name.clone(), y.name.clone()], kinds: [x.kind, y.kind], unchecked };
        // A tool that comes back has its pairs in the list already.
        let index = self.infos.iter().position(|i| *i == info).unwrap_or_else(|| {
            self.infos.push(info);
            self.infos.len() - 1
        });
        if unchecked.is_none() {
            self.pairs.push(Pair {
                a,
                b,
                info: index,
                weights: [0.0; MAX_JOINTS],
                kept: f64::NEG_INFINITY,
                at: self.path,
                state: State::Clear,
                reach: FIRST_REACH_MM,
                fresh: true,
                near: None,
                contact: None,
            });
        }
    }

    fn recompute_weights(&mut self) {
        self.largest_weights = [0.0; MAX_JOINTS];
        for i in 0..self.pairs.len() {
            // What was proved is carried along with the bounds that held until now.
            let kept = lower(&self.pairs[i], &self.path);
            let weights = {
                let p = &self.pairs[i];
                motion_weights(&self.machine, &self.parts[p.a], &self.parts[p.b], &self.envelope)
            };
            let p = &mut self.pairs[i];
            (p.kept, p.at, p.weights) = (kept, self.path, weights);
            for (largest, w) in self.largest_weights.iter_mut().zip(weights) {
                *largest = largest.max(w);
            }
        }
        self.budget = f64::NEG_INFINITY;
        self.spent = 0.0;
    }

    /// Checks one straight motion of the joints, from `time[0]` to `time[1]` (s). The true motion of any point may leave
    /// the straight one by `slack` (mm). Gives the breaches that began in it, as a range of [`Self::breaches`].
    pub fn check_piece(
        &mut self,
        from: &JointValues,
        to: &JointValues,
        time: [f64; 2],
        slack: f64,
    ) -> std::ops::Range<usize> {
        let before = self.breaches.len();
        self.pieces += 1;
        if !(from.is_finite() && to.is_finite() && slack.is_finite()) {
            self.fail_all(time[0]);
            return before..self.breaches.len();
        }
        self.join(from);
        let low = self.envelope.include(&self.machine, from);
        if self.envelope.include(&self.machine, to) || low {
            self.recompute_weights();
        }
        let mut motion = [0.0; MAX_JOINTS];
        for (m, (a, b)) in motion.iter_mut().zip(from.0.iter().zip(to.0)) {
            *m = (b - a).abs();
        }
        let used = dot(&self.largest_weights, &motion);
        if self.spent + used + slack < self.budget {
            self.spent += used;
            self.walk(&motion, 1.0);
        } else {
            self.examine(from, to, time, slack, &motion);
        }
        self.last = Some(*to);
        self.last_time = time[1];
        before..self.breaches.len()
    }

    /// Accounts for a gap between pieces: rounding is motion, a jump forgets what was proved.
    fn join(&mut self, from: &JointValues) {
        let Some(last) = self.last else { return };
        if last == *from {
            return;
        }
        let gap = last.zip_map(*from, |a, b| (b - a).abs());
        let motion = dot(&self.largest_weights, &gap.0);
        if motion > JOIN_MM {
            self.lower_bound = self.clearance().lower_bound;
            for p in &mut self.pairs {
                (p.kept, p.fresh) = (f64::NEG_INFINITY, true);
            }
            self.budget = f64::NEG_INFINITY;
        } else {
            self.walk(&gap.0, 1.0);
            self.spent += motion;
        }
    }

    fn walk(&mut self, motion: &[f64; MAX_JOINTS], part: f64) {
        for (s, m) in self.path.iter_mut().zip(motion) {
            *s += m * part;
        }
    }

    fn examine(
        &mut self,
        from: &JointValues,
        to: &JointValues,
        time: [f64; 2],
        slack: f64,
        motion: &[f64; MAX_JOINTS],
    ) {
        let turn = self.machine.joints.iter().zip(motion).filter(|(j, _)| j.is_rotary()).map(|(_, m)| *m);
        let steps = (turn.fold(0.0, f64::max) / STEP_RAD).ceil().clamp(1.0, 1e6) as usize;
        for k in 0..steps {
            let at = |i: usize| i as f64 / steps as f64;
            let step = Step {
                from: from.interpolated(*to, at(k)),
                to: from.interpolated(*to, at(k + 1)),
                time: [time[0] + (time[1] - time[0]) * at(k), time[0] + (time[1] - time[0]) * at(k + 1)],
                slack,
                motion: motion.map(|m| m / steps as f64),
            };
            for i in 0..self.pairs.len() {
                let left = lower(&self.pairs[i], &self.path) - dot(&self.pairs[i].weights, &step.motion) - slack;
                if left <= self.threshold(&self.pairs[i]) {
                    self.examine_pair(i, &step);
                } else {
                    self.prove(left);
                }
            }
            self.walk(&step.motion, 1.0);
        }
        self.spent = 0.0;
        let remaining = |p: &Pair| lower(p, &self.path) - self.threshold(p);
        self.budget = self.pairs.iter().map(remaining).fold(f64::INFINITY, f64::min);
    }

    /// Distance above which nothing needs to be known of a pair.
    fn threshold(&self, p: &Pair) -> f64 {
        let level = match p.state {
            State::Clear => self.clearance,
            State::Near => 0.0,
            State::Contact => return 0.0,
        };
        (level + SLACK_MM).max(self.watched())
    }

    /// Distance below which a pair may hold the smallest distance of all.
    fn watched(&self) -> f64 {
        WATCH * self.nearest.as_ref().map_or(FAR_MM, |n| n.distance.min(FAR_MM))
    }

    /// Conservative advancement (after Mirtich 1996) of one pair through one step.
    fn examine_pair(&mut self, i: usize, step: &Step) {
        let mu = dot(&self.pairs[i].weights, &step.motion);
        if self.pairs[i].fresh {
            self.pairs[i].fresh = false;
            if let Some(point) = self.inside_at(i, step, 0.0) {
                self.open(i, Severity::Collision, step, 0.0, 0.0, &point, true);
            }
        }
        let mut t = 0.0;
        while self.pairs[i].state != State::Contact {
            let level = if self.pairs[i].state == State::Clear { self.clearance } else { 0.0 };
            let floor = level + SLACK_MM + step.slack;
            let watched = self.watched() + step.slack;
            let need = floor.max(watched) + (mu * (1.0 - t)).max(TOLERANCE_MM);
            let limit = need + self.pairs[i].reach;
            match self.measure(i, step, t, limit) {
                Gap::Beyond => {
                    self.keep(i, limit, step, t);
                    self.pairs[i].reach = (2.0 * self.pairs[i].reach).min(LAST_REACH_MM);
                    self.leave_near(i, limit, step, t);
                    self.prove(limit - mu * (1.0 - t) - step.slack);
                    return;
                }
                Gap::Meeting(point) => self.open(i, Severity::Collision, step, t, 0.0, &point, false),
                Gap::At(d, p, q) => {
                    let middle = nalgebra::center(&p, &q);
                    if !d.is_finite() {
                        self.open(i, Severity::QueryFailed, step, t, 0.0, &middle, false);
                    } else if d <= floor + TOLERANCE_MM {
                        let touching = d <= SLACK_MM + step.slack + TOLERANCE_MM;
                        let severity = if touching { Severity::Collision } else { Severity::NearMiss };
                        self.open(i, severity, step, t, d, &middle, false);
                    } else {
                        self.keep(i, d, step, t);
                        self.leave_near(i, d, step, t);
                        // Not down to the threshold at once: the proved bound stays near the smallest distance measured.
                        let watched = self.watched() + step.slack;
                        let safe = floor.max(watched.min(floor + 0.9 * (d - floor)));
                        let advance = (d - safe) / mu;
                        if mu <= 0.0 || t + advance >= 1.0 {
                            self.prove(d - mu * (1.0 - t) - step.slack);
                            return;
                        }
                        self.prove(safe - step.slack);
                        t += advance;
                    }
                }
            }
        }
        self.follow_contact(i, step);
    }

    /// Notes a distance below which no pair has come.
    fn prove(&mut self, distance: f64) {
        self.lower_bound = self.lower_bound.min(distance.max(0.0));
    }

    /// A colliding pair at the end of a step: how deep, or apart again.
    fn follow_contact(&mut self, i: usize, step: &Step) {
        self.lower_bound = 0.0;
        let limit = SLACK_MM + step.slack + TOLERANCE_MM + self.clearance + self.pairs[i].reach;
        let measured = self.measure(i, step, 1.0, limit);
        let distance = match measured {
            Gap::Meeting(_) => 0.0,
            Gap::At(d, ..) => d,
            Gap::Beyond => limit,
        };
        let within = match measured {
            Gap::Meeting(_) => None,
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
            self.keep(i, CONTACT_REFRESH_MM, step, 1.0);
            return;
        }
        if let Some(b) = self.pairs[i].contact.take().and_then(|k| self.breaches.get_mut(k)) {
            b.end_time = Some(step.time(1.0));
        }
        self.pairs[i].state = if self.pairs[i].near.is_some() { State::Near } else { State::Clear };
        self.keep(i, distance, step, 1.0);
        self.leave_near(i, distance, step, 1.0);
    }

    fn leave_near(&mut self, i: usize, distance: f64, step: &Step, t: f64) {
        let end = step.time(t);
        let p = &mut self.pairs[i];
        let Some(k) = p.near else { return };
        if let Some(b) = self.breaches.get_mut(k) {
            b.least_distance = b.least_distance.min(distance);
            if distance > self.clearance + SLACK_MM + step.slack + 2.0 * TOLERANCE_MM {
                b.end_time = Some(end);
                p.near = None;
                p.state = State::Clear;
            }
        }
    }

    fn keep(&mut self, i: usize, distance: f64, step: &Step, t: f64) {
        let mut at = self.path;
        for (s, m) in at.iter_mut().zip(step.motion) {
            *s += m * t;
        }
        let p = &mut self.pairs[i];
        (p.kept, p.at) = (distance, at);
    }

    fn b_from_a(&self, i: usize, q: &JointValues) -> (Pose, Pose) {
        let p = &self.pairs[i];
        let machine_from_b = self.parts[p.b].pose(&self.machine, q);
        (machine_from_b.inverse() * self.parts[p.a].pose(&self.machine, q), machine_from_b)
    }

    fn measure(&mut self, i: usize, step: &Step, t: f64, limit: f64) -> Gap {
        let q = step.joints(t);
        let (b_from_a, machine_from_b) = self.b_from_a(i, &q);
        self.queries += 1;
        let found = gap(&self.parts[self.pairs[i].a].shape, &self.parts[self.pairs[i].b].shape, &b_from_a, limit);
        let (distance, point) = match found {
            Gap::Beyond => return found,
            Gap::Meeting(p) => (0.0, p),
            Gap::At(d, p, q) => (d, nalgebra::center(&p, &q)),
        };
        if self.nearest.as_ref().is_none_or(|n| distance < n.distance) {
            let info = &self.infos[self.pairs[i].info];
            self.nearest = Some(Nearest {
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

    fn inside_at(&self, i: usize, step: &Step, t: f64) -> Option<Point> {
        let (b_from_a, _) = self.b_from_a(i, &step.joints(t));
        inside(&self.parts[self.pairs[i].a].shape, &self.parts[self.pairs[i].b].shape, &b_from_a)
    }

    fn penetration_at(&self, i: usize, step: &Step, t: f64) -> f64 {
        let (b_from_a, _) = self.b_from_a(i, &step.joints(t));
        penetration(&self.parts[self.pairs[i].a].shape, &self.parts[self.pairs[i].b].shape, &b_from_a)
    }

    #[expect(clippy::too_many_arguments, reason = "the facts of one breach, used in this file only")]
    fn open(&mut self, i: usize, severity: Severity, step: &Step, t: f64, distance: f64, point: &Point, inside: bool) {
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
            self.nearest = Some(Nearest { distance: 0.0, pair, bodies, time, point_in_table });
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the facts of one breach, used in this file only")]
    fn push(
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
            (p.near, p.state) = (Some(index), State::Near);
        } else {
            (p.contact, p.state) = (Some(index), State::Contact);
        }
    }

    /// Joints that are not numbers: no pair is proved clear.
    fn fail_all(&mut self, time: f64) {
        let joints = self.last.unwrap_or_default();
        for i in 0..self.pairs.len() {
            if self.pairs[i].state != State::Contact {
                self.push(i, Severity::QueryFailed, time, joints, 0.0, Point::origin(), false);
            }
            (self.pairs[i].kept, self.pairs[i].fresh) = (f64::NEG_INFINITY, true);
        }
        self.budget = f64::NEG_INFINITY;
        self.last = None;
        self.lower_bound = 0.0;
    }

    /// Every breach so far, in the order of the pieces in which they began; within one piece in the order of the pairs.
    pub fn breaches(&self) -> &[Breach] {
        &self.breaches
    }

    /// Smallest distance so far, measured and proved.
    pub fn clearance(&self) -> Clearance {
        let open = self.pairs.iter().filter(|p| !p.fresh).map(|p| lower(p, &self.path).max(0.0));
        Clearance { measured: self.nearest.clone(), lower_bound: open.fold(self.lower_bound, f64::min) }
    }

    /// Every pair met so far, those that are not checked with the reason. Pairs of tools that were changed stay listed.
    pub fn pairs(&self) -> &[PairInfo] {
        &self.infos
    }

    /// Number of distance queries so far.
    pub fn queries(&self) -> u64 {
        self.queries
    }

    /// Number of pieces so far.
    pub fn pieces(&self) -> u64 {
        self.pieces
    }

    /// Names of the parts now in place: machine bodies, fixtures, tool.
    pub fn part_names(&self) -> impl Iterator<Item = &Arc<str>> {
        self.parts.iter().map(|p| &p.name)
    }
}

/// Distance of a pair that is proved for now.
fn lower(p: &Pair, path: &[f64; MAX_JOINTS]) -> f64 {
    let moved: f64 = (0..MAX_JOINTS).map(|j| p.weights[j] * (path[j] - p.at[j])).sum();
    p.kept - moved
}
