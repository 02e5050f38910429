//! Bounds of the distance on a part of a blade's face, with the terms of `nearest`.
//!
//! About a place, with `t` the step in x' or b, `i = x' - x'0` and `j = -(d - d0)` (outside) or `d - d0`,
//!
//! ```text
//!     N >= M = A + B i + j - C i^2 / 2
//!     X = x - x'0        V = |p - p'|^2 >= (X - i)^2 + (A + B i + j)^2 - A C i^2 - |B i + j| C i^2
//! ```
//!
//! as long as `M >= 0`. Without its last two parts the right side is `U = (X - i)^2 + (A + B i + j)^2`: on
//! the airfoil, where `i = t`, `j = 0`, a parabola; in the fillet, where i and j are sines in b, a sum of
//! sines of b and 2 b, of which slope and least second derivative give a parabola below. Its least value is
//! taken. Besides, `V >= min (X - i)^2 + min(M, 0 below)^2`, and for every unit vector `(m, n)` with `n >=
//! 0`: `sqrt V >= m (X - i) + n M`, a sine in b.
//!
//! A and B come from the convexity of `|z|`: `z = R(-w x') q - c(s)` bends by no more than `w^2 |q|` along x'
//! and 1/R along s (for q far away the centers are turned instead: `w^2 (|c| + R)` and 2/R), so that outside
//! A is F less what a step along s takes away at most. Inside, `|z|^2'' / 2 <= w^2 |q| |c|` bounds `|z|''`
//! from above where z is not zero; else `|z|` changes by at most `w min(|q|, |c|)` a mm. These bounds fall
//! short by the square of an interval's width.

use super::{super::discs::lowest, BladeFace, NearestSearch, SliceNode};

/// The bound of `N` about a node.
pub(super) struct NodeBound {
    a: f64,
    b: f64,
    c: f64,
}

impl NearestSearch<'_> {
    /// What `N` keeps on a part about a node, with `i` up to `climb`, outside. Steps along s within `along`.
    pub(super) fn bound_outside(&self, node: &SliceNode, climb: f64, along: [f64; 2]) -> (NodeBound, f64) {
        let discs = self.blade.discs();
        let w2 = self.twist * self.twist;
        let step = along[1].max(-along[0]);
        let far_away = self.radius > discs.reach + 1.0 / discs.camber_bend;
        let (mut c, mut bend) = if far_away {
            (w2 * (discs.reach + 1.0 / discs.camber_bend), 2.0 * discs.camber_bend + discs.widening_bend)
        } else {
            (w2 * self.radius, discs.camber_bend + discs.widening_bend)
        };
        // With u = b |t|, v = (drift + w^2 |q| |i| / 2) |i|: (u - v)^2 >= u^2 / 2 - v^2.
        let far = node.seen.far + step + self.twist.abs() * self.radius * climb;
        let convex = 0.5 * discs.convex(&node.seen, step, far);
        if !far_away && convex > bend {
            let drift = node.drift.abs() + 0.5 * w2 * self.radius * climb;
            (c, bend) = (c + drift * drift / far, bend - convex);
        }
        let fall = -lowest(node.seen.slope, bend, along);
        (NodeBound { a: node.n - fall, b: node.rise, c }, fall)
    }

    /// The same inside, for the disc of the node.
    pub(super) fn bound_inside(&self, node: &SliceNode, climb: f64) -> NodeBound {
        let center = node.seen.disc.center;
        let center = center[0].hypot(center[1]);
        let fastest = self.twist.abs() * self.radius.min(center);
        let least = node.seen.far - fastest * climb;
        if least > 0.1 * node.seen.far {
            let c = self.twist * self.twist * self.radius * center / least;
            NodeBound { a: -node.n, b: -node.rise, c }
        } else {
            NodeBound { a: -node.n - fastest * climb, b: 0.0, c: 0.0 }
        }
    }

    /// A bound of the distance for steps within `sides` about a node, and by how much an interval's width may
    /// have lowered it.
    pub(super) fn lower(&self, face: BladeFace, node: &SliceNode, bound: &NodeBound, sides: [f64; 2]) -> (f64, f64) {
        let NodeBound { a, b, c } = *bound;
        let x = self.p.x - node.x;
        let step = sides[1].max(-sides[0]);
        let square = match face {
            BladeFace::Airfoil(_) => {
                let least = a + (b * sides[0]).min(b * sides[1]) - 0.5 * c * step * step;
                let flat = (x.clamp(sides[0], sides[1]) - x).powi(2);
                if least <= 0.0 {
                    return (flat.sqrt(), b.abs() * step + 0.5 * c * step * step);
                }
                let bend = 1.0 + b * b - a * c - b.abs() * c * step;
                let parabola = x * x + a * a + lowest(2.0 * (a * b - x), -2.0 * bend, sides);
                parabola.max(flat + least * least)
            }
            BladeFace::Fillet(f) => return self.lower_in_fillet(f, node, bound, sides),
        };
        (square.max(0.0).sqrt(), 0.5 * c * step * step * (1.0 + b.abs() * step))
    }

    fn lower_in_fillet(&self, f: f64, node: &SliceNode, bound: &NodeBound, sides: [f64; 2]) -> (f64, f64) {
        let NodeBound { a, b, c } = *bound;
        let x = self.p.x - node.x;
        let sign = if self.inside { -1.0 } else { 1.0 };
        let (lo, hi) = (node.b + sides[0], node.b + sides[1]);
        let step = sides[1].max(-sides[0]);
        let ((s0, c0), (steep, level)) = (node.b.sin_cos(), (hi.sin(), lo.cos()));
        // i and j at both ends: they rise or fall throughout.
        let i = [f * (c0 - lo.cos()), f * (c0 - hi.cos())];
        let j = [sign * f * (lo.sin() - s0), sign * f * (hi.sin() - s0)];
        let climb = i[1].max(-i[0]);
        let curved = 0.5 * c * climb * climb;
        let least = a + (b * i[0]).min(b * i[1]) + j[0].min(j[1]) - curved;
        let mut square = (x.clamp(i[0], i[1]) - x).powi(2);
        let mut lost = curved + 0.5 * f * step * step;
        if least > 0.0 {
            square += least * least;
            // U = (e + f cos b)^2 + (h0 + h1 cos b + h2 sin b)^2 has this slope at the node and this second
            // derivative.
            let e = x - f * c0;
            let [h0, h1, h2] = [a + b * f * c0 - sign * f * s0, -b * f, sign * f];
            let slope = 2.0 * f * ((a * b - x) * s0 + sign * a * c0);
            let bend = least_sine(-2.0 * (e * f + h0 * h1), -2.0 * h0 * h2, [lo, hi])
                + least_sine(-2.0 * h1 * h1, -4.0 * h1 * h2, [2.0 * lo, 2.0 * hi]);
            let (di, dj) = (f * steep, f * level);
            let rest = (a + (b.abs() * di + dj) * step) * c * di * di;
            square = square.max(x * x + a * a + lowest(slope, 2.0 * rest - bend, sides));
        } else {
            lost += b.abs() * climb + j[1].max(-j[0]).max(j[0].max(-j[1]));
        }
        let mut lower = square.max(0.0).sqrt();
        // The straight bound in the direction that the node itself has.
        let length = x.hypot(a);
        if a >= 0.0 && length > 0.0 {
            let (m, n) = (x / length, a / length);
            // m (X - i) + n (A + B i + j), i = f (cos b0 - cos b), j = sign f (sin b - sin b0).
            let (cosine, sine) = (f * (m - n * b), sign * f * n);
            let least = least_sine(cosine, sine, [lo, hi]);
            lower = lower.max(length - cosine * c0 - sine * s0 + least - n * curved);
        }
        (lower, lost)
    }
}

/// Least value of `cosine cos b + sine sin b` between two angles within a half turn.
fn least_sine(cosine: f64, sine: f64, [lo, hi]: [f64; 2]) -> f64 {
    let at = |b: f64| cosine * b.cos() + sine * b.sin();
    let valley = (-sine).atan2(-cosine);
    if valley > lo && valley < hi { -cosine.hypot(sine) } else { at(lo).min(at(hi)) }
}
