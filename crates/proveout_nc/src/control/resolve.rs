//! Applies a file to what its parents say, and refuses what contradicts itself or has no effect.

use std::collections::BTreeMap;
use std::path::Path;

use super::error::ControlFileError;
use super::file::{
    ArcsFile, CentersFile, ControlFile, CycleDepthFile, CycleReturnFile, DialectFile, DistanceFile, DwellFile,
    FineBoringFile, InterpolationFile, MissingFeedFile, MissingSubprogramFile, MotionFile, NumbersFile, PlaneFile,
    StartFeedFile, StartFile, UnitFile, UnlistedMFile, WithoutHFile, WithoutPointFile,
};
use super::meanings;
use super::model::{ArcTolerance, Centers, Control, DwellUnit, FineBoring, StartFeed, StartMotion, WholeNumbers};
use super::place::{Text, nearest};
use crate::settings::Dialect;
use crate::{AxisValues, OrientationInterpolation};

type Checked<T> = Result<T, Box<ControlFileError>>;

/// The families of readers, for keys that have an effect in some of them only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Fanuc, Haas.
    MacroB,
    LinuxCnc,
    Siemens,
    Heidenhain,
    HeidenhainIso,
    Apt,
}

impl Family {
    pub(super) fn of(dialect: Dialect) -> Option<Self> {
        Some(match dialect {
            Dialect::Fanuc | Dialect::Haas => Self::MacroB,
            Dialect::LinuxCnc => Self::LinuxCnc,
            Dialect::Siemens840d => Self::Siemens,
            Dialect::Heidenhain => Self::Heidenhain,
            Dialect::HeidenhainIso => Self::HeidenhainIso,
            Dialect::Apt => Self::Apt,
            Dialect::Auto | Dialect::Iso => return None,
        })
    }

    /// The reader of the language uses what this key says.
    fn uses(self, path: &[&str]) -> bool {
        use Family::{Apt, Heidenhain, HeidenhainIso, LinuxCnc, MacroB, Siemens};
        let iso = matches!(self, MacroB | LinuxCnc);
        match path {
            ["start", "plane" | "distance" | "feed" | "motion"] => iso || self == Siemens,
            ["start", "unit"] => iso || matches!(self, Siemens | Apt),
            ["start", "position_deg"] => self != Apt,
            ["numbers", _] | ["cycles", _] | ["tool_change", "position_mm"] | ["tool_length", _] => self == MacroB,
            ["arcs", "centers"] | ["dwell", _] => iso,
            ["orientation", "interpolation"] => self == Siemens,
            ["blocks", "skipped_levels"] | ["subprograms", _] => self != Apt,
            ["unlisted", "m"] => self != Apt,
            ["program", _] => true,
            _ => matches!(self, MacroB | LinuxCnc | Siemens | Heidenhain | HeidenhainIso | Apt),
        }
    }
}

/// Applies the file to the control of its parents.
pub(super) fn apply(control: &mut Control, file: &ControlFile, text: &Text<'_>, folder: Option<&Path>) -> Checked<()> {
    dialect(control, file, text)?;
    sources(file, text)?;
    control.name = match &file.name {
        Some(name) if name.trim().is_empty() => {
            return Err(text.error(
                "control-empty-text",
                &["name"],
                "the name is empty",
                "write a name, or leave it out",
            ));
        }
        Some(name) => name.clone(),
        None => stem(text.file),
    };
    start(control, &file.start, text)?;
    if let Some(numbers) = numbers(&file.numbers, control.whole_numbers, text)? {
        control.whole_numbers = numbers;
    }
    arcs(control, &file.arcs, text)?;
    if let Some(g76) = file.cycles.g76 {
        control.fine_boring = match g76 {
            FineBoringFile::NeedsShift => FineBoring::NeedsShift,
            FineBoringFile::ShiftMayBeLeftOut => FineBoring::ShiftMayBeLeftOut,
            FineBoringFile::Refuse => FineBoring::Refused,
        };
    }
    if let Some(returns) = file.cycles.returns {
        control.stated_returns = matches!(returns, CycleReturnFile::M53);
    }
    if let Some(depth) = file.cycles.depth {
        control.depth_in_i = matches!(depth, CycleDepthFile::I);
    }
    if let Some(without) = file.tool_length.without_h {
        control.length_of_tool = matches!(without, WithoutHFile::Tool);
    }
    positions(&mut control.tool_change, &file.tool_change.position_mm, false, &["tool_change", "position_mm"], text)?;
    dwell(control, file, text)?;
    feed(control, file, text)?;
    if let Some(interpolation) = file.orientation.interpolation {
        control.orientation = match interpolation {
            InterpolationFile::GreatCircle => OrientationInterpolation::GreatCircle,
            InterpolationFile::Axes => OrientationInterpolation::Axes,
        };
    }
    if let Some(levels) = &file.blocks.skipped_levels {
        control.skipped_levels = skipped(levels, control.dialect, text)?;
    }
    for (name, value) in &file.variables {
        if !value.is_finite() {
            let path = ["variables", name.as_str()];
            return Err(text.error("control-value", &path, format!("{value} is no value"), "write a finite number"));
        }
        control.variables.insert(name.trim().to_ascii_uppercase(), *value);
    }
    subprograms(control, file, text, folder)?;
    for (key, list, into) in [
        ("header", &file.program.header, &mut control.header),
        ("trailer", &file.program.trailer, &mut control.trailer),
    ] {
        let Some(list) = list else { continue };
        if list.iter().any(|pattern| pattern.trim().trim_matches('*').is_empty()) {
            let message = "a pattern without a character of its own would take every line";
            return Err(text.error("control-pattern", &["program", key], message, "write what the lines begin with"));
        }
        into.clone_from(list);
    }
    if let Some(unlisted) = file.unlisted.m {
        control.refuses_unlisted = unlisted == UnlistedMFile::Refuse;
    }
    meanings::apply(control, &file.words, text)
}

/// `fanuc-30i` of `built-in fanuc-30i` and of `shop/fanuc-30i.toml`.
fn stem(file: &str) -> String {
    let name = file.strip_prefix("built-in ").unwrap_or(file);
    Path::new(name).file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// The language, and keys that have no effect in it.
fn dialect(control: &mut Control, file: &ControlFile, text: &Text<'_>) -> Checked<()> {
    let named = file.dialect.map(|dialect| match dialect {
        DialectFile::Siemens840d => Dialect::Siemens840d,
        DialectFile::Fanuc => Dialect::Fanuc,
        DialectFile::Haas => Dialect::Haas,
        DialectFile::LinuxCnc => Dialect::LinuxCnc,
        DialectFile::Heidenhain => Dialect::Heidenhain,
        DialectFile::HeidenhainIso => Dialect::HeidenhainIso,
        DialectFile::Apt => Dialect::Apt,
    });
    if let Some(named) = named {
        if control.dialect != Dialect::Auto && control.dialect != named {
            let message = format!(
                "the dialect is {}, and that of the parent {:?} is {}",
                named.name(),
                control.name,
                control.dialect.name()
            );
            return Err(text.error(
                "control-contradiction",
                &["dialect"],
                message,
                "take it out, or inherit from another control",
            ));
        }
        control.dialect = named;
    }
    let Some(family) = Family::of(control.dialect) else {
        let remedy = "add dialect = \"fanuc\" (or another language), or inherits = \"fanuc-30i\" (or another control)";
        return Err(text.error(
            "control-no-dialect",
            &["dialect"],
            "nothing says the language of the programs",
            remedy,
        ));
    };
    for path in text.paths() {
        let keys: Vec<&str> = path.splitn(2, '.').collect();
        if !family.uses(&keys) {
            let message = format!("the key has no effect on programs in the dialect {}", control.dialect.name());
            return Err(text.error("control-no-effect", &keys, message, "take it out"));
        }
    }
    Ok(())
}

/// Sources must name keys of the file.
fn sources(file: &ControlFile, text: &Text<'_>) -> Checked<()> {
    let paths = text.paths();
    for (key, source) in &file.source {
        let at = ["source", key.as_str()];
        if source.trim().is_empty() {
            return Err(text.error(
                "control-empty-text",
                &at,
                "the source is empty",
                "write where the value comes from",
            ));
        }
        let known = key == "*" || paths.iter().any(|p| p == key || p.split('.').next() == Some(key));
        if !known {
            let names: Vec<&str> = paths.iter().map(String::as_str).filter(|p| !p.starts_with("source.")).collect();
            let message = format!("the file has no key {key}");
            return Err(text.error("control-unknown-key", &at, message, nearest(key, &names)));
        }
    }
    Ok(())
}

fn start(control: &mut Control, file: &StartFile, text: &Text<'_>) -> Checked<()> {
    let start = &mut control.start;
    if let Some(plane) = file.plane {
        start.normal = Some(match plane {
            PlaneFile::XY => 2,
            PlaneFile::ZX => 1,
            PlaneFile::YZ => 0,
        });
    }
    if let Some(unit) = file.unit {
        start.inch = Some(matches!(unit, UnitFile::Inch));
    }
    if let Some(distance) = file.distance {
        start.incremental = Some(matches!(distance, DistanceFile::Incremental));
    }
    if let Some(feed) = file.feed {
        start.feed = Some(match feed {
            StartFeedFile::PerMinute => StartFeed::PerMinute,
            StartFeedFile::PerRevolution => StartFeed::PerRevolution,
            StartFeedFile::InverseTime => StartFeed::InverseTime,
        });
    }
    if let Some(motion) = file.motion {
        start.motion = Some(match motion {
            MotionFile::None => StartMotion::None,
            MotionFile::Rapid => StartMotion::Rapid,
            MotionFile::Linear => StartMotion::Linear,
        });
        if control.dialect == Dialect::Siemens840d && matches!(motion, MotionFile::None) {
            let message = "a Sinumerik has a motion in force at every time";
            return Err(text.error("control-value", &["start", "motion"], message, "write rapid or linear"));
        }
    }
    for (table, values, rotary) in
        [("position_mm", &file.position_mm, false), ("position_deg", &file.position_deg, true)]
    {
        positions(&mut control.position, values, rotary, &["start", table], text)?;
    }
    Ok(())
}

/// Positions of axes by their letter.
fn positions(
    into: &mut AxisValues,
    values: &BTreeMap<String, f64>,
    rotary: bool,
    path: &[&str],
    text: &Text<'_>,
) -> Checked<()> {
    for (letter, &value) in values {
        let axis = match letter.as_bytes() {
            [byte] => AxisValues::index(char::from(*byte)),
            _ => None,
        };
        let Some(axis) = axis.filter(|axis| (3..6).contains(axis) == rotary) else {
            let axes = if rotary { "A, B, C" } else { "X, Y, Z, U, V, W" };
            let message = format!("{letter} is none of the axes {axes}");
            return Err(text.error("control-value", path, message, "write the letter of an axis"));
        };
        if !value.is_finite() {
            return Err(text.error("control-value", path, format!("{value} is no position"), "write a finite number"));
        }
        into.put(axis, if rotary { value.to_radians() } else { value });
    }
    Ok(())
}

fn positive(value: f64, path: &[&str], text: &Text<'_>) -> Checked<f64> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(text.error(
        "control-value",
        path,
        format!("the value must be above zero and is {value}"),
        "write a number above zero",
    ))
}

fn numbers(file: &NumbersFile, before: WholeNumbers, text: &Text<'_>) -> Checked<Option<WholeNumbers>> {
    let sizes = [
        ("increment_mm", file.increment_mm, 1e-3),
        ("increment_inch", file.increment_inch, 1e-4),
        ("increment_deg", file.increment_deg, 1e-3),
    ];
    let counted = match file.without_point {
        Some(WithoutPointFile::Units) => Some(WholeNumbers::Units),
        Some(WithoutPointFile::Refuse) => Some(WholeNumbers::Refused),
        Some(WithoutPointFile::Increments) => None,
        None if matches!(before, WholeNumbers::Increments { .. }) => None,
        None => Some(before),
    };
    if let Some(counted) = counted {
        if let Some((key, ..)) = sizes.iter().find(|(_, value, _)| value.is_some()) {
            let message = "an increment is stated, and numbers without a decimal point do not count increments";
            let remedy = "write without_point = \"increments\", or take the increment out";
            return Err(text.error("control-contradiction", &["numbers", key], message, remedy));
        }
        return Ok(file.without_point.map(|_| counted));
    }
    let mut found = [0.0; 3];
    for (slot, (at, (key, value, usual))) in found.iter_mut().zip(sizes.into_iter().enumerate()) {
        let inherited = match before {
            WholeNumbers::Increments { mm, inch, deg } => [mm, inch, deg][at],
            _ => usual,
        };
        *slot = positive(value.unwrap_or(inherited), &["numbers", key], text)?;
    }
    let [mm, inch, deg] = found;
    Ok(Some(WholeNumbers::Increments { mm, inch, deg }))
}

fn arcs(control: &mut Control, file: &ArcsFile, text: &Text<'_>) -> Checked<()> {
    if let Some(centers) = file.centers {
        control.centers = match centers {
            CentersFile::Incremental => Centers::Incremental,
            CentersFile::Absolute => Centers::Absolute,
            CentersFile::Unsigned => Centers::Unsigned,
        };
    }
    if file.tolerance_mm.is_none() && file.tolerance_ratio.is_none() && file.largest_difference_mm.is_none() {
        return Ok(());
    }
    let before = control.arc_tolerance.unwrap_or(ArcTolerance::absolute(0.01));
    let absolute_mm = match file.tolerance_mm {
        Some(value) => positive(value, &["arcs", "tolerance_mm"], text)?,
        None => before.absolute_mm,
    };
    let relative = match file.tolerance_ratio {
        Some(value) if (0.0..=0.1).contains(&value) => value,
        Some(value) => {
            let message = format!("the part of the radius must be 0 to 0.1 and is {value}");
            return Err(text.error(
                "control-value",
                &["arcs", "tolerance_ratio"],
                message,
                "write 0.001 for 0.1 percent",
            ));
        }
        None => before.relative,
    };
    let largest_mm = match file.largest_difference_mm {
        Some(value) => positive(value, &["arcs", "largest_difference_mm"], text)?,
        None if relative == 0.0 => absolute_mm,
        // A ratio alone has no bound.
        None if before.relative == 0.0 => f64::INFINITY,
        None => before.largest_mm,
    };
    if file.largest_difference_mm.is_some() && relative == 0.0 {
        let message = "the largest difference bounds a part of the radius, and no part is stated";
        return Err(text.error(
            "control-contradiction",
            &["arcs", "largest_difference_mm"],
            message,
            "add tolerance_ratio, or state tolerance_mm alone",
        ));
    }
    if largest_mm < absolute_mm {
        let message = format!("the largest difference {largest_mm} mm is below the tolerance {absolute_mm} mm");
        let key = if file.largest_difference_mm.is_some() { "largest_difference_mm" } else { "tolerance_mm" };
        return Err(text.error(
            "control-contradiction",
            &["arcs", key],
            message,
            "make it larger, or the tolerance smaller",
        ));
    }
    control.arc_tolerance = Some(ArcTolerance { absolute_mm, relative, largest_mm });
    Ok(())
}

fn dwell(control: &mut Control, file: &ControlFile, text: &Text<'_>) -> Checked<()> {
    for (letter, unit) in &file.dwell {
        let known = match letter.as_bytes() {
            [byte @ (b'P' | b'X' | b'U' | b'F' | b'K')] => Some(usize::from(byte - b'A')),
            _ => None,
        };
        let Some(at) = known else {
            let message = format!("{letter} is no word of a dwell");
            return Err(text.error("control-value", &["dwell", letter], message, "write one of P, X, U, F, K"));
        };
        control.dwell[at] = Some(match unit {
            DwellFile::S => DwellUnit::Seconds,
            DwellFile::Ms => DwellUnit::Milliseconds,
            DwellFile::MsOrS => DwellUnit::MillisecondsOrSeconds,
            DwellFile::Hundredths => DwellUnit::Hundredths,
        });
    }
    Ok(())
}

fn feed(control: &mut Control, file: &ControlFile, text: &Text<'_>) -> Checked<()> {
    match (file.feed.missing, file.feed.missing_mm_min) {
        (None, None) => {}
        (Some(MissingFeedFile::Refuse), None) => control.missing_feed_mm_min = None,
        (Some(MissingFeedFile::Refuse), Some(_)) => {
            let message = "a feed is stated, and motions without a feed are refused";
            return Err(text.error(
                "control-contradiction",
                &["feed", "missing_mm_min"],
                message,
                "write missing = \"value\", or take the feed out",
            ));
        }
        (Some(MissingFeedFile::Value), None) => {
            let message = "the feed that is taken is not stated";
            return Err(text.error("control-contradiction", &["feed", "missing"], message, "add missing_mm_min"));
        }
        (None, Some(_)) if control.missing_feed_mm_min.is_none() => {
            let message = "a feed is stated, and nothing says that it is taken";
            return Err(text.error(
                "control-contradiction",
                &["feed", "missing_mm_min"],
                message,
                "add missing = \"value\"",
            ));
        }
        (_, Some(value)) => control.missing_feed_mm_min = Some(positive(value, &["feed", "missing_mm_min"], text)?),
    }
    Ok(())
}

fn skipped(levels: &[u8], dialect: Dialect, text: &Text<'_>) -> Checked<u16> {
    let heidenhain = matches!(dialect, Dialect::Heidenhain | Dialect::HeidenhainIso);
    let most = if heidenhain { 0 } else { 9 };
    if let Some(wrong) = levels.iter().find(|level| **level > most) {
        let message = format!("{wrong} is no level of blocks with a slash");
        let remedy = if heidenhain { "write 0: the control has one level" } else { "write 0 to 9" };
        return Err(text.error("control-value", &["blocks", "skipped_levels"], message, remedy));
    }
    Ok(levels.iter().fold(0, |bits, level| bits | 1 << level))
}

fn subprograms(control: &mut Control, file: &ControlFile, text: &Text<'_>, folder: Option<&Path>) -> Checked<()> {
    let file = &file.subprograms;
    if let Some(folders) = &file.folders {
        control.folders.clear();
        for name in folders {
            let path = folder.map_or_else(|| name.into(), |folder| folder.join(name));
            if !path.is_dir() {
                let message = format!("{} is no folder", path.display());
                return Err(text.error(
                    "control-value",
                    &["subprograms", "folders"],
                    message,
                    "check the path; relative ones begin at the control file",
                ));
            }
            control.folders.push(path);
        }
    }
    match (file.missing, &file.missing_reason) {
        (None, None) => {}
        (Some(MissingSubprogramFile::Refuse), None) => control.missing_subprogram = None,
        (Some(MissingSubprogramFile::Note), Some(reason)) if !reason.trim().is_empty() => {
            control.missing_subprogram = Some(reason.clone());
        }
        (Some(MissingSubprogramFile::Note), _) => {
            let message = "nothing says why a subprogram that is missing may be left out";
            return Err(text.error(
                "control-contradiction",
                &["subprograms", "missing"],
                message,
                "add missing_reason",
            ));
        }
        (_, Some(_)) => {
            let message = "a reason is given, and missing subprograms are not left out";
            let path = ["subprograms", "missing_reason"];
            return Err(text.error(
                "control-contradiction",
                &path,
                message,
                "write missing = \"note\", or take the reason out",
            ));
        }
    }
    Ok(())
}
