//! Settings and machine data that no plan can be made with are refused before the run.

use proveout_machine::Machine;
use proveout_tool::Tool;

use crate::{error::ControlError, settings::Settings};

pub(super) fn check_settings(settings: &Settings) -> Result<(), Box<ControlError>> {
    let named = [
        ("default_tolerance", settings.default_tolerance.unwrap_or(1.0), true),
        ("default_orientation_tolerance", settings.default_orientation_tolerance.unwrap_or(1.0), true),
        ("pole_cone", settings.pole_cone.unwrap_or(0.0), true),
        ("piece_tolerance", settings.piece_tolerance, false),
        ("piece_body_tolerance", settings.piece_body_tolerance, false),
        ("piece_length", settings.piece_length, false),
        ("piece_angle", settings.piece_angle, false),
        ("sample_time", settings.sample_time.unwrap_or(1.0), false),
    ];
    for (name, value, zero_allowed) in named {
        if !(value.is_finite() && (value > 0.0 || zero_allowed && value == 0.0)) {
            return Err(Box::new(ControlError {
                code: "control-settings",
                message: format!("the setting {name} is {value}"),
                location: None,
                help: Some("give a number above zero".to_owned()),
            }));
        }
    }
    if let Some(cone) = settings.pole_cone.filter(|c| *c > Machine::WIDEST_POLE_CONE) {
        return Err(Box::new(ControlError {
            code: "control-settings",
            message: format!("the setting pole_cone is {} degrees", cone.to_degrees()),
            location: None,
            help: Some(format!("give at most {} degrees", Machine::WIDEST_POLE_CONE.to_degrees())),
        }));
    }
    Ok(())
}

pub(super) fn check_cycle(machine: &Machine) -> Result<(), Box<ControlError>> {
    let cycle = machine.control.cycle_time;
    if cycle > 0.0 && cycle.is_finite() {
        return Ok(());
    }
    Err(Box::new(ControlError {
        code: "control-limits",
        message: format!("the control cycle of machine {} is {cycle} s", machine.name),
        location: None,
        help: Some("give a cycle above zero".to_owned()),
    }))
}

pub(super) fn check_limits(machine: &Machine) -> Result<(), Box<ControlError>> {
    for joint in &machine.joints {
        let named = [
            ("max_velocity", joint.max_velocity),
            ("max_acceleration", joint.max_acceleration),
            ("max_jerk", joint.max_jerk),
            ("rapid_velocity", joint.rapid_velocity),
        ];
        for (name, value) in named {
            if value.is_some_and(|v| v.is_nan() || v <= 0.0) {
                return Err(Box::new(ControlError {
                    code: "control-limits",
                    message: format!("joint {} has {name} = {:?}", joint.name, value.unwrap_or(f64::NAN)),
                    location: None,
                    help: Some(
                        "give a number above zero, or leave the key out where the limit is not known".to_owned(),
                    ),
                }));
            }
        }
    }
    Ok(())
}

/// The tool that is in the spindle before the first block.
pub(super) fn start_tool(tools: &[Tool], number: u32) -> Result<usize, Box<ControlError>> {
    tools.iter().position(|t| t.number == number).ok_or_else(|| {
        let message = format!(
            "tool T{number}, which is in the spindle at the start, is not in the tool library ({} tools)",
            tools.len()
        );
        Box::new(ControlError {
            code: "control-tool",
            message,
            location: None,
            help: Some("add the tool to the library, or correct its number".to_owned()),
        })
    })
}
