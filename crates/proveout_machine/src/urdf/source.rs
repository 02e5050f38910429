//! The text of a URDF file: places for errors, and numbers of attributes.

use std::{f64::consts::FRAC_PI_2, ops::Range, path::Path};

use proveout_geom::Point;
use proveout_input::{InputError, MAX_LENGTH_MM};
use roxmltree::Node;

/// Bytes of the text.
pub(super) type Place = Range<usize>;

/// Characters of a name or value that an error repeats.
const SHOWN: usize = 60;

/// Millimeters of a meter.
pub(super) const METER_MM: f64 = 1e3;

/// A right angle may miss half of its last decimal by this, radian: rounding.
const ROUNDING: f64 = 1e-12;

/// An angle that was less off its right angle is not worth a note, radian: rounding in the last digits of a
/// double.
const WORTH_A_NOTE: f64 = 1e-9;

pub(super) struct UrdfSource<'a> {
    pub(super) file: &'a Path,
    pub(super) text: &'a str,
}

/// A name or value in quotes, cut where it is long.
pub(super) fn shown(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        None => format!("{text:?}"),
        Some((end, _)) => format!("{:?}...", text.get(..end).unwrap_or_default()),
    }
}

/// The first names of a list in quotes, the others counted.
pub(super) fn listed<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    const FIRST: usize = 12;
    let mut names = names.into_iter();
    let first: Vec<String> = names.by_ref().take(FIRST).map(shown).collect();
    match names.count() {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// The largest coordinate of points; infinite where one is no number.
pub(super) fn reach(points: &[Point]) -> f64 {
    let all = points.iter().flat_map(|p| p.iter()).map(|v| if v.is_finite() { v.abs() } else { f64::INFINITY });
    all.fold(0.0, f64::max)
}

/// The opening tag of an element as far as its name goes.
pub(super) fn place(node: Node<'_, '_>) -> Place {
    let start = node.range().start;
    start..start + 1 + node.tag_name().name().len()
}

/// The multiple of a right angle meant by a text that has been cut or rounded to two decimals or more:
/// 1.57, 3.1416.
fn right_angle(text: &str, value: f64) -> Option<f64> {
    let quarters = (value / FRAC_PI_2).round();
    if quarters == 0.0 || quarters.abs() > 8.0 || text.contains(['e', 'E']) {
        return None;
    }
    let exact = quarters * FRAC_PI_2;
    let decimals = text.split_once('.').map_or(0, |(_, d)| d.len().min(15));
    let (unit, miss) = (0.1_f64.powi(decimals as i32), (value - exact).abs());
    let rounded = miss <= 0.5 * unit + ROUNDING;
    let cut = value.abs() < exact.abs() && miss < unit;
    (decimals >= 2 && (rounded || cut)).then_some(exact)
}

impl UrdfSource<'_> {
    pub(super) fn at(&self, place: &Place, message: impl Into<String>, remedy: impl Into<String>) -> InputError {
        InputError::file(self.file, message, remedy).with_span(self.text, place)
    }

    pub(super) fn whole(&self, message: impl Into<String>, remedy: impl Into<String>) -> InputError {
        InputError::file(self.file, message, remedy)
    }

    /// Bytes of an attribute, of its element where it is missing.
    fn place_of(node: Node<'_, '_>, key: &str) -> Place {
        node.attribute_node(key).map_or_else(|| place(node), |a| a.range())
    }

    /// Numbers of an attribute, as many as are wanted; none where it is missing.
    pub(super) fn numbers<const N: usize>(
        &self,
        node: Node<'_, '_>,
        key: &str,
    ) -> Result<Option<[f64; N]>, InputError> {
        let Some(text) = node.attribute(key) else { return Ok(None) };
        let mut values = [0.0; N];
        let mut words = text.split_whitespace();
        let read = values.iter_mut().all(|value| {
            let number = words.next().and_then(|w| w.parse::<f64>().ok()).filter(|v| v.is_finite());
            number.map(|n| *value = n).is_some()
        });
        if read && words.next().is_none() {
            return Ok(Some(values));
        }
        let tag = node.tag_name().name();
        let what = if N == 1 { "not a number".to_owned() } else { format!("not {N} numbers") };
        let remedy = if text.contains("${") {
            "expand the file with xacro first, and name the result"
        } else {
            "correct the value"
        };
        Err(self.at(&Self::place_of(node, key), format!("{key} = {} of <{tag}> is {what}", shown(text)), remedy))
    }

    /// The same, in meter, as millimeters.
    pub(super) fn lengths<const N: usize>(
        &self,
        node: Node<'_, '_>,
        key: &str,
    ) -> Result<Option<[f64; N]>, InputError> {
        let Some(values) = self.numbers::<N>(node, key)? else { return Ok(None) };
        let values = values.map(|v| v * METER_MM);
        match values.iter().find(|v| v.abs() > MAX_LENGTH_MM) {
            None => Ok(Some(values)),
            Some(v) => {
                let message =
                    format!("{key} of <{}> has {v} mm; the limit is {MAX_LENGTH_MM} mm", node.tag_name().name());
                Err(self.at(&Self::place_of(node, key), message, "write meters"))
            }
        }
    }

    /// Roll, pitch and yaw; a right angle whose digits were cut is one, which `squared` learns.
    pub(super) fn angles(&self, node: Node<'_, '_>, squared: &mut usize) -> Result<Option<[f64; 3]>, InputError> {
        let Some(mut values) = self.numbers::<3>(node, "rpy")? else { return Ok(None) };
        let words = node.attribute("rpy").unwrap_or_default().split_whitespace();
        for (value, text) in values.iter_mut().zip(words) {
            if let Some(exact) = right_angle(text, *value) {
                *squared += usize::from((*value - exact).abs() > WORTH_A_NOTE);
                *value = exact;
            }
        }
        Ok(Some(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_of_a_right_angle_are_one() {
        let of = |text: &str| right_angle(text, text.parse().expect("number")).map(|v| (v / FRAC_PI_2).round());
        for (text, quarters) in [
            ("1.57", 1.0),
            ("1.5708", 1.0),
            ("1.5707", 1.0),
            ("-1.57079", -1.0),
            ("1.5707963267948966", 1.0),
            ("1.570796326794897", 1.0),
            ("3.14", 2.0),
            ("3.1416", 2.0),
            ("-3.14159265359", -2.0),
            ("4.71238898", 3.0),
        ] {
            assert_eq!(of(text), Some(quarters), "{text}");
        }
        for text in ["0", "0.0001", "1.6", "1.58", "1.56", "1.571796", "1.5705", "0.7854", "2", "31.4159", "1.57e0"] {
            assert_eq!(of(text), None, "{text}");
        }
    }
}
