//! What an ISO control keeps while its program runs, besides the modal state.

use std::collections::{BTreeMap, BTreeSet};

use super::flavor::Flavor;
use super::index::Index;
use super::modal::{CycleValues, Modal};
use crate::channel::corners::Corners;
use crate::channel::{self, Channel};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::source::Mark;
use crate::{AxisValues, WorkOffset};

/// A program file with its structure.
pub(crate) type Loaded = channel::LoadedProgram<Index>;

/// An ISO program being executed.
pub(crate) type Interpreter = Channel<Iso>;

/// What a call level keeps.
#[derive(Debug)]
pub(crate) struct IsoCall {
    pub(crate) kind: CallKind,
    /// Passes left of O REPEAT loops, by the offset of their first line.
    pub(crate) repeats: Vec<(usize, u64)>,
}

impl IsoCall {
    pub(crate) fn new(kind: CallKind) -> Self {
        Self { kind, repeats: Vec::new() }
    }
}

/// What a level of the call stack was entered by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CallKind {
    Main,
    /// M98, M97
    Sub,
    /// G65, G66: with parameters of its own.
    Macro,
    /// O CALL
    OSub,
}

/// A modal macro with its arguments.
#[derive(Clone, Debug)]
pub(crate) struct MacroCall {
    pub(super) program: CallTarget,
    pub(super) passes: u32,
    pub(super) arguments: Vec<(u32, f64)>,
    /// Values of local variables by name.
    pub(super) names: Vec<(String, f64)>,
    pub(super) depth: usize,
}

/// A program that is called: by a number that must be whole, or by the name of its head.
#[derive(Clone, Debug)]
pub(super) enum CallTarget {
    Number(f64),
    Name(String),
}

/// What an ISO control keeps besides the modal state.
#[derive(Debug)]
pub(crate) struct Iso {
    pub(crate) flavor: Flavor,
    /// The flavor is only the default: nothing in the text decides it.
    pub(crate) assumed: bool,
    /// The block has NCYL.
    pub(crate) no_cycle: bool,
    pub(crate) block_numbers: BTreeMap<(usize, usize, u32), Mark>,
    pub(crate) offsets: BTreeMap<String, WorkOffset>,
    /// Rotations of work offsets (`LinuxCNC`), degrees.
    pub(crate) turns: BTreeMap<String, f64>,
    /// Tool lengths that the program writes itself: geometry and wear, mm.
    pub(crate) lengths: BTreeMap<u32, (Option<f64>, f64)>,
    /// Tool radii that the program writes itself: geometry and wear, mm.
    pub(crate) radii: BTreeMap<u32, (Option<f64>, f64)>,
    /// M70
    pub(crate) kept_modal: Option<Box<Modal>>,
    /// F as written: its meaning follows from unit, feed mode and the axes of the motion.
    pub(crate) feed: Option<f64>,
    /// mm of one unit of length, as it was when F was read.
    pub(crate) feed_unit: f64,
    /// H and D in force.
    pub(crate) h: Option<u32>,
    pub(crate) d: Option<u32>,
    pub(crate) overrides: bool,
    /// The word that has canceled the tool length in Z, while nothing has said since whether it is back
    /// (Fanuc).
    pub(crate) length_canceled_by: Option<&'static str>,
    pub(crate) cycle: CycleValues,
    /// Pole and cycle of a Fagor.
    pub(crate) pole: [f64; 2],
    pub(crate) fagor: FagorCycle,
    /// Coordinates given by rapid motions on a tilted plane, while one coordinate is still open.
    pub(crate) held: AxisValues,
    /// Chamfers and roundings between the motions.
    pub(crate) corners: Corners,
    /// Control vector at the end of the last G5, for the next one.
    pub(crate) spline_end: Option<[f64; 2]>,
    /// Control points between G5.2 and G5.3.
    pub(crate) nurbs: Option<ControlPoints>,
    /// A plane that further blocks complete.
    pub(crate) plane_parts: Option<PlaneParts>,
    pub(crate) modal_macro: Option<MacroCall>,
    /// A modal macro waits for the end of the block with its motion.
    pub(crate) moved_in_block: bool,
    /// The M word that came last.
    pub(crate) last_m: u32,
    /// Words without a value that a note has named: line and letter.
    pub(crate) noted_vacant: BTreeSet<(u32, u8)>,
    /// Line number of the block.
    pub(crate) sequence: u32,
    /// The state at the start has been emitted.
    pub(super) started: bool,
    pub(crate) noted_integers: bool,
    /// A note on a tool length that changes without Z was emitted.
    pub(crate) noted_length: bool,
    pub(crate) noted_surface_speed: bool,
    /// First parameter of the reference points that a note has named.
    pub(crate) noted_references: Vec<u32>,
}

/// Words of a cycle as they are in force, lengths in mm.
#[derive(Clone, Debug, Default)]
pub(crate) struct FagorCycle {
    pub(super) values: [Option<f64>; 26],
}

/// What the blocks between G5.2 and G5.3 have said.
#[derive(Clone, Debug)]
pub(crate) struct ControlPoints {
    /// X, Y in work coordinates, mm, and the weight.
    pub(super) points: Vec<[f64; 3]>,
    pub(super) order: usize,
}

/// What blocks of G68.2 P2 or P3 have said of a plane that is not complete yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlaneParts {
    pub(super) form: u32,
    /// Q0 of P2: origin, and turn about the new z in degrees.
    pub(super) origin: Option<([f64; 3], f64)>,
    /// Q1 to Q3 of P2; of P3 the origin, and the direction of +x.
    pub(super) points: [Option<[f64; 3]>; 3],
}

/// Name of a work offset as a key: upper case, no blanks.
pub(crate) fn offset_key(word: &str) -> String {
    word.chars().filter(|c| !c.is_whitespace()).collect::<String>().to_ascii_uppercase()
}

/// `#3000 = 1 (TEXT)`, `(ABORT, TEXT)`: the program ends itself.
pub(crate) fn alarm(text: &str, span: Span) -> Fault {
    Fault::new(codes::PROGRAM_ALARM, span, format!("the program raises an alarm: {}", text.trim()))
        .help("find out which of its conditions is not met")
}
