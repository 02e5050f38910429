//! NC program text to canonical commands, and back. Knows nothing about machines: no tool lengths, no
//! kinematics, no limits.
//!
//! **Data in and out.** In: program text and [`Settings`] (work offsets, values of variables, limits). Out:
//! [`Command`]s with their place in the text. Lengths are mm, angles radian, times seconds, whatever the unit
//! of the program. Every motion carries its end twice: `end` in the active work frame, as programmed, and
//! `end_base` after all offsets, frames, mirrors and scales, tool length not applied. With tool center point
//! control on (TRAORI), base coordinates are fixed to the table; with it off, they are those of the machine's
//! linear axes at the tool tip; with all rotary axes at zero both are the same. A coordinate that the program
//! has not set has no value.
//!
//! **Main types.**
//! * [`Program`] – an iterator of commands; nothing that was executed is kept, so length of a program costs
//!   no memory.
//! * [`Command`], [`Op`] – what the control is to do.
//! * [`Diagnostic`] – what is wrong, with file, line, column, remedy and a stable code of [`CODES`];
//!   [`check`] collects them.
//! * [`Survey`] – a whole program read at once: all its faults, and the text that its run does not reach
//!   ([`NotRun`]).
//! * [`Advice`] – what keeps a text from being read, and the control file that mends it.
//! * [`JsonWriter`] – commands as JSON lines.
//! * [`post`] – commands back to text.
//!
//! **Algorithm and sources.** Hand-written scanner and Pratt parser for each line; an index of the structure
//! of a file (loops, branches, labels, subprograms) made once; execution line by line in one channel that all
//! languages share: calls, recovery, feed and spindle, motions, courses of holes, formulas. Language of the
//! Siemens reader: Siemens, *SINUMERIK 840D sl, NC programming*, chapters on frames, control structures,
//! transformations, cycles. The README's table says word by word what is supported, approximated, ignored
//! with a note, or refused by name.
//!
//! **Limits.** The README says word by word what each dialect supports. Rounding of corners is
//! handed on as a tolerance. An action that a machine builder assigns to an M word is named in a
//! note and not executed.
//!
//! **Files.**
//!
//! | file or folder | holds |
//! |---|---|
//! | `dialect/` | the languages: `apt/`, `heidenhain/`, `iso/`, `siemens/`; which one a text is |
//! | `channel/` | what all languages share: calls, jumps, formulas, holes, milling, recovery, coverage |
//! | `cycle/` | the parameters of all cycles as tables, one file a language |
//! | `advice/` | the control file that lets a program be read, from the program itself |
//! | `control/` | control files: words, start state and parameters of a control |
//! | `compensation/`, `overcut.rs` | the path of the tool center from a contour; where it cuts the contour |
//! | `json/` | commands as JSON lines |
//! | `post/` | commands to text, one file a language |
//! | `feed_words.rs` | F words of a text, found and rewritten |
//! | `command.rs`, `g_code.rs` | the commands; G words by number |
//! | `probing.rs` | what probing motions have found |
//! | `program.rs`, `survey.rs`, `not_run.rs`, `tally.rs` | a program as commands, and as a whole |
//! | `codes.rs`, `diagnostic.rs` | codes and texts of faults |
//! | `settings.rs`, `machine_data.rs` | what the reader knows besides the text |
//! | `scan.rs`, `source.rs` | characters and lines of a text |
//! | `operation_names.rs` | operations by the names that comments give them |
//! | `state.rs`, `frame.rs` | place of the tool; transforms between coordinate systems |
//! | `arc.rs`, `spline.rs`, `optional_stop.rs` | circles; B-splines and NURBS; M1 with a spindle that turns |

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

mod advice;
mod arc;
mod channel;
mod codes;
mod command;
mod compensation;
mod control;
mod cycle;
mod diagnostic;
mod dialect;
mod feed_words;
mod frame;
mod g_code;
mod json;
mod machine_data;
mod not_run;
mod operation_names;
mod optional_stop;
mod overcut;
pub mod post;

mod probing;
mod program;
mod scan;
mod settings;
mod source;
mod spline;
mod state;
mod survey;
mod tally;

pub use advice::{Advice, AdviceCall, Advised};
pub use codes::{CODES, CodeInfo, explain};
pub use command::*;
pub use control::{
    ArcTolerance, Control, ControlFileError, UnknownWord, UnknownWords, WholeNumbers, builtin_controls, control_schema,
};
pub use diagnostic::{Diagnostic, Diagnostics};
pub use dialect::detect;
pub use feed_words::{FeedMotion, FeedText, FeedTextFault, FeedWord, feed_motions, same_but_feeds};
pub use json::{JsonWriter, to_json};
pub use machine_data::{Kinematics, ReferencePoints};
pub use not_run::{NotRun, NotRunKind, Weight};
pub use operation_names::{OperationHead, operation_heads};
pub use optional_stop::OptionalStop;
pub use overcut::{Overcut, OvercutKind, OvercutWeight};
pub use probing::{Contact, Met, Touch, TouchList};
pub use program::{CommandSource, Program, check, check_text};
pub use settings::{Compensation, Dialect, Limits, Settings, ToolRadii, WorkOffset};
pub use source::ProgramText;
pub use survey::{Look, Survey};
pub use tally::{Remark, Tally, long_dwell};
