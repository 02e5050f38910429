//! How far a tool reaches round the center of its ball: at which angles from the axis a place is too near.
//!
//! A ball end turns about its center Q and is a body of revolution about every axis through it.
//! Whether a place X is too near to the rest of the tool therefore depends on two numbers, its
//! distance r from Q and the angle a between X - Q and the axis:
//!
//! ```text
//!         V                 hi(r): too near at no larger angle
//!      +--|--+              lo(r): too near at no smaller angle; 0 where the tool is met on its axis:
//!      |  |  |   X                 everywhere but past its top
//!      +-+|+-+  /           in(r): too near at all angles within
//!        ||| a /
//!        |||  / r           A fixed place forbids the axes of a cap, or of a ring, about the direction
//!        (Q)-'              in which it is seen from Q.
//! ```
//!
//! Both bounds are taken over bins of r, each a fifth of a percent wide at most. With w the half width of a
//! bin every place of it is within w of one at the middle distance c, and a distance changes by no more than
//! the place moves: where the middle is farther than `need + w` from a part at an angle a, so it is at all
//! angles within `(distance - need - w)/c` of it. Steps of that size go from a right angle up or down to the
//! first angle at which the bound fails, and leave out none in between. The same with `need - w - distance`
//! for places that are too near.

use std::f64::consts::PI;

use super::tool_part::ToolPart;

/// A bin holds the distances whose first bits are the same: sign, exponent and nine bits of the fraction.
/// There are 512 to an octave, each a fifth to a tenth of a percent wide, and no logarithm is asked for.
const BITS_BELOW: u32 = 52 - 9;
/// Distances below this share of the ball's radius are inside of it and are not looked at, nor those below
/// the other, mm.
const INSIDE: f64 = 0.25;
const LEAST_MM: f64 = 0.01;
/// Steps end when they get shorter than this, radian: a hundredth of a degree.
const STEP: f64 = 1e-4;
/// Number of places on the arc from which the angles that are too near are looked for.
const STARTS: usize = 24;
/// Distances and the widths of bins are larger by this part, and widths by this, mm: rounding.
const LARGER: f64 = 1e-9;
const WIDER_MM: f64 = 1e-12;

/// Angles from the axis, radian; from above to for none.
type Angles = [f64; 2];
/// The same by their cosines, which fall.
pub(crate) type Cosines = [f64; 2];
const NONE: Angles = [f64::INFINITY, f64::NEG_INFINITY];

/// The reach of a tool round the center of its ball, for one distance that is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Extent {
    /// First bits of the distances of the first bin.
    first: u64,
    /// Nothing at this distance or farther is too near, mm.
    far: f64,
    /// Per bin all angles at which a place may be too near: those of one bin, of two adjacent bins,
    /// of four, and so on.
    outer: Vec<Vec<Cosines>>,
    /// Per bin angles at which a place is too near.
    inner: Vec<Cosines>,
}

impl Extent {
    /// The parts that turn with the axis; `kind` picks the distance that they must keep.
    pub(crate) fn new(limbs: &[ToolPart], kind: usize, ball: f64) -> Self {
        let far = limbs.iter().map(|l| l.reach + l.needs[kind]).fold(0.0, f64::max) * (1.0 + LARGER);
        let near = (INSIDE * ball).max(LEAST_MM);
        let first = bin(near);
        let count = (bin(far.max(near)) - first + 1) as usize;
        let (mut outer, mut inner) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for k in 0..count as u64 {
            let [low, high] = [first + k, first + k + 1].map(|b| f64::from_bits(b << BITS_BELOW));
            let middle = 0.5 * (low + high);
            let half = 0.5 * (high - low) * (1.0 + LARGER) + WIDER_MM;
            let (mut hull, mut sure) = (NONE, Vec::new());
            for limb in limbs {
                let own = may_be_near(limb, limb.needs[kind], middle, half);
                hull = [hull[0].min(own[0]), hull[1].max(own[1])];
                sure.extend(is_near(limb, limb.needs[kind], middle, half, own));
            }
            outer.push(cosines(hull));
            inner.push(cosines(longest(sure)));
        }
        let mut levels = vec![outer];
        while levels.last().is_some_and(|l| l.len() > 1 << (levels.len() - 1)) && levels.len() < 32 {
            let step = 1 << (levels.len() - 1);
            let below = &levels[levels.len() - 1];
            let count = below.len() - step;
            let next = (0..count).map(|i| hull_of(below[i], below[i + step])).collect();
            levels.push(next);
        }
        Self { first, far, outer: levels, inner }
    }

    /// All angles at which a place may be too near whose distance from the center lies between two; none
    /// where it cannot be.
    #[inline(always)]
    pub(crate) fn outer(&self, low: f64, high: f64) -> Option<Cosines> {
        if low >= self.far {
            return None;
        }
        let (from, to) = (bin(low), bin(high));
        if from < self.first {
            return Some([1.0, -1.0]);
        }
        let last = self.inner.len() - 1;
        let (from, to) = (((from - self.first) as usize).min(last), ((to - self.first) as usize).min(last));
        let level = (to + 1 - from).ilog2() as usize;
        let row = &self.outer[level];
        let all = hull_of(row[from], row[to + 1 - (1 << level)]);
        if all[0] >= all[1] { Some(all) } else { None }
    }

    /// Angles at all of which a place at this distance is too near; none where none are known.
    pub(crate) fn inner(&self, r: f64) -> Option<Cosines> {
        let at = bin(r).checked_sub(self.first)?;
        self.inner.get(at as usize).copied().filter(|a| a[0] > a[1])
    }
}

/// First bits of a distance; rises with it.
#[inline(always)]
fn bin(r: f64) -> u64 {
    r.abs().to_bits() >> BITS_BELOW
}

#[inline(always)]
fn hull_of(a: Cosines, b: Cosines) -> Cosines {
    [a[0].max(b[0]), a[1].min(b[1])]
}

fn cosines(a: Angles) -> Cosines {
    if a[0] > a[1] { [-2.0, 2.0] } else { a.map(f64::cos) }
}

fn distance(limb: &ToolPart, r: f64, angle: f64) -> f64 {
    let (s, c) = angle.sin_cos();
    limb.height([r * s, r * c]).distance
}

/// Angles outside of which no place of the bin is nearer to the part than `need`.
fn may_be_near(limb: &ToolPart, need: f64, middle: f64, half: f64) -> Angles {
    if middle - half > limb.reach + need {
        return NONE;
    }
    let room = |angle: f64| (distance(limb, middle, angle) - need - half) / middle;
    let mut high = PI;
    loop {
        let step = room(high);
        if step < STEP {
            break;
        }
        high -= step;
        if high < 0.0 {
            return NONE;
        }
    }
    let mut low = 0.0;
    loop {
        let step = room(low);
        if step < STEP {
            break;
        }
        low += step;
        if low > high {
            return NONE;
        }
    }
    [low, high]
}

/// Stretches of angles at which every place of the bin is nearer to the part than `need`.
fn is_near(limb: &ToolPart, need: f64, middle: f64, half: f64, within: Angles) -> Vec<Angles> {
    let mut found: Vec<Angles> = Vec::new();
    if within[0] > within[1] {
        return found;
    }
    let depth = |angle: f64| (need - half - distance(limb, middle, angle)) / middle;
    for k in 0..STARTS {
        let start = within[0] + (within[1] - within[0]) * k as f64 / (STARTS - 1) as f64;
        if found.iter().any(|f| (f[0]..=f[1]).contains(&start)) || depth(start) < STEP {
            continue;
        }
        let go = |sign: f64, end: f64| {
            let mut at = start;
            loop {
                let step = depth(at);
                if step < STEP {
                    return at;
                }
                // The end of the arc is reached: 0 or half a turn.
                if step >= (end - at) * sign {
                    return end;
                }
                at += sign * step;
            }
        };
        found.push([go(-1.0, 0.0), go(1.0, PI)]);
    }
    found
}

/// The longest stretch when those that overlap have become one.
fn longest(mut stretches: Vec<Angles>) -> Angles {
    stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut best, mut now) = (NONE, NONE);
    for s in stretches {
        now = if s[0] <= now[1] { [now[0], now[1].max(s[1])] } else { s };
        if best[0] > best[1] || now[1] - now[0] > best[1] - best[0] {
            best = now;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use proveout_tool::{Cutter, HolderSection, ToolBuilder};

    use super::*;
    use crate::orientation::cutter_end::CutterEnd;

    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Places in and around a tool with a neck, a stepped holder and a barrel, at distances from
    /// the ball's skin to past the top, at the borders of bins, on the axis, straight below: no
    /// bound contradicts the distance.
    #[test]
    fn angles_hold_all_places_that_are_too_near_and_hardly_any_other() {
        let section = |diameter, top_diameter, length| HolderSection { diameter, top_diameter, length };
        let tools = [
            ToolBuilder::new(1, "NECK", Cutter::ball(8.0).expect("ball"), 6.0, 90.0).neck(6.0, 25.0).shank(12.0),
            ToolBuilder::new(2, "HOLDER", Cutter::ball(6.0).expect("ball"), 10.0, 90.0)
                .shank(6.0)
                .holder([section(20.0, 32.0, 30.0), section(63.0, 63.0, 15.0)]),
            ToolBuilder::new(3, "TAPER", Cutter::taper_ball(4.0, 6.0, 10.0).expect("taper"), 35.0, 95.0).shank(10.0),
        ];
        let mut state = 5;
        for builder in tools {
            let tool = builder.build().expect("tool");
            let end = CutterEnd::of(&tool).expect("ball");
            for need in [-0.02, 0.0, 0.5, 3.0] {
                let mut limbs = vec![ToolPart::body(&end.rest, end.height, [need; 2])];
                limbs.extend(tool.bodies.iter().skip(1).map(|b| ToolPart::body(&b.profile, end.height, [need; 2])));
                let extent = Extent::new(&limbs, 0, end.round);
                let (mut near, mut reported, mut possible, mut places) = (0, 0, 0, 0);
                for n in 0..20_000 {
                    let share = random(&mut state);
                    let mut r = end.round * (1.02 * extent.far / end.round).powf(share);
                    if n % 7 == 0 {
                        r = f64::from_bits(bin(r) << BITS_BELOW).max(end.round);
                    }
                    let angle = [0.0, PI].get(n % 11).copied().unwrap_or(PI * random(&mut state));
                    let is = limbs.iter().any(|l| distance(l, r, angle) < need);
                    let may = extent.outer(r, r).is_some_and(|[a, b]| (b..=a).contains(&angle.cos()));
                    let sure = extent.inner(r).is_some_and(|[a, b]| (b..=a).contains(&angle.cos()));
                    assert!(may || !is, "{} {need} {r} {angle}", tool.name);
                    assert!(is || !sure, "{} {need} {r} {angle}", tool.name);
                    // A range of distances holds what each of them does.
                    let (low, high) = (r * (1.0 - 0.3 * share), r * (1.0 + random(&mut state)));
                    if let Some([a, b]) = extent.outer(r, r) {
                        let wide = extent.outer(low, high).expect("at least as much");
                        assert!(wide[0] >= a && wide[1] <= b);
                    }
                    near += usize::from(is);
                    reported += usize::from(sure);
                    possible += usize::from(may);
                    places += 1;
                }
                assert!(near > 500, "{}: {near}", tool.name);
                assert!(possible - near < places / 20, "{} {need}: {possible} {near}", tool.name);
                assert!(near - reported < places / 20, "{} {need}: {reported} {near}", tool.name);
                assert_eq!(extent.outer(extent.far * 1.01, extent.far * 2.0), None);
            }
        }
    }
}
