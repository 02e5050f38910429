//! Units of files and plots: joints in mm or degrees, feeds in mm/min.

use proveout_machine::{Joint, Machine};

/// A joint with the factor from internal units (mm or radian) to those of files and plots (mm or degrees).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointUnit {
    pub(crate) name: String,
    pub(crate) rotary: bool,
    /// `mm` or `deg`.
    pub(crate) unit: &'static str,
    pub(crate) factor: f64,
    /// `N` or `Nm`.
    pub(crate) force_unit: &'static str,
    /// From N or N mm to it.
    pub(crate) force_factor: f64,
}

impl JointUnit {
    fn of(joint: &Joint) -> Self {
        let (unit, factor) = (joint.kind.unit(), joint.kind.unit_factor());
        let (force_unit, force_factor) = if joint.is_rotary() { ("Nm", N_M_PER_N_MM) } else { ("N", 1.0) };
        Self { name: joint.name.clone(), rotary: joint.is_rotary(), unit, factor, force_unit, force_factor }
    }

    /// What its drive gives.
    pub(crate) fn effort(&self) -> &'static str {
        if self.rotary { "torque" } else { "force" }
    }

    /// Units of all joints, in machine order.
    pub(crate) fn all(machine: &Machine) -> Vec<Self> {
        machine.joints.iter().map(Self::of).collect()
    }
}

/// N m of an N mm.
const N_M_PER_N_MM: f64 = 1e-3;
/// Micrometers of a millimeter.
pub(crate) const UM_PER_MM: f64 = 1e3;
/// Millimeters of a micrometer.
pub(crate) const MM_PER_UM: f64 = 1e-3;
/// mm/s to mm/min.
pub(crate) const PER_MINUTE: f64 = 60.0;
