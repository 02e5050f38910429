//! What parameters and machine data of a control decide: one table for all languages.
//!
//! A key that neither the control file nor one of its parents states is a doubt where a program
//! depends on it: the reader takes the usual reading of its language, and reports it as an
//! assumption.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::Checked;
use super::place::ControlText;
use crate::AxisValues;

/// What parameters and machine data of the control decide. Where a program depends on a key that is left out,
/// the finding program-assumed says which reading is taken.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParametersFile {
    /// What F counts in a block that moves linear and rotary axes together without tool center point control.
    pub(crate) mixed_feed: Option<MixedFeed>,
    /// Radius at which the angle of a rotary axis counts in the feed, by its letter, mm; 57.296 (one degree
    /// counts as one millimeter) when left out.
    #[serde(default)]
    pub(crate) reference_radius_mm: BTreeMap<String, f64>,
    /// Way of a rotary axis to an absolute position.
    pub(crate) rollover: Option<Rollover>,
    /// Letters of the axes that `rollover` holds for; the rotary axes of the machine without limits of travel
    /// when left out.
    pub(crate) rollover_axes: Option<Vec<String>>,
    /// `DC()`, `ACP()` and `ACN()` of a position outside of 0 to 359.999 degrees.
    pub(crate) outside_modulo: Option<OutsideModulo>,
    /// A word that switches the tool length on or off in a block without the axis of the tool.
    pub(crate) length_word: Option<LengthWord>,
    /// Where a drilling cycle comes back to before the first G98 or G99.
    pub(crate) return_level: Option<ReturnLevel>,
    /// What the angles A2= B2= C2= are before ORIEULER or ORIRPY.
    pub(crate) orientation_angles: Option<OrientationAngles>,
    /// Letter of the rotary axis whose angle DIR of CYCLE800, SEQ of PLANE and the choice of G53.1 refer to;
    /// the rotary axis nearest to the tool when left out.
    pub(crate) tilt_reference: Option<String>,
    /// Of two positions of the rotary axes on a tilted plane, the one that is taken where the program does
    /// not choose.
    pub(crate) tilt_solution: Option<TiltSolution>,
    /// How far corners may be rounded under G64 without P, mm; without the key as far as the acceleration of
    /// the axes needs.
    pub(crate) g64_tolerance_mm: Option<f64>,
    /// What the contour of a program is where cutter compensation is on.
    pub(crate) compensation: Option<CompensatedPath>,
    /// Tool radius offsets in the memory of the control, by their D number, mm. A number that is left out is
    /// that of the tool with this number.
    #[serde(default)]
    pub(crate) radius_offset_mm: BTreeMap<String, f64>,
}

/// What F counts in a block that moves linear and rotary axes together without tool center point control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum MixedFeed {
    /// The linear axes; rotary axes arrive at the same time.
    Linear,
    /// The vector of all axes, an angle as the arc at its reference radius.
    Vector,
}

/// Way of a rotary axis to an absolute position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Rollover {
    /// The position as it is written: from 350 to 10 by -340 degrees.
    AsWritten,
    /// The position within one turn, by the shorter way: from 350 to 10 by +20 degrees.
    Shortest,
    /// The position within one turn, in the direction of its sign.
    Sign,
}

/// `DC()`, `ACP()` and `ACN()` of a position outside of 0 to 359.999 degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum OutsideModulo {
    /// It is refused (alarm 16830).
    Refuse,
    /// It is taken as the same position within one turn (bit 0 of MD30455).
    Convert,
}

/// A word that switches the tool length on or off in a block without the axis of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LengthWord {
    /// Coordinates shift, and nothing moves.
    Shifts,
    /// The axis moves by the length.
    Moves,
}

/// Where a drilling cycle comes back to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ReturnLevel {
    /// The level before the cycle (G98).
    Initial,
    /// The R plane (G99).
    RPlane,
}

/// What the angles A2= B2= C2= are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum OrientationAngles {
    /// ORIEULER.
    Euler,
    /// ORIRPY.
    Rpy,
}

/// What the contour of a program is where cutter compensation is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum CompensatedPath {
    /// The wall of the part: the offset D is the radius of the tool.
    Contour,
    /// The path of the tool center, as CAM systems post it with the compensation type wear: the offset D is
    /// the difference of the real radius from the nominal one, zero where nothing states it.
    Wear,
}

/// Of two positions of the rotary axes on a tilted plane, the one that is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum TiltSolution {
    /// With the least turn from the present positions of the axes.
    Shortest,
    /// With the lower angle of the reference axis.
    Lower,
    /// With the higher angle of the reference axis.
    Higher,
}

/// What the parameters of a control say, parents included.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Parameters {
    pub(crate) mixed_feed: Option<MixedFeed>,
    /// A, B, C: radius in the feed, mm.
    pub(crate) reference_radius: [Option<f64>; 3],
    pub(crate) rollover: Option<Rollover>,
    /// Bits of the axes in [`crate::AXIS_LETTERS`].
    pub(crate) rollover_axes: Option<u16>,
    pub(crate) outside_modulo: Option<OutsideModulo>,
    pub(crate) length_word: Option<LengthWord>,
    pub(crate) return_level: Option<ReturnLevel>,
    pub(crate) orientation_angles: Option<OrientationAngles>,
    pub(crate) tilt_reference: Option<char>,
    pub(crate) tilt_solution: Option<TiltSolution>,
    pub(crate) g64_tolerance_mm: Option<f64>,
    pub(crate) compensation: Option<CompensatedPath>,
    /// By D number, mm.
    pub(crate) radius_offsets: BTreeMap<u32, f64>,
}

fn take<T: Copy>(into: &mut Option<T>, value: Option<T>) {
    if value.is_some() {
        *into = value;
    }
}

/// Applies the table to what the parents say.
pub(super) fn parameters(into: &mut Parameters, file: &ParametersFile, text: &ControlText<'_>) -> Checked<()> {
    take(&mut into.mixed_feed, file.mixed_feed);
    take(&mut into.rollover, file.rollover);
    take(&mut into.outside_modulo, file.outside_modulo);
    take(&mut into.length_word, file.length_word);
    take(&mut into.return_level, file.return_level);
    take(&mut into.orientation_angles, file.orientation_angles);
    take(&mut into.tilt_solution, file.tilt_solution);
    take(&mut into.compensation, file.compensation);
    let wrong = |key: &str, message: String, remedy: &str| {
        Err(text.error("control-value", &["parameters", key], message, remedy.to_owned()))
    };
    for (letter, &radius) in &file.reference_radius_mm {
        let Some(axis) = rotary(letter) else {
            return wrong("reference_radius_mm", format!("{letter} is not one of the axes A, B, C"), "write A, B or C");
        };
        if !(radius > 0.0 && radius.is_finite()) {
            let message = format!("the radius of {letter} must be above zero and is {radius} mm");
            return wrong("reference_radius_mm", message, "write the radius of the part at this axis");
        }
        into.reference_radius[axis - 3] = Some(radius);
    }
    if !file.reference_radius_mm.is_empty() && into.mixed_feed != Some(MixedFeed::Vector) {
        return Err(text.error(
            "control-contradiction",
            &["parameters", "reference_radius_mm"],
            "a radius is stated, but angles do not count in the feed",
            "write mixed_feed = \"vector\", or remove the radius",
        ));
    }
    if let Some(letters) = &file.rollover_axes {
        let mut axes = 0;
        for letter in letters {
            let Some(axis) = rotary(letter) else {
                return wrong("rollover_axes", format!("{letter} is not one of the axes A, B, C"), "write A, B or C");
            };
            axes |= 1 << axis;
        }
        into.rollover_axes = Some(axes);
    }
    if let Some(letter) = &file.tilt_reference {
        let Some(axis) = rotary(letter) else {
            return wrong("tilt_reference", format!("{letter} is not one of the axes A, B, C"), "write A, B or C");
        };
        into.tilt_reference = crate::AXIS_LETTERS.get(axis).copied();
    }
    if let Some(tolerance) = file.g64_tolerance_mm {
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            let message = format!("the tolerance must not be negative and is {tolerance} mm");
            return wrong("g64_tolerance_mm", message, "write 0.01");
        }
        into.g64_tolerance_mm = Some(tolerance);
    }
    for (number, &radius) in &file.radius_offset_mm {
        let Ok(offset) = number.parse::<u32>() else {
            let message = format!("{number} is not an offset number");
            return wrong("radius_offset_mm", message, "write the D number: 2 = 6.0");
        };
        if !radius.is_finite() {
            return wrong("radius_offset_mm", format!("{radius} is not a valid radius"), "write the radius in mm");
        }
        into.radius_offsets.insert(offset, radius);
    }
    Ok(())
}

/// Index of a rotary axis by its letter.
fn rotary(letter: &str) -> Option<usize> {
    let mut letters = letter.trim().chars();
    let axis = AxisValues::index(letters.next()?.to_ascii_uppercase())?;
    ((3..6).contains(&axis) && letters.next().is_none()).then_some(axis)
}
