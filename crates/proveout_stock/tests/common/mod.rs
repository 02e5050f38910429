//! Cutters, random numbers and the oracle that several tests use.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr, reason = "a failed test says why")]
#![allow(dead_code, unreachable_pub, reason = "each test file uses a part")]

use proveout_geom::{Aabb, Point, ToolPose, Vector};
use proveout_stock::{Action, SweepItem, SweepMotion};
use proveout_tool::{Cutter, Profile, Segment};

pub const GIB: u64 = 1 << 30;

/// Xorshift generator (Marsaglia 2003).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    pub fn pick(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    pub fn direction(&mut self) -> Vector {
        loop {
            let v = Vector::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            if (0.01..1.0).contains(&v.norm_squared()) {
                return v.normalize();
            }
        }
    }
}

pub fn line(from: [f64; 2], to: [f64; 2]) -> Segment {
    Segment::Line { from, to }
}

pub fn arc(center: [f64; 2], radius: f64, from: [f64; 2], to: [f64; 2]) -> Segment {
    Segment::Arc { center, radius, from, to }
}

pub fn flat(r: f64, l: f64) -> Profile {
    Profile::new(vec![line([0.0, 0.0], [r, 0.0]), line([r, 0.0], [r, l]), line([r, l], [0.0, l])]).unwrap()
}

pub fn ball(r: f64, l: f64) -> Profile {
    Profile::new(vec![arc([0.0, r], r, [0.0, 0.0], [r, r]), line([r, r], [r, l]), line([r, l], [0.0, l])]).unwrap()
}

pub fn bull(r: f64, c: f64, l: f64) -> Profile {
    Profile::new(vec![
        line([0.0, 0.0], [r - c, 0.0]),
        arc([r - c, c], c, [r - c, 0.0], [r, c]),
        line([r, c], [r, l]),
        line([r, l], [0.0, l]),
    ])
    .unwrap()
}

pub fn drill(r: f64, half_angle: f64, l: f64) -> Profile {
    let tip = r / half_angle.tan();
    Profile::new(vec![line([0.0, 0.0], [r, tip]), line([r, tip], [r, l]), line([r, l], [0.0, l])]).unwrap()
}

pub fn chamfer(r0: f64, r1: f64, h: f64, l: f64) -> Profile {
    Profile::new(vec![
        line([0.0, 0.0], [r0, 0.0]),
        line([r0, 0.0], [r1, h]),
        line([r1, h], [r1, l]),
        line([r1, l], [0.0, l]),
    ])
    .unwrap()
}

/// Conical body with a ball end, tangent to each other.
pub fn taper_ball(r: f64, angle: f64, l: f64) -> Profile {
    let (s, c) = angle.sin_cos();
    let joint = [r * c, r - r * s];
    let top = joint[0] + (l - joint[1]) * angle.tan();
    Profile::new(vec![arc([0.0, r], r, [0.0, 0.0], joint), line(joint, [top, l]), line([top, l], [0.0, l])]).unwrap()
}

/// Barrel: flank arc of large radius whose center lies beyond the axis.
pub fn barrel(r: f64, flank: f64, l: f64) -> Profile {
    let flank = flank.max(0.3 * l * l / r); // the ends stay off the axis
    let center = [r - flank, 0.5 * l];
    let end = center[0] + (flank * flank - 0.25 * l * l).sqrt();
    Profile::new(vec![line([0.0, 0.0], [end, 0.0]), arc(center, flank, [end, 0.0], [end, l]), line([end, l], [0.0, l])])
        .unwrap()
}

/// Lens: a shallow arc across the axis, then a flank.
pub fn lens(r: f64, bottom: f64, l: f64) -> Profile {
    let h = bottom - (bottom * bottom - r * r).sqrt();
    Profile::new(vec![arc([0.0, bottom], bottom, [0.0, 0.0], [r, h]), line([r, h], [r, l]), line([r, l], [0.0, l])])
        .unwrap()
}

/// The first body of a cutter of the library.
pub fn body_of(cutter: &Cutter, flute_length: f64) -> Profile {
    cutter.bodies(flute_length).unwrap().remove(0)
}

/// Families of [`random_cutter`].
pub const KINDS: usize = 12;

/// A cutter of some kind: the kind's index gives the family.
pub fn random_cutter(random: &mut Random) -> (usize, Profile) {
    let r = random.range(0.5, 8.0);
    let l = random.range(2.5 * r, 40.0);
    let kind = random.pick(KINDS);
    let profile = match kind {
        0 => ball(r, l),
        1 => flat(r, l),
        2 => bull(r, r * random.range(0.05, 0.95), l),
        3 => chamfer(r * random.range(0.01, 0.5), r, r * random.range(0.3, 2.0), l),
        4 => drill(r, random.range(0.5, 1.3), l),
        5 => barrel(r, random.range(2.0, 8.0) * l, l),
        6 => taper_ball(r, random.range(0.02, 0.3), l),
        7 => lens(r, random.range(1.5, 10.0) * r, l),
        8 => Profile::new(vec![arc([0.0, r], r, [0.0, 0.0], [0.0, 2.0 * r])]).unwrap(),
        9 => {
            let side = r * random.range(1.5, 8.0);
            body_of(&Cutter::oval(2.0 * r, r * random.range(0.2, 0.8), side).unwrap(), 4.0 * side)
        }
        10 => {
            let (height, side) = (r * random.range(0.3, 1.2), r * random.range(0.8, 3.0));
            body_of(&Cutter::drum_wheel(2.0 * r, side, height * random.range(0.0, 0.4), height).unwrap(), height)
        }
        _ => {
            let corner = r * random.range(0.05, 0.4);
            body_of(&Cutter::lens(2.0 * r, r * random.range(2.0, 8.0), corner).unwrap(), l)
        }
    };
    (kind, profile)
}

pub fn pose(tip: [f64; 3], axis: [f64; 3]) -> ToolPose {
    ToolPose { tip: Point::from(tip), axis: Vector::from(axis).normalize() }
}

pub fn remove<'a>(id: u32, body: &'a Profile, from: ToolPose, to: ToolPose) -> SweepItem<'a> {
    SweepItem { id, body, action: Action::Remove, motion: SweepMotion { from, to } }
}

pub fn probe<'a>(id: u32, body: &'a Profile, from: ToolPose, to: ToolPose) -> SweepItem<'a> {
    SweepItem { action: Action::Probe, ..remove(id, body, from, to) }
}

pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Aabb {
    Aabb { min: Point::from(min), max: Point::from(max) }
}

/// Distance of a point from the body at one time, by the profile's own distance.
pub fn stamp(body: &Profile, motion: &SweepMotion, x: &Point, t: f64) -> f64 {
    let at = motion.from.interpolated(&motion.to, t);
    let y = x - at.tip;
    let z = y.dot(&at.axis);
    body.signed_distance([(y - at.axis * z).norm(), z])
}

/// Signed distance of a point from the swept body: stamps along the motion, then golden section round every
/// low stamp until the time is known to 1e-9. Shares nothing with the sweep but the profile.
pub fn oracle(body: &Profile, motion: &SweepMotion, x: &Point, stamps: usize) -> f64 {
    let n = stamps;
    let values: Vec<f64> = (0..=n).map(|k| stamp(body, motion, x, k as f64 / n as f64)).collect();
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let reach = body.max_radius() + body.z_max().abs().max(body.z_min().abs());
    let speed = (motion.to.tip - motion.from.tip).norm() + motion.from.angle_to(&motion.to) * (reach + 20.0);
    let mut best = lowest;
    for k in 0..=n {
        let low = values[k.saturating_sub(1)].min(values[(k + 1).min(n)]);
        if values[k] > low || values[k] > lowest + speed / n as f64 {
            continue;
        }
        let (mut a, mut b) = (k.saturating_sub(1) as f64 / n as f64, (k + 1).min(n) as f64 / n as f64);
        let ratio = 0.5 * (5_f64.sqrt() - 1.0);
        let (mut c, mut d) = (b - ratio * (b - a), a + ratio * (b - a));
        let (mut fc, mut fd) = (stamp(body, motion, x, c), stamp(body, motion, x, d));
        while b - a > 1e-9 {
            if fc < fd {
                (b, d, fd) = (d, c, fc);
                c = b - ratio * (b - a);
                fc = stamp(body, motion, x, c);
            } else {
                (a, c, fc) = (c, d, fd);
                d = a + ratio * (b - a);
                fd = stamp(body, motion, x, d);
            }
        }
        best = best.min(fc).min(fd);
    }
    best
}
