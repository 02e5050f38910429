//! Meaning of numbers: those without a decimal point, the roundness of arcs, times of a dwell, the
//! feed where none is written.

use super::error::Checked;
use super::file::{ArcsFile, ControlFile, MissingFeedFile, NumbersFile, SenseFile, WithoutPointFile};
use super::model::{ArcTolerance, Control, WholeNumbers};
use super::place::ControlText;

/// Increment of lengths where none is stated, mm.
const INCREMENT_MM: f64 = 1e-3;
/// The same of programs in inches, inch.
const INCREMENT_INCH: f64 = 1e-4;
/// Increment of angles where none is stated, degree.
const INCREMENT_DEG: f64 = 1e-3;

fn positive(value: f64, path: &[&str], text: &ControlText<'_>) -> Checked<f64> {
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

pub(super) fn numbers(
    file: &NumbersFile,
    before: WholeNumbers,
    text: &ControlText<'_>,
) -> Checked<Option<WholeNumbers>> {
    let sizes = [
        ("increment_mm", file.increment_mm, INCREMENT_MM),
        ("increment_inch", file.increment_inch, INCREMENT_INCH),
        ("increment_deg", file.increment_deg, INCREMENT_DEG),
    ];
    let counted = match file.without_point {
        Some(WithoutPointFile::Units) => Some(WholeNumbers::Units),
        Some(WithoutPointFile::Assume) => Some(WholeNumbers::Told),
        Some(WithoutPointFile::Refuse) => Some(WholeNumbers::Refused),
        Some(WithoutPointFile::Increments) => None,
        None if matches!(before, WholeNumbers::Increments { .. }) => None,
        None => Some(before),
    };
    if let Some(counted) = counted {
        if let Some((key, ..)) = sizes.iter().find(|(_, value, _)| value.is_some()) {
            let message = "an increment is stated, but numbers without a decimal point do not count increments";
            let remedy = "write without_point = \"increments\", or remove the increment";
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

pub(super) fn arcs(control: &mut Control, file: &ArcsFile, text: &ControlText<'_>) -> Checked<()> {
    if let Some(sense) = file.clsf_sense {
        control.clockwise_circles = Some(matches!(sense, SenseFile::Clockwise));
    }
    if let Some(centers) = file.centers {
        control.centers = centers;
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
        let message = "the largest difference limits a part of the radius, but no part is stated";
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

pub(super) fn dwell(control: &mut Control, file: &ControlFile, text: &ControlText<'_>) -> Checked<()> {
    for (letter, unit) in &file.dwell {
        let known = match letter.as_bytes() {
            [byte @ (b'P' | b'X' | b'U' | b'F' | b'K')] => Some(usize::from(byte - b'A')),
            _ => None,
        };
        let Some(at) = known else {
            let message = format!("{letter} is not a dwell word");
            return Err(text.error("control-value", &["dwell", letter], message, "write one of P, X, U, F, K"));
        };
        control.dwell[at] = Some(*unit);
    }
    Ok(())
}

pub(super) fn feed(control: &mut Control, file: &ControlFile, text: &ControlText<'_>) -> Checked<()> {
    match (file.feed.missing, file.feed.missing_mm_min) {
        (None, None) => {}
        (Some(MissingFeedFile::Refuse), None) => control.missing_feed_mm_min = None,
        (Some(MissingFeedFile::Refuse), Some(_)) => {
            let message = "a feed is stated, but motions without a feed are refused";
            return Err(text.error(
                "control-contradiction",
                &["feed", "missing_mm_min"],
                message,
                "write missing = \"value\", or remove the feed",
            ));
        }
        (Some(MissingFeedFile::Value), None) => {
            let message = "the default feed is not stated";
            return Err(text.error("control-contradiction", &["feed", "missing"], message, "add missing_mm_min"));
        }
        (None, Some(_)) if control.missing_feed_mm_min.is_none() => {
            let message = "a feed is stated, but `missing` does not say that it applies";
            return Err(text.error(
                "control-contradiction",
                &["feed", "missing_mm_min"],
                message,
                "add missing = \"value\"",
            ));
        }
        (_, Some(value)) => control.missing_feed_mm_min = Some(positive(value, &["feed", "missing_mm_min"], text)?),
    }
    if let Some(value) = file.feed.rapid_from_mm_min {
        control.rapid_from_mm_min = Some(positive(value, &["feed", "rapid_from_mm_min"], text)?);
    }
    Ok(())
}
