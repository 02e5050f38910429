//! The options of methods: one list with key, value as text, and how a text is taken; which method reads
//! which.

use proveout_input::renamed_key;

use super::MethodFile::{MinAngularAcceleration, MultiScale, Quaternion, STheta, Singularity, Smooth};
use proveout_reschedule::{Criterion, Junction, RowEnds, ThetaUnit};

use super::{ChannelFile, InsetFile, InsetWordFile, KeyAxesFile, MethodFile, RescheduleFile};

/// What is wrong with a value, and what to write.
type Wrong = (String, String);

/// An option.
struct Known {
    key: &'static str,
    /// Methods that read it.
    of: &'static [MethodFile],
    /// Its value as text, where it is given.
    get: fn(&RescheduleFile) -> Option<String>,
    set: fn(&mut RescheduleFile, &str) -> Result<(), Wrong>,
}

/// An option from the field of its name, its kind, and for words what a value is that is none of them.
macro_rules! option {
    ($of:expr, $key:ident, number) => {
        Known {
            key: stringify!($key),
            of: $of,
            get: |file| file.$key.map(|value| value.to_string()),
            set: |file, text| number(stringify!($key), text).map(|value| file.$key = Some(value)),
        }
    };
    ($of:expr, $key:ident, count) => {
        Known {
            key: stringify!($key),
            of: $of,
            get: |file| file.$key.map(|value| value.to_string()),
            set: |file, text| count(stringify!($key), text).map(|value| file.$key = Some(value)),
        }
    };
    ($of:expr, $key:ident, $words:ident, $none:literal) => {
        Known {
            key: stringify!($key),
            of: $of,
            get: |file| file.$key.map(|value| name_of(&$words::NAMES, value)),
            set: |file, text| named(&$words::NAMES, stringify!($key), text, $none).map(|value| file.$key = Some(value)),
        }
    };
}

/// Methods that keep the rules of a bull-nose: strip and roughness.
const BULL_NOSE: &[MethodFile] = &[MultiScale, Smooth];

/// All options, in the order of the scene file.
const ALL: [Known; 30] = [
    option!(&[STheta, Quaternion, Smooth], clearance_deg, number),
    Known { key: "inset_deg", of: &[STheta], get: inset, set: set_inset },
    option!(&[STheta], start_flat_mm, number),
    option!(&[STheta], end_flat_percent, number),
    option!(&[STheta], merge_mm, number),
    option!(&[STheta], theta_unit, ThetaUnit, "no unit"),
    option!(&[Quaternion], keys, count),
    option!(&[Singularity], cone_deg, number),
    option!(&[Singularity], rate_deg_mm, number),
    option!(&[Singularity], junction, Junction, "no rule"),
    option!(&[MinAngularAcceleration], max_key_lean_deg, number),
    option!(&[MinAngularAcceleration], window_mm, number),
    option!(&[MinAngularAcceleration], criterion, Criterion, "not one of its words"),
    option!(&[MinAngularAcceleration], key_axes, KeyAxesFile, "not one of its words"),
    option!(BULL_NOSE, strip_min_mm, number),
    option!(BULL_NOSE, strip_max_mm, number),
    option!(BULL_NOSE, strip_height_mm, number),
    option!(BULL_NOSE, ra_um, number),
    option!(BULL_NOSE, evaluation_length_mm, number),
    option!(BULL_NOSE, run_in_mm, number),
    option!(&[MultiScale], margin_deg, number),
    option!(&[MultiScale], coefficients, count),
    option!(BULL_NOSE, measured_ratio, number),
    option!(BULL_NOSE, measured_spread, number),
    option!(&[Smooth], channel, ChannelFile, "no channel"),
    option!(&[Smooth], lean_max_deg, number),
    Known {
        key: "monotone",
        of: &[Smooth],
        get: |file| file.monotone.map(|value| value.to_string()),
        set: set_monotone,
    },
    option!(&[Smooth], max_time_loss_percent, number),
    option!(&[Smooth], turn_max_deg, number),
    option!(&[Smooth], ends, RowEnds, "not one of its words"),
];

impl RescheduleFile {
    /// Options that a method reads.
    pub fn options_of(method: MethodFile) -> Vec<&'static str> {
        ALL.iter().filter(|option| option.of.contains(&method)).map(|option| option.key).collect()
    }

    /// Options that the method reads with the channel and the criterion that are given.
    pub fn read(&self) -> Vec<&'static str> {
        let rows = self.channel == Some(ChannelFile::Rows);
        let reads = |key: &&str| match (self.method, *key) {
            (MinAngularAcceleration, "window_mm") => self.criterion != Some(Criterion::TrueMinimum),
            // A measurement counts places above a limit.
            (_, "measured_ratio") if self.ra_um == Some(0.0) => false,
            (_, "measured_spread") if self.ra_um == Some(0.0) || self.measured_ratio.is_none() => false,
            (Smooth, "channel" | "lean_max_deg") => true,
            (Smooth, "clearance_deg" | "monotone" | "max_time_loss_percent") => !rows,
            (Smooth, _) => rows,
            _ => true,
        };
        Self::options_of(self.method).into_iter().filter(reads).collect()
    }

    /// Options that are given, as `KEY=VALUE`.
    pub fn given(&self) -> Vec<(&'static str, String)> {
        ALL.iter().filter_map(|option| Some((option.key, (option.get)(self)?))).collect()
    }

    /// An option that is given and that the method does not read.
    pub fn unread(&self) -> Option<&'static str> {
        let read = self.read();
        self.given().into_iter().map(|(key, _)| key).find(|key| !read.contains(key))
    }

    /// Sets an option from its text.
    ///
    /// # Errors
    /// What is wrong, and what to write: an option that the method does not read, or a value that is none.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), (String, String)> {
        match ALL.iter().find(|option| option.key == key && option.of.contains(&self.method)) {
            Some(option) => (option.set)(self, value),
            None => {
                let method = name_of(&MethodFile::NAMES, self.method);
                let read = Self::options_of(self.method);
                let help = match renamed_key(key, &read) {
                    Some(new) => format!("its name is {new} now"),
                    None => format!("options of {method}: {}", read.join(", ")),
                };
                Err((format!("{method} has no option {key:?}"), help))
            }
        }
    }
}

fn number(key: &str, text: &str) -> Result<f64, Wrong> {
    let number = text.parse::<f64>().ok().filter(|v| v.is_finite());
    number.ok_or_else(|| (format!("{key}={text} is not a number"), "write a number with a decimal point".to_owned()))
}

fn count(key: &str, text: &str) -> Result<usize, Wrong> {
    text.parse().ok().ok_or_else(|| (format!("{key}={text} is not a count"), "write a whole number".to_owned()))
}

fn inset(file: &RescheduleFile) -> Option<String> {
    file.inset_deg.map(|inset| match inset {
        InsetFile::Degrees(degrees) => degrees.to_string(),
        InsetFile::Word(InsetWordFile::Search) => "search".to_owned(),
    })
}

fn set_inset(file: &mut RescheduleFile, text: &str) -> Result<(), Wrong> {
    file.inset_deg = Some(match text {
        "search" => InsetFile::Word(InsetWordFile::Search),
        _ => {
            let help = "write degrees with a point, or search".to_owned();
            InsetFile::Degrees(number("inset_deg", text).map_err(|(message, _)| (message, help))?)
        }
    });
    Ok(())
}

fn set_monotone(file: &mut RescheduleFile, text: &str) -> Result<(), Wrong> {
    let value = text.parse::<bool>().ok();
    let wrong = || (format!("monotone={text} is neither true nor false"), "write true or false".to_owned());
    file.monotone = Some(value.ok_or_else(wrong)?);
    Ok(())
}

fn name_of<T: Copy + PartialEq>(names: &[(&'static str, T)], value: T) -> String {
    names.iter().find(|(_, v)| *v == value).map_or("", |(name, _)| name).to_owned()
}

fn named<T: Copy>(names: &[(&'static str, T)], key: &str, value: &str, none: &str) -> Result<T, Wrong> {
    names.iter().find(|(name, _)| *name == value).map(|(_, v)| *v).ok_or_else(|| {
        let all: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        (format!("{key}={value} is {none}"), format!("write one of {}", all.join(", ")))
    })
}
