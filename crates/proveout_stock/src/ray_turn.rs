//! Sweep of any convex body whose tip moves while its axis turns.
//!
//! At one time tau the ray meets the convex body in an interval [a(tau), b(tau)], found by Newton's method on the convex
//! function s -> F(tau, s) from outside (it cannot overshoot), or not at all, and then two samples left and right of the
//! minimum prove the gap. What is wanted is the union over tau.
//!
//! In the frame of the body a point of the ray moves on q(tau, s) = R(tau)^T (p + s e - tip(tau)). Turning bends this path:
//!
//! ```text
//!     |q_tautau| <= A = w^2 L + 2 w |d|        |q_taus| = w |e_perp| <= w
//! ```
//!
//! with the angle w and travel d of the piece and the reach L of the body. The second derivative of an end follows by
//! differentiating F(tau, b(tau)) = 0 twice; the Hessian of the convex F makes b concave, and only the bend works against it:
//!
//! ```text
//!     b'' <= (A + 2 w |b'|) / mu,        mu = |n . e|,  b' = -F_tau / F_s    (b' = 0: normal . velocity = 0, the envelope)
//!
//!     b ^        __                  slopes up and down: one maximum, bracketed by the two tangents; the search
//!       |    .-''  ''-.              goes on at their intersection until they bound the gain
//!       |  .'          '.
//!       +--[-------------]---> tau   both slopes the same way: a hidden maximum needs a slope below c h, and then
//!          0             h           rises at most c h^2 / 2 above the ends (c: the bound of b'');
//!                                     down, then up: at most c h^2 / 8
//! ```
//!
//! A time range is split in halves until one of these proofs holds to [`TURN_ERROR`] in the direction of the normal:
//!
//! 1. both ends of the range meet the ray and their intervals overlap: the union is connected; improve a and b as above;
//! 2. both meet it in disjoint intervals (a thin neck may stand between): split;
//! 3. one meets it: done when neither end grows towards the other side; else split;
//! 4. none meets it: done when the gaps, which shrink at most at their slope plus the bend, stay open; else split;
//! 5. no point of the body moves further than [`TURN_ERROR`] in the range: nothing deeper than that can be missed, and what
//!    lies between two intervals is within it of the body. This ends every splitting.
//!
//! In the bound of b'' mu is taken at the ends of the range; that it does not fall much inside of it is the one step that
//! is an estimate and no proof. The oracle test covers it.

use crate::{
    meridian::Meridian,
    motion::{Piece, SEARCH_ERROR, Sample, TURN_ERROR},
    ray::{End, REACHED, Ray, Taken},
    span::SLIVER,
    vec3::{V, norm},
};

/// One end of the interval at one time.
#[derive(Clone, Copy, Debug)]
struct Edge {
    s: f64,
    normal: V,
    /// ds/dtau.
    slope: f64,
    /// |normal . e|.
    mu: f64,
    /// At the end of the range of the material: there is nothing more to gain.
    full: bool,
}

/// The ray at one time.
#[derive(Clone, Copy, Debug)]
enum State {
    Meets {
        lo: Edge,
        hi: Edge,
    },
    /// F is at least `gap + slope dtau` along the ray, but for the bend.
    Misses {
        gap: f64,
        slope: f64,
    },
}

/// Steps of one search; reached only by rays within rounding of grazing.
const STEPS: usize = 60;
/// Halvings of a time range: 2^-24 of a piece.
const DEPTH: u32 = 24;

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
    let reach = body.reach();
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
        if first.f + first.fs * (nearest - s) - 0.5 * first.ft.abs() - sweep.margin(0.5, most) > REACHED {
            return;
        }
    }
    let states = [sweep.state(0.0), sweep.state(1.0)];
    sweep.cover([0.0, 1.0], states, DEPTH, taken);
}

impl TurnSweep<'_> {
    /// What the bend can take from a half space over the time `h` and the length `ds` of the ray.
    fn margin(&self, h: f64, ds: f64) -> f64 {
        self.angle * h * ds + 0.5 * self.bend * h * h
    }

    fn sample(&self, tau: f64, s: f64) -> Sample {
        self.piece.sample(self.body, self.ray.at(s), tau)
    }

    fn edge(s: f64, sample: &Sample, full: bool) -> Edge {
        let mu = sample.fs.abs();
        let slope = if mu > 1e-12 { -sample.ft / sample.fs } else { 0.0 };
        Edge { s, normal: sample.normal, slope, mu, full }
    }

    /// Newton's method from outside (`sign` 1: downward from above) to the edge; the last sample outside when the body
    /// is not met.
    fn newton(&self, tau: f64, start: f64, sign: f64) -> Result<Edge, (f64, Sample)> {
        let end = if sign > 0.0 { self.ray.lo } else { self.ray.hi };
        let mut s = start;
        let mut outside = (s, self.sample(tau, s));
        for step in 0..STEPS {
            let sample = self.sample(tau, s);
            if sample.f <= REACHED {
                return Ok(Self::edge(s, &sample, step == 0));
            }
            if sample.fs * sign <= 0.0 {
                return Err(if step == 0 { (s, sample) } else { outside });
            }
            outside = (s, sample);
            s -= sample.f / sample.fs;
            if (s - end) * sign < 0.0 {
                return Err(outside);
            }
        }
        Err(outside)
    }

    /// The interval at one time, or the proof that there is none.
    fn state(&self, tau: f64) -> State {
        match self.newton(tau, self.ray.hi, 1.0) {
            Ok(hi) => match self.newton(tau, self.ray.lo, -1.0) {
                Ok(lo) => State::Meets { lo, hi },
                // Rounding at a grazing ray: the edge that was found is all there is.
                Err(_) => State::Meets { lo: Edge { full: false, ..hi }, hi },
            },
            Err(above) => self.gap(tau, above),
        }
    }

    /// Minimum of F along the ray from samples on both sides of it (cutting planes in one dimension).
    fn gap(&self, tau: f64, above: (f64, Sample)) -> State {
        let (mut sr, mut right) = above;
        if right.fs <= 0.0 {
            return State::Misses { gap: right.f, slope: right.ft };
        }
        let (mut sl, mut left) = (self.ray.lo, self.sample(tau, self.ray.lo));
        if left.fs >= 0.0 {
            return State::Misses { gap: left.f.max(0.0), slope: left.ft };
        }
        for _ in 0..STEPS {
            // Both tangents bound F from below; at their intersection the bound is least.
            let k = right.fs / (right.fs - left.fs);
            let s = (left.fs * sl - right.fs * sr + right.f - left.f) / (left.fs - right.fs);
            let bound = left.f + left.fs * (s - sl);
            if bound > REACHED || s <= sl || s >= sr {
                return State::Misses { gap: bound.max(0.0), slope: k * left.ft + (1.0 - k) * right.ft };
            }
            let sample = self.sample(tau, s);
            if sample.f <= REACHED {
                let edges = (self.newton(tau, sl, -1.0), self.newton(tau, sr, 1.0));
                if let (Ok(lo), Ok(hi)) = edges {
                    return State::Meets { lo: Edge { full: false, ..lo }, hi: Edge { full: false, ..hi } };
                }
                let edge = Edge { full: false, ..Self::edge(s, &sample, false) };
                return State::Meets { lo: edge, hi: edge };
            }
            if sample.fs > 0.0 {
                (sr, right) = (s, sample);
            } else {
                (sl, left) = (s, sample);
            }
        }
        State::Misses { gap: 0.0, slope: 0.0 }
    }

    fn push(taken: &mut Vec<Taken>, lo: &Edge, hi: &Edge) {
        if hi.s - lo.s > SLIVER {
            let end = |e: &Edge| End { s: e.s, normal: e.normal };
            taken.push(Taken { lo: end(lo), hi: end(hi) });
        }
    }

    fn cover(&self, t: [f64; 2], states: [State; 2], depth: u32, taken: &mut Vec<Taken>) {
        let h = t[1] - t[0];
        let still = depth == 0 || self.way * h <= TURN_ERROR;
        let split = match states {
            [State::Meets { lo: lo0, hi: hi0 }, State::Meets { lo: lo1, hi: hi1 }] => {
                if lo0.s.max(lo1.s) > hi0.s.min(hi1.s) + SLIVER && !still {
                    true
                } else {
                    let hi = self.best(t, [hi0, hi1], 1.0, still);
                    let lo = self.best(t, [lo0, lo1], -1.0, still);
                    if let (Some(hi), Some(lo)) = (hi, lo) {
                        Self::push(taken, &lo, &hi);
                        return;
                    }
                    true
                }
            }
            [State::Meets { lo, hi }, State::Misses { .. }] => {
                Self::push(taken, &lo, &hi);
                !still && (self.grows(&hi, 1.0, 1.0, h) || self.grows(&lo, -1.0, 1.0, h))
            }
            [State::Misses { .. }, State::Meets { lo, hi }] => {
                Self::push(taken, &lo, &hi);
                !still && (self.grows(&hi, 1.0, -1.0, h) || self.grows(&lo, -1.0, -1.0, h))
            }
            [State::Misses { gap: g0, slope: s0 }, State::Misses { gap: g1, slope: s1 }] => {
                // Times up to which the first gap, and from which the second gap, is proven open.
                let margin = self.margin(h, self.chord);
                let open = |gap: f64, rate: f64| {
                    if rate <= 0.0 && gap > margin { h } else { ((gap - margin) / rate.max(1e-300)).clamp(0.0, h) }
                };
                !still && open(g0, -s0) + open(g1, s1) < h
            }
        };
        if split {
            let middle = 0.5 * (t[0] + t[1]);
            let state = self.state(middle);
            self.cover([t[0], middle], [states[0], state], depth - 1, taken);
            self.cover([middle, t[1]], [state, states[1]], depth - 1, taken);
        }
    }

    /// Bound of b'' at an edge.
    fn curvature(&self, e: &Edge) -> f64 {
        (self.bend + 2.0 * self.angle * e.slope.abs()) / e.mu.max(1e-9)
    }

    /// Whether the end may move outward (`sign` 1: up) when time runs on (`way` 1) or back (`way` -1) over `h`.
    fn grows(&self, e: &Edge, sign: f64, way: f64, h: f64) -> bool {
        let rate = e.slope * sign * way;
        !e.full && (rate * h + 0.5 * self.curvature(e) * h * h) * e.mu > TURN_ERROR
    }

    /// The outermost position of an end over a time range at whose ends it is known; none when the range must be split.
    fn best(&self, t: [f64; 2], edges: [Edge; 2], sign: f64, still: bool) -> Option<Edge> {
        let [mut first, mut last] = edges;
        let outer = |a: Edge, b: Edge| if (b.s - a.s) * sign > 0.0 { b } else { a };
        if first.full || last.full || still {
            return Some(if last.full { last } else if first.full { first } else { outer(first, last) });
        }
        let [mut t0, mut t1] = t;
        for _ in 0..STEPS {
            let h = t1 - t0;
            let (up0, up1) = (first.slope * sign, last.slope * sign);
            let best = outer(first, last);
            if up0 > 0.0 && up1 < 0.0 {
                // One maximum between: the tangents meet above it.
                let x = ((last.s - first.s) * sign - up1 * h) / (up0 - up1);
                let gain = ((first.s - best.s) * sign + up0 * x) * first.mu.max(last.mu);
                if gain <= SEARCH_ERROR || h * self.way <= 0.1 * SEARCH_ERROR {
                    return Some(best);
                }
                let tau = t0 + x.clamp(0.05 * h, 0.95 * h);
                let above = best.s + sign * (gain / best.mu.max(1e-3) + SLIVER);
                let Some(edge) = self.edge_from(tau, above, sign) else { return None };
                if edge.full {
                    return Some(edge);
                }
                if edge.slope * sign > 0.0 {
                    (t0, first) = (tau, edge);
                } else {
                    (t1, last) = (tau, edge);
                }
                continue;
            }
            // The end whose slope would have to turn for a maximum to hide.
            let hidden = if up0 <= 0.0 && up1 >= 0.0 {
                let c = self.curvature(&first).max(self.curvature(&last));
                c * h * h / 8.0 * first.mu.max(last.mu)
            } else {
                let flat = if up1 >= 0.0 { last } else { first };
                let c = self.curvature(&flat);
                (0.5 * c * h - flat.slope.abs()).max(0.0) * h * flat.mu
            };
            return (hidden <= 1.01 * TURN_ERROR).then_some(best);
        }
        Some(outer(first, last))
    }

    /// The edge at a time, searched from a height that should lie outside.
    fn edge_from(&self, tau: f64, above: f64, sign: f64) -> Option<Edge> {
        let limit = if sign > 0.0 { self.ray.hi } else { self.ray.lo };
        let start = if (above - limit) * sign >= 0.0 { limit } else { above };
        match self.newton(tau, start, sign) {
            Ok(edge) if edge.full && start != limit => self.newton(tau, limit, sign).ok(),
            Ok(edge) => Some(edge),
            Err(_) => None,
        }
    }
}
