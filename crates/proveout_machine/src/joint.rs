use std::ops::{Add, Index, IndexMut, Mul, Neg, Sub};

use proveout_geom::{Point, Pose, Vector};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::TurnShift;

use crate::Drive;

/// Largest number of joints of a machine, held ones included.
pub const MAX_JOINTS: usize = 8;

/// Two rotary positions nearer than this (radian) count as equal where a travel limit is tested: 1e-9 rad is
/// 0.0002 arc second, far below any encoder, and covers the rounding of degrees read from text.
pub(crate) const TRAVEL_TOLERANCE: f64 = 1e-9;

/// One number a joint, in the order of [`crate::Machine::joints`]; unused entries are zero.
///
/// Positions are in mm (linear) and radian (rotary); the same type serves velocities, accelerations and
/// jerks, in mm and radian per second, second² and second³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointValues(pub [f64; MAX_JOINTS]);

impl JointValues {
    /// All zero.
    pub const ZERO: Self = Self([0.0; MAX_JOINTS]);

    /// The function of each entry.
    #[inline]
    pub fn map(self, f: impl FnMut(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    /// Entry by entry with another set.
    #[inline]
    pub fn zip_map(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    /// The straight way to `to` in joint space: `self` at `t` = 0 and exactly `to` at `t` = 1.
    #[inline]
    pub fn interpolated(self, to: Self, t: f64) -> Self {
        self.zip_map(to, |a, b| a * (1.0 - t) + b * t)
    }

    /// Largest absolute entry.
    pub fn max_abs(&self) -> f64 {
        self.0.iter().fold(0.0, |m, v| v.abs().max(m))
    }

    /// True when every entry is finite.
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }
}

impl Index<usize> for JointValues {
    type Output = f64;

    #[inline]
    fn index(&self, joint: usize) -> &f64 {
        &self.0[joint]
    }
}

impl IndexMut<usize> for JointValues {
    #[inline]
    fn index_mut(&mut self, joint: usize) -> &mut f64 {
        &mut self.0[joint]
    }
}

impl Add for JointValues {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip_map(other, |a, b| a + b)
    }
}

impl Sub for JointValues {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip_map(other, |a, b| a - b)
    }
}

impl Mul<f64> for JointValues {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        self.map(|a| a * factor)
    }
}

impl Neg for JointValues {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

// Positions inside of the program are in mm and radian.
/// Slide or turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum JointKind {
    /// Slides; its keys are in mm.
    Linear,
    /// Turns; its keys are in degrees.
    Rotary,
}

impl JointKind {
    /// Unit of positions in files, tables and texts: `mm` or `deg`.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Linear => "mm",
            Self::Rotary => "deg",
        }
    }

    /// From mm or radian to [`Self::unit`].
    pub fn unit_factor(self) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Rotary => 1_f64.to_degrees(),
        }
    }

    /// A position in [`Self::unit`]; right angles are exact.
    pub fn in_unit(self, position: f64) -> f64 {
        match self {
            Self::Linear => position,
            Self::Rotary => proveout_geom::deg(position),
        }
    }
}

/// Side of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Carries {
    /// Between base and spindle.
    Tool,
    /// Between base and table.
    Workpiece,
}

/// One axis of the machine with its limits; `None` means that the limit is not stated.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name, as in programs and tables (`X`, `B`, `C`).
    pub name: String,
    /// Slide or turn.
    pub kind: JointKind,
    /// Side of the machine that it moves.
    pub carries: Carries,
    /// Joint that carries this one; `None` for the base.
    pub parent: Option<usize>,
    /// Unit vector in M with all joints at zero.
    pub direction: Vector,
    /// A point on the axis of a rotary joint in M with all joints at zero, mm; the origin for a linear joint.
    pub point: Point,
    /// Sideways shift that comes with the turn: the tilt joint of a [`crate::Platform`] has one, no other
    /// joint.
    pub turn_shift: Option<TurnShift>,
    /// +1 or -1: the carried body moves physically by `sense` times the joint value along (about,
    /// right-handed) the direction. A table axis after ISO 841 has -1, since its values describe the motion
    /// of the tool relative to the workpiece.
    pub sense: f64,
    /// Lowest and highest position.
    pub travel: Option<[f64; 2]>,
    /// A rotary joint without end stops.
    pub endless: bool,
    /// Held at a value by the setup: inverse kinematics never moves it.
    pub held: bool,
    /// Highest velocity, mm/s or rad/s.
    pub max_velocity: Option<f64>,
    /// Highest acceleration, mm/s² or rad/s².
    pub max_acceleration: Option<f64>,
    /// Highest jerk, mm/s³ or rad/s³.
    pub max_jerk: Option<f64>,
    /// Velocity of rapid moves, mm/s or rad/s.
    pub rapid_velocity: Option<f64>,
    /// Position after switching on, and of a held joint: the stated one, else zero.
    pub home: f64,
    /// Somebody has stated the home position, so that it is a reference point (G28) too.
    pub home_stated: bool,
    /// Position in which tools are changed, if the joint has one.
    pub tool_change: Option<f64>,
    /// Mass (kg) or moment of inertia about the axis (kg mm²) that the drive moves, where known.
    pub moving_inertia: Option<f64>,
    /// The drive, where it is known.
    pub drive: Option<Drive>,
}

impl Joint {
    /// True for a rotary joint.
    #[inline]
    pub fn is_rotary(&self) -> bool {
        self.kind == JointKind::Rotary
    }

    /// Motion of what the joint carries at a position, in M with all joints at zero, errors apart.
    pub fn motion(&self, value: f64) -> Pose {
        if !self.is_rotary() {
            return Pose::from_translation(self.direction * (self.sense * value));
        }
        let turn = Pose::about_line(&self.point, &(self.direction * self.sense), value);
        match &self.turn_shift {
            None => turn,
            Some(shift) => Pose { translation: turn.translation + shift.at(value), ..turn },
        }
    }

    /// First reference point, that of G28: the home position, where it is stated.
    pub fn first_reference(&self) -> Option<f64> {
        self.home_stated.then_some(self.home)
    }

    /// Second reference point, that of G30: the tool change position, else the first one.
    pub fn second_reference(&self) -> Option<f64> {
        self.tool_change.or_else(|| self.first_reference())
    }

    /// The limit that a position passes, if it does. Positions within 1e-9 (mm or radian) of a limit keep it.
    pub fn travel_violation(&self, value: f64) -> Option<f64> {
        let [low, high] = self.travel?;
        if value < low - TRAVEL_TOLERANCE {
            Some(low)
        } else if value > high + TRAVEL_TOLERANCE {
            Some(high)
        } else {
            None
        }
    }
}
