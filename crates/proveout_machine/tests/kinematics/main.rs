//! Forward and inverse kinematics: laws on random machines, branch choice and singular poses on known ones.

mod branches;
mod common;
mod laws;
