//! Drives for machines of which no drive data are published: sized from what each joint moves.
//!
//! A real axis is laid out from the moved mass and the wanted acceleration; the rule takes the same way back,
//! so that the drives of a machine belong to its bodies and limits. All numbers that it gives are choices;
//! those that it takes are the moved mass m (inertia J, at home), the limits of velocity v and acceleration
//! a, and the loads of the bodies.
//!
//! ```text
//!                        linear: ball screw and scale             rotary: torque motor or stiff gear,
//!                                                                 ring encoder
//!   elastic frequency f  75 Hz (600 kg / m)^(1/4), 40 to 120 Hz   none
//!   elastic damping      0.08                                     none
//!   motor at the joint   0.7 m                                    none
//!   velocity bandwidth   fv = 0.55 f                              fv = 30 Hz
//!   Kv                   2 pi fv / 5                              the same
//!   Tn                   3 / (2 pi fv)                            the same
//!   dry friction         3 percent of the weight m g              15 percent of J a
//!   static friction      1.45 times that, down to the dry one at 150 mm/min, 0.5 degrees/s
//!   viscous friction     at v three times the dry friction
//!   highest force        1.5 times (load of the bodies + motor + friction)
//! ```
//!
//! *Loads* are the largest of Newton-Euler over seeded random states within travel and velocity limits in
//! which every joint accelerates as hard as it may, one way or the other: corners of the limits, where loads
//! are largest, as they are linear in the accelerations.
//!
//! *Reasons.* Stiffness of screw drives grows about with the square root of what they move, hence the fourth
//! root; 75 Hz at 600 kg, motor and screw of 0.3 to 0.9 of the load, and Kv near 3 m/min per mm are usual for
//! machining centers. The velocity loop stays well below the oscillation that it must not excite, the
//! position loop by a factor of five below the velocity loop so that it does not overshoot (Groß, Hamann and
//! Wiegärtner 2001; Altintas et al. 2011). With the ratios fixed, all linear axes have the same shape of
//! answer, faster or slower.
//!
//! Limits: as trustworthy as the masses, which come from drawn shapes and densities. No backlash, no weight
//! compensation.

use std::f64::consts::TAU;

use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use super::model::MS_PER_S;
use crate::dynamics::{RigidTree, STANDARD_GRAVITY, TO_NEWTON};
use crate::pieces::WHOLE;

/// Random states that are tried for the loads; twice as many change no rounded force of the library.
const STATES: u32 = 4096;
/// Highest force over the largest need.
const RESERVE: f64 = 1.5;
const STATIC_OVER_DRY: f64 = 1.45;
const VISCOUS_OVER_DRY: f64 = 3.0;
/// mm make m, N mm make N m.
const M_PER_MM: f64 = 1e-3;
/// kg mm² make kg m².
const M2_PER_MM2: f64 = 1e-6;

/// A drive by the rule, in the units and rounding of `machine.toml`: N, kg, mm/min or Nm, kg m², degrees/s.
#[derive(Clone, Debug, PartialEq)]
pub struct SizedDrive {
    /// Index of the joint.
    pub joint: usize,
    /// What the joint moves, kg or kg m².
    pub moved: f64,
    /// Largest force (N) or torque (Nm) that motion within the limits takes.
    pub need: f64,
    /// Keys of `[joint.drive]` with their values, in the order of the schema.
    pub keys: Vec<(&'static str, f64)>,
    /// True when the joint turns.
    pub rotary: bool,
}

impl SizedDrive {
    /// The table in the form used in `machine.toml`.
    pub fn toml(&self) -> String {
        let mut text = String::from("[joint.drive]\n");
        for (key, value) in &self.keys {
            text.push_str(&format!("{key} = {value}\n"));
            if key.starts_with("stribeck") {
                text.push_str("encoder = \"load\"\n");
            }
        }
        text
    }
}

/// Nearest number of `digits` significant digits; `up`: not below the value.
fn rounded(value: f64, digits: i32, up: bool) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 0.0;
    }
    let power = digits - 1 - value.log10().floor() as i32;
    let whole = value * 10_f64.powi(power);
    let whole = if up { (whole - WHOLE).ceil() } else { whole.round() };
    // Division by a power of ten gives the decimal number itself.
    if power >= 0 { whole / 10_f64.powi(power) } else { whole * 10_f64.powi(-power) }
}

/// Random numbers of a fixed seed between -1 and 1 (xorshift64*, Vigna 2016).
struct Xorshift(u64);

impl Xorshift {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let unit = (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64;
        2.0 * unit - 1.0
    }
}

/// Largest loads (N, N mm) over `states` random states at the limits of acceleration.
pub fn largest_loads(machine: &Machine, tree: &RigidTree, states: u32, seed: u64) -> JointValues {
    let mut numbers = Xorshift(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut largest = JointValues::ZERO;
    for _ in 0..states {
        let [mut q, mut v, mut a] = [JointValues::ZERO; 3];
        for (j, joint) in machine.joints.iter().enumerate().take(MAX_JOINTS) {
            let [low, high] = joint.travel.unwrap_or([-TAU / 2.0, TAU / 2.0]);
            q[j] = 0.5 * (low + high) + 0.5 * (high - low) * numbers.next();
            v[j] = joint.max_velocity.unwrap_or(0.0) * numbers.next();
            a[j] = joint.max_acceleration.unwrap_or(0.0).copysign(numbers.next());
        }
        largest = largest.zip_map(tree.inverse_dynamics(&q, &v, &a), |m, t| m.max(t.abs()));
    }
    largest
}

/// Drives of all joints by the rule.
///
/// # Errors
/// A sentence on what is missing: masses, `up`, limits of velocity and acceleration; a platform.
pub fn size_drives(machine: &Machine) -> Result<Vec<SizedDrive>, String> {
    if let Some(platform) = machine.platforms.first() {
        return Err(format!(
            "machine {}: the rule sizes no legs, and platform {} has some",
            machine.name, platform.name
        ));
    }
    let tree = RigidTree::new(machine);
    if let Some((_, reason)) = tree.report().unknown.first() {
        return Err(format!("machine {}: {reason}", machine.name));
    }
    let loads = largest_loads(machine, &tree, STATES, 1);
    let matrix = tree.mass_matrix(&machine.home());
    let size = |(j, joint): (usize, &proveout_machine::Joint)| {
        let (Some(v), Some(a)) = (joint.max_velocity, joint.max_acceleration) else {
            let what = if joint.max_velocity.is_none() { "velocity" } else { "acceleration" };
            return Err(format!("machine {}, joint {}: the highest {what} is not stated", machine.name, joint.name));
        };
        Ok(if joint.is_rotary() {
            rotary(j, matrix[(j, j)] * M2_PER_MM2, v, a, loads[j] * M_PER_MM)
        } else {
            linear(j, matrix[(j, j)], v, a, loads[j])
        })
    };
    machine.joints.iter().enumerate().take(MAX_JOINTS).map(size).collect()
}

fn loops(bandwidth: f64) -> [(&'static str, f64); 5] {
    [
        ("position_gain_1_s", rounded(TAU * bandwidth / 5.0, 2, false)),
        ("velocity_bandwidth_hz", rounded(bandwidth, 2, false)),
        ("integral_time_ms", rounded(3.0 * MS_PER_S / (TAU * bandwidth), 2, false)),
        ("velocity_feed_forward", 1.0),
        ("acceleration_feed_forward", 1.0),
    ]
}

/// Mass in kg, mm/s, mm/s², N.
fn linear(joint: usize, moved: f64, v: f64, a: f64, load: f64) -> SizedDrive {
    let frequency = (75.0 * (600.0 / moved).powf(0.25)).clamp(40.0, 120.0);
    let motor = 0.7 * moved;
    let dry = 0.03 * moved * STANDARD_GRAVITY * TO_NEWTON;
    let need = load + motor * a * TO_NEWTON + (VISCOUS_OVER_DRY + 1.0) * dry;
    let mut keys = loops(0.55 * frequency).to_vec();
    keys.extend([
        ("max_force_N", rounded(RESERVE * need, 2, true)),
        ("viscous_friction_N_s_m", rounded(VISCOUS_OVER_DRY * dry / (v * M_PER_MM), 2, false)),
        ("coulomb_friction_N", rounded(dry, 2, false)),
        ("static_friction_N", rounded(STATIC_OVER_DRY * dry, 2, true)),
        ("stribeck_velocity_mm_min", 150.0),
        ("elastic_frequency_hz", rounded(frequency, 2, false)),
        ("elastic_damping", 0.08),
        ("motor_mass_kg", rounded(motor, 2, false)),
    ]);
    SizedDrive { joint, moved, need, keys, rotary: false }
}

/// Inertia in kg m², rad/s, rad/s², Nm.
fn rotary(joint: usize, moved: f64, v: f64, a: f64, load: f64) -> SizedDrive {
    let dry = 0.15 * moved * a;
    let need = load + (VISCOUS_OVER_DRY + 1.0) * dry;
    let mut keys = loops(30.0).to_vec();
    keys.extend([
        ("max_torque_Nm", rounded(RESERVE * need, 2, true)),
        ("viscous_friction_Nm_s_rad", rounded(VISCOUS_OVER_DRY * dry / v, 2, false)),
        ("coulomb_friction_Nm", rounded(dry, 2, false)),
        ("static_friction_Nm", rounded(STATIC_OVER_DRY * dry, 2, true)),
        ("stribeck_velocity_deg_s", 0.5),
    ]);
    SizedDrive { joint, moved, need, keys, rotary: true }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_two_digits() {
        for (value, nearest, up) in
            [(8712.0, 8700.0, 8800.0), (0.012_34, 0.012, 0.013), (50.0, 50.0, 50.0), (9.96, 10.0, 10.0)]
        {
            assert_eq!((rounded(value, 2, false), rounded(value, 2, true)), (nearest, up));
        }
    }

    #[test]
    fn a_slide_of_600_kg_has_the_usual_drive() {
        let d = linear(0, 600.0, 600.0, 5000.0, 3000.0);
        let of = |key: &str| d.keys.iter().find(|(k, _)| *k == key).expect("a key").1;
        // 0.55 x 75 Hz = 41.25 Hz: Kv = 51.8 1/s, Tn = 11.6 ms; 420 kg of motor take 2100 N, friction 4 x 177
        // N.
        assert_eq!((of("position_gain_1_s"), of("integral_time_ms"), of("motor_mass_kg")), (52.0, 12.0, 420.0));
        assert!((d.need - (3000.0 + 2100.0 + 4.0 * 176.52)).abs() < 0.1, "{}", d.need);
        assert_eq!(of("max_force_N"), 8800.0);
        assert!(d.toml().contains("encoder = \"load\"\nelastic_frequency_hz = 75\n"));
    }
}
