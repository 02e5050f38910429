//! Numbers as people read them.

use crate::units::UM_PER_MM;

/// Sizes of numbers that are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-4..1e9;

/// A number with `digits` after the point and without a negative zero; a dash for what is not a number.
pub(crate) fn fixed(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| matches!(b, b'0' | b'.')) => rest.to_owned(),
        _ => text,
    }
}

/// A number with about four significant digits and thin gaps between thousands.
pub(crate) fn compact(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let size = value.abs();
    if size > 0.0 && !PLAIN.contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size >= 1000.0 || size == 0.0 { 0 } else { (3 - size.log10().floor() as i32).clamp(0, 6) as usize };
    let text = fixed(value, digits);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    grouped(&text)
}

/// Narrow no-break spaces between groups of three digits before the point, from five digits on.
fn grouped(text: &str) -> String {
    let (whole, rest) = text.split_once('.').map_or((text, None), |(w, r)| (w, Some(r)));
    let (sign, digits) = whole.strip_prefix('-').map_or(("", whole), |d| ("-", d));
    let mut out = String::from(sign);
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && digits.len() > 4 && (digits.len() - i) % 3 == 0 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    if let Some(rest) = rest {
        out.push('.');
        out.push_str(rest);
    }
    out
}

/// Whole numbers with gaps between thousands.
pub(crate) fn count(n: u64) -> String {
    grouped(&n.to_string())
}

/// A time as `12.34 s`, from one minute on as `2:05.3 min`, from one hour on as `1:02:05.4 h`.
pub(crate) fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return "–".into();
    }
    if seconds < 60.0 {
        return format!("{} s", fixed(seconds, 2));
    }
    let tenths = (seconds * 10.0).round() as u64;
    let (hours, minutes, rest) = (tenths / 36_000, tenths / 600 % 60, tenths % 600);
    let rest = format!("{:02}.{}", rest / 10, rest % 10);
    if hours > 0 { format!("{hours}:{minutes:02}:{rest} h") } else { format!("{minutes}:{rest} min") }
}

/// A length in mm in the unit in which a machinist speaks of it: micrometer below 0.1 mm.
pub(crate) fn length(mm: f64) -> String {
    if mm.is_finite() && mm.abs() < 0.1 {
        format!("{} µm", fixed(mm * UM_PER_MM, if mm.abs() < 0.01 { 2 } else { 1 }))
    } else {
        format!("{} mm", fixed(mm, 3))
    }
}

/// The same for a value that may be missing.
pub(crate) fn length_or_dash(mm: Option<f64>) -> String {
    mm.map_or_else(|| "–".into(), length)
}

/// A volume in cm³ from 1000 mm³ on.
pub(crate) fn volume(mm3: f64) -> String {
    if mm3.abs() >= 1000.0 { format!("{} cm³", compact(mm3 / 1000.0)) } else { format!("{} mm³", compact(mm3)) }
}

/// A path in m from 1000 mm on.
pub(crate) fn path(mm: f64) -> String {
    if mm.abs() >= 1000.0 { format!("{} m", compact(mm / 1000.0)) } else { format!("{} mm", compact(mm)) }
}

/// A file without its folders.
pub(crate) fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().filter(|n| !n.is_empty()).unwrap_or(path)
}

/// A tool by number and name; its number alone where the name says no more.
pub(crate) fn tool_name(number: u32, name: &str) -> String {
    let by_number = format!("T{number}");
    if name.is_empty() || name == by_number { by_number } else { format!("{by_number} {name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tool_is_named_once() {
        assert_eq!([tool_name(3, "T3"), tool_name(3, ""), tool_name(3, "END")], ["T3", "T3", "T3 END"]);
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(fixed(-0.0004, 3), "0.000");
        assert_eq!(fixed(f64::NAN, 2), "–");
        assert_eq!(compact(1234567.0), "1\u{202f}234\u{202f}567");
        assert_eq!(compact(-12.3456), "-12.35");
        assert_eq!(compact(0.0), "0");
        assert_eq!(compact(1234.0), "1234");
        assert_eq!(compact(2.5e-6), "2.50e-6");
        assert_eq!(duration(59.994), "59.99 s");
        assert_eq!(duration(119.96), "2:00.0 min");
        assert_eq!(duration(3725.44), "1:02:05.4 h");
        assert_eq!(length(0.0123), "12.3 µm");
        assert_eq!(length(-1.5), "-1.500 mm");
        assert_eq!(length_or_dash(None), "–");
        assert_eq!(volume(12_345.0), "12.35 cm³");
        assert_eq!(path(999.5), "999.5 mm");
        assert_eq!(file_name("a/b\\c.mpf"), "c.mpf");
    }
}
