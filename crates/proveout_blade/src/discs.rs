//! Signed distance to a section, as a union of discs.
//!
//! The outline is the envelope of circles `(c, r)` whose centers run along the camber line. Where no circle
//! reaches over the place at which another one touches the outline (asked for when a blade is made), the
//! section is the union of their discs and each of them touches the outline on both sides: it fits into no
//! larger disc within the section. So for every point q of the plane, with the way `s` along the camber line,
//!
//! ```text
//!     g(q) = min over s of F(s),     F(s) = |q - c(s)| - r(s)
//! ```
//!
//! is the signed distance from the outline, below zero inside. *Outside:* the distance from a union is the
//! least of those from its parts. *Inside:* the largest disc about q within the section touches the outline
//! at a point P, which belongs to the circle of some s; q and c(s) lie on the normal of P. Were q farther
//! from P than c(s), its disc would hold that of s, which fits into none. So q lies between, `|q - c| = r -
//! |q - P|`, and no s gives a lower value, since every disc about q of radius `-F(s)` lies within the
//! section. With r + d in place of r the same holds for the outline at a distance d: its signed distance is
//! g - d.
//!
//! **The least value, wherever it lies** (branch and bound). `|z|` is convex, so that with `z = q - c`, `e =
//! z / |z|`, a camber line of radius R and `r'' <= k`
//!
//! ```text
//!     F(s + t) >= F + F' t - (1/R + k) t^2 / 2            F' = -e . c' - r'
//!     F(s + t) >= F + F' t - (1/R + k - b^2 / f) t^2 / 2   b = |c' - (c' . e) e| - |t| / 2R,   f = |z| + |t|
//! ```
//!
//! The second follows from `sqrt(u^2 + v^2) >= u + v^2 / 2 sqrt(u^2 + v^2)` for the parts u, v of z along and
//! across e; it makes most intervals convex, so that one look at the place of Newton's method settles them.

use std::f64::consts::{PI, TAU};

use super::section::CamberSection;

/// An interval that cannot hold a value lower by more than this is left, mm.
const SETTLED_MM: f64 = 1e-9;
/// A place that is lower by more than this is gone down from at once, mm.
const LOWER_MM: f64 = 1e-12;
/// Intervals at the start.
pub(super) const STARTS: usize = 8;
/// Steps of Newton's method.
const STEPS: usize = 40;
/// Distance from a center by which a bend is divided at least, mm.
const LEAST_FAR_MM: f64 = 1e-12;
/// A Newton step that is shorter is right to the last digits, where the value is too coarse to show an
/// improvement, mm.
const SURE_MM: f64 = 1e-5;
/// The search ends at a step of this part of the length.
const LAST_STEP: f64 = 1e-13;
/// A step that does not improve is halved down to this, mm.
const LAST_HALF_MM: f64 = 1e-7;
/// An interval that is shorter is a place, mm.
const NARROW_MM: f64 = 1e-12;

/// The discs of a section, in y and z.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Discs {
    /// Center and radius of the camber line.
    pivot: [f64; 2],
    camber_radius: f64,
    /// Angle about the pivot at the leading end; it falls along the camber line.
    first_angle: f64,
    /// Length of the camber line, mm.
    pub(super) length: f64,
    leading: f64,
    /// Difference of both radii.
    slope: f64,
    bulge: f64,
    /// Bounds of 1/R and of r''.
    pub(super) camber_bend: f64,
    pub(super) widening_bend: f64,
    /// Largest distance of a center from the origin.
    pub(super) reach: f64,
    /// Those in the middle of the first intervals.
    starts: [(f64, Disc); STARTS],
}

/// A disc and how it changes along the camber line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Disc {
    pub(super) center: [f64; 2],
    /// Unit tangent of the camber line.
    pub(super) along: [f64; 2],
    pub(super) radius: f64,
    /// r' and r''.
    pub(super) widens: f64,
    bends: f64,
}

/// A point seen from a disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct DiscView {
    pub(super) disc: Disc,
    /// F.
    pub(super) value: f64,
    /// F'.
    pub(super) slope: f64,
    /// Distance from the center and direction from there; zero in the center itself, where any slope down to
    /// this one is a bound.
    pub(super) far: f64,
    pub(super) away: [f64; 2],
    /// Part of `along` across `away`.
    pub(super) across: f64,
}

impl Discs {
    pub(super) fn new(section: &CamberSection) -> Self {
        let radius = section.camber_radius();
        let length = radius * section.camber_angle;
        let half = 0.5 * section.camber_angle;
        let pivot = [section.shift[0], section.shift[1] - radius * half.cos()];
        let bulge = 0.5 * section.thickness - 0.5 * (section.leading_radius + section.trailing_radius);
        let mut discs = Self {
            pivot,
            camber_radius: radius,
            first_angle: 0.5 * PI + half,
            length,
            leading: section.leading_radius,
            slope: section.trailing_radius - section.leading_radius,
            bulge,
            camber_bend: 1.0 / radius,
            widening_bend: 2.0 * (PI / length).powi(2) * bulge.abs(),
            reach: pivot[0].hypot(pivot[1]) + radius,
            starts: [(0.0, Disc::default()); STARTS],
        };
        let middle = |k: usize| (k as f64 + 0.5) * length / STARTS as f64;
        discs.starts = std::array::from_fn(|k| (middle(k), discs.disc(middle(k))));
        discs
    }

    /// The disc at a way along the camber line, mm.
    pub(super) fn disc(&self, s: f64) -> Disc {
        let (sine, cosine) = (self.first_angle - s * self.camber_bend).sin_cos();
        let x = s / self.length;
        let (a, b) = (PI * x).sin_cos();
        Disc {
            center: [self.pivot[0] + self.camber_radius * cosine, self.pivot[1] + self.camber_radius * sine],
            along: [sine, -cosine],
            radius: self.leading + self.slope * x + self.bulge * a * a,
            widens: (self.slope + self.bulge * TAU * a * b) / self.length,
            bends: 2.0 * (PI / self.length).powi(2) * self.bulge * (b * b - a * a),
        }
    }

    pub(super) fn see(&self, q: [f64; 2], s: f64) -> DiscView {
        Self::see_disc(q, self.disc(s))
    }

    fn see_disc(q: [f64; 2], disc: Disc) -> DiscView {
        let z = [q[0] - disc.center[0], q[1] - disc.center[1]];
        let far = (z[0] * z[0] + z[1] * z[1]).sqrt();
        let away = if far > 0.0 { [z[0] / far, z[1] / far] } else { [0.0; 2] };
        DiscView {
            disc,
            value: far - disc.radius,
            slope: -(away[0] * disc.along[0] + away[1] * disc.along[1]) - disc.widens,
            far,
            away,
            across: away[0] * disc.along[1] - away[1] * disc.along[0],
        }
    }

    /// Down from a place by Newton's method to where F has a minimum nearby.
    pub(super) fn settle(&self, q: [f64; 2], mut s: f64) -> (f64, DiscView) {
        let mut seen = self.see(q, s);
        for _ in 0..STEPS {
            let disc = &seen.disc;
            let toward_pivot = [self.pivot[0] - disc.center[0], self.pivot[1] - disc.center[1]];
            let inward = seen.away[0] * toward_pivot[0] + seen.away[1] * toward_pivot[1];
            let bend = seen.across * seen.across / seen.far.max(LEAST_FAR_MM)
                - inward * self.camber_bend * self.camber_bend
                - disc.bends;
            let most = self.length / STARTS as f64;
            let wanted = if bend > 0.0 { -seen.slope / bend } else { -seen.slope.signum() * most };
            let to = (s + wanted.clamp(-most, most)).clamp(0.0, self.length);
            let mut way = to - s;
            let sure = bend > 0.0 && way.abs() < SURE_MM;
            if way.abs() < LAST_STEP * self.length {
                break;
            }
            let mut next = self.see(q, s + way);
            while !sure && next.value >= seen.value && way.abs() > LAST_HALF_MM {
                way *= 0.5;
                next = self.see(q, s + way);
            }
            if !sure && next.value >= seen.value {
                break;
            }
            (s, seen) = (s + way, next);
        }
        (s, seen)
    }

    /// Signed distance of a point from the outline with the place that gives it: no other place gives less by
    /// more than a nanometer's thousandth.
    pub(super) fn nearest(&self, q: [f64; 2]) -> (f64, DiscView) {
        let width = self.length / STARTS as f64;
        let seen = self.starts.map(|(_, disc)| Self::see_disc(q, disc));
        let first = (0..STARTS).min_by(|a, b| seen[*a].value.total_cmp(&seen[*b].value)).unwrap_or_default();
        let mut best = self.settle(q, self.starts[first].0);
        let mut open: Vec<[f64; 2]> = Vec::new();
        for (k, seen) in seen.iter().enumerate() {
            let way = [k as f64 * width, (k + 1) as f64 * width];
            if self.may_hold(seen, self.starts[k].0, way, best.1.value) {
                open.push(way);
            }
        }
        while let Some([lo, hi]) = open.pop() {
            let at = look_at([lo, hi], Some(best.0));
            let seen = if at == best.0 { best.1 } else { self.see(q, at) };
            if seen.value < best.1.value - LOWER_MM {
                best = self.settle(q, at);
            }
            if !self.may_hold(&seen, at, [lo, hi], best.1.value) || hi - lo < NARROW_MM {
                continue;
            }
            let cut = cut([lo, hi], Some(best.0));
            open.push([lo, cut]);
            open.push([cut, hi]);
        }
        best
    }

    /// Whether an interval may hold a lower value, seen from a place in it.
    fn may_hold(&self, seen: &DiscView, at: f64, [lo, hi]: [f64; 2], best: f64) -> bool {
        let sides = [lo - at, hi - at];
        let most = sides[1].max(-sides[0]);
        let bend = self.camber_bend + self.widening_bend - self.convex(seen, most, seen.far + most);
        seen.value + lowest(seen.slope, bend, sides) < best - SETTLED_MM
    }

    /// `b^2 / f` within `most` of a place, `far` the largest distance from the centers.
    pub(super) fn convex(&self, seen: &DiscView, most: f64, far: f64) -> f64 {
        let across = seen.across.abs() - 0.5 * most * self.camber_bend;
        if across > 0.0 && far > 0.0 { across * across / far } else { 0.0 }
    }
}

/// Where an interval is looked at: at its place nearest to the best one known, when that is not far away,
/// else in the middle.
pub(super) fn look_at([lo, hi]: [f64; 2], best: Option<f64>) -> f64 {
    let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
    best.filter(|best| (best - middle).abs() <= 3.0 * half).map_or(middle, |best| best.clamp(lo, hi))
}

/// Where an interval is cut: in its middle, or, if it contains the best place known, between that and the
/// farther end.
pub(super) fn cut([lo, hi]: [f64; 2], best: Option<f64>) -> f64 {
    match best.filter(|best| (lo..=hi).contains(best)) {
        None => 0.5 * (lo + hi),
        Some(best) if hi - best > best - lo => 0.5 * (best + hi),
        Some(best) => 0.5 * (lo + best),
    }
}

/// Least value of `slope t - bend t^2 / 2` for t between two bounds.
pub(super) fn lowest(slope: f64, bend: f64, [lo, hi]: [f64; 2]) -> f64 {
    let at = |t: f64| t * (slope - 0.5 * bend * t);
    let ends = at(lo).min(at(hi));
    if bend < 0.0 { ends.min(at((slope / bend).clamp(lo, hi))) } else { ends }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_discs_are_those_of_the_section_and_their_derivatives_are_right() {
        let section = CamberSection { shift: [1.5, -0.7], ..CamberSection::stand_in() };
        let discs = Discs::new(&section);
        for k in 0..=50 {
            let x = f64::from(k) / 50.0;
            let disc = discs.disc(x * discs.length);
            let (center, [lower, upper]) = section.pair(x, 0.0);
            assert!((disc.center[0] - center[0]).hypot(disc.center[1] - center[1]) < 1e-12);
            for p in [lower, upper] {
                let way = [p.position[0] - center[0], p.position[1] - center[1]];
                assert!((way[0].hypot(way[1]) - disc.radius).abs() < 1e-12);
                // The circle touches its envelope.
                assert!((p.normal()[0] * disc.along[0] + p.normal()[1] * disc.along[1] + disc.widens).abs() < 1e-12);
            }
            let (h, s) = (1e-4, (x * discs.length).clamp(1e-3, discs.length - 1e-3));
            let (a, b, m) = (discs.disc(s - h), discs.disc(s + h), discs.disc(s));
            assert!(((b.radius - a.radius) / (2.0 * h) - m.widens).abs() < 1e-8);
            assert!(((b.widens - a.widens) / (2.0 * h) - m.bends).abs() < 1e-8);
            assert!(m.bends <= discs.widening_bend + 1e-12 && m.center[0].hypot(m.center[1]) <= discs.reach);
        }
    }

    #[test]
    fn the_least_of_all_discs_is_found_everywhere() {
        // Compared with 20001 discs: near the least of them F rises by less than slope h + bend h^2 / 2
        // with h = 1.6e-3 mm, slope 0 at a minimum inside, up to 1 at an end, where a station lies.
        // Corners: camber line, pivot, beyond both ends, far away.
        let section = CamberSection::stand_in();
        let discs = Discs::new(&section);
        let n = 20_000;
        let mut points: Vec<[f64; 2]> =
            (0..60).map(|k| discs.disc(f64::from(k) / 59.0 * discs.length).center).collect();
        points.extend([discs.pivot, [discs.pivot[0] + 0.3, discs.pivot[1]], [0.0, 1e4], [-2e3, -1e3]]);
        for k in 0..12 {
            points.extend((0..12).map(|j| [f64::from(k) * 7.3 - 40.0, f64::from(j) * 5.9 - 35.0]));
        }
        for q in points {
            let (s, seen) = discs.nearest(q);
            let all = (0..=n).map(|k| discs.see(q, discs.length * f64::from(k) / f64::from(n)).value);
            let least = all.fold(f64::INFINITY, f64::min);
            assert!(seen.value <= least + 1e-9, "{q:?}: {} {least}", seen.value);
            // A cone of slope one has its tip at a center: half a spacing.
            assert!(least - seen.value <= 1.7e-3 * (0.01 + if seen.far < 0.01 { 1.0 } else { 0.0 }), "{q:?} {s}");
        }
    }

    #[test]
    fn an_outline_at_a_distance_has_that_distance() {
        let section = CamberSection::stand_in();
        let discs = Discs::new(&section);
        for offset in [-1.1, -0.3, 0.0, 2.0, 10.0, 25.0] {
            for k in 0..=200 {
                for p in section.pair(f64::from(k) / 200.0, offset).1 {
                    assert!((discs.nearest(p.position).1.value - offset).abs() < 1e-9, "{offset} {k}");
                }
            }
        }
    }
}
