//! Forward and inverse kinematics: laws on random machines, branch choice and singular poses on known ones,
//! platforms, actual machines, tool axes past and through poles.
#![allow(clippy::print_stdout, reason = "figures for people, shown with --nocapture")]

mod actual;
mod branches;
mod common;
mod hybrid;
mod laws;
mod limits;
mod poles;
mod redundant;
