//! Machines for the unit tests of this crate.

use std::path::Path;

use crate::Machine;

/// The library machine with a swiveling rotary table.
pub(crate) fn u5() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
    Machine::read(&folder).expect("the library machine is right")
}
