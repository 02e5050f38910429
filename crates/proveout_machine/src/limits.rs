//! Travel, rate limits and amplification of a state of motion, as data for findings.

use std::fmt;

use crate::{JointKind, JointValues, Machine};

/// A leg may be past the end of its travel by this, mm: rounding.
const LENGTH_TOLERANCE_MM: f64 = 1e-9;

/// Joint positions and their first three derivatives by time: mm or radian, per s, s² and s³. What is not
/// known is [`JointValues::ZERO`], which keeps every limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionState {
    /// Positions.
    pub q: JointValues,
    /// Velocities.
    pub velocity: JointValues,
    /// Accelerations.
    pub acceleration: JointValues,
    /// Jerks.
    pub jerk: JointValues,
}

/// What passes a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limited {
    /// A joint, by index.
    Joint(usize),
    /// A leg of a platform.
    Leg {
        /// Index of the platform in [`Machine::platforms`].
        platform: usize,
        /// 0, 1 or 2.
        leg: usize,
    },
    /// The rotary joints together.
    RotaryJoints,
}

/// Which limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LimitKind {
    /// Position.
    Travel,
    /// First derivative.
    Velocity,
    /// Second derivative.
    Acceleration,
    /// Third derivative.
    Jerk,
    /// Turn of the rotary joints for a turn of the tool axis, rad/rad.
    Amplification,
}

/// A limit that is passed.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitViolation {
    /// What passes it.
    pub limited: Limited,
    /// Its name, `B` or `L1`.
    pub name: String,
    /// Which limit.
    pub kind: LimitKind,
    /// The value with its sign, in mm or radian per the second's power; infinite for the amplification of a
    /// singular pose.
    pub value: f64,
    /// The limit passed, same unit; the nearer end of the travel.
    pub limit: f64,
    /// True for radian.
    pub rotary: bool,
}

impl fmt::Display for LimitViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let power = match self.kind {
            LimitKind::Travel => "",
            LimitKind::Velocity => "/s",
            LimitKind::Acceleration => "/s²",
            LimitKind::Jerk => "/s³",
            LimitKind::Amplification => {
                return write!(
                    f,
                    "{} turn {:.3} times as fast as the tool axis; the limit is {:.3}",
                    self.name, self.value, self.limit
                );
            }
        };
        let word = format!("{:?}", self.kind).to_lowercase();
        let kind = if self.rotary { JointKind::Rotary } else { JointKind::Linear };
        let (unit, factor) = (kind.unit(), kind.unit_factor());
        let (value, limit) = (factor * self.value, factor * self.limit);
        write!(f, "{word} of {}: {value:.6} {unit}{power}, limit {limit:.6} {unit}{power}", self.name)
    }
}

/// A value and the limit of its size that it passes by more than the relative tolerance.
fn passed(value: f64, limit: Option<f64>, tolerance: f64) -> Option<(f64, f64)> {
    let limit = limit?;
    // A value that is no number is no value within the limit.
    let within = value.abs() <= limit * (1.0 + tolerance);
    (!within).then_some((value, limit))
}

impl Machine {
    /// Every limit that a state of motion exceeds: travel, velocity, acceleration and jerk of each joint
    /// and of each leg, in the order of the joints, then of the legs. `tolerance` is the fraction by which
    /// velocity, acceleration and jerk may exceed their limits (0.001 for 0.1 percent); for travel it is
    /// 1e-9 mm or rad.
    ///
    /// A limit that is not stated cannot be exceeded: see [`Machine::missing_limits`] for what stays
    /// unchecked. Nothing is allocated while every limit is kept.
    ///
    /// ```
    /// use proveout_machine::{Machine, MotionState};
    ///
    /// let machine = Machine::read("../../machines/spinner-u5-620".as_ref())?;
    /// let mut state = MotionState { q: machine.home(), ..MotionState::default() };
    /// assert!(machine.limit_violations(&state, 0.001).is_empty());
    /// // X runs at 36 m/min at most, which is 600 mm/s.
    /// state.velocity[machine.joint("X").expect("it has X")] = 610.0;
    /// let found = machine.limit_violations(&state, 0.001);
    /// assert_eq!(found.len(), 1);
    /// assert_eq!((found[0].name.as_str(), found[0].value), ("X", 610.0));
    /// assert!((found[0].limit - 600.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn limit_violations(&self, state: &MotionState, tolerance: f64) -> Vec<LimitViolation> {
        let mut all = Vec::new();
        for (j, joint) in self.joints.iter().enumerate() {
            let travel = joint.travel_violation(state.q[j]).map(|limit| (state.q[j], limit));
            let travel = travel.or((!state.q[j].is_finite()).then_some((state.q[j], f64::NAN)));
            let found = [
                (LimitKind::Travel, travel),
                (LimitKind::Velocity, passed(state.velocity[j], joint.max_velocity, tolerance)),
                (LimitKind::Acceleration, passed(state.acceleration[j], joint.max_acceleration, tolerance)),
                (LimitKind::Jerk, passed(state.jerk[j], joint.max_jerk, tolerance)),
            ];
            for (kind, values) in found {
                let Some((value, limit)) = values else { continue };
                let (limited, name, rotary) = (Limited::Joint(j), joint.name.clone(), joint.is_rotary());
                all.push(LimitViolation { limited, name, kind, value, limit, rotary });
            }
        }
        for (p, platform) in self.platforms.iter().enumerate() {
            let lengths = platform.leg_lengths(&state.q);
            let [rates, accelerations] = platform.leg_motion(&state.q, &state.velocity, &state.acceleration);
            let jerks = platform.leg_jerk(&state.q, [&state.velocity, &state.acceleration, &state.jerk]);
            for (k, leg) in platform.legs.iter().enumerate() {
                let travel = leg.travel.and_then(|[low, high]| {
                    let within = (low - LENGTH_TOLERANCE_MM..=high + LENGTH_TOLERANCE_MM).contains(&lengths[k]);
                    (!within).then_some((lengths[k], if lengths[k] < low { low } else { high }))
                });
                let found = [
                    (LimitKind::Travel, travel),
                    (LimitKind::Velocity, passed(rates[k], leg.max_velocity, tolerance)),
                    (LimitKind::Acceleration, passed(accelerations[k], leg.max_acceleration, tolerance)),
                    (LimitKind::Jerk, passed(jerks[k], leg.max_jerk, tolerance)),
                ];
                for (kind, values) in found {
                    let Some((value, limit)) = values else { continue };
                    let (limited, name) = (Limited::Leg { platform: p, leg: k }, leg.name.clone());
                    all.push(LimitViolation { limited, name, kind, value, limit, rotary: false });
                }
            }
        }
        all
    }

    /// The amplification of a pose where it is above `limit` (rad/rad): see
    /// [`Machine::rotary_amplification`].
    pub fn amplification_violation(&self, q: &JointValues, limit: f64) -> Option<LimitViolation> {
        let value = self.rotary_amplification(q)?;
        let within = value <= limit;
        if within {
            return None;
        }
        let names: Vec<&str> = self.rotary_joints().iter().map(|&j| self.joints[j].name.as_str()).collect();
        Some(LimitViolation {
            limited: Limited::RotaryJoints,
            name: names.join(" and "),
            kind: LimitKind::Amplification,
            value,
            limit,
            rotary: true,
        })
    }

    /// Angle (radian) between a tool axis in K and the nearest one at which the machine is singular: where
    /// the table-side rotary joint does not turn the tool, or its reach ends and branches meet. `None` with
    /// fewer than two rotary joints, or with more.
    pub fn cone_angle(&self, axis_in_table: &proveout_geom::Vector) -> Option<f64> {
        self.solver.cone_angle(&self.chain, axis_in_table)
    }
}
