//! The length unit that the shapes of a file count in.
//!
//! A shape belongs to a context; a context assigns units, one of which is a length. That unit is a meter with
//! a prefix, or a named one with its size in another unit:
//!
//! ```text
//!  #429 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) ... GLOBAL_UNIT_ASSIGNED_CONTEXT((#430,#431,#432)) ... )
//!  #430 = ( CONVERSION_BASED_UNIT('INCH',#434) LENGTH_UNIT() NAMED_UNIT(#433) )
//!  #434 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#435)
//!  #435 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )
//! ```

use std::collections::BTreeMap;

use crate::scan::{arguments, records, reference, string};

/// A unit of length.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthUnit {
    /// Name, as the file has it: `millimetre`, `INCH`.
    pub name: String,
    /// Millimeters of one unit.
    pub millimeters: f64,
}

/// Instances that units are made of, by number.
pub(crate) type UnitInstances<'a> = BTreeMap<u64, &'a [u8]>;

/// Units that are named in terms of others in terms of others: more are a circle.
const DEEPEST: u32 = 4;
/// Keywords of instances that are kept until all units are known.
const KEYWORDS: [&[u8]; 5] =
    [b"SI_UNIT", b"CONVERSION_BASED_UNIT", b"LENGTH_UNIT", b"LENGTH_MEASURE_WITH_UNIT", b"MEASURE_WITH_UNIT"];

/// Whether an instance is part of the description of a unit.
pub(crate) fn is_of_unit(keyword: &[u8]) -> bool {
    KEYWORDS.contains(&keyword)
}

/// The length unit with a number, where it is one that can be understood.
pub(crate) fn length_unit(all: &UnitInstances<'_>, id: u64) -> Option<LengthUnit> {
    unit_within(all, id, DEEPEST)
}

/// Whether the unit with a number is one of length.
pub(crate) fn is_length(all: &UnitInstances<'_>, id: u64) -> bool {
    all.get(&id).is_some_and(|value| records(value).iter().any(|r| r.0 == b"LENGTH_UNIT"))
}

fn unit_within(all: &UnitInstances<'_>, id: u64, depth: u32) -> Option<LengthUnit> {
    let records = records(all.get(&id)?);
    let of = |keyword: &[u8]| records.iter().find(|r| r.0 == keyword).map(|r| arguments(r.1));
    if let Some(si) = of(b"SI_UNIT") {
        let [prefix, unit] = [si.first()?, si.get(1)?].map(|a| a.trim_ascii());
        if unit != b".METRE." {
            return None;
        }
        let (word, meters) = prefix_of(prefix)?;
        return Some(LengthUnit { name: format!("{word}metre"), millimeters: 1000.0 * meters });
    }
    let conversion = of(b"CONVERSION_BASED_UNIT")?;
    let name = string(conversion.first()?)?;
    let measure = crate::scan::records(all.get(&reference(conversion.get(1)?)?)?);
    let measure = measure.first()?;
    let parts = arguments(measure.1);
    // The measure is typed, LENGTH_MEASURE(25.4), or bare, as Open CASCADE writes it.
    let value = *parts.first()?;
    let typed = crate::scan::records(value);
    let size = typed.first().map_or(value, |record| record.1);
    let size: f64 = std::str::from_utf8(size).ok()?.trim().parse().ok()?;
    let of = unit_within(all, reference(parts.get(1)?)?, depth.checked_sub(1)?)?;
    let millimeters = size * of.millimeters;
    (millimeters.is_finite() && millimeters > 0.0).then_some(LengthUnit { name, millimeters })
}

fn prefix_of(prefix: &[u8]) -> Option<(&'static str, f64)> {
    Some(match prefix {
        b"$" => ("", 1.0),
        b".MILLI." => ("milli", 1e-3),
        b".CENTI." => ("centi", 1e-2),
        b".DECI." => ("deci", 1e-1),
        b".MICRO." => ("micro", 1e-6),
        b".NANO." => ("nano", 1e-9),
        b".KILO." => ("kilo", 1e3),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meters_with_prefixes_and_named_units_have_their_size() {
        let all: UnitInstances<'_> = [
            (1, b"( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )".as_slice()),
            (2, b"( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) )"),
            (3, b"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#1)"),
            (4, b"( CONVERSION_BASED_UNIT('INCH',#3) LENGTH_UNIT() NAMED_UNIT(#9) )"),
            (5, b"( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )"),
            (6, b"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(12.),#4)"),
            (7, b"( CONVERSION_BASED_UNIT('FOOT',#6) LENGTH_UNIT() NAMED_UNIT(#9) )"),
            (8, b"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.),#9)"),
            (10, b"LENGTH_MEASURE_WITH_UNIT(25.4,#1)"),
            (11, b"( CONVERSION_BASED_UNIT('inch',#10) LENGTH_UNIT() NAMED_UNIT(\n  #12) )"),
            (9, b"( CONVERSION_BASED_UNIT('LOOP',#8) LENGTH_UNIT() NAMED_UNIT(#9) )"),
        ]
        .into_iter()
        .collect();
        let unit = |id| length_unit(&all, id).map(|u| (u.name, u.millimeters));
        assert_eq!(unit(1), Some(("millimetre".into(), 1.0)));
        assert_eq!(unit(2), Some(("metre".into(), 1000.0)));
        assert_eq!(unit(4), Some(("INCH".into(), 25.4)));
        assert_eq!(unit(11), Some(("inch".into(), 25.4)));
        let foot = length_unit(&all, 7).expect("a foot");
        assert!((foot.millimeters - 304.8).abs() < 1e-9, "{foot:?}");
        assert_eq!((unit(5), unit(9), unit(77)), (None, None, None));
        assert!(is_length(&all, 4) && !is_length(&all, 5) && !is_length(&all, 3));
    }
}
