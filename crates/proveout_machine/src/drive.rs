//! What is known of a joint's drive: loop gains, friction, backlash, elasticity, force limit;
//! `[joint.drive]`.
//!
//! ```text
//!              Kv              Kp, Tn           F max
//!   set ──►( )──►( )──────►( )───────►( )─────►[ / ]──► motor mass ──┤backlash├──spring, damper── load mass
//!    │      ▲     ▲ feed    ▲          ▲ feed                 │                             friction │
//!    │      │     │ forward └──────────┼──── motor encoder ◄──┤                                      │
//!    └──────┼─────┴────────────────────┘                      │ encoder = "motor"                    │
//!           └─────────────────────────────────────────────────┴───────────── encoder = "load" ◄──────┘
//! ```
//!
//! Linear joints are described in N, kg and mm, rotary joints in Nm, kg m² and degrees; all seen at the
//! joint, with gears and screws taken out. Inside, forces are in N and torques in N mm.

use schemars::JsonSchema;
use serde::Deserialize;

/// Place of the position encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Encoder {
    /// On the motor, before backlash and elasticity.
    Motor,
    /// On the load side: scale or ring encoder.
    Load,
}

/// Proportional gain of a velocity loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocityGain {
    /// N s/mm or N mm s/rad.
    Gain(f64),
    /// The gain over the moved mass (inertia), 1/s.
    Bandwidth(f64),
}

/// One oscillation between motor and load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticMode {
    /// Natural frequency of the load on the held motor, rad/s.
    pub frequency: f64,
    /// Damping ratio.
    pub damping: f64,
}

/// Data of a joint's drive, seen at the joint. Forces in N, torques in N mm, masses in kg, inertias in kg
/// mm²; mm, radian, second.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Kv, 1/s.
    pub position_gain: f64,
    /// Gain of the velocity loop.
    pub velocity_gain: VelocityGain,
    /// Tn, s; none: a proportional loop.
    pub integral_time: Option<f64>,
    /// Part of the commanded velocity that is fed forward.
    pub velocity_feed_forward: f64,
    /// Part of mass times commanded acceleration that is fed forward.
    pub acceleration_feed_forward: f64,
    /// Highest force or torque of the motor; none: not stated.
    pub max_force: Option<f64>,
    /// N s/mm or N mm s/rad.
    pub viscous_friction: f64,
    /// N or N mm.
    pub coulomb_friction: f64,
    /// N or N mm, not below the dry friction.
    pub static_friction: f64,
    /// mm/s or rad/s; zero where static and dry friction are equal.
    pub stribeck_velocity: f64,
    /// Whole lost motion, mm or radian.
    pub backlash: f64,
    /// Place of the position encoder.
    pub encoder: Encoder,
    /// Elasticity between motor and load; none: stiff.
    pub elastic: Option<ElasticMode>,
    /// Mass or inertia of the motor, which moves in addition to the load.
    pub motor_inertia: Option<f64>,
    /// Constant force of a weight compensation, N.
    pub counterbalance: f64,
}
