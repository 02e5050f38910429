//! Checks of our own, each a function from what is there to a list of faults.

pub(crate) mod architecture;
pub(crate) mod book;
pub(crate) mod facts;
pub(crate) mod findings;
pub(crate) mod layers;
pub(crate) mod style;
pub(crate) mod test_command;
