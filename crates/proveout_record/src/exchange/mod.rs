//! Results for other programs: SARIF 2.1.0 (OASIS 2020) for code review and editors, `JUnit` XML for build
//! servers. Both are made from the same plain data, of a run or of a check.
//!
//! | file | what it does |
//! |---|---|
//! | `sarif.rs` | SARIF |
//! | `junit.rs` | JUnit XML |
//! | `of_verdict.rs` | the data of a verdict |

mod junit;
mod of_verdict;
mod sarif;

pub use junit::junit;
pub use of_verdict::{LineOf, reported};
pub use sarif::sarif;

use proveout_sim::finding::Severity;
use serde_json::{Map, Value};

/// What is said of one program, or of one checked file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportedSuite {
    /// Name of the program, or path of the file.
    pub name: String,
    /// Scene, or kind of the file.
    pub group: String,
    /// Machine time, s, where it is known.
    pub time_s: Option<f64>,
    /// Questions with their answers.
    pub cases: Vec<ReportedCase>,
    /// Everything found, with or without a case.
    pub items: Vec<ReportedItem>,
    /// False where no answer could be given at all, since an input is not in order.
    pub executed: bool,
}

/// A gate, or the check of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportedCase {
    /// Stable name.
    pub name: String,
    /// Answer.
    pub answer: CaseAnswer,
    /// Why.
    pub reason: String,
}

/// The answer to a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseAnswer {
    /// Checked and passed.
    Pass,
    /// Checked and failed.
    Fail,
    /// Not checked: this never counts as passed.
    Unchecked,
    /// The scene does not ask.
    NotAsked,
}

/// Something found, with its place in a text.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportedItem {
    /// Stable code.
    pub code: String,
    /// What the code means, one sentence; empty where it is not in the registry.
    pub summary: String,
    /// Weight.
    pub severity: Severity,
    /// What, where, by how much.
    pub message: String,
    /// Name of the case that it fails.
    pub case: Option<String>,
    /// Path of the file, relative to the folder of the call where it is below it.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<u32>,
    /// Column, from 1, in characters.
    pub column: Option<u32>,
    /// Text of the line, for a fingerprint that a new line above does not change; empty where it is not
    /// known.
    pub line_text: String,
    /// Further data: time, axes, point, value and limit with their units in the names.
    pub more: Map<String, Value>,
}
