//! Branch and bound over time, for one pair of bodies.
//!
//! Of a stretch of the motion one of three things is proved.
//!
//! *Place.* At a place q of the motion the distance D is measured; elsewhere in the stretch it is smaller by
//! at most `T = sum w_j max |q'_j - q_j|` (Mirtich 1996).
//!
//! *Box.* The joints are in a box. At its middle, with the slides free and the turning joints held, the
//! distance D of the two is proved (text of `swept.rs`); turning to any other place of the box moves a point
//! of one against the other by at most `T = sum w_j h_j` over the turning joints, w being farthest distances
//! from their axes and h half the edges of the box.
//!
//! *Chord.* The joints go from one end of the stretch to the other along a straight line d, and leave it by
//! no more than `e_j`. D is the distance of the hull of the body at both ends. A point p of it leaves its
//! own chord by at most `|p''| / 8`; its second derivative is a sum over pairs of joints of which the outer
//! one turns, `|p''| <= 2 (sum |d_turning|) (sum w_j |d_j|)`, so that `T = (sum |d_turning|) (sum w_j |d_j|)
//! / 4 + sum w_j e_j`. Only points nearer to the other body than what is asked for count; for joints that
//! carry the other body w is their distance from the axis, so much more than that of the other body's
//! points. It shrinks with the square of the length, that of the box with the length.
//!
//! *Curve.* The same with the parabola of each point through its places at both ends and in the middle, in
//! the hull of its control points (text of `swept.rs`). `|p'''| <= 3 (sum |d_turning|)^2 (sum w_j |d_j|)`, by
//! the same count of the joints of which the outer two turn, and a parabola through three places leaves a
//! point by `|p'''| / (72 sqrt 3)`, so that `T = 0.0241 (sum |d_turning|)^2 (sum w_j |d_j|) + sum w_j e_j`.
//!
//! *Turns.* A box in which one joint may be anywhere: D is the distance of the hulls of all its turns (text
//! of `ring.rs`), and this joint does not count in T.
//!
//! Over the whole stretch then
//!
//! ```text
//!    distance >= D - T - slack
//! ```
//!
//! The stretch is done when D - T is within the tolerance below the least distance measured. Otherwise it is
//! halved, and the half with the smaller bound comes first.
//!
//! Every stretch that is done is a part of the certificate: its time, the box, D and T. Since the stretch
//! with the smallest bound comes first, what is opened has a bound below the true least distance less the
//! tolerance, whatever the order in which places are measured (Hart, Nilsson and Raphael 1968). At the end
//! the longest stretches count whose bound is good enough.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use proveout_machine::{JointValues, MAX_JOINTS};

use super::piece_bounds::PieceBounds;
use super::piece_tree::{MotionStretch, PieceTree};
use super::{BEYOND, ENOUGH_MM};

/// A stretch whose motion is more than this part of the least distance that was measured is long.
const LONG: f64 = 0.05;

/// What is proved of a stretch: D, and by how much at most the distance is smaller somewhere in it (T and the
/// slack), mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StretchBound {
    pub(crate) distance: f64,
    pub(crate) turning: f64,
    pub(crate) slack: f64,
    /// Share of it that no shorter stretch gets rid of: the joints may be off the straight motion, mm.
    pub(crate) aside: f64,
    /// Ends of the straight motion for which it holds; none for the box.
    pub(crate) chord: Option<[JointValues; 2]>,
    /// Of that motion the parabolas of the points count, and not the straight lines between their ends.
    pub(crate) curved: bool,
    /// It holds at all turns of this joint.
    pub(crate) turns: Option<usize>,
}

impl StretchBound {
    pub(crate) fn least(&self) -> f64 {
        (self.distance - self.turning - self.slack).max(0.0)
    }

    /// The better of two.
    pub(crate) fn or(self, other: Self) -> Self {
        if other.reached() > self.reached() { other } else { self }
    }

    /// The same without what no shorter stretch makes better.
    pub(crate) fn reached(&self) -> f64 {
        self.distance - self.turning + self.aside
    }
}

/// The least distance that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeasuredDistance {
    pub(crate) distance: f64,
    pub(crate) joints: JointValues,
    pub(crate) time: f64,
}

/// How near the bound is to come to the least distance that was measured: the larger of a length, mm, and a
/// part of the distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub(crate) absolute: f64,
    pub(crate) relative: f64,
}

/// Asks about one pair.
pub(crate) trait Ask {
    /// What is proved of the joints in a stretch; D needs to be known below `limit` plus T only. `seen` is a
    /// distance in the stretch, mm: where it leaves no room for T, the distance of the whole is not asked
    /// for.
    fn bound(&mut self, way: &PieceTree, stretch: MotionStretch, limit: f64, seen: f64) -> StretchBound;

    /// The T of [`Self::bound`] that a shorter stretch makes smaller, mm.
    fn spread(&self, way: &PieceTree, stretch: MotionStretch, limit: f64) -> f64;

    /// Distance at some joints, or something above the limit, mm: what is proved, and that of two points.
    fn distance(&mut self, joints: &JointValues, limit: f64) -> [f64; 2];

    /// What was asked so far has cost this, in pairs of boxes.
    fn effort(&self) -> u64;

    /// What a distance there says of a stretch.
    fn about(&self, way: &PieceTree, stretch: MotionStretch, joints: &JointValues, distance: f64) -> StretchBound;
}

struct BoundedStretch {
    stretch: MotionStretch,
    bound: StretchBound,
    parent: Option<usize>,
}

/// A stretch that is open; its parent says what is known of it.
#[derive(PartialEq)]
struct OpenStretch {
    least: f64,
    stretch: MotionStretch,
    begin: (usize, f64),
    parent: Option<usize>,
}

impl Eq for OpenStretch {}

impl Ord for OpenStretch {
    /// The smallest bound is the greatest; the earlier of equals.
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(along(&other.begin, &self.begin))
    }
}

impl PartialOrd for OpenStretch {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A search that can be taken up again with a finer tolerance.
pub(crate) struct LeastSearch {
    open: BinaryHeap<OpenStretch>,
    looked: Vec<BoundedStretch>,
    /// Stretches that are good enough, by their place in `looked`.
    done: Vec<usize>,
    pub(crate) measured: Option<MeasuredDistance>,
    /// What is known of single pieces beforehand.
    noted: PieceBounds,
    /// Distance at the last place that was measured, mm.
    seen: f64,
    /// Distances beyond this are not needed, mm.
    enough: f64,
}

impl LeastSearch {
    /// `known` is the least distance that was measured of the pair before; beyond `enough` (mm) it is not
    /// asked how far. `noted` is known of pieces.
    pub(crate) fn new(way: &PieceTree, known: Option<MeasuredDistance>, enough: f64, noted: PieceBounds) -> Self {
        let whole = MotionStretch::Node(1);
        let open = OpenStretch { least: f64::NEG_INFINITY, stretch: whole, begin: way.begin(whole), parent: None };
        Self {
            open: BinaryHeap::from([open]),
            looked: Vec::new(),
            done: Vec::new(),
            measured: known,
            noted,
            seen: f64::INFINITY,
            enough,
        }
    }

    fn wanted(&self, tolerance: Tolerance) -> f64 {
        let least = |d: f64| d - tolerance.absolute.max(tolerance.relative * d);
        self.measured.map_or(self.enough, |m| least(m.distance).min(self.enough))
    }

    /// Opens again what was good enough for a coarser tolerance.
    pub(crate) fn reopen(&mut self, way: &PieceTree, tolerance: Tolerance) {
        let wanted = self.wanted(tolerance);
        let (keep, again): (Vec<usize>, Vec<usize>) =
            std::mem::take(&mut self.done).into_iter().partition(|&k| self.looked[k].bound.reached() >= wanted);
        self.done = keep;
        for k in again {
            self.part(way, k);
        }
    }

    /// Smallest bound of what is open, mm, where it is not yet within `tolerance` of the least distance
    /// measured.
    pub(crate) fn open_below(&self, tolerance: Tolerance) -> Option<f64> {
        let wanted = self.wanted(tolerance);
        self.open.peek().map(|o| o.least).filter(|least| *least < wanted && wanted > 0.0)
    }

    /// Goes on until the bound of what is open is within `tolerance` of the least distance measured, or
    /// `most` effort was made.
    pub(crate) fn refine(&mut self, way: &PieceTree, ask: &mut impl Ask, tolerance: Tolerance, most: u64) {
        let begin = ask.effort();
        if let Some(worst) = self.noted.worst().filter(|_| self.looked.is_empty() && self.enough > 0.0) {
            // Where least is known is most likely the least of all.
            self.measure(way, ask, MotionStretch::Node(worst), self.wanted(tolerance));
        }
        while let Some(next) = self.open.pop() {
            let wanted = self.wanted(tolerance);
            if next.least >= wanted || wanted <= 0.0 || ask.effort() - begin >= most {
                self.open.push(next);
                break;
            }
            let Some(next) = self.split_by_pieces(way, next, wanted) else { continue };
            let known = self.recorded_bound(next.stretch);
            let bound = if let Some(known) = known {
                self.measure(way, ask, next.stretch, wanted).or(known)
            } else if self.is_place_first(way, ask, next.stretch, tolerance) {
                let place = self.measure(way, ask, next.stretch, wanted);
                let wanted = self.wanted(tolerance);
                if wanted <= 0.0 || place.reached() >= wanted {
                    place
                } else {
                    ask.bound(way, next.stretch, wanted, self.seen).or(place)
                }
            } else {
                // Mostly the whole stretch is proved at once. Else what is measured in it may be the least.
                let whole = ask.bound(way, next.stretch, wanted, f64::INFINITY);
                if whole.reached() >= wanted { whole } else { self.measure(way, ask, next.stretch, wanted).or(whole) }
            };
            let wanted = self.wanted(tolerance);
            if wanted <= 0.0 {
                self.open.push(next);
                break;
            }
            self.looked.push(BoundedStretch { stretch: next.stretch, bound, parent: next.parent });
            let k = self.looked.len() - 1;
            if bound.reached() >= wanted { self.done.push(k) } else { self.part(way, k) }
        }
    }

    fn recorded_bound(&self, stretch: MotionStretch) -> Option<StretchBound> {
        match stretch {
            MotionStretch::Node(n) => self.noted.bound(n),
            MotionStretch::Part(..) => None,
        }
    }

    /// Takes a stretch by what is known of its pieces: where that is enough of all of them they are done, and
    /// where it is known of most of them the stretch is parted without a look. Gives the stretch back where
    /// neither is so.
    fn split_by_pieces(&mut self, way: &PieceTree, next: OpenStretch, wanted: f64) -> Option<OpenStretch> {
        let MotionStretch::Node(node) = next.stretch else { return Some(next) };
        let (known, least) = self.noted.below(node);
        let leaves = way.leaves_of(node);
        if known == leaves.len() && least >= wanted {
            for leaf in leaves {
                if let Some(bound) = self.noted.bound(leaf) {
                    self.looked.push(BoundedStretch { stretch: MotionStretch::Node(leaf), bound, parent: next.parent });
                    self.done.push(self.looked.len() - 1);
                }
            }
            return None;
        }
        if leaves.len() > 1 && 2 * known >= leaves.len() {
            // Its halves have the parent of the whole, of which nothing is claimed.
            if let Some(parent) = next.parent {
                self.open_halves(way, next.stretch, next.least, Some(parent));
                return None;
            }
        }
        Some(next)
    }

    /// Whether to measure at a place of the stretch before all of it is asked for: while nothing is known,
    /// where a rough bound will do, and where the stretch is so long that it is most likely parted.
    fn is_place_first(&self, way: &PieceTree, ask: &impl Ask, stretch: MotionStretch, tolerance: Tolerance) -> bool {
        let Some(known) = self.measured.filter(|_| tolerance.relative == 0.0) else { return true };
        let wanted = self.wanted(tolerance);
        ask.spread(way, stretch, wanted) > (LONG * known.distance).max(tolerance.absolute)
    }

    /// Measures at a place of the stretch, as far as is needed for what is wanted.
    fn measure(&mut self, way: &PieceTree, ask: &mut impl Ask, stretch: MotionStretch, wanted: f64) -> StretchBound {
        let (joints, time) = way.middle(stretch);
        let known = self.measured.map_or(self.enough, |m| m.distance);
        let needed = wanted - ask.about(way, stretch, &joints, 0.0).reached();
        // Where it is not asked how far they are, a place that is nearer than the nearest one so far does not
        // matter either.
        let nearer = if self.measured.is_none() { ENOUGH_MM } else { known.min(self.enough) };
        let limit = nearer.max(needed) * (1.0 + BEYOND);
        let [proved, distance] = ask.distance(&joints, limit);
        self.seen = distance;
        if distance < known.min(limit) {
            self.measured = Some(MeasuredDistance { distance, joints, time });
        }
        ask.about(way, stretch, &joints, proved)
    }

    fn part(&mut self, way: &PieceTree, k: usize) {
        let of = &self.looked[k];
        self.open_halves(way, of.stretch, of.bound.reached(), Some(k));
    }

    fn open_halves(&mut self, way: &PieceTree, stretch: MotionStretch, least: f64, parent: Option<usize>) {
        let halves = way.halves(stretch).into_iter().flatten();
        self.open.extend(halves.map(|stretch| OpenStretch { least, stretch, begin: way.begin(stretch), parent }));
    }

    /// Beyond this it is asked no longer how far, mm.
    pub(crate) fn limit_distance(&mut self, enough: f64) {
        self.enough = self.enough.min(enough);
    }

    /// What is proved of the whole so far, mm.
    pub(crate) fn proved(&self) -> f64 {
        let open = self.open.iter().map(|o| o.parent.map_or(0.0, |k| self.looked[k].bound.least()));
        open.chain(self.done.iter().map(|&k| self.looked[k].bound.least())).fold(f64::INFINITY, f64::min)
    }

    /// The two meet, so no distance is needed.
    pub(crate) fn is_met(&self) -> bool {
        self.enough <= 0.0
    }

    /// The stretches that make up the whole, in order along it, each as long as its bound is no worse than
    /// what the search has reached in all.
    pub(crate) fn spans(&self, way: &PieceTree) -> Vec<(MotionStretch, StretchBound)> {
        let none = StretchBound {
            distance: 0.0,
            turning: 0.0,
            slack: 0.0,
            aside: 0.0,
            chord: None,
            curved: false,
            turns: None,
        };
        let mut ends: Vec<((usize, f64), Option<usize>)> = self.open.iter().map(|o| (o.begin, o.parent)).collect();
        ends.extend(self.done.iter().map(|&k| (way.begin(self.looked[k].stretch), Some(k))));
        ends.sort_by(|a, b| along(&a.0, &b.0));
        let reached =
            ends.iter().map(|(_, k)| k.map_or(0.0, |k| self.looked[k].bound.least())).fold(self.enough, f64::min);
        let mut out: Vec<usize> = Vec::new();
        for (_, known) in ends {
            let Some(mut k) = known else { return vec![(MotionStretch::Node(1), none)] };
            let mut best = k;
            while let Some(parent) = self.looked[k].parent {
                k = parent;
                if self.looked[k].bound.least() >= reached {
                    best = k;
                }
            }
            if out.last() != Some(&best) {
                out.push(best);
            }
        }
        out.into_iter().map(|k| (self.looked[k].stretch, self.looked[k].bound)).collect()
    }
}

/// Order along the way.
fn along(a: &(usize, f64), b: &(usize, f64)) -> Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}

/// `sum w h` over the joints that turn, mm.
pub(crate) fn turned(weights: &[f64; MAX_JOINTS], turns: &[bool; MAX_JOINTS], half: &JointValues) -> f64 {
    (0..MAX_JOINTS).filter(|&j| turns[j]).map(|j| weights[j] * half[j]).sum()
}
