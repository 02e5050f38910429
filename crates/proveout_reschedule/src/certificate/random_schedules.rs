//! Random channels that tests of bounds and of the taut string share.

use super::{JointGates, Schedules, SwingLimits};

pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Channels of all kinds: level, rising, falling, wavy, ragged; narrow to wide; some gates open, some a
/// point; feeds of equal and of very different times; limits from none to tight.
pub(super) fn random_schedules(random: &mut Random) -> Schedules {
    let n = 2 + (60.0 * random.next().powi(2)) as usize;
    let least: Vec<f64> = if random.next() < 0.5 {
        vec![random.between(0.01, 0.2); n]
    } else {
        (0..n).map(|_| 10_f64.powf(random.between(-3.0, 0.0))).collect()
    };
    let joints = (0..1 + usize::from(random.next() < 0.3))
        .map(|k| {
            let (kind, width) = ((5.0 * random.next()) as usize, 10_f64.powf(random.between(-2.0, 1.0)));
            let (waves, phase) = (random.between(0.5, 8.0), random.between(0.0, 6.3));
            let mut walk = 0.0;
            let gates = (0..=n)
                .map(|i| {
                    let s = i as f64 / n as f64;
                    walk += random.between(-0.5, 0.5);
                    let middle = match kind {
                        0 => 0.0,
                        1 => 8.0 * s,
                        2 => -8.0 * s,
                        3 => 2.0 * (6.3 * waves * s + phase).sin(),
                        _ => walk,
                    };
                    match (20.0 * random.next()) as usize {
                        0 => [f64::NEG_INFINITY, f64::INFINITY],
                        1 => [f64::NEG_INFINITY, middle + width],
                        2 => [middle; 2],
                        _ => [middle - width * random.next(), middle + width * random.next()],
                    }
                })
                .collect();
            let open = |random: &mut Random, v: f64| if random.next() < 0.2 { f64::INFINITY } else { v };
            let (a, j) = (10_f64.powf(random.between(-1.0, 2.0)), 10_f64.powf(random.between(-1.0, 3.0)));
            let limits = SwingLimits {
                velocity: 10_f64.powf(random.between(-1.0, 2.0)),
                acceleration: open(random, a),
                jerk: open(random, j),
            };
            JointGates { name: format!("R{k}"), limits, gates }
        })
        .collect();
    Schedules { least, joints }
}
