//! Readers, one folder for each dialect.

pub(crate) mod siemens;
