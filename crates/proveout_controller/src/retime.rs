//! Runs a first law faster where the joints allow it.
//!
//! The chains of `look_ahead.rs` know constants V, A and J a cell and have no acceleration at their anchors:
//! a law that keeps all limits and wastes time at corners and in curves. Its own time p is a parameter in
//! which the joints q(p) have finite derivatives even at rests. The law is run with a *tempo* dp/dt =
//! sqrt(b(p)) (`tempo.rs`); the chain rule gives
//!
//! ```text
//!   q.   = q' sqrt(b)
//!   q..  = q' b'/2 + q'' b
//!   q... = sqrt(b) (q' b''/2 + 3/2 q'' b' + q''' b)
//!   T    = integral dp / sqrt(b)
//! ```
//!
//! (Verscheure et al. 2009 for the first two, over the path instead of a time). b = 1 is the law as it is.
//!
//! ```text
//!   b |      __            __          b cubic between knots, slope continuous: acceleration is continuous,
//!     |  ___/  \__      __/  \___        jerk bounded and free to jump at knots
//!   1 |_/         \____/         \__    b = 1 where the law runs at feed or joint speed already (held)
//!     +--.--.--.--.----.--.--.--.--.--> p
//!      region 1   held     region 2
//! ```
//!
//! 1. *Regions* (`grid.rs`): all but the stretches that run at their highest speed for longer than a few
//!    intervals. They do not act on each other. A program that runs at its feed costs nothing here.
//! 2. *Grid*: knots at borders of phases and cells and between them, closer where the speed is low; limits at
//!    two to five points an interval, on both sides of every jump.
//! 3. *Solution* (`problem.rs`, `stages.rs`, `solver.rs`): an interior point method, chunk by chunk with an
//!    overlap. Where a row passes its limit between two points, a point is put there and the search goes on,
//!    at the end around that place alone.
//! 4. *Samples* (`watch.rs`): the law is measured at the control samples. Where one passes a limit, or a
//!    difference of set points does, that place gets a point of its own, or rows around it are tightened
//!    where they do not see the excess, and the surroundings are solved again; after some rounds the tempo is
//!    lowered there (`lower_tempo_at`).
//! 5. *What rounds leave* (`settle`) is taken away by plateaus of some percent, and where more is left the
//!    first law is kept for some hundredths of a second. A tempo that would come near to rest is refused
//!    (`Tempo::is_sound`).
//! 6. *Last resort* (`stretch.rs`): from rest to rest the law runs slower as a whole; in motion the machine
//!    comes to rest by the reserve of the stretch before.
//!
//! *Windows.* A part of a run is committed up to a node half a second before the last known one.
//! The next part begins with the tempo and its slope there; the tempo found for the rest is kept,
//! in case that beginning cannot be solved again.
//!
//! *Limits of the method.* Knots do not move to where the jerk switches: compared with an
//! independent search that begins at the plan, the method loses up to 1.5 percent of the time
//! (`tests/optimum.rs`). Compared with TOPP3-LP, which begins at a law of its own, the plans of
//! curves from rest to rest are 0.1 to 0.3 percent faster (`tests/against_copp.rs`). The decisive
//! point: every border of the first law's phases is a knot, since its jerk jumps there, by b^(3/2)
//! times as much in the law that is looked for (docs/performance.md).

mod band;
mod cap;
mod field;
mod grid;
mod lanes;
mod part;
mod problem;
mod side;
mod solved;
mod solver;
mod stages;
mod start;
mod system;

pub(crate) use self::grid::{LimitExcess, jerk_along};
pub(crate) use self::stages::Stages;
use self::{grid::Probe, solved::RegionTempo};
use crate::{
    path::{PathContext, RunPath},
    profile::Law,
    tempo::Tempo,
};

/// How a law begins: square of the tempo and its slope, and a tempo that is known to be possible from there
/// on.
#[derive(Clone, Debug)]
pub(crate) struct LawEntry {
    pub(crate) square: [f64; 2],
    pub(crate) tail: Vec<Tempo>,
}

impl Default for LawEntry {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl LawEntry {
    /// The law goes on with these tempos.
    pub(crate) fn new(tail: Vec<Tempo>) -> Self {
        Self { square: tail.first().map_or([1.0, 0.0], |t| [t.square[0], t.square[1]]), tail }
    }

    fn is_even(&self) -> bool {
        self.square == [1.0, 0.0]
    }
}

/// Excess of b up to which a region is slowed down on plateaus, how often, the half length of a plateau and
/// of its ramps, s.
const LEVELED: f64 = 0.05;
const LEVELS: usize = 6;
/// Time of the first law to either side of a sample that could not be brought below its limit over which the
/// first law is kept, s.
const AS_IT_WAS: f64 = 0.03;

/// What is to be run faster: a first law over the first `cells` cells of a path. `rest` says
/// whether it begins and ends at rest; where it does not, it begins as `entry` says and ends with
/// its own tempo.
pub(crate) struct RetimeTask<'a> {
    pub(crate) path: &'a RunPath,
    pub(crate) frame: &'a PathContext<'a>,
    pub(crate) law: &'a Law,
    pub(crate) cells: usize,
    pub(crate) entry: &'a LawEntry,
    pub(crate) rest: [bool; 2],
}

/// What came of an attempt to settle what could not be mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RepairOutcome {
    /// Regions run slower.
    Slower,
    /// The first law is kept in places.
    AsItWas,
    /// There was nothing to change.
    Nothing,
}

/// Results of earlier rounds, and the places where samples passed limits outside of all regions.
pub(crate) struct Rounds<'a> {
    known: Vec<RegionTempo>,
    /// In the order of time.
    spots: Vec<LimitExcess>,
    /// Stretches of time that run as in the first law, rising.
    cuts: Vec<[f64; 2]>,
    stages: &'a mut Stages,
}

impl<'a> Rounds<'a> {
    /// No round yet; the searches have room from before.
    pub(crate) fn new(stages: &'a mut Stages) -> Self {
        Self { known: Vec::new(), spots: Vec::new(), cuts: Vec::new(), stages }
    }

    /// Tightens the rows at these places, to be solved again; with `dips` lowers the tempo there at once,
    /// which always succeeds.
    pub(crate) fn slow_down(&mut self, spots: &[LimitExcess], dips: bool) {
        for known in &mut self.known {
            let own: Vec<&LimitExcess> = spots.iter().filter(|s| s.at >= known.from && s.at <= known.to).collect();
            if dips && !own.is_empty() {
                known.lower_tempo_at(&own);
            } else {
                known.spots.extend(own.iter().map(|s| **s));
            }
        }
        for spot in spots {
            if !self.known.iter().any(|k| spot.at >= k.from && spot.at <= k.to) {
                let at = self.spots.partition_point(|s| s.at < spot.at);
                self.spots.insert(at, *spot);
            }
        }
    }

    /// Settles what rounds of [`Self::slow_down`] could not mend: regions that pass limits by little run
    /// slower on plateaus, and the law is left as it was around other places.
    pub(crate) fn settle(&mut self, spots: &[LimitExcess]) -> RepairOutcome {
        let mut settled = RepairOutcome::Nothing;
        let mut times: Vec<f64> = Vec::new();
        for known in &mut self.known {
            let own: Vec<&LimitExcess> = spots.iter().filter(|s| s.at >= known.from && s.at <= known.to).collect();
            if own.is_empty() {
                continue;
            }
            let far = own.iter().any(|s| s.excess > LEVELED);
            if !far && known.levels < LEVELS {
                known.level(&own);
                settled = RepairOutcome::Slower;
            } else {
                times.extend(own.iter().filter(|s| !far || s.excess > LEVELED).map(|s| s.at));
            }
        }
        for t in times {
            if !self.cuts.iter().any(|c| (c[0]..=c[1]).contains(&t)) {
                settled = RepairOutcome::AsItWas;
                self.cut(t - AS_IT_WAS, t + AS_IT_WAS);
            }
        }
        settled
    }

    /// Adds a cut; those that overlap become one.
    fn cut(&mut self, mut from: f64, mut to: f64) {
        self.cuts.retain(|c| {
            let apart = c[1] < from || c[0] > to;
            if !apart {
                (from, to) = (from.min(c[0]), to.max(c[1]));
            }
            apart
        });
        let at = self.cuts.partition_point(|c| c[0] < from);
        self.cuts.insert(at, [from, to]);
    }

    /// The law with the fastest tempo that is found.
    pub(crate) fn retimed(&mut self, course: &RetimeTask<'_>) -> Law {
        let RetimeTask { path, frame, law, cells, entry, rest } = course;
        let moving = !entry.is_even();
        let mut found: Vec<Vec<Tempo>> = Vec::new();
        // What must be kept of the tail, where the begin cannot be solved.
        let mut kept_until = 0.0;
        let mut before = std::mem::take(&mut self.known);
        let tail_end = entry.tail.last().map_or(0.0, |t| t.begin + t.length);
        if moving && self.cuts.first().is_some_and(|c| c[0] < tail_end) {
            self.cut(0.0, tail_end);
            found.push(entry.tail.clone());
        }
        let mut probe = Probe::new(path, frame, law);
        let regions = grid::regions(path, frame, law, *cells, moving, &self.spots);
        for region in regions.iter().flat_map(|r| r.without(&self.cuts)) {
            let at_begin = region.from <= 0.0;
            let same = before.iter().position(|k| k.from == region.from && k.to == region.to);
            let known = match same {
                Some(i) => before.swap_remove(i).repaired(&mut probe, self.stages),
                None => {
                    let fixed = [!(at_begin && rest[0]), !(region.to >= law.planned && rest[1])];
                    let start = if at_begin { entry.square } else { [1.0, 0.0] };
                    let field = grid::field(&mut probe, &region, fixed, &self.spots);
                    RegionTempo::new((&mut probe, self.stages), field, [region.from, region.to], start)
                }
            };
            if region.from >= kept_until {
                match known.tempos() {
                    Some(tempos) => found.push(tempos),
                    None if at_begin && moving => {
                        found.push(entry.tail.clone());
                        kept_until = entry.tail.last().map_or(0.0, |t| t.begin + t.length);
                    }
                    None => {}
                }
            }
            self.known.push(known);
        }
        let mut law = (*law).clone();
        if !found.is_empty() {
            let tempos = spliced(found, law.planned);
            law.set_tempos(tempos);
        }
        law
    }
}

/// The tempos of consecutive regions, with even ones in the gaps up to `end`.
fn spliced(regions: Vec<Vec<Tempo>>, end: f64) -> Vec<Tempo> {
    let mut tempos: Vec<Tempo> = Vec::new();
    let (mut p, mut time) = (0.0, 0.0);
    for region in regions {
        let Some(first) = region.first() else { continue };
        if first.begin > p {
            tempos.push(Tempo::even(p, first.begin - p, time));
            time += first.begin - p;
        }
        for tempo in region {
            tempos.push(Tempo { time, ..tempo });
            time += tempo.duration;
            p = tempo.begin + tempo.length;
        }
    }
    if end > p {
        tempos.push(Tempo::even(p, end - p, time));
    }
    tempos
}
