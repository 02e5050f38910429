//! A control as data: what the builder of a machine and the set-up of its control decide about the words of a
//! program.
//!
//! A file `controls/NAME.toml` says what M and G words mean, what is in force at the start, how
//! numbers without a decimal point are read, how round an arc must be, and so on. A file may
//! inherit from another one; the last parent names the language. Where no file says anything, the
//! behavior of the language's reader applies.
//!
//! [`file`] is the text with its schema, [`place`] finds lines and columns for errors, [`inherit`]
//! follows the parents, [`resolve`] with [`start`], [`values`] and [`meanings`] turns files into a
//! [`Control`]. [`family`] says who uses a key, [`words`] is the table of words, [`builtin`] lists
//! the files that come with the program. [`unknown`] collects the words of a program that a control
//! has no meaning for.

mod builtin;
mod error;
mod family;
mod file;
mod inherit;
mod meanings;
mod model;
mod parameters;
mod place;
mod resolve;
mod start;
#[cfg(test)]
mod tests;
mod unknown;
mod values;
pub(crate) mod words;

pub use builtin::builtin_controls;
pub use error::ControlFileError;
pub use file::control_schema;
pub use model::{ArcTolerance, Control, WholeNumbers};
pub(crate) use model::{Centers, DwellUnit, FineBoring, StartFeed, StartMotion};
pub(crate) use parameters::{
    CompensatedPath, LengthWord, MixedFeed, OrientationAngles, OutsideModulo, ReturnLevel, Rollover, TiltSolution,
};
pub use unknown::{UnknownWord, UnknownWords};
pub(crate) use words::Meaning;
