//! Linear joints that follow the tool axis: their position for every angle of a channel.
//!
//! With the other rotary joints and the center of the ball fixed, a linear joint depends on the
//! table's angle q as `a + b cos q + c sin q`, whatever lies between table and tool in the chain,
//! since table and tool turn rigidly about one axis. Three angles give the three numbers, and a
//! fourth checks them. The range over an interval is that of its ends and of the extrema inside it.

use std::f64::consts::TAU;

use proveout_geom::ToolPose;
use proveout_machine::{JointValues, Machine};
use proveout_reschedule::{JointGates, SwingLimits};

use crate::rtcp::Rig;

/// How near the fourth angle must be to the law of the other three, mm.
const LAW: f64 = 1e-6;

/// A wave of the table's angle.
#[derive(Clone, Copy)]
struct Wave {
    mean: f64,
    cosine: f64,
    sine: f64,
}

impl Wave {
    /// By its values at zero, a third and two thirds of a turn.
    fn of([a, b, c]: [f64; 3]) -> Self {
        Self { mean: (a + b + c) / 3.0, cosine: (2.0 * a - b - c) / 3.0, sine: (b - c) / 3.0_f64.sqrt() }
    }

    fn at(&self, q: f64) -> f64 {
        self.mean + self.cosine * q.cos() + self.sine * q.sin()
    }

    fn range(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let (size, crest) = (self.cosine.hypot(self.sine), self.sine.atan2(self.cosine));
        // Whether some `crest + k turns` lies in the interval.
        let holds = |angle: f64| angle + TAU * ((low - angle) / TAU).ceil() <= high;
        let [a, b] = [self.at(low), self.at(high)];
        [
            if holds(crest + 0.5 * TAU) { self.mean - size } else { a.min(b) },
            if holds(crest) { self.mean + size } else { a.max(b) },
        ]
    }
}

/// What holds at a gate.
pub(super) struct AtGate<'a> {
    pub(super) pose: &'a ToolPose,
    pub(super) joints: &'a JointValues,
    /// The table's angles, widened by what the control may leave them by.
    pub(super) table: [f64; 2],
}

/// Gates of the linear joints (mm) of a ball of a radius on a tool of a length (mm), the tip within `off` of
/// its place and rotary joints within `rounding` of theirs. None where the machine has not three straight
/// slides, or another law than the wave.
pub(super) fn linear_gates(
    machine: &Machine,
    table: usize,
    gates: &[AtGate<'_>],
    (ball, length): (f64, f64),
    (off, rounding): (f64, f64),
) -> Option<Vec<JointGates>> {
    let rig = Rig::new(machine)?;
    let mut out: Vec<(usize, JointGates)> = Vec::new();
    for &j in machine.linear_joints() {
        let joint = &machine.joints[j];
        let Some(velocity) = joint.max_velocity else { continue };
        let limits = SwingLimits {
            velocity,
            acceleration: joint.max_acceleration.unwrap_or(f64::INFINITY),
            jerk: joint.max_jerk.unwrap_or(f64::INFINITY),
        };
        out.push((j, JointGates { name: joint.name.clone(), limits, gates: Vec::with_capacity(gates.len()) }));
    }
    for gate in gates {
        let center = gate.pose.tip + gate.pose.axis * ball;
        let at = |angle: f64| {
            let mut q = *gate.joints;
            q[table] = angle;
            let axis = machine.forward(&q, 0.0).axis;
            machine.inverse_with_rotary(&(center - axis * ball), &q, length)
        };
        let [third, two] = [TAU / 3.0, 2.0 * TAU / 3.0];
        let tried = [0.0, third, two].map(at);
        let fourth = at(1.0);
        let mut task = *gate.joints;
        for (slot, x) in rig.slots.into_iter().zip(gate.pose.tip.coords.iter()) {
            task[slot] = *x;
        }
        // The table's own rounding is in its interval; what is left is that of the tip and of the joints that
        // incline the tool.
        let slack = rig.slack(&task, length, off + rounding * ball, rounding)?;
        for (j, joint) in &mut out {
            let wave = Wave::of(tried.map(|q| q[*j]));
            if (wave.at(1.0) - fourth[*j]).abs() > LAW {
                return None;
            }
            let [low, high] = wave.range(gate.table);
            let own = rig.slots.iter().position(|slot| slot == j).map(|k| slack[k])?;
            joint.gates.push([low - own, high + own]);
        }
    }
    Some(out.into_iter().map(|(_, joint)| joint).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_of_a_wave_holds_its_places_and_is_reached() {
        let mut state = 3_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..500 {
            let wave = Wave { mean: random(), cosine: random() - 0.5, sine: random() - 0.5 };
            let again = Wave::of([0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(|q| wave.at(q)));
            assert!((again.at(0.7) - wave.at(0.7)).abs() < 1e-12);
            let low = 20.0 * (random() - 0.5);
            let interval = [low, low + 8.0 * random().powi(2)];
            let [least, most] = wave.range(interval);
            let places = (0..=2000).map(|k| wave.at(low + (interval[1] - low) * f64::from(k) / 2000.0));
            let (down, up) = places.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            // A crest between two places 0.004 apart is no more than 0.7 * 0.002^2 / 2 above both.
            assert!(least <= down + 1e-12 && least > down - 2e-6 && most >= up - 1e-12 && most < up + 2e-6);
        }
    }
}
