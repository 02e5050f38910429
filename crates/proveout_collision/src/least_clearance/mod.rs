//! The least distance of every pair over a motion, and the proof of it.
//!
//! The check of a motion (text of the crate) only asks whether two parts come nearer than wanted:
//! what it proves of a pair is a bound that is good enough for that. Here the pieces are kept and
//! searched afterwards, by branch and bound over time (`search.rs`): the least distance of a pair
//! is measured at a place of the motion, and proved to 1 um plus the error of the joints. The
//! stretches that are needed for it are a certificate: whoever can measure a distance can check it.
//!
//! The cost must be small compared with the check. So every pair is first searched coarsely, with
//! rough distances and little effort. Then the pair with the smallest proved bound is refined, a
//! little at a time: it decides what can be stated of all of them, whether it is near or only hard
//! to prove. Pairs that can neither hold the least clearance of all nor come near are left as soon
//! as that is proved. Effort is counted in pairs of boxes, since one query of two meshes that turn
//! about each other may cost as much as a thousand others. Neighbors are left to the check: they
//! are near each other all the time.
//!
//! Findings of the check about whole pieces are not queried again (`piece_bounds.rs`): a tool that slides
//! along a wall is queried in every piece of its way.
//!
//! Pieces are kept up to [`MOST_PIECES`] and then looked at, so that memory is bounded for a program of any
//! length. Two bodies that are met or lie one within the other have the distance zero in that part of the
//! motion.

mod piece_bounds;
mod piece_tree;
mod search;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use proveout_geom::{Point, Pose, Vector};
use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::box_tree::Effort;
use crate::distance::{Separation, WarmStart, gap_with};
use crate::pair_advance::CheckedPair;
use crate::parts::{CollisionPart, chain_to};
use crate::proved_distance::dot;
use crate::report::Severity;
use crate::ring::Ring;
use crate::shape::PartShape;
use crate::swept::{BodyPlaces, bent, least_distance_with};
use crate::{Interference, JointMotion};
use piece_bounds::{PieceBounds, PieceRecord};
use piece_tree::{MotionStretch, PieceTree, Range};
use search::{Ask, LeastSearch, MeasuredDistance, StretchBound, Tolerance, turned};

/// Pieces that are kept at most: 7 MB.
const MOST_PIECES: usize = 1 << 15;
/// The least distance of a pair is searched to this, mm,
pub(crate) const FINE_MM: f64 = 1e-3;
/// where it is below this, mm, or may be the smallest of all;
const NEAR_MM: f64 = 20.0;
/// elsewhere first to this part of it: who keeps half a meter away does not care for micrometers.
const COARSE: f64 = 0.5;
/// Effort for the pieces that are kept at a time: of the coarse search for each pair, of the fine one for all
/// together, and once more of that for those of which not yet is proved that they keep what is wanted.
const COARSE_EFFORT: u64 = 1 << 15;
const FINE_EFFORT: u64 = 1 << 26;
/// As much of it a pair gets until the next one is chosen.
const SHARE: u64 = 1 << 13;
/// Cost of a query in addition to the boxes, and the most that one may cost.
const LOOK_EFFORT: u64 = 256;
const MOST_OF_LOOK: u64 = 1 << 14;
/// Largest distance that is asked for, mm: beyond any machine.
const ENOUGH_MM: f64 = 1e6;
/// Turning by less than this, mm, is asked of the body itself and not of its hulls at all turns.
const WORTH_MM: f64 = 0.1;
/// After so many stretches that the hulls of all turns did not prove they are asked for one in so many only.
const IN_VAIN: u32 = 16;
/// Points that leave the straight line by no more than this, mm, need no parabola: a tenth of the
/// accuracy of the least distance.
pub(crate) const STRAIGHT_MM: f64 = 1e-4;
/// Joints that differ by less are at rest, mm and radian: rounding.
const STANDS: f64 = 1e-8;
/// Distances are asked for by this part farther, so that rounding hides nothing that lies at the limit.
pub(crate) const BEYOND: f64 = 1e-12;

/// Least distance of a pair over the motion so far. The true one is at least `proved`, and at most `measured`
/// where that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct PairClearance {
    /// Index in [`Interference::pairs`].
    pub pair: usize,
    /// Proved, mm; zero where the two may have met.
    pub proved: f64,
    /// Measured at some joints of the motion, mm; none where it was not measured, being beyond what
    /// is of interest.
    pub measured: Option<f64>,
    /// When that was, s.
    pub time: Option<f64>,
    /// Machine bodies of neighboring joints, which are near each other all the time: by the check of the
    /// motion alone, without spans. Proved is the clearance that they keep, or zero where they came nearer.
    pub neighbors: bool,
}

/// A part of the motion of a pair in which it keeps apart by at least `distance - motion`.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvedSpan {
    /// Index in [`Interference::pairs`].
    pub pair: usize,
    /// Begin and end, s. The spans of a pair follow each other without a gap while it is in place. Spans that
    /// follow each other with the same time are parts of one piece of the motion: at every moment of it the
    /// joints are in one of them.
    pub time: [f64; 2],
    /// The joints are in this range in this part of the motion, mm and radian; one that may be at
    /// any turn has no ends.
    pub low: JointValues,
    /// Upper end of the range.
    pub high: JointValues,
    /// Distance that is proved, mm: measured at a place (both ends of `straight`); or with the turning joints
    /// in the middle of their ranges and the slides anywhere in theirs, those without ends at every turn; or,
    /// with `straight`, of the hulls of one body at both ends, as the other sees it.
    pub distance: f64,
    /// Most by which it is smaller anywhere in the span, mm: what turns, leaves the straight way, and the
    /// slack of the motion.
    pub motion: f64,
    /// Ends of the straight motion that the joints follow, but for what is in `motion`.
    pub straight: Option<[JointValues; 2]>,
    /// The distance is that of the hull of the parabolas on which the points go in that motion, through their
    /// places at both ends and in the middle: `motion` then holds what leaves them, not the straight line.
    pub curved: bool,
}

/// What the search may cost, in pairs of boxes.
#[derive(Clone, Copy, Debug)]
struct Efforts {
    coarse: u64,
    fine: u64,
    look: u64,
}

impl Default for Efforts {
    fn default() -> Self {
        Self { coarse: COARSE_EFFORT, fine: FINE_EFFORT, look: MOST_OF_LOOK }
    }
}

impl ProvedSpan {
    /// What is proved, mm.
    pub fn least(&self) -> f64 {
        (self.distance - self.motion).max(0.0)
    }
}

/// What is kept of the motion, and what was proved so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Proof {
    kept: Vec<JointMotion>,
    /// What the check has found of whole pieces among them, in their order.
    noted: Vec<PieceRecord>,
    least: Vec<PairClearance>,
    joints: Vec<Option<JointValues>>,
    spans: Vec<ProvedSpan>,
    /// Where and when the motion ended by now.
    end: Option<(JointValues, f64)>,
    looks: u64,
    effort: u64,
    efforts: Efforts,
}

impl Interference {
    /// The same, with the motion kept so that [`Self::least_clearances`] is available.
    #[must_use]
    pub fn with_proof(mut self) -> Self {
        self.keep_proof();
        self
    }

    /// Keeps the motion from now on.
    pub fn keep_proof(&mut self) {
        self.proof = Some(Proof::default());
    }

    /// Least distance of every pair that is checked over all motion so far, in the order of [`Self::pairs`];
    /// empty without [`Self::with_proof`].
    pub fn least_clearances(&mut self) -> Vec<PairClearance> {
        self.prove_kept();
        let Some(proof) = self.proof.as_ref().filter(|p| p.end.is_some()) else { return Vec::new() };
        let neighbors = self.pairs.iter().filter(|p| p.neighbors.is_some()).map(|p| self.of_neighbors(p));
        let mut all: Vec<PairClearance> = proof.least.iter().cloned().chain(neighbors).collect();
        all.sort_by_key(|l| l.pair);
        all
    }

    /// What the check of the motion has proved of two neighbors.
    fn of_neighbors(&self, pair: &CheckedPair) -> PairClearance {
        let breaches = self.breaches.iter().filter(|b| b.pair == pair.info);
        let nearest = breaches.min_by(|a, b| a.least_distance.total_cmp(&b.least_distance));
        let (measured, time) = (nearest.map(|b| b.least_distance), nearest.map(|b| b.time));
        let proved = if nearest.is_some() { 0.0 } else { pair.clearance };
        PairClearance { pair: pair.info, proved, measured, time, neighbors: true }
    }

    /// The spans of time that prove what [`Self::least_clearances`] said, by pair and time.
    pub fn proved_spans(&self) -> &[ProvedSpan] {
        self.proof.as_ref().map_or(&[], |p| &p.spans)
    }

    /// Stretches of motion that were looked at for it.
    pub fn looks(&self) -> u64 {
        self.proof.as_ref().map_or(0, |p| p.looks)
    }

    /// What they have cost, in pairs of boxes that were looked at (some 30 ns each).
    pub fn proof_effort(&self) -> u64 {
        self.proof.as_ref().map_or(0, |p| p.effort)
    }

    pub(crate) fn keep_piece(&mut self, piece: JointMotion) {
        let Some(proof) = &mut self.proof else { return };
        proof.kept.push(piece);
        if proof.kept.len() >= MOST_PIECES {
            self.prove_kept();
        }
    }

    /// Looks at what is kept; before a tool is changed, and when there is much of it.
    pub(crate) fn prove_kept(&mut self) {
        let Some(mut proof) = self.proof.take() else { return };
        let noted = std::mem::take(&mut proof.noted);
        if let Some(way) = PieceTree::new(std::mem::take(&mut proof.kept)) {
            self.prove_way(&way, &noted, &mut proof);
        }
        self.proof = Some(proof);
    }

    /// Notes the distance of a pair on the straight way of the joints, or on the parabolas of the points,
    /// through the piece that is checked now.
    pub(crate) fn note_piece(&mut self, pair: usize, distance: f64, curved: bool) {
        let Some(proof) = &mut self.proof else { return };
        proof.noted.push(PieceRecord { pair, piece: proof.kept.len(), distance, curved });
    }

    fn prove_way(&self, way: &PieceTree, noted: &[PieceRecord], proof: &mut Proof) {
        let whole = way.time(MotionStretch::Node(1));
        let begin = whole[0];
        let met = |pair: usize| {
            let meets = |b: &&crate::Breach| b.pair == pair && b.severity != Severity::NearMiss;
            self.breaches.iter().filter(meets).any(|b| b.end_time.is_none_or(|t| t >= begin))
        };
        let mut searches: Vec<(&CheckedPair, PairAsk<'_>, LeastSearch)> = Vec::new();
        for (k, pair) in self.pairs.iter().enumerate().filter(|(_, p)| p.neighbors.is_none()) {
            let known = proof.least.iter().position(|l| l.pair == pair.info);
            let known = known.and_then(|k| {
                let (least, joints) = (&proof.least[k], proof.joints[k]?);
                Some(MeasuredDistance { distance: least.measured?, time: least.time?, joints })
            });
            let (known, enough) = if met(pair.info) { (None, 0.0) } else { (known, ENOUGH_MM) };
            let ask = PairAsk::new(self, pair, proof.efforts.look);
            let noted =
                PieceBounds::new(way, noted.iter().filter(|n| n.pair == k).map(|n| (n.piece, ask.noted(way, n))));
            searches.push((pair, ask, LeastSearch::new(way, known, enough, noted)));
        }
        let coarse = Tolerance { absolute: FINE_MM, relative: COARSE };
        for (_, ask, search) in &mut searches {
            search.refine(way, ask, coarse, proof.efforts.coarse);
        }
        smallest_first(way, &mut searches, proof.efforts.fine);
        let mut left = proof.efforts.fine;
        for (pair, ask, search) in &mut searches {
            // Every pair is proved to keep what is wanted of it, as the check has found.
            if search.proved() < pair.clearance {
                search.limit_distance(pair.clearance);
                let before = ask.effort;
                search.refine(way, ask, coarse, left);
                left = left.saturating_sub(ask.effort - before);
            }
        }
        searches.sort_by_key(|(pair, ..)| pair.info);
        let ends = way.ends();
        // Where the joints stood since, the last span holds until now.
        let stood = |(q, _): &(JointValues, f64)| ends.is_some_and(|[from, _]| (from - *q).max_abs() <= STANDS);
        let stood_since = proof.end.filter(stood).map(|(_, time)| time);
        for (pair, ask, search) in &searches {
            proof.looks += ask.looks;
            proof.effort += ask.effort;
            let last = proof.spans.iter_mut().rfind(|s| s.pair == pair.info);
            if let Some(last) = last.filter(|s| Some(s.time[1]) == stood_since) {
                last.time[1] = begin;
            }
            self.note(way, pair, search, proof);
        }
        proof.end = ends.map(|[_, to]| (to, whole[1]));
    }

    fn note(&self, way: &PieceTree, pair: &CheckedPair, search: &LeastSearch, proof: &mut Proof) {
        let before = proof.spans.len();
        for (stretch, bound) in search.spans(way) {
            let mut range = way.range(stretch);
            if let Some(joint) = bound.turns {
                (range.low[joint], range.high[joint]) = (f64::NEG_INFINITY, f64::INFINITY);
            }
            proof.spans.push(ProvedSpan {
                pair: pair.info,
                time: way.time(stretch),
                low: range.low,
                high: range.high,
                distance: bound.distance,
                motion: bound.turning + bound.slack,
                straight: bound.chord,
                curved: bound.curved,
            });
        }
        let proved = proof.spans[before..].iter().map(ProvedSpan::least).fold(f64::INFINITY, f64::min);
        let measured = search.measured;
        let met = search.is_met();
        let (distance, time, joints) = match measured {
            Some(m) => (Some(m.distance), Some(m.time), Some(m.joints)),
            None if met => (Some(0.0), None, None),
            None => (None, None, None),
        };
        let Some(k) = proof.least.iter().position(|l| l.pair == pair.info) else {
            proof.least.push(PairClearance { pair: pair.info, proved, measured: distance, time, neighbors: false });
            proof.joints.push(joints);
            return;
        };
        let known = &mut proof.least[k];
        known.proved = known.proved.min(proved);
        if distance.is_some_and(|d| known.measured.is_none_or(|m| d < m)) {
            (known.measured, known.time) = (distance, time);
            proof.joints[k] = joints;
        }
    }
}

/// Brings the bounds of all pairs to the fine tolerance, the smallest first, as far as the effort reaches.
fn smallest_first(way: &PieceTree, searches: &mut [(&CheckedPair, PairAsk<'_>, LeastSearch)], mut left: u64) {
    let fine = Tolerance { absolute: FINE_MM, relative: 0.0 };
    let measured = |s: &LeastSearch| s.measured.map_or(f64::INFINITY, |m| m.distance);
    let least_of = |searches: &[(&CheckedPair, PairAsk<'_>, LeastSearch)]| {
        searches.iter().map(|(_, _, s)| measured(s)).fold(f64::INFINITY, f64::min).max(NEAR_MM)
    };
    let mut least = f64::INFINITY;
    while left > 0 {
        let (first, now) = (least.is_infinite(), least_of(searches));
        if now < least {
            least = now;
            for (_, ask, search) in searches.iter_mut() {
                ask.exact = least;
                if measured(search) > least {
                    // Not the smallest of all: it is enough to know that.
                    search.limit_distance(least);
                }
            }
        }
        if first {
            searches.iter_mut().for_each(|(_, _, search)| search.reopen(way, fine));
        }
        let open = searches.iter_mut().filter_map(|s| Some((s.2.open_below(fine)?, s)));
        let Some((_, (_, ask, search))) = open.min_by(|(x, a), (y, b)| x.total_cmp(y).then(a.0.info.cmp(&b.0.info)))
        else {
            return;
        };
        let before = ask.effort;
        search.refine(way, ask, fine, SHARE.min(left));
        left = left.saturating_sub(ask.effort - before);
    }
}

/// One of a pair at all turns of its joint, and the other.
struct RingAsk<'a> {
    joint: usize,
    /// The hulls.
    a: Arc<CollisionPart>,
    b: &'a CollisionPart,
}

impl<'a> RingAsk<'a> {
    fn new(world: &'a Interference, pair: &'a CheckedPair, ring: &Ring) -> Self {
        let other = if ring.side == 0 { pair.b } else { pair.a };
        Self { joint: ring.joint, a: ring.part.clone(), b: &world.parts[other] }
    }
}

fn b_from_a(machine: &Machine, a: &CollisionPart, b: &CollisionPart, q: &JointValues) -> Pose {
    b.pose(machine, q).inverse() * a.pose(machine, q)
}

/// Where a point of a goes for a unit of a slide, at some joints, in the frame of b.
fn column(machine: &Machine, a: &CollisionPart, b: &CollisionPart, q: &JointValues, joint: usize) -> Vector {
    let (mut low, mut high) = (*q, *q);
    (low[joint], high[joint]) = (q[joint] - 0.5, q[joint] + 0.5);
    let of = |q: &JointValues| b_from_a(machine, a, b, q).point(&Point::origin());
    of(&high) - of(&low)
}

/// Distances and bounds of one pair.
struct PairAsk<'a> {
    machine: &'a Machine,
    a: &'a CollisionPart,
    b: &'a CollisionPart,
    weights: [f64; MAX_JOINTS],
    turns: [bool; MAX_JOINTS],
    /// Joints that carry b.
    of_b: [bool; MAX_JOINTS],
    /// One of the two at all turns of its joint.
    ring: Option<RingAsk<'a>>,
    warm: WarmStart,
    looks: u64,
    /// What they have cost.
    effort: u64,
    /// Distances below this are exact, mm.
    exact: f64,
    /// The most that one look may cost.
    most_of_look: u64,
    /// Stretches since the hulls of all turns proved one.
    in_vain: u32,
}

impl<'a> PairAsk<'a> {
    fn new(world: &'a Interference, pair: &'a CheckedPair, most_of_look: u64) -> Self {
        let joints = &world.machine.joints;
        let (mut a, mut b) = (&world.parts[pair.a], &world.parts[pair.b]);
        if matches!(*b.shape, PartShape::Convex(_)) {
            (a, b) = (b, a);
        }
        let carries = chain_to(&world.machine, b.attached);
        Self {
            machine: &world.machine,
            a,
            b,
            weights: pair.own_weights,
            ring: pair.ring.as_ref().map(|r| RingAsk::new(world, pair, &r.of)),
            turns: std::array::from_fn(|j| joints.get(j).is_some_and(proveout_machine::Joint::is_rotary)),
            of_b: std::array::from_fn(|j| carries.contains(&j)),
            warm: None,
            looks: 0,
            effort: 0,
            exact: NEAR_MM,
            most_of_look,
            in_vain: 0,
        }
    }

    fn b_from_a(&self, q: &JointValues) -> Pose {
        b_from_a(self.machine, self.a, self.b, q)
    }

    /// Distance in a pose as far as below a limit: what is proved, and that of two points, mm.
    fn apart(&mut self, b_from_a: &Pose, limit: f64) -> [f64; 2] {
        let limits = [limit.min(self.exact), limit];
        let mut effort = Effort::at_most(self.most_of_look);
        // Beyond the limit nothing needs to be known of them.
        let found = gap_with((&self.a.shape, &self.b.shape), b_from_a, limits, &mut self.warm, &mut effort);
        self.effort += effort.spent;
        match found {
            // Two points were not found: their distance is the limit or more, or was not looked for to the
            // end.
            Separation::Beyond(proved) => [proved.min(ENOUGH_MM), ENOUGH_MM],
            Separation::Between(two, ..) => two.map(|d| d.min(ENOUGH_MM)),
            Separation::At(d, ..) if d.is_finite() => [d; 2],
            Separation::At(..) | Separation::Meeting(_) => [0.0; 2],
        }
    }

    fn sum(&self, of: impl Fn(usize) -> f64) -> f64 {
        (0..MAX_JOINTS).map(|j| self.weights[j] * of(j)).sum()
    }

    /// What the hulls of all turns prove, where it is enough.
    fn at_all_turns(&mut self, range: &Range, half: &JointValues, wanted: f64) -> Option<StretchBound> {
        let ring = self.ring.as_ref()?;
        // A joint that hardly turns is no reason to take more than the body; nor is one that seldom helped.
        if half[ring.joint] * self.weights[ring.joint] < WORTH_MM {
            return None;
        }
        self.in_vain += 1;
        if self.in_vain > IN_VAIN && !self.in_vain.is_multiple_of(IN_VAIN) {
            return None;
        }
        self.effort += LOOK_EFFORT;
        let mut weights = self.weights;
        weights[ring.joint] = 0.0;
        let aside = dot(&weights, &range.off.0);
        let turning = turned(&weights, &self.turns, half);
        let middle = (range.low + range.high) * 0.5;
        let mut places = BodyPlaces::at(b_from_a(self.machine, &ring.a, ring.b, &middle));
        for j in (0..MAX_JOINTS).filter(|&j| !self.turns[j] && weights[j] > 0.0) {
            places.shift(column(self.machine, &ring.a, ring.b, &middle, j) * half[j]);
        }
        let limit = (wanted + turning - aside).max(0.0) * (1.0 + BEYOND);
        let mut effort = Effort::at_most(self.most_of_look);
        let shapes = (&*ring.a.shape, &*ring.b.shape);
        let distance = least_distance_with(shapes, &places, limit, &mut effort).min(limit);
        self.effort += effort.spent;
        let bound = StretchBound {
            distance,
            turning,
            slack: range.slack,
            aside,
            chord: None,
            curved: false,
            turns: Some(ring.joint),
        };
        if bound.reached() < wanted {
            return None;
        }
        self.in_vain = 0;
        Some(bound)
    }

    /// The motion by which the distance of all places of a stretch may be too large, mm, and the straight
    /// motion whose hull they are taken for: its ends, and whether by the parabolas of the points. None for
    /// the box.
    fn held(
        &self,
        way: &PieceTree,
        stretch: MotionStretch,
        half: &JointValues,
        wanted: f64,
    ) -> (f64, Option<([JointValues; 2], bool)>) {
        let turning = turned(&self.weights, &self.turns, half);
        let Some((ends, off)) = way.chord(stretch, &self.weights) else { return (turning, None) };
        let [chord, parabola] = bent(&self.weights, &self.turns, &self.of_b, &(ends[1] - ends[0]), wanted);
        let curved = chord - parabola > STRAIGHT_MM;
        let bent = if curved { parabola } else { chord } + self.sum(|j| off[j]);
        let aside = self.sum(|j| way.range(stretch).off[j]);
        let better = bent < turning || bent <= 1.01 * aside;
        if better { (bent, Some((ends, curved))) } else { (turning, None) }
    }

    /// What the check has found of a piece.
    fn noted(&self, way: &PieceTree, noted: &PieceRecord) -> StretchBound {
        let (ends, range) = way.piece(noted.piece);
        let [chord, parabola] = bent(&self.weights, &self.turns, &self.of_b, &(ends[1] - ends[0]), noted.distance);
        let aside = self.sum(|j| range.off[j]);
        let turning = if noted.curved { parabola } else { chord } + aside;
        StretchBound {
            distance: noted.distance,
            turning,
            slack: range.slack,
            aside,
            chord: Some(ends),
            curved: noted.curved,
            turns: None,
        }
    }

    fn least(&mut self, places: &BodyPlaces, limit: f64) -> f64 {
        let distance = match places.single() {
            Some(pose) => self.apart(&pose, limit)[0],
            None => {
                let mut effort = Effort::at_most(self.most_of_look);
                let found = least_distance_with((&self.a.shape, &self.b.shape), places, limit, &mut effort);
                self.effort += effort.spent;
                found
            }
        };
        distance.min(ENOUGH_MM)
    }
}

impl Ask for PairAsk<'_> {
    fn effort(&self) -> u64 {
        self.effort
    }

    fn bound(&mut self, way: &PieceTree, stretch: MotionStretch, wanted: f64, seen: f64) -> StretchBound {
        (self.looks, self.effort) = (self.looks + 1, self.effort + LOOK_EFFORT);
        let range = way.range(stretch);
        let half = (range.high - range.low) * 0.5;
        if let Some(found) = self.at_all_turns(&range, &half, wanted) {
            return found;
        }
        let aside = self.sum(|j| range.off[j]);
        let (turning, line) = self.held(way, stretch, &half, wanted);
        let slack = range.slack;
        let (chord, curved) = line.map_or((None, false), |(ends, curved)| (Some(ends), curved));
        let none = StretchBound { distance: 0.0, turning, slack, aside, chord, curved, turns: None };
        if seen - turning + aside < wanted {
            return none;
        }
        let limit = (wanted + turning - aside).max(0.0) * (1.0 + BEYOND);
        let Some((ends, curved)) = line else {
            let middle = (range.low + range.high) * 0.5;
            let mut places = BodyPlaces::at(self.b_from_a(&middle));
            for j in (0..MAX_JOINTS).filter(|&j| !self.turns[j] && self.weights[j] > 0.0) {
                places.shift(column(self.machine, self.a, self.b, &middle, j) * half[j]);
            }
            return StretchBound { distance: self.least(&places, limit), ..none };
        };
        let [from, to] = ends.map(|q| self.b_from_a(&q));
        let places = if curved {
            BodyPlaces::along([from, self.b_from_a(&ends[0].interpolated(ends[1], 0.5)), to])
        } else {
            BodyPlaces::between([from, to])
        };
        // What is farther was not looked at.
        StretchBound { distance: self.least(&places, limit).min(limit), ..none }
    }

    fn spread(&self, way: &PieceTree, stretch: MotionStretch, wanted: f64) -> f64 {
        let range = way.range(stretch);
        let half = (range.high - range.low) * 0.5;
        (self.held(way, stretch, &half, wanted).0 - self.sum(|j| range.off[j])).max(0.0)
    }

    fn distance(&mut self, joints: &JointValues, limit: f64) -> [f64; 2] {
        (self.looks, self.effort) = (self.looks + 1, self.effort + LOOK_EFFORT);
        let pose = self.b_from_a(joints);
        self.apart(&pose, limit)
    }

    fn about(&self, way: &PieceTree, stretch: MotionStretch, joints: &JointValues, distance: f64) -> StretchBound {
        let range = way.range(stretch);
        let far = (range.high - *joints).zip_map(*joints - range.low, f64::max);
        let (turning, aside) = (self.sum(|j| far[j]), self.sum(|j| range.off[j]));
        let chord = Some([*joints; 2]);
        StretchBound { distance, turning, slack: range.slack, aside, chord, curved: false, turns: None }
    }
}
