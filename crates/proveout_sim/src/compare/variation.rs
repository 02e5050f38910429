//! The twin with one parameter changed.

use proveout_controller::{Dynamics, servo::without_drive};

use super::uncertainty::VariationKind;
use crate::prepare::motion_only::MotionCase;

/// Range in which a limit of a joint is known: what a machine is set to in the workshop and what its data
/// sheet says differ by about a tenth.
const LIMIT_RANGE: f64 = 0.1;

/// What is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Pieces(f64),
    Window(f64),
    Cycle(f64),
    Sampling(f64),
    PathTolerance(f64),
    Velocity(f64),
    Acceleration(f64),
    Jerk(f64),
    Dynamics(Dynamics),
    OwnLimits,
}

/// A variation of the twin.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TwinVariation {
    pub(crate) name: String,
    pub(crate) parameter: &'static str,
    pub(crate) kind: VariationKind,
    change: Change,
}

/// The twin with the limits of the machine itself in place of those that the scene sets: another twin, not an
/// error of this one.
pub(crate) fn own_limits() -> TwinVariation {
    TwinVariation {
        name: "limits of the machine itself".into(),
        parameter: "limits of the scene",
        kind: VariationKind::Model,
        change: Change::OwnLimits,
    }
}

/// Every variation of a twin with these dynamics.
pub(crate) fn variations(nominal: Dynamics) -> Vec<TwinVariation> {
    use VariationKind::{Model, Numerical};
    let mut out = Vec::new();
    let mut put = |name: String, parameter, kind, change| out.push(TwinVariation { name, parameter, kind, change });
    let halves = [(0.5, "halved"), (2.0, "doubled")];
    put("tolerance of motion pieces halved".into(), "motion pieces", Numerical, Change::Pieces(0.5));
    for (factor, word) in halves {
        put(format!("window of the look-ahead {word}"), "look-ahead window", Numerical, Change::Window(factor));
    }
    for (factor, word) in halves {
        put(format!("control cycle {word}"), "control cycle", Numerical, Change::Cycle(factor));
    }
    put("sampling of the motion halved".into(), "sampling", Numerical, Change::Sampling(0.5));
    for (factor, word) in halves {
        put(format!("path tolerance {word}"), "path tolerance", Model, Change::PathTolerance(factor));
    }
    for parameter in ["joint velocity limits", "joint acceleration limits", "joint jerk limits"] {
        for sign in [-1.0, 1.0] {
            let factor = 1.0 + sign * LIMIT_RANGE;
            let change = match parameter {
                "joint velocity limits" => Change::Velocity(factor),
                "joint acceleration limits" => Change::Acceleration(factor),
                _ => Change::Jerk(factor),
            };
            put(format!("{parameter} {:+.0} %", 100.0 * sign * LIMIT_RANGE), parameter, Model, change);
        }
    }
    for (dynamics, word) in
        [(Dynamics::Ideal, "ideal"), (Dynamics::Planned, "planned"), (Dynamics::Servo, "those of the drives")]
    {
        if dynamics != nominal {
            put(format!("dynamics {word}"), "dynamics", Model, Change::Dynamics(dynamics));
        }
    }
    out
}

impl TwinVariation {
    /// Whether the times of the set points can be others. Pieces cut a motion that is planned, and without
    /// drives rounded corners are run at the times of the programmed ones (`proveout_controller`: one law for
    /// both).
    pub(crate) fn changes_law(&self, case: &MotionCase) -> bool {
        let planned = case.settings.dynamics != Dynamics::Servo;
        match self.change {
            Change::Pieces(_) => !planned,
            Change::Dynamics(dynamics) => !planned || dynamics == Dynamics::Servo,
            _ => true,
        }
    }

    /// The case with this change.
    ///
    /// # Errors
    /// Why the change cannot be made on this machine, in words.
    pub(crate) fn apply(&self, case: &MotionCase) -> Result<MotionCase, String> {
        let mut out = case.clone().unmeasured();
        match self.change {
            Change::Pieces(f) => {
                out.settings.piece_tolerance *= f;
                out.settings.piece_body_tolerance *= f;
                out.settings.piece_length *= f;
                out.settings.piece_angle *= f;
            }
            Change::Window(f) => {
                out.settings.look_ahead_blocks = ((out.settings.look_ahead_blocks as f64 * f) as usize).max(1);
            }
            Change::Cycle(f) => {
                out.machine.control.cycle_time *= f;
                out.settings.sample_time = out.settings.sample_time.map(|t| t * f);
            }
            Change::Sampling(f) => {
                let time = out.settings.sample_time.unwrap_or(out.machine.control.cycle_time);
                out.settings.sample_time = Some(time * f);
            }
            Change::PathTolerance(f) => {
                out.tolerance_factor *= f;
                out.machine.control.default_tolerance *= f;
                let orientation = &mut out.machine.control.default_orientation_tolerance;
                *orientation = orientation.map(|t| t * f);
                out.settings.default_tolerance = out.settings.default_tolerance.map(|t| t * f);
                let orientation = &mut out.settings.default_orientation_tolerance;
                *orientation = orientation.map(|t| t * f);
            }
            Change::Velocity(f) => {
                for joint in &mut out.machine.joints {
                    joint.max_velocity = joint.max_velocity.map(|v| v * f);
                    joint.rapid_velocity = joint.rapid_velocity.map(|v| v * f);
                }
            }
            Change::Acceleration(f) => {
                for joint in &mut out.machine.joints {
                    joint.max_acceleration = joint.max_acceleration.map(|a| a * f);
                }
            }
            Change::Jerk(f) => {
                for joint in &mut out.machine.joints {
                    joint.max_jerk = joint.max_jerk.map(|j| j * f);
                }
            }
            Change::Dynamics(dynamics) => {
                if dynamics == Dynamics::Servo {
                    let missing = without_drive(&out.machine);
                    if !missing.is_empty() {
                        return Err(format!("the machine does not describe the drives of {}", missing.join(", ")));
                    }
                }
                out.settings.dynamics = dynamics;
            }
            Change::OwnLimits => {
                if let Some(machine) = &case.own_machine {
                    out.machine = machine.clone();
                }
            }
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_is_varied_and_the_nominal_dynamics_are_not() {
        for nominal in [Dynamics::Ideal, Dynamics::Planned, Dynamics::Servo] {
            let all = variations(nominal);
            assert!(all.iter().all(|v| v.change != Change::Dynamics(nominal)));
            assert_eq!(all.iter().filter(|v| v.parameter == "dynamics").count(), 2);
            let mut names: Vec<&str> = all.iter().map(|v| v.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), all.len(), "each has its own name");
            assert!(all.iter().any(|v| v.name == "joint jerk limits -10 %"), "{names:?}");
        }
    }
}
