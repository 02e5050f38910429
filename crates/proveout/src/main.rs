//! The command line of Proveout.
fn main() {}
