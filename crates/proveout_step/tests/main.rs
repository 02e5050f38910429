//! STEP files through helpers that the tests write: what they answer is used, or refused by name.
#![cfg(unix)]

mod fake;
mod faults;
mod kernel;
mod limits;
