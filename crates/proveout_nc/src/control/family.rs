//! Which keys of a control file the reader of a language uses.

use crate::settings::Dialect;

/// The families of readers, for keys that have an effect in some of them only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ReaderFamily {
    /// Fanuc, Haas.
    MacroB,
    LinuxCnc,
    Siemens,
    Heidenhain,
    HeidenhainIso,
    Apt,
}

impl ReaderFamily {
    pub(super) fn of(dialect: Dialect) -> Option<Self> {
        Some(match dialect {
            Dialect::Iso | Dialect::Fanuc | Dialect::Haas => Self::MacroB,
            Dialect::LinuxCnc => Self::LinuxCnc,
            Dialect::Siemens840d => Self::Siemens,
            Dialect::Heidenhain => Self::Heidenhain,
            Dialect::HeidenhainIso => Self::HeidenhainIso,
            Dialect::Apt => Self::Apt,
            Dialect::Auto => return None,
        })
    }

    /// The reader of the language uses what this key says.
    pub(super) fn uses(self, path: &[&str]) -> bool {
        use ReaderFamily::{Apt, Heidenhain, HeidenhainIso, LinuxCnc, MacroB, Siemens};
        let iso = matches!(self, MacroB | LinuxCnc);
        match path {
            ["start", "plane" | "distance" | "feed" | "motion"] => iso || self == Siemens,
            ["start", "unit"] => iso || matches!(self, Siemens | Apt),
            ["start", "position_deg"] => self != Apt,
            ["numbers", _] | ["cycles", _] | ["tool_change", "position_mm"] | ["tool_length", _] => self == MacroB,
            ["parameters", "mixed_feed" | "reference_radius_mm" | "rollover" | "rollover_axes"] => self != Apt,
            ["parameters", "outside_modulo" | "orientation_angles"] => self == Siemens,
            ["parameters", "length_word" | "radius_offset_mm"] => self == MacroB,
            ["parameters", "compensation"] => self != Apt,
            ["parameters", "return_level"] => iso,
            ["parameters", "g64_tolerance_mm"] => self == LinuxCnc,
            ["parameters", "tilt_reference"] => matches!(self, MacroB | Siemens | Heidenhain | HeidenhainIso),
            ["parameters", "tilt_solution"] => matches!(self, MacroB | Heidenhain | HeidenhainIso),
            ["arcs", "clsf_sense"] => self == Apt,
            ["arcs", "centers"] | ["dwell", _] => iso,
            ["orientation", "interpolation"] => self == Siemens,
            ["blocks", "skipped_levels"] | ["subprograms", _] | ["limits", _] => self != Apt,
            ["unlisted", "m"] => self != Apt,
            ["feed", "rapid_from_mm_min"] => matches!(self, Heidenhain | HeidenhainIso),
            ["program", "words"] => iso,
            ["program", "end"] => true,
            ["program", "modal_variables"] => self == MacroB,
            ["program", _] => true,
            _ => matches!(self, MacroB | LinuxCnc | Siemens | Heidenhain | HeidenhainIso | Apt),
        }
    }
}
