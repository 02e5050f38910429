//! The text that runs instead of a program: re-scheduled from it, or planned again.

use proveout_controller::ReprogrammedRun;

/// A program that was made from another one.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeProgram {
    /// Name of its text, in findings and in the run folder.
    pub file: String,
    /// Its text, for an 840D.
    pub text: String,
    /// What was re-scheduled.
    pub runs: Vec<ReprogrammedRun>,
    /// The text that it was made from, where the call has that planned again.
    pub planned: Option<String>,
}
