//! What a TNC keeps while its program runs, in addition to the modal state.

use std::collections::BTreeMap;

use crate::Location;
use crate::channel::{self, Channel};
use crate::source::Mark;

/// A program file with its labels.
pub(crate) type Loaded = channel::LoadedProgram<Labels>;

/// A Heidenhain program being executed.
pub(crate) type Interpreter = Channel<Heidenhain>;

/// The labels of a file.
#[derive(Debug)]
pub(crate) struct Labels {
    /// The file is DIN/ISO.
    pub(crate) din: bool,
    pub(crate) labels: BTreeMap<String, Mark>,
    /// A line that may hold a label cannot be read.
    pub(crate) unreadable: bool,
}

/// Key of a label: numbers and names share one namespace.
pub(crate) fn label_key(number: f64) -> String {
    format!("{number}")
}

/// What a call level keeps.
#[derive(Debug)]
pub(crate) struct KlartextCall {
    /// A program called with CALL PGM, not a label.
    pub(super) program: bool,
    /// Repetitions still to do, by the place of their CALL LBL block.
    pub(super) repetitions: BTreeMap<usize, u64>,
    /// Unit of the calling program.
    pub(super) inch: bool,
}

impl KlartextCall {
    pub(super) fn new(program: bool, inch: bool) -> Self {
        Self { program, repetitions: BTreeMap::new(), inch }
    }
}

/// What a TNC keeps in addition to the modal state.
#[derive(Debug, Default)]
pub(crate) struct Heidenhain {
    /// The main program is DIN/ISO.
    pub(super) din: bool,
    /// Lines of a joined block.
    pub(super) buffer: String,
    pub(super) calls: u64,
    pub(super) selected: Option<String>,
    /// The block that is executed is DIN/ISO.
    pub(crate) din_now: bool,
    /// Line of an earlier block, if the fault is one of that block, which waited for its end.
    pub(super) earlier: Option<u32>,
    /// The last reported fault was one of an earlier block.
    pub(super) earlier_failed: bool,
    /// A fault released the element that waited for its corner.
    pub(super) element_out: bool,
    /// Motions since the position became known again, and where the last one ended.
    pub(super) since: u32,
    pub(super) last: crate::AxisValues,
    /// Elements of a free contour that wait for their ends.
    pub(super) free: Free,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SignedCircle {
    pub(super) center: [f64; 2],
    /// Below zero clockwise.
    pub(super) signed: f64,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Held {
    Line,
    Arc(SignedCircle),
}

/// Elements whose ends are not known yet, and where a closed contour began.
#[derive(Debug, Default)]
pub(crate) struct Free {
    pub(super) start: Option<[f64; 2]>,
    /// FPOL
    pub(super) pole: Option<[f64; 2]>,
    pub(super) held: Vec<(Location, Held)>,
}

impl Free {
    pub(crate) fn waits(&self) -> bool {
        !self.held.is_empty()
    }
}
