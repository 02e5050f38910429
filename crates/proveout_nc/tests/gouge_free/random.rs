//! Random contours, and which corners they visit.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use crate::gouge_free::program::{Block, Contour};
use crate::gouge_free::shape::{Point, far};

#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Evenly by its logarithm.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.range(low.ln(), high.ln()).exp()
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.range(0.0, 1.0) < share
    }

    fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }
}

/// Counts of what the generator made, by name.
pub(crate) type Visits = BTreeMap<&'static str, u64>;

fn rounded(p: Point, digits: usize) -> Point {
    let unit = 10f64.powi(digits as i32);
    p.map(|v| (v * unit).round() / unit + 0.0)
}

/// A chain that grows at its end.
struct Chain {
    at: Point,
    heading: f64,
    blocks: Vec<Block>,
    digits: usize,
}

impl Chain {
    fn line(&mut self, length: f64) {
        let end = [self.at[0] + length * self.heading.cos(), self.at[1] + length * self.heading.sin()];
        self.at = rounded(end, self.digits);
        self.blocks.push(Block::Line(self.at));
    }

    /// Signed sweep: to the left above zero.
    fn arc(&mut self, radius: f64, sweep: f64) {
        let side = sweep.signum();
        let center = [self.at[0] - side * radius * self.heading.sin(), self.at[1] + side * radius * self.heading.cos()];
        let center = rounded(center, self.digits);
        let (sine, cosine) = sweep.sin_cos();
        let d = [self.at[0] - center[0], self.at[1] - center[1]];
        let end = [center[0] + cosine * d[0] - sine * d[1], center[1] + sine * d[0] + cosine * d[1]];
        let full = (sweep.abs() - TAU).abs() < 1e-12;
        let end = if full { self.at } else { rounded(end, self.digits) };
        if !full && far(end, self.at) < 1e-5 {
            return;
        }
        self.blocks.push(Block::Arc(end, center, sweep > 0.0));
        self.at = end;
        self.heading += sweep;
    }
}

/// A chain of any lines and arcs: corners of all angles, near-tangent ones of 1e-9 to 0.05 radian, cusps,
/// reversals, arcs about as large as the tool, tiny blocks, full circles. It may cross itself, and be
/// narrower than the tool anywhere. In three of four, inside corners and inside arcs that are too small are
/// rare, so that the tool often fits.
pub(crate) fn wild(random: &mut Random, full_circles: bool, visits: &mut Visits) -> Contour {
    let radius = random.scale(0.1, 10.0);
    let left = random.chance(0.5);
    // With three digits the text itself turns and moves corners by up to a micrometer.
    let digits = if random.chance(0.3) { 3 } else { 9 };
    let start = [random.range(-50.0, 50.0), random.range(-50.0, 50.0)];
    let mut chain = Chain { at: rounded(start, digits), heading: random.range(-PI, PI), blocks: Vec::new(), digits };
    let start = chain.at;
    let first_heading = chain.heading;
    let mut visit = |name: &'static str| *visits.entry(name).or_default() += 1;
    // Turns to this side are outside corners.
    let outside = if left { -1.0 } else { 1.0 };
    let mild = random.chance(0.75);
    let side = |random: &mut Random| if mild && random.chance(0.95) { outside } else { random.sign() };
    for index in 0..1 + random.below(6) {
        if index > 0 {
            let turn = match random.below(10) {
                0 | 1 => {
                    visit("joint: tangent");
                    0.0
                }
                2 | 3 => {
                    visit("joint: near-tangent, 1e-9 to 0.05 rad");
                    let sign = random.sign();
                    sign * random.scale(1e-9, if mild && sign != outside { 0.005 } else { 0.05 })
                }
                4 => {
                    visit("joint: reversal");
                    PI
                }
                5 => {
                    visit("joint: near reversal, 1e-9 to 0.05 rad");
                    side(random) * (PI - random.sign() * random.scale(1e-9, 0.05))
                }
                _ => {
                    visit("joint: any angle");
                    let sign = side(random);
                    sign * random.range(0.0, if mild { if sign == outside { 2.0 } else { 1.0 } } else { PI })
                }
            };
            chain.heading += turn;
        }
        // The smallest inside radius in a mild contour.
        let least = |sign: f64, low: f64| if mild && sign != outside { 1.05 } else { low };
        let longest = if mild && random.chance(0.8) { 2.0 } else { 0.95 * TAU };
        match random.below(10) {
            0 => {
                visit("block: tiny line");
                chain.line(random.scale(2e-3, 0.1));
            }
            1..=3 => {
                visit("block: line");
                chain.line(radius * random.scale(if mild { 2.0 } else { 0.2 }, 20.0));
            }
            4 => {
                visit("block: arc about as large as the tool");
                let (sign, off) = (side(random), random.scale(1e-6, 0.3));
                let off = if mild && sign != outside { off } else { random.sign() * off };
                chain.arc(radius * (1.0 + off), sign * random.range(0.05, longest));
            }
            5 => {
                visit("block: small arc");
                chain.arc(radius * random.scale(0.05, 0.9), side(random) * random.range(0.05, longest));
            }
            6 if full_circles => {
                visit("block: full circle");
                let sign = random.sign();
                chain.arc(radius * random.scale(least(sign, 0.5), 10.0), sign * TAU);
            }
            7 => {
                // Two arcs that leave their corner the way they came: the figure of a heart or of two bumps.
                visit("block: two arcs with a cusp");
                let sign = side(random);
                let radii = [0; 2].map(|_| radius * random.scale(least(sign, 0.5), 10.0));
                chain.arc(radii[0], sign * random.range(0.3, 3.0));
                chain.heading += PI;
                let same = if random.chance(0.8) { sign } else { -sign };
                chain.arc(radii[1], same * random.range(0.3, 3.0));
            }
            _ => {
                visit("block: arc");
                let sign = random.sign();
                chain.arc(radius * random.scale(least(sign, 0.5), 20.0), sign * random.range(0.05, longest));
            }
        }
    }
    if random.chance(0.2) && far(chain.at, start) > 1e-3 {
        visit("contour: closed");
        chain.at = start;
        chain.blocks.push(Block::Line(start));
    }
    finish(random, chain, start, first_heading, left, radius)
}

/// A chain that runs to the right within 60 degrees of the first axis, with the tool above or below: lines of
/// four tool radii at least, inside arcs of 1.5 radii at least, corners between lines, near-tangent ones
/// anywhere. The tool fits everywhere.
pub(crate) fn legal(random: &mut Random, visits: &mut Visits) -> Contour {
    const STEEP: f64 = PI / 3.0;
    let radius = random.scale(0.1, 10.0);
    let left = random.chance(0.5);
    let digits = 9;
    let heading = random.range(-STEEP, STEEP);
    let start = rounded([random.range(-50.0, 50.0), random.range(-50.0, 50.0)], digits);
    let mut chain = Chain { at: start, heading, blocks: Vec::new(), digits };
    let mut visit = |name: &'static str| *visits.entry(name).or_default() += 1;
    chain.line(radius * random.range(4.0, 10.0));
    for _ in 0..2 + random.below(8) {
        let to = random.range(-STEEP, STEEP);
        match random.below(3) {
            0 => {
                visit("legal: corner of two lines");
                chain.heading = to;
            }
            1 => {
                visit("legal: near-tangent corner, 1e-9 to 0.01 rad");
                let turn = random.sign() * random.scale(1e-9, 0.01);
                chain.heading = (chain.heading + turn).clamp(-STEEP, STEEP);
            }
            _ => {
                let bend = to - chain.heading;
                if bend.abs() > 0.3 {
                    visit("legal: arc with tangent or near-tangent ends");
                    let arc = radius * random.scale(1.5, 10.0);
                    if random.chance(0.5) {
                        chain.heading += random.sign() * random.scale(1e-9, 1e-3);
                    }
                    chain.arc(arc, bend);
                    if random.chance(0.5) {
                        chain.heading += random.sign() * random.scale(1e-9, 1e-3);
                    }
                }
            }
        }
        chain.line(radius * random.range(4.0, 10.0));
    }
    finish(random, chain, start, heading, left, radius)
}

/// Entry and exit: square to the contour, from a distance of one and a half to four radii on the side of the
/// tool.
fn finish(random: &mut Random, chain: Chain, start: Point, first: f64, left: bool, radius: f64) -> Contour {
    let side = if left { 1.0 } else { -1.0 };
    let beside = |p: Point, heading: f64, far: f64| {
        rounded([p[0] - side * far * heading.sin(), p[1] + side * far * heading.cos()], chain.digits)
    };
    let from = beside(start, first, radius * random.range(1.5, 4.0));
    let to = beside(chain.at, chain.heading, radius * random.range(1.5, 4.0));
    Contour { from, start, blocks: chain.blocks, to, left, radius, digits: chain.digits }
}
