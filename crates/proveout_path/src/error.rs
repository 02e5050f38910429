use proveout_machine::KinematicsError;
use thiserror::Error;

/// Where on a blade, for messages: the section by its v, the point by its u, both as part of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BladeLocation {
    /// Part of the way along the blade, 0 to 1.
    pub section: f64,
    /// Part of the way round the section, 0 to 1.
    pub round: f64,
    /// Place in the frame of the blade, mm.
    pub point: [f64; 3],
}

impl std::fmt::Display for BladeLocation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.point;
        write!(f, "section {:.4}, point {:.4} of its round (X{x:.3} Y{y:.3} Z{z:.3})", self.section, self.round)
    }
}

/// Why a path cannot be planned. Nothing is left half done: a plan is whole or is refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PathError {
    /// A number is not finite or outside of its range.
    #[error("{name} is {value}; it must be {range}")]
    Value {
        /// The number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: String,
    },
    /// A local concavity is narrower than the cutter.
    #[error(
        "the cutter is too large at {at}: its curvature there is {cutter_1_mm:.5} 1/mm, the hollow of the surface has \
         {surface_1_mm:.5} 1/mm in the same direction"
    )]
    CutterTooLarge {
        /// The place.
        at: BladeLocation,
        /// Normal curvature of the cutter in the direction in which both are nearest to each other, 1/mm.
        cutter_1_mm: f64,
        /// Hollowness of the surface in that direction, 1/mm.
        surface_1_mm: f64,
    },
    /// The contact would lie on the upper end of the cutter.
    #[error(
        "the tool axis at {at} is tilted {angle_deg:.2} degrees from the outward normal: the cutter would touch with its upper end"
    )]
    AxisBelowSurface {
        /// The place.
        at: BladeLocation,
        /// Angle between axis and normal, degree.
        angle_deg: f64,
    },
    /// The rule of the tool axis has no direction.
    #[error("the rule of the tool axis has no direction at {at}: the normal is parallel to the table's axis")]
    NoAxis {
        /// The place.
        at: BladeLocation,
    },
    /// The machine cannot take the pose.
    #[error("the machine cannot take the tool axis at {at}: {fault}")]
    Unreachable {
        /// The place.
        at: BladeLocation,
        /// What the machine says.
        fault: KinematicsError,
    },
    /// A step, or the step that a chord error allows, is longer than the radius of the path.
    #[error("the step of {step_mm:.4} mm at {at} is longer than the radius of the path, {radius_mm:.4} mm")]
    StepLongerThanRadius {
        /// The place.
        at: BladeLocation,
        /// Step, mm.
        step_mm: f64,
        /// Radius of curvature of the path, mm.
        radius_mm: f64,
    },
    /// The flank of the cutter does not fit the ruled side.
    #[error(
        "the flank of the cutter errs at {at}: it cuts {gouge_mm:.4} mm into the side and leaves {left_mm:.4} mm, {limit_mm} mm are allowed; \
         the normals along the ruling turn by {twist_deg:.3} degrees"
    )]
    Flank {
        /// The place.
        at: BladeLocation,
        /// Deepest cut, mm.
        gouge_mm: f64,
        /// Most that is left, mm.
        left_mm: f64,
        /// What is allowed, mm.
        limit_mm: f64,
        /// Angle between the normals at both ends of the ruling, degree.
        twist_deg: f64,
    },
    /// No side step gives the scallop that is asked for.
    #[error("no side step leaves a scallop of {scallop_mm} mm at {at}: {reason}")]
    NoSideStep {
        /// The place.
        at: BladeLocation,
        /// Height, mm.
        scallop_mm: f64,
        /// Why.
        reason: &'static str,
    },
    /// A line of the strategy does not exist on this surface.
    #[error("{what} (section {section:.4})")]
    NoLine {
        /// What is missing.
        what: String,
        /// Part of the way along the blade, 0 to 1.
        section: f64,
    },
    /// The path needs more points than any program has.
    #[error("the path needs more than {MOST_POINTS} points: use a longer step or a larger scallop")]
    TooLong,
}

/// Points of a path beyond which its numbers are a mistake.
pub const MOST_POINTS: usize = 20_000_000;
/// By how much the length of a direction may be off one: rounding.
pub(super) const UNIT: f64 = 1e-9;
/// Smallest scallop that can be asked for, mm.
pub(super) const LEAST_SCALLOP_MM: f64 = 1e-6;

impl PathError {
    /// Takes a number that is finite and within a closed range.
    pub(crate) fn within(name: &'static str, value: f64, low: f64, high: f64) -> Result<f64, Self> {
        if value >= low && value <= high {
            return Ok(value);
        }
        Err(Self::Value { name, value, range: format!("{low} to {high}") })
    }
}
