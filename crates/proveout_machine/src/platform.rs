//! The 3-RPS platform: three legs of variable length between a fixed and a moving plate.
//!
//! Each leg turns on the fixed plate about a hinge (R), slides (P) and ends in a ball joint (S) on the
//! moving plate. The joints are 120 degrees apart on circles of radius `r_p` (fixed) and `r_b` (moving).
//! Leg 1 is in the direction `e1`, and each hinge keeps its leg in the upright plane through the middle and
//! its hinge.
//!
//! ```text
//!      side view, tilt a             from above
//!          S1                              S1
//!     ___--                                |  e1 ^
//!  S2,3  \                                 o     |
//!    \    |  leg 1                       /   \
//!     \   |                            S2     S3
//!   ---R--R---  fixed plate       tilt axis: across e1 and heave
//! ```
//!
//! With legs 2 and 3 of equal length the plate has two freedoms, the heave H of its middle over the fixed
//! plate and the tilt a about the axis `t` across `e1` and the heave direction (positive where it raises leg
//! 1). The ball joints 2 and 3 lie at `-r_b/2` along `e1` before the tilt and must stay in planes through the
//! upright middle line that meet `e1` at 60 degrees; their distance from the plane of `e1` and heave does not
//! change with a, hence neither may their place along `e1`: the middle shifts by
//!
//! ```text
//!   c(a) = -(r_b / 2) (1 - cos a)     along e1, the parasitic motion     (Lu, Yang and Zhao 2022, corrected)
//!   L1^2 = (1.5 r_b cos a - 0.5 r_b - r_p)^2 + (H + r_b sin a)^2
//!   L2^2 = L3^2 = (r_b - r_p)^2 + (H - 0.5 r_b sin a)^2
//! ```
//!
//! From the legs: `h2 = H - 0.5 r_b sin a = sqrt(L2^2 - (r_b - r_p)^2)`, the moving plate staying above its
//! hinges; put into L1 this is linear in sine and cosine, `L1^2 - (1.5 r_b)^2 - k^2 - h2^2 = 3 r_b (h2 sin
//! a - k cos a)` with `k = 0.5 r_b + r_p`, so that the assembly has two tilts, and the one nearer to the
//! last is taken. They meet where leg 1 lies in the plane of the moving plate.
//!
//! Limits: the second tilt, which legs 2 and 3 of different length would give, is not driven; lengths that
//! differ are refused. The legs are rigid.

use proveout_geom::Vector;
use thiserror::Error;

use crate::{Drive, JointValues};

/// Legs 2 and 3 count as equal within this, mm: a difference of 1e-6 tilts a plate of 100 mm by 1e-8 rad.
const EQUAL_LEGS_MM: f64 = 1e-6;

/// One leg; `None` means that the limit is not stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Leg {
    /// Name, `L1`.
    pub name: String,
    /// Shortest and longest distance of its two joints, mm.
    pub travel: Option<[f64; 2]>,
    /// Highest velocity, mm/s.
    pub max_velocity: Option<f64>,
    /// Highest acceleration, mm/s².
    pub max_acceleration: Option<f64>,
    /// Highest jerk, mm/s³.
    pub max_jerk: Option<f64>,
    /// Mass that the drive moves, along the leg, kg.
    pub moving_mass: Option<f64>,
    /// The drive; of legs 2 and 3 the same.
    pub drive: Option<Drive>,
}

/// A 3-RPS platform: a heave and a tilt joint of the machine, driven together by three legs.
#[derive(Clone, Debug, PartialEq)]
pub struct Platform {
    /// Name.
    pub name: String,
    /// Linear joint: height of the moving plate.
    pub heave: usize,
    /// Rotary joint on the heave joint: tilt of the moving plate. Its point is the middle of the moving
    /// circle.
    pub tilt: usize,
    /// Radius of the circle of fixed joints, mm.
    pub fixed_radius: f64,
    /// Radius of the circle of moving joints, mm.
    pub moving_radius: f64,
    /// Distance of the two circles with both joints at zero, mm.
    pub height: f64,
    /// Unit vector from the middle to leg 1 in M.
    pub leg_1_direction: Vector,
    /// Heave of the plate for a growing value of the heave joint, +1 or -1.
    pub heave_sign: f64,
    /// +1 where a growing value of the tilt joint raises leg 1, else -1.
    pub tilt_sign: f64,
    /// Legs 1, 2 and 3.
    pub legs: [Leg; 3],
}

/// Why legs have no pose of the platform.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PlatformError {
    /// A length is not finite or not positive.
    #[error("a leg length of {length} mm is impossible; lengths are distances between the joints of a leg")]
    Length {
        /// The length, mm.
        length: f64,
    },
    /// Legs 2 and 3 differ.
    #[error("legs 2 and 3 differ by {difference:.6} mm: that is a second tilt, which this platform does not have")]
    SecondTilt {
        /// Difference, mm.
        difference: f64,
    },
    /// The legs do not reach each other.
    #[error("legs of {first:.6} mm and {second:.6} mm do not close: leg {leg} is too {}", if *short { "short" } else { "long" })]
    Open {
        /// Length of leg 1, mm.
        first: f64,
        /// Length of legs 2 and 3, mm.
        second: f64,
        /// The leg at fault, 1 or 2.
        leg: usize,
        /// Whether it is too short.
        short: bool,
    },
}

/// Values that the formulas share.
struct LegTerms {
    sin: f64,
    cos: f64,
    /// Reach of leg 1 and legs 2, 3 outward (mm, constant for the latter) and upward.
    out_1: f64,
    out_2: f64,
    up_1: f64,
    up_2: f64,
}

impl Platform {
    fn state(&self, q: &JointValues) -> LegTerms {
        let height = self.height + self.heave_sign * q[self.heave];
        let (sin, cos) = proveout_geom::sin_cos(self.tilt_sign * q[self.tilt]);
        let r = self.moving_radius;
        LegTerms {
            sin,
            cos,
            out_1: 1.5 * r * cos - 0.5 * r - self.fixed_radius,
            out_2: r - self.fixed_radius,
            up_1: height + r * sin,
            up_2: height - 0.5 * r * sin,
        }
    }

    /// Shift of the plate's middle along [`Platform::leg_1_direction`], mm: the parasitic motion, never
    /// positive.
    pub fn parasitic_shift(&self, q: &JointValues) -> f64 {
        // 1 - cos a without cancellation.
        let half = (0.5 * q[self.tilt]).sin();
        -self.moving_radius * half * half
    }

    /// Lengths of legs 1, 2 and 3, mm.
    pub fn leg_lengths(&self, q: &JointValues) -> [f64; 3] {
        let s = self.state(q);
        let second = s.out_2.hypot(s.up_2);
        [s.out_1.hypot(s.up_1), second, second]
    }

    /// Velocity and acceleration of legs 1, 2 and 3, mm/s and mm/s², for joint velocities and accelerations.
    pub fn leg_motion(&self, q: &JointValues, velocity: &JointValues, acceleration: &JointValues) -> [[f64; 3]; 2] {
        let s = self.state(q);
        let r = self.moving_radius;
        let (dh, ddh) = (self.heave_sign * velocity[self.heave], self.heave_sign * acceleration[self.heave]);
        let (da, dda) = (self.tilt_sign * velocity[self.tilt], self.tilt_sign * acceleration[self.tilt]);
        // First and second derivative of sine and cosine of the tilt.
        let (sin_1, cos_1) = (s.cos * da, -s.sin * da);
        let (sin_2, cos_2) = (s.cos * dda - s.sin * da * da, -s.sin * dda - s.cos * da * da);
        let leg = |out: [f64; 3], up: [f64; 3]| {
            let length = out[0].hypot(up[0]);
            let rate = (out[0] * out[1] + up[0] * up[1]) / length;
            let squares = out[1] * out[1] + up[1] * up[1] + out[0] * out[2] + up[0] * up[2];
            [rate, (squares - rate * rate) / length]
        };
        let first = leg([s.out_1, 1.5 * r * cos_1, 1.5 * r * cos_2], [s.up_1, dh + r * sin_1, ddh + r * sin_2]);
        let second = leg([s.out_2, 0.0, 0.0], [s.up_2, dh - 0.5 * r * sin_1, ddh - 0.5 * r * sin_2]);
        [[first[0], second[0], second[0]], [first[1], second[1], second[1]]]
    }

    /// Rates of leg 1 and of legs 2 and 3 with the values of heave joint (first column, mm/mm) and tilt joint
    /// (mm/rad).
    pub fn leg_rates(&self, q: &JointValues) -> [[f64; 2]; 2] {
        let s = self.state(q);
        let r = self.moving_radius;
        let [first, second] = [s.out_1.hypot(s.up_1), s.out_2.hypot(s.up_2)];
        [
            [self.heave_sign * s.up_1 / first, self.tilt_sign * r * (s.up_1 * s.cos - 1.5 * s.out_1 * s.sin) / first],
            [self.heave_sign * s.up_2 / second, -0.5 * self.tilt_sign * r * s.up_2 * s.cos / second],
        ]
    }

    /// Velocities of heave and tilt joint for those of leg 1 and of legs 2 and 3 (mm/s, rad/s); not finite
    /// where the legs do not hold the plate.
    pub fn joint_rates(&self, q: &JointValues, [first, second]: [f64; 2]) -> [f64; 2] {
        let [[a, b], [c, d]] = self.leg_rates(q);
        let determinant = a * d - b * c;
        [(d * first - b * second) / determinant, (a * second - c * first) / determinant]
    }

    /// Jerk of legs 1, 2 and 3, mm/s³, for the first three derivatives of the joints.
    ///
    /// With p from the fixed to the moving joint of a leg and L its length, two more derivatives of `L L' = p
    /// . p'` give `L L''' = 3 p' . p'' + p . p''' - 3 L' L''`.
    pub fn leg_jerk(&self, q: &JointValues, [velocity, acceleration, jerk]: [&JointValues; 3]) -> [f64; 3] {
        let s = self.state(q);
        let r = self.moving_radius;
        let [rates, accelerations] = self.leg_motion(q, velocity, acceleration);
        let heave = [velocity, acceleration, jerk].map(|d| self.heave_sign * d[self.heave]);
        let [a1, a2, a3] = [velocity, acceleration, jerk].map(|d| self.tilt_sign * d[self.tilt]);
        // First to third derivative of sine and cosine of the tilt.
        let sin = [s.cos * a1, s.cos * a2 - s.sin * a1 * a1, s.cos * (a3 - a1.powi(3)) - 3.0 * s.sin * a1 * a2];
        let cos = [-s.sin * a1, -s.sin * a2 - s.cos * a1 * a1, s.sin * (a1.powi(3) - a3) - 3.0 * s.cos * a1 * a2];
        let leg = |k: usize, at: [f64; 2], out: [f64; 3], up: [f64; 3]| {
            let steps = out[0] * out[1] + up[0] * up[1];
            let reach = at[0] * out[2] + at[1] * up[2];
            (3.0 * steps + reach - 3.0 * rates[k] * accelerations[k]) / at[0].hypot(at[1])
        };
        let up = |part: f64| std::array::from_fn(|k| heave[k] + part * r * sin[k]);
        let first = leg(0, [s.out_1, s.up_1], cos.map(|c| 1.5 * r * c), up(1.0));
        let second = leg(1, [s.out_2, s.up_2], [0.0; 3], up(-0.5));
        [first, second, second]
    }

    /// How well the legs hold the plate, from 1 down to 0 at a singular pose: the sine of the angle of legs 2
    /// and 3 over the fixed plate times that of leg 1 over the moving plate (the determinant of leg rates by
    /// heave and tilt, divided by `1.5 r_b`).
    pub fn transmission(&self, q: &JointValues) -> f64 {
        let s = self.state(q);
        let first = (s.up_1 * s.cos - s.out_1 * s.sin) / s.out_1.hypot(s.up_1);
        let second = s.up_2 / s.out_2.hypot(s.up_2);
        (first * second).abs()
    }

    /// Values of heave and tilt joint (mm, radian) for leg lengths (mm); of the two assemblies the one whose
    /// tilt is nearer to `near`.
    ///
    /// # Errors
    /// [`PlatformError`]: the legs do not close.
    pub fn from_legs(&self, lengths: [f64; 3], near: &JointValues) -> Result<[f64; 2], PlatformError> {
        if let Some(&length) = lengths.iter().find(|l| !(l.is_finite() && **l > 0.0)) {
            return Err(PlatformError::Length { length });
        }
        let [first, second, third] = lengths;
        if (second - third).abs() > EQUAL_LEGS_MM {
            return Err(PlatformError::SecondTilt { difference: (second - third).abs() });
        }
        let second = 0.5 * (second + third);
        let r = self.moving_radius;
        let out_2 = r - self.fixed_radius;
        let square = (second - out_2) * (second + out_2);
        let open = |leg, short| Err(PlatformError::Open { first, second, leg, short });
        if square < 0.0 {
            return open(2, true);
        }
        let up_2 = square.sqrt();
        let k = 0.5 * r + self.fixed_radius;
        // up_2 sin a - k cos a = c, thus reach sin(a - phase) = c with phase = atan2(k, up_2).
        let c = (first * first - 2.25 * r * r - k * k - square) / (3.0 * r);
        let reach = k.hypot(up_2);
        let rest = (reach - c) * (reach + c);
        if rest < 0.0 {
            return open(1, c < 0.0);
        }
        let phase = k.atan2(up_2);
        let turn = c.atan2(rest.sqrt());
        let wanted = self.tilt_sign * near[self.tilt];
        let tilt = [phase + turn, phase + std::f64::consts::PI - turn]
            .map(|a| proveout_geom::wrap_near(a, wanted))
            .into_iter()
            .min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()))
            .unwrap_or(phase);
        let height = up_2 + 0.5 * r * tilt.sin();
        Ok([self.heave_sign * (height - self.height), self.tilt_sign * tilt])
    }
}
