//! The check of a motion.

use std::collections::BTreeMap;
use std::sync::Arc;

use proveout_geom::Point;
use proveout_machine::{JointValues, MAX_JOINTS, Machine, PairCare};
use proveout_tool::Tool;

use crate::box_tree::BoxTree;
use crate::neighbors::{EMPTY, Neighbors, SkinRests, at_rest, is_left, is_round, rests};
use crate::pair_advance::{CheckedPair, JointStep, PairState};
use crate::parts::{
    CollisionPart, Envelope, Fixture, chain_to, fixture_part, machine_parts, motion_weights, relation, rule_of,
    tool_parts,
};
use crate::proved_distance::{PairGroup, ProvedDistance, Turns, dot};
use crate::report::{
    Breach, Clearance, CollisionError, Effort, LeastMeasured, MeshFaults, PairInfo, Severity, Unchecked,
};
use crate::ring::{Ring, RingState, ring_of, turning_joint};
use crate::shape::PartShape;
use crate::{JointMotion, least_clearance::Proof};

/// Range of the first query of a pair beyond what is needed, mm; doubled when nothing is found.
const FIRST_REACH_MM: f64 = 100.0;
/// A jump between pieces up to this motion counts as rounding, mm.
const JOIN_MM: f64 = 1e-3;
/// Pairs in the group of the nearest ones.
const TIGHT: usize = 12;
/// Largest turn of a rotary joint in one step of the check, radian (10 degrees).
const STEP_RAD: f64 = std::f64::consts::PI / 18.0;
/// Steps of a turn at most: the work for a senseless motion stays bounded.
const MOST_STEPS: f64 = 1e6;

/// Where the joints are at the quarters of a piece, with the bounds for the ways between these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinerPiece {
    /// At one, two and three quarters, mm and radian.
    pub joints: [JointValues; 3],
    /// Bound of the deviation of each joint from the straight ways between them.
    pub off: JointValues,
    /// As for the whole piece: how far any point may be off in addition, mm.
    pub slack: f64,
}

/// Interference of the parts of a machine, the tool and the fixtures while the joints move.
///
/// See the crate's text for the method. The check is sequential: pieces must come in the order of the motion.
#[derive(Clone, Debug)]
pub struct Interference {
    pub(crate) machine: Machine,
    pub(crate) parts: Vec<CollisionPart>,
    pub(crate) fixed_parts: usize,
    pub(crate) allowed: Vec<(String, String)>,
    pub(crate) clearance: f64,
    pub(crate) infos: Vec<PairInfo>,
    pub(crate) fixed_infos: usize,
    pub(crate) pairs: Vec<CheckedPair>,
    pub(crate) envelope: Envelope,
    pub(crate) turns: Turns,
    pub(crate) last: Option<JointValues>,
    pub(crate) last_time: f64,
    pub(crate) largest_weights: [f64; MAX_JOINTS],
    /// The pairs that are nearest to what needs to be known of them, and the others.
    pub(crate) groups: [PairGroup; 2],
    /// What is proved at the end of the last piece, mm.
    pub(crate) now: f64,
    /// Parts at all turns of the joint that carries them, by their places among the parts.
    pub(crate) rings: BTreeMap<usize, Option<(usize, Arc<CollisionPart>)>>,
    /// What is left of neighbors without what bears, by their places among the parts.
    pub(crate) rests: BTreeMap<(usize, usize), Arc<SkinRests>>,
    /// Ranges of the joints in which all neighbors keep clear of each other, and the slack for which that
    /// holds, mm.
    pub(crate) proved_ranges: [[f64; 2]; MAX_JOINTS],
    pub(crate) proved_slack: f64,
    pub(crate) breaches: Vec<Breach>,
    pub(crate) nearest: Option<LeastMeasured>,
    pub(crate) lower_bound: f64,
    pub(crate) effort: Effort,
    /// The motion, where the least clearances are asked for.
    pub(crate) proof: Option<Proof>,
}

impl Interference {
    /// Takes the bodies of a machine and the fixtures, without a tool. Below `clearance_mm` two parts give a
    /// near miss.
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
            turns: Turns::of(machine),
            last: None,
            last_time: 0.0,
            largest_weights: [0.0; MAX_JOINTS],
            groups: [PairGroup::NONE; 2],
            now: f64::INFINITY,
            rings: BTreeMap::new(),
            rests: BTreeMap::new(),
            proved_ranges: [EMPTY; MAX_JOINTS],
            proved_slack: 0.0,
            breaches: Vec::new(),
            nearest: None,
            lower_bound: f64::INFINITY,
            effort: Effort::default(),
            proof: None,
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
        self.prove_kept();
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
        let rule = rule_of(&self.machine, x, y);
        let near_miss = match rule.map(|r| r.care) {
            Some(PairCare::NearMiss(distance)) => distance,
            Some(PairCare::Unchecked) | None => self.clearance,
        };
        let ruled = rule.map(|r| r.reason.as_str().into());
        let neighbors = if unchecked == Some(Unchecked::Neighbors) { self.neighbors(a, b, near_miss) } else { None };
        let (x, y) = (&self.parts[a], &self.parts[b]);
        let bearing = neighbors.as_ref().map_or(0.0, |n| n.rests.left_out[0].max(n.rests.left_out[1]));
        let unchecked = unchecked.filter(|_| neighbors.is_none()).map(|why| match self.rests.get(&(a, b)) {
            Some(rests) if why == Unchecked::Neighbors && self.bears_all_over(rests, [x, y]) => Unchecked::Guide,
            _ => why,
        });
        let bodies = [x.name.clone(), y.name.clone()];
        let info = PairInfo { bodies, kinds: [x.kind, y.kind], unchecked, near_miss, ruled, bearing };
        // A tool that comes back has its pairs in the list already.
        let index = self.infos.iter().position(|i| *i == info).unwrap_or_else(|| {
            self.infos.push(info);
            self.infos.len() - 1
        });
        if unchecked.is_none() {
            let ring = if neighbors.is_none() { self.ring(a, b) } else { None };
            self.pairs.push(CheckedPair {
                a,
                b,
                info: index,
                weights: [0.0; MAX_JOINTS],
                own_weights: [0.0; MAX_JOINTS],
                kept: ProvedDistance::NONE,
                state: PairState::Clear,
                reach: FIRST_REACH_MM,
                warm: None,
                // Skins of neighbors that never met outside of their bearing have nothing inside of the other
                // there.
                fresh: neighbors.is_none(),
                ring,
                tight: false,
                slides: false,
                least_found: f64::INFINITY,
                neighbors,
                near: None,
                contact: None,
                clearance: near_miss,
            });
        }
    }

    /// One of two parts at all turns of the joint that carries it and not the other; the one that turns
    /// farther.
    fn ring(&mut self, a: usize, b: usize) -> Option<RingState> {
        let of = |part: usize, other: usize| {
            let joint = turning_joint(&self.machine, &self.parts[part])?;
            let free = !chain_to(&self.machine, self.parts[other].attached).contains(&joint);
            let travel = self.machine.joints[joint].travel.map_or(f64::INFINITY, |[low, high]| high - low);
            free.then_some((joint, travel))
        };
        let (side, part, joint) = match (of(a, b), of(b, a)) {
            (Some((x, far)), Some((_, other))) if far >= other => (0, a, x),
            (_, Some((y, _))) => (1, b, y),
            (Some((x, _)), None) => (0, a, x),
            (None, None) => return None,
        };
        if !self.rings.contains_key(&part) {
            let made = ring_of(&self.machine, &self.parts[part], joint).map(|p| (joint, Arc::new(p)));
            self.rings.insert(part, made);
        }
        let (joint, part) = self.rings.get(&part)?.clone()?;
        Some(RingState::new(Ring { side, joint, part }))
    }

    /// Two machine bodies with one joint between them, without what bears; none where nothing is left.
    fn neighbors(&mut self, a: usize, b: usize, clearance: f64) -> Option<Neighbors> {
        let (x, y) = (&self.parts[a], &self.parts[b]);
        let (up, down) = (chain_to(&self.machine, x.attached), chain_to(&self.machine, y.attached));
        let joint = *if up.len() > down.len() { up.last()? } else { down.last()? };
        let (PartShape::Mesh(m), PartShape::Mesh(n)) = (&*x.shape, &*y.shape) else { return None };
        let rests = match self.rests.get(&(a, b)) {
            Some(known) => known.clone(),
            None => {
                let q = at_rest(&self.machine, joint);
                let b_from_a = y.pose(&self.machine, &q).inverse() * x.pose(&self.machine, &q);
                let made = Arc::new(rests(&self.machine, joint, [m, n], &b_from_a, clearance));
                self.rests.insert((a, b), made.clone());
                made
            }
        };
        is_left(&rests).then(|| Neighbors::new(&self.machine, joint, rests))
    }

    /// Whether each body of which nothing is left bears by its role, or is round about the joint between
    /// them: then it is at every turn where it is at rest.
    fn bears_all_over(&self, rests: &SkinRests, bodies: [&CollisionPart; 2]) -> bool {
        let [up, down] = bodies.map(|p| chain_to(&self.machine, p.attached));
        let Some(joint) = (if up.len() > down.len() { up } else { down }).last().map(|&j| &self.machine.joints[j])
        else {
            return false;
        };
        let round = |body: &CollisionPart| match &*body.shape {
            PartShape::Mesh(mesh) => joint.is_rotary() && joint.turn_shift.is_none() && is_round(mesh, joint),
            PartShape::Convex(_) => false,
        };
        rests.skins.iter().zip(bodies).all(|(skin, body)| skin.root().is_some() || body.bears || round(body))
    }

    fn recompute_weights(&mut self) {
        self.largest_weights = [0.0; MAX_JOINTS];
        for i in 0..self.pairs.len() {
            let weights = {
                let p = &self.pairs[i];
                let all = motion_weights(&self.machine, &self.parts[p.a], &self.parts[p.b], &self.envelope);
                p.neighbors.as_ref().map_or(all, |n| std::array::from_fn(|j| if j == n.joint { n.weight } else { 0.0 }))
            };
            let p = &mut self.pairs[i];
            // What was proved is carried along with the bounds that held until now.
            if let Some(last) = self.last.filter(|_| p.kept.is_known()) {
                p.kept = ProvedDistance { distance: p.kept.along(&self.turns, &p.weights, [&last; 2]), at: last };
            }
            (p.own_weights, p.weights) = (weights, weights);
            if let Some(ring) = p.ring.as_ref().filter(|r| r.live) {
                p.weights[ring.of.joint] = 0.0;
            }
            if p.neighbors.is_some() {
                continue;
            }
            for (largest, w) in self.largest_weights.iter_mut().zip(p.weights) {
                *largest = largest.max(w);
            }
        }
        self.settle();
        self.groups = [PairGroup::NONE; 2];
    }

    /// Notes what was proved of all pairs together since they were last looked at one by one.
    pub(crate) fn settle(&mut self) {
        for group in &mut self.groups {
            self.lower_bound = self.lower_bound.min((group.closest - group.roamed).max(0.0));
            (group.closest, group.roamed) = (f64::INFINITY, 0.0);
        }
    }

    /// Checks one straight motion of the joints, from `time[0]` to `time[1]` (s). The true motion of any
    /// point may leave the straight one by `slack` (mm). Gives the breaches that began in it, as a range of
    /// [`Self::breaches`].
    pub fn check_piece(
        &mut self,
        from: &JointValues,
        to: &JointValues,
        time: [f64; 2],
        slack: f64,
    ) -> std::ops::Range<usize> {
        self.check_bent_piece([from, to], time, slack, &JointValues::ZERO)
    }

    /// The same where the joints may leave the straight motion, each by no more than `off` (mm, radian): at
    /// every moment all of them are so near to one place of it. They may turn back within the piece; then the
    /// ends alone would say nothing of how far they went.
    ///
    /// With weights w of a pair (how far one moves against the other for a unit of each joint), its distance
    /// at the true joints is at least that at the place on the straight motion, less `sum w_j off_j`: that is
    /// the slack of this pair.
    pub fn check_bent_piece(
        &mut self,
        [from, to]: [&JointValues; 2],
        time: [f64; 2],
        slack: f64,
        off: &JointValues,
    ) -> std::ops::Range<usize> {
        self.check_curved_piece([from, to], time, slack, off, None)
    }

    /// The same where more is known of the motion than its ends. It is needed where the bound for
    /// the whole piece does not show that two parts keep apart: a joint that bends by micrometers
    /// would otherwise be reported as a contact of parts that are micrometers apart.
    pub fn check_curved_piece(
        &mut self,
        [from, to]: [&JointValues; 2],
        time: [f64; 2],
        slack: f64,
        off: &JointValues,
        finer: Option<&FinerPiece>,
    ) -> std::ops::Range<usize> {
        let before = self.breaches.len();
        self.effort.pieces += 1;
        if !(from.is_finite() && to.is_finite() && slack.is_finite() && off.is_finite()) {
            self.fail_all(time[0]);
            return before..self.breaches.len();
        }
        self.join(from);
        let low = from.zip_map(*to, f64::min).zip_map(*off, |q, e| q - e);
        let high = from.zip_map(*to, f64::max).zip_map(*off, |q, e| q + e);
        let grown = self.envelope.include(&self.machine, &low);
        if self.envelope.include(&self.machine, &high) || grown {
            self.recompute_weights();
        }
        let needs = self.groups.each_ref().map(|g| g.budget_needed(&self.turns, [from, to], off, slack));
        let fits = [0, 1].map(|k| needs[k] < self.groups[k].budget);
        let others = fits[1] && self.neighbors_keep_clear(&low, &high, slack);
        for k in (0..2).filter(|&k| fits[k] && others) {
            self.groups[k].roamed = self.groups[k].roamed.max(needs[k]);
        }
        if fits[0] && others {
            self.effort.pieces_by_allowance += 1;
            self.now = (self.groups[0].closest - needs[0]).min(self.groups[1].closest - needs[1]);
        } else {
            self.examine([from, to], time, (slack, off, finer), !others);
            let far = if others { self.groups[1].closest - needs[1] } else { self.groups[1].closest };
            self.now = self.groups[0].closest.min(far);
        }
        self.last = Some(*to);
        self.last_time = time[1];
        self.keep_piece(JointMotion { joints: [*from, *to], time, off: *off, slack });
        before..self.breaches.len()
    }

    /// Whether every joint stays where its neighbors are known to keep clear of each other.
    fn neighbors_keep_clear(&self, from: &JointValues, to: &JointValues, slack: f64) -> bool {
        let within = |(j, [low, high]): (usize, &[f64; 2])| *low <= from[j] && to[j] <= *high;
        slack <= self.proved_slack && self.proved_ranges.iter().enumerate().all(within)
    }

    /// Accounts for a gap between pieces: a jump that is more than rounding forgets what was proved.
    fn join(&mut self, from: &JointValues) {
        let Some(last) = self.last else { return };
        if last == *from {
            return;
        }
        let gap = last.zip_map(*from, |a, b| (b - a).abs());
        if dot(&self.largest_weights, &gap.0) > JOIN_MM {
            self.lower_bound = self.clearance().lower_bound;
            for p in &mut self.pairs {
                (p.kept, p.fresh) = (ProvedDistance::NONE, p.neighbors.is_none());
            }
            self.groups = [PairGroup::NONE; 2];
        }
    }

    /// Looks at pairs one by one: at all, or only at the nearest ones.
    fn examine(
        &mut self,
        [from, to]: [&JointValues; 2],
        time: [f64; 2],
        (slack, off, finer): (f64, &JointValues, Option<&FinerPiece>),
        all: bool,
    ) {
        let settled = if all { 2 } else { 1 };
        for group in &mut self.groups[..settled] {
            self.lower_bound = self.lower_bound.min((group.closest - group.roamed).max(0.0));
        }
        let motion: [f64; MAX_JOINTS] = std::array::from_fn(|j| (to[j] - from[j]).abs());
        let turn = self.machine.joints.iter().zip(&motion).filter(|(j, _)| j.is_rotary()).map(|(_, m)| *m);
        let steps = (turn.fold(0.0, f64::max) / STEP_RAD).ceil().clamp(1.0, MOST_STEPS) as usize;
        for k in 0..steps {
            let at = |i: usize| i as f64 / steps as f64;
            let step = JointStep {
                from: from.interpolated(*to, at(k)),
                to: from.interpolated(*to, at(k + 1)),
                time: [time[0] + (time[1] - time[0]) * at(k), time[0] + (time[1] - time[0]) * at(k + 1)],
                slack,
                motion: motion.map(|m| m / steps as f64),
                whole: steps == 1,
            };
            for i in 0..self.pairs.len() {
                let p = &self.pairs[i];
                if !(all || p.tight) {
                    continue;
                }
                self.effort.pair_checks += 1;
                if p.neighbors.is_some() && p.state == PairState::Clear {
                    if self.neighbors_clear(i, &step, off) {
                        self.effort.pairs_by_allowance += 1;
                    } else {
                        self.examine_pair(i, &self.widened(i, &step, off));
                    }
                    continue;
                }
                let aside = slack + dot(&p.weights, &off.0);
                let left = p.kept.along(&self.turns, &p.weights, [&step.from, &step.to]) - aside;
                if left > self.threshold(p) {
                    self.effort.pairs_by_allowance += 1;
                    self.prove(i, left);
                } else if !self.ring_keeps(i, &self.widened(i, &step, off)) {
                    self.examine_in_quarters(i, &step, off, finer);
                }
            }
        }
        self.regroup(to, all);
        if !all {
            return;
        }
        (self.proved_ranges, self.proved_slack) = ([[f64::NEG_INFINITY, f64::INFINITY]; MAX_JOINTS], f64::INFINITY);
        for p in &self.pairs {
            let Some(n) = &p.neighbors else { continue };
            let proved = if p.state == PairState::Clear { n.proved } else { EMPTY };
            let range = &mut self.proved_ranges[n.joint];
            *range = [range[0].max(proved[0]), range[1].min(proved[1])];
            self.proved_slack = self.proved_slack.min(n.slack);
        }
    }

    /// Records the distances of the pairs that were checked. After a check of all pairs, those
    /// nearest to their thresholds become a group of their own, so that the others need not be
    /// checked because of them.
    fn regroup(&mut self, at: &JointValues, all: bool) {
        let here = |p: &CheckedPair| p.kept.along(&self.turns, &p.weights, [at; 2]);
        if all {
            let mut left: Vec<(f64, usize)> = Vec::with_capacity(self.pairs.len());
            let pairs = self.pairs.iter().enumerate().filter(|(_, p)| p.neighbors.is_none());
            left.extend(pairs.map(|(i, p)| (here(p) - self.threshold(p), i)));
            let nearest = TIGHT.min(left.len());
            if nearest < left.len() {
                left.select_nth_unstable_by(nearest, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            }
            let mut tight = vec![false; self.pairs.len()];
            left[..nearest].iter().for_each(|(_, i)| tight[*i] = true);
            self.pairs.iter_mut().zip(tight).for_each(|(p, t)| p.tight = t);
        }
        let here = |p: &CheckedPair| p.kept.along(&self.turns, &p.weights, [at; 2]);
        let mut groups = [PairGroup::empty_at(*at); 2];
        for p in self.pairs.iter().filter(|p| p.neighbors.is_none() && (all || p.tight)) {
            groups[usize::from(!p.tight)].add(&p.weights, here(p), self.threshold(p));
        }
        self.groups[0] = groups[0];
        if all {
            self.groups[1] = groups[1];
        }
    }

    /// Joints that are not numbers: no pair is proved clear.
    fn fail_all(&mut self, time: f64) {
        let joints = self.last.unwrap_or_default();
        for i in 0..self.pairs.len() {
            if self.pairs[i].state != PairState::Contact {
                self.push(i, Severity::QueryFailed, time, joints, 0.0, Point::origin(), false);
            }
            (self.pairs[i].kept, self.pairs[i].fresh) = (ProvedDistance::NONE, self.pairs[i].neighbors.is_none());
        }
        self.groups = [PairGroup::NONE; 2];
        self.last = None;
        self.now = 0.0;
        self.lower_bound = 0.0;
    }

    /// Every breach so far, in the order of the pieces in which they began; within one piece in the order of
    /// the pairs.
    pub fn breaches(&self) -> &[Breach] {
        &self.breaches
    }

    /// Smallest distance so far, measured and proved. Machine bodies of neighboring joints, which are always
    /// near each other, count where they come nearer than the clearance.
    ///
    /// ```
    /// use proveout_collision::{Fixture, Interference};
    /// use proveout_geom::{Aabb, Point, box_mesh};
    /// use proveout_machine::{JointValues, Machine};
    /// use proveout_tool::{Cutter, ToolBuilder};
    ///
    /// # let mut machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// # machine.bodies.clear();
    /// let block = Aabb { min: Point::new(50.0, -20.0, 0.0), max: Point::new(60.0, 20.0, 400.0) };
    /// let wall = Fixture { name: "wall".to_owned(), mesh: box_mesh(&block), on_table: true };
    /// let mut check = Interference::new(&machine, &[wall], 1.0)?;
    /// let tool = ToolBuilder::new(1, "END_D12", Cutter::flat(12.0)?, 26.0, 120.0).build()?;
    /// check.set_tool(Some(&tool));
    /// let at = |x: f64| JointValues([x, 0.0, 300.0, 0.0, 0.0, 0.0, 0.0, 0.0]); // X Y Z B C
    /// assert!(check.check_piece(&at(0.0), &at(30.0), [0.0, 1.0], 0.0).is_empty());
    /// // 14 mm are left at the end; at least the 1 mm that was asked for is proved.
    /// assert!((1.0..=14.0 + 1e-9).contains(&check.clearance().lower_bound));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn clearance(&self) -> Clearance {
        let since = self.groups.iter().map(|g| g.closest - g.roamed).fold(self.now, f64::min);
        let now = since.max(0.0);
        Clearance { measured: self.nearest.clone(), lower_bound: self.lower_bound.min(now) }
    }

    /// Distance that is proved for all pairs at the end of the last piece, mm; infinite when there is no
    /// pair.
    pub fn proved_now(&self) -> f64 {
        self.now.max(0.0)
    }

    /// Every pair met so far, those that are not checked with the reason. Pairs of tools that were changed
    /// stay listed.
    ///
    /// ```
    /// use proveout_collision::{Fixture, Interference, Unchecked};
    /// use proveout_geom::cylinder_mesh;
    /// use proveout_machine::Machine;
    ///
    /// let mut machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// machine.bodies.clear(); // fixtures alone
    /// let pin = |name: &str, on_table: bool| {
    ///     let mesh = cylinder_mesh(5.0, 0.0, 40.0, 24); // mm
    ///     Fixture { name: name.to_owned(), mesh, on_table }
    /// };
    /// let fixtures = [pin("stop", true), pin("clamp", true), pin("probe", false)];
    /// let check = Interference::new(&machine, &fixtures, 1.0)?;
    /// // Stop with clamp, which turn as one with the table, and each of them with the probe.
    /// let unchecked: Vec<_> = check.pairs().iter().map(|pair| pair.unchecked).collect();
    /// assert_eq!(unchecked, [Some(Unchecked::Rigid), None, None]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pairs(&self) -> &[PairInfo] {
        &self.infos
    }

    /// How the checks so far were settled.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Number of distance queries so far.
    pub fn queries(&self) -> u64 {
        self.effort.misses + self.effort.distances
    }

    /// Number of pieces so far.
    pub fn pieces(&self) -> u64 {
        self.effort.pieces
    }

    /// Machine bodies and fixtures whose mesh lacks something, with what it lacks.
    pub fn mesh_faults(&self) -> impl Iterator<Item = (&Arc<str>, &MeshFaults)> {
        self.parts[..self.fixed_parts].iter().filter(|p| !p.excluded).filter_map(|p| match &*p.shape {
            PartShape::Mesh(m) if m.faults != MeshFaults::default() => Some((&p.name, &m.faults)),
            _ => None,
        })
    }

    /// Names of the parts now in place: machine bodies, fixtures, tool.
    pub fn part_names(&self) -> impl Iterator<Item = &Arc<str>> {
        self.parts.iter().map(|p| &p.name)
    }
}
