//! Text of a program that its run does not reach.

use std::fmt;
use std::sync::Arc;

/// Lines in the files of a program that its run has not reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotRun {
    /// File as given by the caller.
    pub file: Arc<str>,
    /// First and last line, from 1. Every line between them that holds a block was not run.
    pub lines: [u32; 2],
    /// Why they were not run.
    pub kind: NotRunKind,
    /// Some of them move an axis.
    pub moves: bool,
    /// Text of the first line.
    pub text: String,
}

/// Why text is not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotRunKind {
    /// It is after the end of the program (M30, FINI, an M30 in a subprogram), and no jump leads
    /// there.
    BehindEnd,
    /// It is another main program of the file.
    Program(String),
    /// It is a subprogram that no block calls.
    Subprogram(String),
    /// Conditions and jumps lead around it.
    Branch,
    /// It is a subprogram that is called and not there; the lines are those of its call.
    MissingSubprogram(String),
    /// It is before the first or after the last `%`, where no control reads.
    Outside,
}

/// What text that is not run means for a prove-out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// The machine does not run it either: nothing is missing.
    Harmless,
    /// The machine may be asked to run it, and the run says nothing of it.
    Unproven,
    /// Motion of the program itself that is lost.
    Lost,
}

impl NotRun {
    /// What it means for a prove-out.
    ///
    /// Motion after the end belongs to the program and is lost, on the machine as well. Another
    /// main program is one that an operator can choose. Subprograms that are not called and
    /// branches that are not taken do nothing on the machine.
    pub fn weight(&self) -> Weight {
        match self.kind {
            NotRunKind::BehindEnd if self.moves => Weight::Lost,
            NotRunKind::Program(_) | NotRunKind::Outside | NotRunKind::MissingSubprogram(_) if self.moves => {
                Weight::Unproven
            }
            _ => Weight::Harmless,
        }
    }

    /// A call whose subprogram is not there, left out for the reason that the control states.
    pub fn is_left_out(&self) -> bool {
        matches!(self.kind, NotRunKind::MissingSubprogram(_))
    }

    /// What can be done about it.
    pub fn remedy(&self) -> &'static str {
        match self.kind {
            NotRunKind::BehindEnd => "remove the end word where the program goes on, or remove the text after it",
            NotRunKind::Program(_) => "give each main program a file of its own and prove each of them",
            NotRunKind::Subprogram(_) => "call it, or remove it",
            NotRunKind::MissingSubprogram(_) => {
                "put it into the folder of the program, or name its folder with --subprograms"
            }
            NotRunKind::Branch => "prove the other values of the condition too, or remove the text",
            NotRunKind::Outside => "write it between the two `%`, or remove it",
        }
    }
}

impl fmt::Display for NotRun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, last] = self.lines;
        let (is, belongs) = if first == last {
            write!(f, "line {first} of {}", self.file)?;
            ("is", "belongs")
        } else {
            write!(f, "lines {first} to {last} of {}", self.file)?;
            ("are", "belong")
        };
        match &self.kind {
            NotRunKind::BehindEnd => write!(f, " {is} never run: the program ends before"),
            NotRunKind::Program(name) => write!(f, " {is} not run: {belongs} to another main program, {name}"),
            NotRunKind::Subprogram(name) => write!(f, " {is} not run: nothing calls {name}"),
            NotRunKind::MissingSubprogram(name) => {
                write!(f, " {belongs} to a call that is left out: {name} was not found")
            }
            NotRunKind::Branch => write!(f, " {is} not run: conditions and jumps lead around"),
            NotRunKind::Outside => write!(f, " {is} not read: outside of the two `%` of the program"),
        }
    }
}
