//! NC program text to canonical commands, and back.
//!
//! Knows nothing about machines: no tool lengths, no kinematics, no limits.
//!
//! * [`Command`] – one canonical command with its place in the text.

mod command;

pub use command::*;
