//! How wide the corners of a run of lines are rounded: fitting of short blocks within the tolerances.
//!
//! The exact path x(s) of lines has kinks `m_i` (jumps of its slope) at `s_i`. The fitted path adds to it,
//! for each kink, what a moving average with a parabola of half width `d_i` as weight makes of it:
//!
//! ```text
//!   y(s) = x(s) + sum of m_i d_i e((s - s_i)/d_i)     e(t) = (3 - 8|t| + 6 t^2 - t^4)/16 for |t| < 1, else 0
//!   y''(s) = sum of m_i k((s - s_i)/d_i)/d_i          k(t) = 3/4 (1 - t^2)
//!
//!        x ____/\____        kinks far apart: each is a blend of its own, a polynomial of fourth degree
//!        y  _.-''''-._       kinks close together: the averages overlap, the curvature of the chords
//!          |<-d->|           becomes smooth
//! ```
//!
//! y has continuous curvature, breaks only at the 2 n places `s_i -+ d_i`, and keeps the parameter of the
//! exact path.
//!
//! *Tolerance.* e is not negative and convex on either side of its kink. So `S(s) = sum of |m_i| d_i e(..)`,
//! which bounds the deviation |y - x|, is convex on each block and highest at the borders of blocks: looked
//! at there, it is looked at everywhere. The half widths follow by rules that never go back:
//!
//! 1. `T_i`: the widest common half width with `S(s_i)` within the tolerance. d e(x/d) grows with d, so that
//!    narrower ones keep it too.
//! 2. `d_j <= max(T_i, |s_i - s_j|)` for all i: every kink that acts on `s_i` is no wider than `T_i`, hence
//!    `S(s_i)` holds.
//! 3. `d_j <= d_i + |s_i - s_j|`: supports begin and end in the order of the kinks. Then y' is a mean of the
//!    slopes of the blocks with weights that are not negative.
//!
//! Each rule only lowers, so none breaks another. A kink sees no more than [`NEIGHBORS`] others on either
//! side: what is decided depends on six times as many blocks ahead (`points.rs` goes on from here), never on
//! where a window of the look-ahead ends.
//!
//! *Points.* An average lies inside of a curve; `points.rs` moves the borders of short blocks outward before
//! they are averaged, so that y passes through the programmed points of a curve.
//!
//! *Limits.* S adds up sizes: kinks to and fro, which cancel in y, count fully, so that noisy points are
//! smoothed over less length than the tolerance would allow. Blocks that are no lines keep the blends of
//! `corner_rounding.rs`.

use std::collections::VecDeque;

use proveout_machine::JointValues;

use super::{Tolerance, points::Point};

/// Kinks to either side that act on one.
pub(super) const NEIGHBORS: usize = 16;

/// A corner between two lines.
#[derive(Clone, Debug)]
pub(super) struct Kink {
    /// Running number of the block before it.
    pub(super) number: u64,
    pub(super) s: f64,
    /// Slope of the block before it.
    pub(super) before: JointValues,
    /// Jump of the slope, and its size: tip or linear joints, and rotary joints.
    pub(super) slope: JointValues,
    pub(super) size: Tolerance,
    /// Half width that is asked for; infinite where the slope does not jump.
    pub(super) wanted: f64,
    /// The tighter one of the blocks on both sides.
    pub(super) tolerance: Tolerance,
    /// Both blocks are short and the kink is small: chords of a curve.
    pub(super) short: bool,
    /// `T_i`, then what rules 1 and 2 leave, then what rule 3 leaves.
    common: f64,
    free: f64,
    pub(super) half_width: f64,
    /// What is done with its point.
    pub(super) point: Point,
}

impl Kink {
    pub(super) fn new(
        (number, s): (u64, f64),
        [before, slope]: [JointValues; 2],
        size: Tolerance,
        wanted: f64,
        (tolerance, short): (Tolerance, bool),
    ) -> Self {
        Self {
            number,
            s,
            before,
            slope,
            size,
            wanted,
            tolerance,
            short,
            common: 0.0,
            free: 0.0,
            half_width: 0.0,
            point: Point::default(),
        }
    }

    pub(super) fn begin(&self) -> f64 {
        self.s - self.half_width
    }

    pub(super) fn end(&self) -> f64 {
        self.s + self.half_width
    }

    pub(super) fn half_width(&self) -> f64 {
        self.half_width
    }

    /// The slope does not jump, and the point is not moved against its neighbors.
    pub(super) fn is_flat(&self) -> bool {
        self.wanted == f64::INFINITY && self.point.bend == JointValues::ZERO
    }

    /// Slopes of the blocks on both sides with their points moved.
    pub(super) fn slopes(&self) -> [JointValues; 2] {
        let before = self.before + self.point.lean;
        [before, before + self.kink()]
    }

    /// The jump between them.
    pub(super) fn kink(&self) -> JointValues {
        self.slope + self.point.bend
    }
}

/// d e(x/d).
pub(super) fn lift(x: f64, d: f64) -> f64 {
    let t = (x / d).abs();
    if t < 1.0 { d * (3.0 - t * (8.0 - t * (6.0 - t * t))) / 16.0 } else { 0.0 }
}

/// Value, slope and half of the second derivative of d e(x/d) by x, counted from the kink; with
/// `behind` the block comes after it.
pub(super) fn lift_jet(x: f64, d: f64, behind: bool) -> [f64; 3] {
    let t = (x / d).abs();
    if t >= 1.0 {
        return [0.0; 3];
    }
    let slope = (-8.0 + t * (12.0 - 4.0 * t * t)) / 16.0;
    [lift(x, d), if behind { slope } else { -slope }, 0.375 * (1.0 - t * t) / d]
}

/// Kinks of the run of lines under way, in the order of the path.
#[derive(Debug, Default)]
pub(super) struct Fit {
    pub(super) kinks: VecDeque<Kink>,
    /// Where the first support may begin.
    pub(super) low: f64,
    /// Number of kinks, from the front, for which each of the three steps is done.
    common: usize,
    free: usize,
    pub(super) settled: usize,
    /// The same for the steps of `points.rs`.
    pub(super) points: [usize; 5],
    /// Number of kinks whose begin, middle, end and deviation have been seen.
    begun: usize,
    passed: usize,
    ended: usize,
    measured: usize,
    /// Bounds of the deviation at the last one that was measured: by sizes, and as it is.
    last_bounds: Option<[f64; 2]>,
}

/// A place of the path that means something to a kink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    pub(super) s: f64,
    pub(super) half_width: f64,
    pub(super) kind: EventKind,
    pub(super) flat: bool,
}

/// What happens there, in the order in which places that coincide are seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum EventKind {
    /// The support ends.
    End,
    /// The border of two blocks.
    Border,
    /// The support begins.
    Begin,
}

impl Fit {
    /// A run whose supports begin at `low` or later.
    pub(super) fn from(low: f64) -> Self {
        Self { low, ..Self::default() }
    }

    pub(super) fn push(&mut self, kink: Kink) {
        self.kinks.push_back(kink);
    }

    pub(super) fn kinks(&self) -> &VecDeque<Kink> {
        &self.kinks
    }

    /// Decides half widths and points as far as the known kinks allow; all of them where the end of the run
    /// is given.
    pub(super) fn settle(&mut self, high: Option<f64>, size: &dyn Fn(&JointValues) -> Tolerance) {
        let n = self.kinks.len();
        let ready = |known: usize| if high.is_some() { known } else { known.saturating_sub(NEIGHBORS) };
        while self.common < ready(n) {
            let i = self.common;
            let most = self.near(i).map(|k| self.kinks[k].wanted).filter(|w| w.is_finite()).fold(0.0, f64::max);
            self.kinks[i].common = self.widest(i, most.min(self.room(i, high)));
            self.common += 1;
        }
        while self.free < ready(self.common) {
            let j = self.free;
            let mut d = self.kinks[j].wanted.min(self.room(j, high));
            for i in self.near(j) {
                let other = &self.kinks[i];
                d = d.min(other.common.max((other.s - self.kinks[j].s).abs()));
            }
            self.kinks[j].free = d;
            self.free += 1;
        }
        while self.settled < ready(self.free) {
            let j = self.settled;
            let s = self.kinks[j].s;
            self.kinks[j].half_width =
                self.near(j).map(|i| self.kinks[i].free + (self.kinks[i].s - s).abs()).fold(f64::INFINITY, f64::min);
            self.settled += 1;
        }
        self.place_points(high.is_some(), size);
    }

    /// Kinks whose half widths and points are decided.
    fn decided(&self) -> usize {
        self.points[self.points.len() - 1]
    }

    /// The kink of this number, if it is one of the run.
    pub(super) fn numbered(&self, number: Option<u64>) -> Option<&Kink> {
        let first = self.kinks.front()?.number;
        self.kinks.get(number?.checked_sub(first)? as usize)
    }

    pub(super) fn near(&self, i: usize) -> std::ops::Range<usize> {
        i.saturating_sub(NEIGHBORS)..(i + NEIGHBORS + 1).min(self.kinks.len())
    }

    /// Way to the kinks that are too far to act, or to the ends of the run.
    fn room(&self, i: usize, high: Option<f64>) -> f64 {
        let s = self.kinks[i].s;
        let before = i.checked_sub(NEIGHBORS).map_or(self.low, |k| self.kinks[k].s);
        let behind = self.kinks.get(i + NEIGHBORS).map_or(high.unwrap_or(s), |k| k.s);
        (s - before).min(behind - s)
    }

    /// Largest common half width up to `most` that keeps the tolerance at kink `i`.
    fn widest(&self, i: usize, most: f64) -> f64 {
        // S grows between the first and the second power of d: the second is tried first, the first is always
        // enough.
        const TRIES: u32 = 6;
        let mut d = most;
        for tries in 0.. {
            let used = self.used(i, |_| d);
            if used.is_nan() || used <= 1.0 || tries > 2 * TRIES {
                break;
            }
            d *= if tries < TRIES { (0.98 / used).sqrt() } else { 0.98 / used };
        }
        d
    }

    /// S at kink `i` as part of the tolerances.
    fn used(&self, i: usize, width: impl Fn(&Kink) -> f64) -> f64 {
        let here = &self.kinks[i];
        let (mut tip, mut angle) = (0.0, 0.0);
        for k in self.near(i) {
            let other = &self.kinks[k];
            let lift = lift(here.s - other.s, width(other));
            tip += other.size.tip * lift;
            angle += other.size.angle * lift;
        }
        (tip / here.tolerance.tip).max(angle / here.tolerance.angle)
    }

    /// Where the supports of all kinks that come or are not decided yet begin at the earliest.
    pub(super) fn known_to(&self) -> Option<f64> {
        self.decided().checked_sub(1).map(|last| self.kinks[last].begin())
    }

    /// The next place of a decided kink.
    pub(super) fn next_event(&self) -> Option<Event> {
        let at = |i: usize, kind: EventKind| {
            let k = (i < self.decided()).then(|| &self.kinks[i])?;
            let s = match kind {
                EventKind::Begin => k.begin(),
                EventKind::Border => k.s,
                EventKind::End => k.end(),
            };
            Some(Event { s, half_width: k.half_width, kind, flat: k.is_flat() })
        };
        // A border comes after its own begin, an end after its own border.
        let end = at(self.ended, EventKind::End).filter(|_| self.ended < self.passed);
        let border = at(self.passed, EventKind::Border).filter(|_| self.passed < self.begun);
        [end, border, at(self.begun, EventKind::Begin)]
            .into_iter()
            .flatten()
            .reduce(|first, next| if next.s < first.s { next } else { first })
    }

    pub(super) fn take(&mut self, event: Event) {
        match event.kind {
            EventKind::Begin => self.begun += 1,
            EventKind::Border => self.passed += 1,
            EventKind::End => self.ended += 1,
        }
    }

    /// Largest deviation of y from x up to kinks before s that have not been asked for, mm.
    pub(super) fn rounding(&mut self, s: f64, size: &dyn Fn(&JointValues) -> Tolerance) -> f64 {
        let mut worst = 0.0_f64;
        while self.measured < self.decided() && self.kinks[self.measured].s <= s {
            let i = self.measured;
            let bounds = self.bounds_at(i, size);
            let block = match self.last_bounds {
                Some(before) => {
                    let between = self.between(i, size);
                    bounds[0].max(before[0]).min(bounds[1].max(before[1]) + between)
                }
                None => bounds[0],
            };
            // After the last kink of a run the deviation only falls.
            let ends = i + 1 == self.kinks.len();
            worst = worst.max(block).max(if ends { bounds[0] } else { 0.0 });
            self.last_bounds = Some(bounds);
            self.measured += 1;
        }
        worst
    }

    /// Forgets kinks that act neither on the path after s nor on other kinks.
    pub(super) fn forget_before(&mut self, s: f64) {
        let needed = NEIGHBORS + 2;
        while self.measured > needed
            && self.decided() > needed
            && self.ended > 0
            && self.kinks.front().is_some_and(|k| k.end() <= s)
        {
            self.kinks.pop_front();
            self.common -= 1;
            self.free -= 1;
            self.settled -= 1;
            self.points.iter_mut().for_each(|count| *count -= 1);
            self.begun -= 1;
            self.passed -= 1;
            self.ended -= 1;
            self.measured -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn the_lift_has_the_closed_form_of_a_mean_with_a_parabola() {
        // Mean of |x|/2 with the weight 3/4 (1 - t^2) over d = 2, less |x|/2, by the midpoint rule.
        let d = 2.0;
        for x in [-1.9, -0.7, 0.0, 0.3, 1.4, 2.5] {
            let n = 40_000;
            let mean: f64 = (0..n)
                .map(|k| {
                    let t = (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
                    0.75 * (1.0 - t * t) * 0.5 * (x - d * t).abs() * 2.0 / f64::from(n)
                })
                .sum();
            assert!((mean - 0.5 * f64::abs(x) - lift(x, d)).abs() < 1e-8, "{x}");
            let h = 1e-5;
            let [value, slope, half_bend] = lift_jet(x, d, x > 0.0);
            if x != 0.0 {
                assert!((slope - (lift(x + h, d) - lift(x - h, d)) / (2.0 * h)).abs() < 1e-9);
                let bend = (lift(x + h, d) - 2.0 * value + lift(x - h, d)) / (h * h);
                assert!((2.0 * half_bend - bend).abs() < 1e-4);
            }
        }
    }

    /// Kinks of random sizes at random distances; what is decided piece by piece is what is decided at once,
    /// keeps the tolerance between all kinks too, and orders the supports.
    #[test]
    fn half_widths_keep_tolerance_and_order_and_do_not_hang_on_what_is_known_when() {
        for case in 0..60 {
            let mut seed = 77 + case;
            let tolerance = Tolerance { tip: 0.01, angle: 0.001 };
            let none = |_: &JointValues| Tolerance { tip: 0.0, angle: 0.0 };
            let (mut at_once, mut stream) = (Fit::from(0.0), Fit::from(0.0));
            let mut s = 0.0;
            let mut widths: Vec<(f64, f64, f64)> = Vec::new();
            let mut streamed = Vec::new();
            for number in 0..300 {
                s += 10_f64.powf(2.0 * random(&mut seed) - 1.5);
                let tip = 10_f64.powf(3.0 * random(&mut seed) - 3.0);
                let angle = 0.1 * tip * random(&mut seed);
                let wanted = 10_f64.powf(2.0 * random(&mut seed) - 1.0);
                let slopes = [JointValues::ZERO; 2];
                let kink = Kink::new((number, s), slopes, Tolerance { tip, angle }, wanted, (tolerance, false));
                at_once.push(kink.clone());
                stream.push(kink);
                stream.settle(None, &none);
                while streamed.len() < stream.settled {
                    streamed.push(stream.kinks[streamed.len()].half_width);
                }
            }
            let end = s + 0.3;
            at_once.settle(Some(end), &none);
            stream.settle(Some(end), &none);
            for (a, b) in at_once.kinks.iter().zip(&stream.kinks) {
                assert_eq!(a.half_width.to_bits(), b.half_width.to_bits());
                assert!(a.half_width > 0.0 && a.begin() >= 0.0 && a.end() <= end);
                widths.push((a.s, a.half_width, a.size.tip));
            }
            assert!(streamed.len() > 200);
            for (w, k) in streamed.iter().zip(&at_once.kinks) {
                assert_eq!(w.to_bits(), k.half_width.to_bits());
            }
            for w in widths.windows(2) {
                assert!(w[0].0 - w[0].1 <= w[1].0 - w[1].1 + 1e-12 && w[0].0 + w[0].1 <= w[1].0 + w[1].1 + 1e-12);
            }
            let mut highest = 0.0_f64;
            for k in 0..4000 {
                let x = end * f64::from(k) / 4000.0;
                let sum: f64 = widths.iter().map(|(s, d, m)| m * lift(x - s, *d)).sum();
                highest = highest.max(sum);
            }
            for (s, ..) in &widths {
                let sum: f64 = widths.iter().map(|(o, d, m)| m * lift(s - o, *d)).sum();
                highest = highest.max(sum);
            }
            assert!(highest <= tolerance.tip * (1.0 + 1e-12), "case {case}: {highest}");
            assert!(highest > 0.5 * tolerance.tip, "case {case}: the tolerance is hardly used: {highest}");
        }
    }
}
