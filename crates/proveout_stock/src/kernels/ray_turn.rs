//! Sweep of any convex body whose tip moves while its axis turns.
//!
//! At one time tau the ray meets the convex body in an interval, found by Newton's method on the convex
//! function s -> F(tau, s) from outside (it cannot overshoot), or not at all, and then two samples left and
//! right of the minimum prove the gap. What is wanted is the union over tau.
//!
//! A supporting half space of the body at one time bounds F at other times too. In the frame of the body a
//! point of the ray moves on q(tau, s) = R(tau)^T (p + s e - tip(tau)). With the normal n of a sample at
//! (tau0, s0), carried along with the body, y = x - tip, the angular velocity w and the travel d of the
//! piece,
//!
//! ```text
//!     n . q_tautau = (w . n)(w . y) - w^2 (n . y) - 2 (w x n) . d  = B
//!     n . q_taus   = (w x n) . e                                   = C          q_ss = 0
//!     |q_tautautau| <= w^3 L + 3 w^2 |d|  = 6 D                    |q_tautaus| <= w^2   L: reach of the body
//! ```
//!
//! F is convex with a unit gradient, so with dtau and ds counted from the sample
//!
//! ```text
//!     F(tau, s) >= F0 + F_tau dtau + F_s ds + B dtau^2 / 2 - |C dtau ds|
//!                  - w^2 dtau^2 |ds| / 2 - D |dtau|^3                        (1)
//!
//!     s ^                               The ends of the range give intervals (bars) and half planes (lines).
//!       |         .x.                   Above the hull H of the bars only the triangle below x is not proven
//!     H |- - - -.- - -.- - - -          free. It is no deeper in the body than (1) says at the crossing; too
//!       |  |  .         '.   |          deep: sample at the time of the crossing, extend H, go on in both
//!       |  |.             '. |          parts.
//!       +--[----------------]---> tau
//! ```
//!
//! The crossing of the two tangents is where normal . velocity changes its sign, the envelope. Since (1)
//! holds for every convex body and needs nothing about what happens between the samples, the result is
//! proven: what is missed lies less than [`SEARCH_ERROR`] + [`TURN_ERROR`] deep in the swept body. Intervals
//! at the ends of a range that do not overlap may have material between them (a thin neck), so such a range
//! is split first. When no point of the body moves further than [`TURN_ERROR`] in a range, nothing deeper can
//! be missed and what lies between two intervals is within it of the body; that ends every splitting.

use crate::{
    field::span::SLIVER,
    kernels::meridian::Meridian,
    kernels::motion::{BodySample, MotionPiece, SEARCH_ERROR, TURN_ERROR},
    kernels::ray::{REACHED, RayLine, TakenEnd, TakenInterval},
    kernels::vec3::{V, add, cross, dot, norm, scale, sub},
};

/// Slope of F outward along the ray from which on nothing of the body is beyond a place outside of it.
const RISES: f64 = 1e-3;

/// An end of the interval at one time, or a point outside of it with the half plane there.
#[derive(Clone, Copy, Debug)]
struct SweepEdge {
    s: f64,
    tau: f64,
    sample: BodySample,
}

/// The ray at one time.
#[derive(Clone, Copy, Debug)]
enum RayState {
    /// The ends of the interval; after a mere look at the ends of the hull, what was found there.
    Meets { lo: SweepEdge, hi: SweepEdge },
    /// A half plane that is parallel to the ray and shuts the body off it.
    Misses(HalfPlaneBound),
}

/// Half plane at an end of the hull: what (1) needs.
#[derive(Clone, Copy, Debug)]
struct HalfPlaneBound {
    value: f64,
    ft: f64,
    /// Growth outward along the ray; infinite for a half plane that covers the whole ray.
    outward: f64,
    /// B and |C|.
    second: f64,
    cross: f64,
    /// Length of the ray that it covers, where it does not grow outward.
    ds: f64,
}

impl HalfPlaneBound {
    /// Right side of (1) at a time.
    fn at(&self, dtau: f64) -> f64 {
        self.value + self.ft * dtau + 0.5 * self.second * dtau * dtau
    }

    /// Least right side of (1) from the sample to a time: on its way the parabola hangs at most B dtau^2 / 8
    /// below its chord.
    fn least(&self, dtau: f64, angle2: f64, third: f64) -> f64 {
        let square = dtau * dtau;
        self.value.min(self.at(dtau))
            - 0.125 * self.second.max(0.0) * square
            - dtau.abs() * (self.cross * self.ds + third * square)
            - 0.5 * angle2 * square * self.ds
    }
}

/// Steps of one search; reached only by rays within rounding of grazing.
const STEPS: usize = 60;
/// Splittings of a time range: 2^-33 of a piece at least.
const DEPTH: u32 = 100;

pub(crate) struct TurnSweep<'a> {
    piece: &'a MotionPiece,
    body: &'a Meridian,
    ray: &'a RayLine,
    angle: f64,
    /// D of (1).
    third: f64,
    /// Bound of the way of any body point in the whole piece, mm.
    way: f64,
    /// Bound of the length of the interval, mm.
    chord: f64,
}

/// Adds to `taken` the intervals that the body takes up on the ray on its way, in no order; they may overlap.
pub(crate) fn sweep_turning(piece: &MotionPiece, body: &Meridian, ray: &RayLine, taken: &mut Vec<TakenInterval>) {
    let reach = body.reach;
    let angle = piece.angle2.sqrt();
    let sweep = TurnSweep {
        piece,
        body,
        ray,
        angle,
        third: piece.angle2 * (angle * reach + 3.0 * norm(piece.travel)) / 6.0,
        way: norm(piece.travel) + angle * reach,
        chord: (ray.hi - ray.lo).min(2.0 * body.radius.hypot(0.5 * (body.z[1] - body.z[0]))),
    };
    // One sample in the middle proves most misses.
    let s = piece.facing(body, ray.at(0.5 * (ray.lo + ray.hi))).clamp(ray.lo, ray.hi);
    let first = piece.sample(body, ray.at(s), 0.5);
    if first.f > REACHED {
        let nearest = if first.fs > 0.0 { ray.lo } else { ray.hi };
        let most = (s - ray.lo).max(ray.hi - s);
        let second = 0.5 * angle * most + piece.bend(reach) / 8.0;
        if first.f + first.fs * (nearest - s) - 0.5 * first.ft.abs() - second > REACHED {
            return;
        }
    }
    let states = [sweep.state(0.0), sweep.state(1.0)];
    sweep.cover([0.0, 1.0], states, DEPTH, taken);
}

impl TurnSweep<'_> {
    fn sample(&self, tau: f64, s: f64) -> BodySample {
        self.piece.sample(self.body, self.ray.at(s), tau)
    }

    /// Half space with a normal, known to have a value at the height `s`, as (1) needs it there. All terms
    /// are linear in the normal, so a mean of two samples may be given.
    fn bound_at(&self, tau: f64, s: f64, normal: V, value: f64) -> HalfPlaneBound {
        let axis = self.piece.axis_at(tau);
        let omega = cross(axis, self.piece.turn);
        let y = sub(self.ray.at(s), self.piece.tip_at(tau));
        let carried = cross(omega, normal);
        let ft = dot(carried, y) - dot(normal, self.piece.travel);
        let second = dot(omega, normal) * dot(omega, y)
            - self.piece.angle2 * dot(normal, y)
            - 2.0 * dot(carried, self.piece.travel);
        HalfPlaneBound { value, ft, outward: f64::INFINITY, second, cross: carried[0].abs(), ds: 0.0 }
    }

    /// Newton's method from outside (`sign` 1: downward from above) to the edge; the last sample outside when
    /// the body is not met.
    fn newton(&self, tau: f64, start: f64, sign: f64) -> Result<SweepEdge, (f64, BodySample)> {
        let end = if sign > 0.0 { self.ray.lo } else { self.ray.hi };
        let mut s = start;
        let mut outside = None;
        for _ in 0..STEPS {
            let sample = self.sample(tau, s);
            if sample.f <= REACHED {
                return Ok(SweepEdge { s, tau, sample });
            }
            if sample.fs * sign <= 0.0 {
                return Err(outside.unwrap_or((s, sample)));
            }
            outside = Some((s, sample));
            s -= sample.f / sample.fs;
            if (s - end) * sign < 0.0 {
                break;
            }
        }
        Err(outside.unwrap_or_else(|| (s, self.sample(tau, s))))
    }

    /// The interval at one time, or the proof that there is none.
    fn state(&self, tau: f64) -> RayState {
        match self.newton(tau, self.ray.hi, 1.0) {
            Ok(hi) => {
                // Rounding at a grazing ray may hide the other edge; the one that was found is then all there
                // is.
                let lo = self.newton(tau, self.ray.lo, -1.0).unwrap_or(hi);
                RayState::Meets { lo, hi }
            }
            Err(above) => self.gap(tau, above),
        }
    }

    /// Minimum of F along the ray from samples on both sides of it (cutting planes in one dimension).
    fn gap(&self, tau: f64, above: (f64, BodySample)) -> RayState {
        let (mut sr, mut right) = above;
        if right.fs <= 0.0 {
            return self.misses(tau, sr, right.f, right.normal);
        }
        let (mut sl, mut left) = (self.ray.lo, self.sample(tau, self.ray.lo));
        if left.fs >= 0.0 {
            return self.misses(tau, sl, left.f, left.normal);
        }
        for _ in 0..STEPS {
            // Both tangents bound F from below; where they cross the bound is least.
            let k = right.fs / (right.fs - left.fs);
            let s = (left.fs * sl - right.fs * sr + right.f - left.f) / (left.fs - right.fs);
            let bound = left.f + left.fs * (s - sl);
            if bound > REACHED || s <= sl || s >= sr {
                let normal = add(scale(left.normal, k), scale(right.normal, 1.0 - k));
                return self.misses(tau, s, bound, normal);
            }
            let sample = self.sample(tau, s);
            if sample.f <= REACHED {
                let point = SweepEdge { s, tau, sample };
                let lo = self.newton(tau, sl, -1.0).unwrap_or(point);
                let hi = self.newton(tau, sr, 1.0).unwrap_or(point);
                return RayState::Meets { lo, hi };
            }
            if sample.fs > 0.0 {
                (sr, right) = (s, sample);
            } else {
                (sl, left) = (s, sample);
            }
        }
        self.misses(tau, sr, 0.0, right.normal)
    }

    fn misses(&self, tau: f64, s: f64, gap: f64, normal: V) -> RayState {
        // The body may come in anywhere within its own length from where it is nearest now.
        RayState::Misses(HalfPlaneBound {
            ds: self.chord + self.way + gap.max(0.0),
            ..self.bound_at(tau, s, normal, gap.max(0.0))
        })
    }

    fn push(&self, taken: &mut Vec<TakenInterval>, hull: Option<(SweepEdge, SweepEdge)>) {
        if let Some((lo, hi)) = hull
            && hi.s - lo.s > SLIVER
        {
            taken.push(TakenInterval { lo: TakenEnd { s: lo.s, tau: lo.tau }, hi: TakenEnd { s: hi.s, tau: hi.tau } });
        }
    }

    /// Finds the intervals of a time range from the states at its ends.
    fn cover(&self, t: [f64; 2], states: [RayState; 2], depth: u32, taken: &mut Vec<TakenInterval>) {
        let still = depth == 0 || self.way * (t[1] - t[0]) <= TURN_ERROR;
        let mut hull = match states {
            [RayState::Meets { lo: lo0, hi: hi0 }, RayState::Meets { lo: lo1, hi: hi1 }] => {
                if lo0.s.max(lo1.s) > hi0.s.min(hi1.s) + SLIVER && !still {
                    let middle = 0.5 * (t[0] + t[1]);
                    let state = self.state(middle);
                    self.cover([t[0], middle], [states[0], state], depth - 1, taken);
                    self.cover([middle, t[1]], [state, states[1]], depth - 1, taken);
                    return;
                }
                Some((if lo0.s < lo1.s { lo0 } else { lo1 }, if hi0.s > hi1.s { hi0 } else { hi1 }))
            }
            [RayState::Meets { lo, hi }, _] | [_, RayState::Meets { lo, hi }] => Some((lo, hi)),
            _ => None,
        };
        self.extend(t, states, &mut hull, depth, taken);
        self.push(taken, hull);
    }

    /// Extends the hull until nothing outside of it is missed in the time range.
    fn extend(
        &self,
        t: [f64; 2],
        states: [RayState; 2],
        hull: &mut Option<(SweepEdge, SweepEdge)>,
        depth: u32,
        taken: &mut Vec<TakenInterval>,
    ) {
        let h = t[1] - t[0];
        if depth == 0 || self.way * h <= TURN_ERROR {
            return;
        }
        let open = match hull {
            None => self.open_at(h, states.map(|s| self.bound(&s, 0.0, 0.0))),
            Some((lo, hi)) => {
                let up = (hi.s < self.ray.hi).then(|| self.open_at(h, states.map(|s| self.bound(&s, hi.s, 1.0))));
                let down = (lo.s > self.ray.lo).then(|| self.open_at(h, states.map(|s| self.bound(&s, lo.s, -1.0))));
                match (up.flatten(), down.flatten()) {
                    (Some(a), Some(b)) => Some(if a.depth > b.depth { a } else { b }),
                    (a, b) => a.or(b),
                }
            }
        };
        let Some(open) = open else { return };
        // Between a miss and a hit, where the gap closes: from outside, as Newton's method on a convex
        // function does. Every third time the middle, which ends the splitting whatever the shape.
        let at = match states {
            _ if depth.is_multiple_of(3) => 0.5 * h,
            [RayState::Misses(gap), RayState::Meets { .. }] if gap.ft < 0.0 => (gap.value + TURN_ERROR) / -gap.ft,
            [RayState::Meets { .. }, RayState::Misses(gap)] if gap.ft > 0.0 => h - (gap.value + TURN_ERROR) / gap.ft,
            _ => open.at,
        };
        let tau = t[0] + at.clamp(0.02 * h, 0.98 * h);
        let looked = hull.as_mut().and_then(|hull| self.extend_hull(tau, hull, h, open.depth));
        let state = looked.unwrap_or_else(|| self.state(tau));
        if let (RayState::Meets { lo, hi }, None) = (state, looked) {
            match hull {
                None => *hull = Some((lo, hi)),
                Some((low, high)) if lo.s <= high.s + SLIVER && hi.s >= low.s - SLIVER => {
                    if lo.s < low.s {
                        *low = lo;
                    }
                    if hi.s > high.s {
                        *high = hi;
                    }
                }
                Some(_) => {
                    let [before, after] = t.map(|t| self.state(t));
                    self.cover([t[0], tau], [before, state], depth - 1, taken);
                    self.cover([tau, t[1]], [state, after], depth - 1, taken);
                    return;
                }
            }
        }
        self.extend([t[0], tau], [states[0], state], hull, depth - 1, taken);
        self.extend([tau, t[1]], [state, states[1]], hull, depth - 1, taken);
    }

    /// Samples at the ends of the hull and moves them outward where the body reaches further; none
    /// if the body is apart from the hull or grazes the ray, and the whole ray must be searched.
    fn extend_hull(&self, tau: f64, hull: &mut (SweepEdge, SweepEdge), h: f64, depth: f64) -> Option<RayState> {
        let lo = self.extend_end(tau, &hull.0, -1.0, h, depth)?;
        let hi = self.extend_end(tau, &hull.1, 1.0, h, depth)?;
        if lo.s < hull.0.s {
            hull.0 = lo;
        }
        if hi.s > hull.1.s {
            hull.1 = hi;
        }
        Some(RayState::Meets { lo, hi })
    }

    fn extend_end(&self, tau: f64, end: &SweepEdge, sign: f64, h: f64, depth: f64) -> Option<SweepEdge> {
        let limit = if sign > 0.0 { self.ray.hi } else { self.ray.lo };
        if (end.s - limit) * sign >= 0.0 {
            return Some(SweepEdge { tau, ..*end });
        }
        let sample = self.sample(tau, end.s);
        if sample.f > REACHED {
            let falls = sample.fs * sign < (self.angle * h).max(RISES);
            return if falls { None } else { Some(SweepEdge { s: end.s, tau, sample }) };
        }
        let guess = end.s + sign * (1.5 * depth / end.sample.fs.abs().max(0.05) + SLIVER);
        let start = if (guess - limit) * sign < 0.0 { guess } else { limit };
        match self.newton(tau, start, sign) {
            Ok(edge) if edge.s == start && start != limit => self.newton(tau, limit, sign).ok(),
            found => found.ok(),
        }
    }

    /// What a state says about F at the height `s` and further outward (`sign` 1: up; 0: everywhere).
    fn bound(&self, state: &RayState, s: f64, sign: f64) -> HalfPlaneBound {
        match state {
            RayState::Misses(bound) => *bound,
            RayState::Meets { lo, hi } => {
                let edge = if sign > 0.0 { hi } else { lo };
                let value = edge.sample.f.max(0.0) + edge.sample.fs * (s - edge.s);
                HalfPlaneBound {
                    outward: edge.sample.fs * sign,
                    ..self.bound_at(edge.tau, s, edge.sample.normal, value)
                }
            }
        }
    }

    /// None when two bounds at the ends of a time range of length `h` prove that nothing is missed; else
    /// where to look.
    fn open_at(&self, h: f64, [a, b]: [HalfPlaneBound; 2]) -> Option<DoubtfulTime> {
        // Further outward (1) must not fall.
        let turned = 0.5 * self.piece.angle2 * h * h;
        if a.outward < a.cross * h + turned || b.outward < b.cross * h + turned {
            return Some(DoubtfulTime { at: 0.5 * h, depth: SEARCH_ERROR });
        }
        // Lines a(x) = value + ft x and b(x) = value - ft (h - x), x from 0 to h.
        let b0 = b.value - b.ft * h;
        let x = if a.ft < b.ft { ((b0 - a.value) / (a.ft - b.ft)).clamp(0.0, h) } else { 0.5 * h };
        let least = |bound: &HalfPlaneBound, dtau: f64| bound.least(dtau, self.piece.angle2, self.third);
        let (left, right) = (least(&a, x), least(&b, x - h));
        // One bound alone may cover all of the range.
        let alone = least(&a, h).max(least(&b, -h));
        let proven = left.min(right).max(alone);
        (proven < -(SEARCH_ERROR + TURN_ERROR)).then_some(DoubtfulTime { at: x, depth: -proven })
    }
}

/// Where in a time range something may be missed, and how deep at most, mm.
#[derive(Clone, Copy)]
struct DoubtfulTime {
    at: f64,
    depth: f64,
}
