//! Developer programs: CI steps, dependency check, asset generators.
fn main() {}
