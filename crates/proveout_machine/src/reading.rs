//! What every reader of a part of the machine file needs: single values with their checks, and notes.

use std::collections::BTreeMap;

use proveout_geom::Vector;
use proveout_input::{Document, InputError, Step};

/// A direction may miss the length one by this much, and is then normalized: six digits in a file.
const UNIT_TOLERANCE: f64 = 1e-6;
/// Shorter vectors have no direction.
const SHORTEST: f64 = 1e-12;

pub(crate) type Checked<T> = Result<T, InputError>;

/// Notes on numbers: key of the same table, or `*` for all others, to a text.
pub(crate) type Notes = BTreeMap<String, String>;

pub(crate) fn positive(source: &Document<'_>, path: &[Step<'_>], value: Option<f64>) -> Checked<Option<f64>> {
    match value {
        Some(v) if !(v > 0.0 && v.is_finite()) => {
            let remedy = "write a finite number above zero, or leave the key out where the value is not known";
            Err(source.error("machine-not-positive", path, format!("{v} cannot be"), remedy))
        }
        v => Ok(v),
    }
}

pub(crate) fn finite_vector(source: &Document<'_>, path: &[Step<'_>], v: [f64; 3]) -> Checked<Vector> {
    if v.iter().all(|x| x.is_finite()) {
        return Ok(Vector::from(v));
    }
    Err(source.error(
        "machine-not-finite",
        path,
        format!("{v:?} is not a valid position"),
        "write three finite numbers",
    ))
}

pub(crate) fn unit(source: &Document<'_>, path: &[Step<'_>], v: [f64; 3]) -> Checked<Vector> {
    let v = finite_vector(source, path, v)?;
    let length = v.norm();
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        // A vector that is exact already, as along a machine axis, must stay exact.
        return Ok(if length == 1.0 { v } else { v / length });
    }
    let remedy = match v.try_normalize(SHORTEST) {
        Some(n) => format!("write [{:.9}, {:.9}, {:.9}] if that is the direction", n.x, n.y, n.z),
        None => "write a vector of length one".to_owned(),
    };
    let message = format!("the direction {:?} has the length {length:.9}, not one", [v.x, v.y, v.z]);
    Err(source.error("machine-not-unit", path, message, remedy))
}
