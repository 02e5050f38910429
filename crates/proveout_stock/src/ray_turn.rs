//! Sweep of any convex body whose tip moves while its axis turns.
//!
//! At one time tau the ray meets the convex body in an interval, found by Newton's method on the convex function
//! s -> F(tau, s) from outside (it cannot overshoot), or not at all, and then two samples left and right of the minimum prove
//! the gap. What is wanted is the union over tau.
//!
//! A supporting half space of the body at one time bounds F at other times too. In the frame of the body a point of the
//! ray moves on q(tau, s) = R(tau)^T (p + s e - tip(tau)), whose second derivatives are
//!
//! ```text
//!     |q_tautau| <= A = w^2 L + 2 w |d|        |q_taus| <= w        q_ss = 0
//! ```
//!
//! with the angle w and travel d of the piece and the reach L of the body. F is convex with a unit gradient, so from a sample
//! at (tau0, s0), with dtau and ds counted from there,
//!
//! ```text
//!     F(tau, s) >= F0 + F_tau dtau + F_s ds - w |dtau| |ds| - A dtau^2 / 2                                       (1)
//!
//!     s ^                                  The ends of the range give intervals (bars) and half planes (lines).
//!       |         .x.                      Above the hull H of the bars only the triangle below x is not proven
//!     H |- - - -.- - -.- - - -             free. It is no deeper in the body than (1) says at the crossing; too
//!       |  |  .         '.   |             deep: sample at the time of the crossing, extend H, go on in both parts.
//!       |  |.             '. |
//!       +--[----------------]---> tau
//! ```
//!
//! The crossing of the two tangents is where normal . velocity changes its sign, the envelope. Since (1) holds for every
//! convex body and needs nothing about what happens between the samples, the result is proven: what is missed lies less than
//! [`SEARCH_ERROR`] + [`TURN_ERROR`] deep in the swept body. Intervals at the ends of a range that do not overlap may have
//! material between them (a thin neck), so such a range is split first. When no point of the body moves further than
//! [`TURN_ERROR`] in a range, nothing deeper can be missed and what lies between two intervals is within it of the body;
//! that ends every splitting.

use crate::{
    meridian::Meridian,
    motion::{Piece, SEARCH_ERROR, Sample, TURN_ERROR},
    ray::{End, REACHED, Ray, Taken, swept_normal},
    span::SLIVER,
    vec3::norm,
};

/// One end of the interval at one time.
#[derive(Clone, Copy, Debug)]
struct Edge {
    s: f64,
    tau: f64,
    sample: Sample,
}

/// The ray at one time.
#[derive(Clone, Copy, Debug)]
enum State {
    Meets {
        lo: Edge,
        hi: Edge,
    },
    /// F is at least `gap + ft dtau` all along the ray, but for the terms of second order.
    Misses {
        gap: f64,
        ft: f64,
    },
}

/// Half plane above an end of the hull: value at the hull's end, its growth with time and outward along the ray, and the
/// length ds of (1).
struct Bound {
    value: f64,
    ft: f64,
    outward: f64,
    ds: f64,
}

/// Steps of one search; reached only by rays within rounding of grazing.
const STEPS: usize = 60;
/// Splittings of a time range.
const DEPTH: u32 = 40;

pub(crate) struct TurnSweep<'a> {
    piece: &'a Piece,
    body: &'a Meridian,
    ray: &'a Ray,
    angle: f64,
    bend: f64,
    /// Bound of the way of any body point in the whole piece, mm.
    way: f64,
    /// Bound of the length of the interval, mm.
    chord: f64,
}

/// Adds to `taken` the intervals that the body takes up on the ray on its way, in no order; they may overlap.
pub(crate) fn sweep_turning(piece: &Piece, body: &Meridian, ray: &Ray, taken: &mut Vec<Taken>) {
    let reach = body.reach;
    let angle = piece.angle2.sqrt();
    let sweep = TurnSweep {
        piece,
        body,
        ray,
        angle,
        bend: piece.bend(reach),
        way: norm(piece.travel) + angle * reach,
        chord: (ray.hi - ray.lo).min(2.0 * body.radius.hypot(0.5 * (body.z[1] - body.z[0]))),
    };
    // One sample in the middle proves most misses.
    let middle = piece.tip_at(0.5)[0] + 0.5 * (body.z[0] + body.z[1]) * piece.axis[0];
    let s = middle.clamp(ray.lo, ray.hi);
    let first = piece.sample(body, ray.at(s), 0.5);
    if first.f > REACHED {
        let nearest = if first.fs > 0.0 { ray.lo } else { ray.hi };
        let most = (s - ray.lo).max(ray.hi - s);
        if first.f + first.fs * (nearest - s) - 0.5 * first.ft.abs() - sweep.second_order(0.5, most) > REACHED {
            return;
        }
    }
    let states = [sweep.state(0.0), sweep.state(1.0)];
    sweep.cover([0.0, 1.0], states, DEPTH, taken);
}

impl TurnSweep<'_> {
    /// The last two terms of (1).
    fn second_order(&self, dtau: f64, ds: f64) -> f64 {
        self.angle * dtau * ds + 0.5 * self.bend * dtau * dtau
    }

    fn sample(&self, tau: f64, s: f64) -> Sample {
        self.piece.sample(self.body, self.ray.at(s), tau)
    }

    /// Newton's method from outside (`sign` 1: downward from above) to the edge; the last sample outside when the body
    /// is not met.
    fn newton(&self, tau: f64, start: f64, sign: f64) -> Result<Edge, (f64, Sample)> {
        let end = if sign > 0.0 { self.ray.lo } else { self.ray.hi };
        let mut s = start;
        let mut outside = None;
        for _ in 0..STEPS {
            let sample = self.sample(tau, s);
            if sample.f <= REACHED {
                return Ok(Edge { s, tau, sample });
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
    fn state(&self, tau: f64) -> State {
        match self.newton(tau, self.ray.hi, 1.0) {
            Ok(hi) => {
                // Rounding at a grazing ray may hide the other edge; the one that was found is then all there is.
                let lo = self.newton(tau, self.ray.lo, -1.0).unwrap_or(hi);
                State::Meets { lo, hi }
            }
            Err(above) => self.gap(tau, above),
        }
    }

    /// Minimum of F along the ray from samples on both sides of it (cutting planes in one dimension).
    fn gap(&self, tau: f64, above: (f64, Sample)) -> State {
        let (mut sr, mut right) = above;
        if right.fs <= 0.0 {
            return State::Misses { gap: right.f, ft: right.ft };
        }
        let (mut sl, mut left) = (self.ray.lo, self.sample(tau, self.ray.lo));
        if left.fs >= 0.0 {
            return State::Misses { gap: left.f.max(0.0), ft: left.ft };
        }
        for _ in 0..STEPS {
            // Both tangents bound F from below; where they cross the bound is least.
            let k = right.fs / (right.fs - left.fs);
            let s = (left.fs * sl - right.fs * sr + right.f - left.f) / (left.fs - right.fs);
            let bound = left.f + left.fs * (s - sl);
            if bound > REACHED || s <= sl || s >= sr {
                return State::Misses { gap: bound.max(0.0), ft: k * left.ft + (1.0 - k) * right.ft };
            }
            let sample = self.sample(tau, s);
            if sample.f <= REACHED {
                let point = Edge { s, tau, sample };
                let lo = self.newton(tau, sl, -1.0).unwrap_or(point);
                let hi = self.newton(tau, sr, 1.0).unwrap_or(point);
                return State::Meets { lo, hi };
            }
            if sample.fs > 0.0 {
                (sr, right) = (s, sample);
            } else {
                (sl, left) = (s, sample);
            }
        }
        State::Misses { gap: 0.0, ft: 0.0 }
    }

    fn push(&self, taken: &mut Vec<Taken>, hull: Option<(Edge, Edge)>) {
        if let Some((lo, hi)) = hull
            && hi.s - lo.s > SLIVER
        {
            let end = |e: &Edge, sign: f64| {
                let inner = e.s < self.ray.hi && e.s > self.ray.lo;
                let at = (e.s, e.tau);
                let normal = if inner {
                    swept_normal(self.piece, self.body, self.ray, at, sign, &e.sample, self.way)
                } else {
                    e.sample.normal
                };
                End { s: e.s, normal }
            };
            taken.push(Taken { lo: end(&lo, -1.0), hi: end(&hi, 1.0) });
        }
    }

    /// Finds the intervals of a time range from the states at its ends.
    fn cover(&self, t: [f64; 2], states: [State; 2], depth: u32, taken: &mut Vec<Taken>) {
        let still = depth == 0 || self.way * (t[1] - t[0]) <= TURN_ERROR;
        let mut hull = match states {
            [State::Meets { lo: lo0, hi: hi0 }, State::Meets { lo: lo1, hi: hi1 }] => {
                if lo0.s.max(lo1.s) > hi0.s.min(hi1.s) + SLIVER && !still {
                    let middle = 0.5 * (t[0] + t[1]);
                    let state = self.state(middle);
                    self.cover([t[0], middle], [states[0], state], depth - 1, taken);
                    self.cover([middle, t[1]], [state, states[1]], depth - 1, taken);
                    return;
                }
                Some((if lo0.s < lo1.s { lo0 } else { lo1 }, if hi0.s > hi1.s { hi0 } else { hi1 }))
            }
            [State::Meets { lo, hi }, _] | [_, State::Meets { lo, hi }] => Some((lo, hi)),
            _ => None,
        };
        self.extend(t, states, &mut hull, depth, taken);
        self.push(taken, hull);
    }

    /// Extends the hull until nothing outside of it is missed in the time range.
    fn extend(
        &self,
        t: [f64; 2],
        states: [State; 2],
        hull: &mut Option<(Edge, Edge)>,
        depth: u32,
        taken: &mut Vec<Taken>,
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
                up.flatten().or(down.flatten())
            }
        };
        let Some(at) = open else { return };
        let tau = t[0] + at.clamp(0.1 * h, 0.9 * h);
        let state = self.state(tau);
        if let State::Meets { lo, hi } = state {
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
                    self.cover([t[0], tau], [states[0], state], depth - 1, taken);
                    self.cover([tau, t[1]], [state, states[1]], depth - 1, taken);
                    return;
                }
            }
        }
        self.extend([t[0], tau], [states[0], state], hull, depth - 1, taken);
        self.extend([tau, t[1]], [state, states[1]], hull, depth - 1, taken);
    }

    /// What a state says about F at the height `s` and further outward (`sign` 1: up; 0: everywhere).
    fn bound(&self, state: &State, s: f64, sign: f64) -> Bound {
        match state {
            State::Misses { gap, ft } => Bound { value: *gap, ft: *ft, outward: f64::INFINITY, ds: self.chord },
            State::Meets { lo, hi } => {
                let edge = if sign > 0.0 { hi } else { lo };
                let ds = ((s - edge.s) * sign).max(0.0);
                let outward = edge.sample.fs * sign;
                Bound { value: outward * ds, ft: edge.sample.ft, outward, ds }
            }
        }
    }

    /// None when two bounds at the ends of a time range of length `h` prove that nothing is missed; else the time from its
    /// start at which to look.
    fn open_at(&self, h: f64, [a, b]: [Bound; 2]) -> Option<f64> {
        // Further outward (1) must not fall: F_s >= w dtau.
        if a.outward < self.angle * h || b.outward < self.angle * h {
            return Some(0.5 * h);
        }
        // Lines a(x) = value + ft x and b(x) = value - ft (h - x), x from 0 to h.
        let b0 = b.value - b.ft * h;
        let x = if a.ft < b.ft { ((b0 - a.value) / (a.ft - b.ft)).clamp(0.0, h) } else { 0.5 * h };
        let (a_x, b_x) = (a.value + a.ft * x, b0 + b.ft * x);
        let left = a.value.min(a_x) - self.second_order(x, a.ds);
        let right = b.value.min(b_x) - self.second_order(h - x, b.ds);
        if left.min(right) >= -(SEARCH_ERROR + TURN_ERROR) {
            return None;
        }
        // Where one bound alone covers all of the range.
        let alone = |p: &Bound, other_end: f64| p.value.min(other_end) - self.second_order(h, p.ds);
        let best = alone(&a, a.value + a.ft * h).max(alone(&b, b0));
        (best < -(SEARCH_ERROR + TURN_ERROR)).then_some(x)
    }
}
