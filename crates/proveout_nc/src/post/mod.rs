//! Posts: canonical commands to program text.
//!
//! A post writes what the commands say and nothing else. Reading the text gives the same motions within the
//! decimals that were written; a frame may come back as several commands that end in the same transform.

mod apt;
mod format;
mod heidenhain;
mod iso;
mod iso_motion;
mod siemens;
mod siemens_frames;
mod verify;

use std::collections::BTreeMap;
use std::io;

use crate::settings::Dialect;
use crate::{Command, Coolant, FeedCounts, Location, Motion, Op, WorkOffset};

pub use apt::AptPost;
pub use heidenhain::HeidenhainPost;
pub use iso::IsoPost;
pub use siemens::SiemensPost;
pub use verify::{Difference, verify};

/// Writes canonical commands as program text, one after the other.
pub trait Post {
    /// Writes a command.
    ///
    /// # Errors
    /// The sink fails, or the command cannot be said in this language.
    fn write(&mut self, command: &Command) -> Result<(), PostError>;

    /// Writes what follows the last command, and flushes the sink.
    ///
    /// # Errors
    /// The sink fails.
    fn finish(&mut self) -> Result<(), PostError>;
}

/// The post of a dialect.
///
/// ```
/// use proveout_nc::post::{PostSettings, post_for};
/// use proveout_nc::{Dialect, Program, Settings};
///
/// let fanuc = "G21 G90 G54\nG0 X0. Y0. Z5.\nG1 Z-2. F200.\nX40. F600.\nM30\n";
/// let form = PostSettings::between(Dialect::Fanuc, Dialect::Siemens840d);
/// let mut text = Vec::new();
/// let mut post = post_for(Dialect::Siemens840d, form, &mut text)?;
/// for command in Program::from_text("slot.nc", fanuc, &Settings::default())? {
///     post.write(&command?)?;
/// }
/// post.finish()?;
/// drop(post);
/// let text = String::from_utf8(text)?;
/// assert!(text.contains("X40") && text.contains("F600"), "{text}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// There is no post for [`Dialect::Auto`] and [`Dialect::HeidenhainIso`].
pub fn post_for<'a, W: io::Write + 'a>(
    dialect: Dialect,
    settings: PostSettings,
    sink: W,
) -> Result<Box<dyn Post + 'a>, PostError> {
    Ok(match dialect {
        Dialect::Siemens840d => fed(SiemensPost::new(sink, settings)),
        Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => fed(IsoPost::new(dialect, sink, settings)),
        Dialect::Heidenhain => fed(HeidenhainPost::new(sink, settings)),
        Dialect::Apt => Box::new(AptPost::new(sink, settings)),
        Dialect::HeidenhainIso | Dialect::Auto => return Err(PostError::NoPost { dialect: dialect.name() }),
    })
}

/// Writes what a change of the coolant takes, with the words of a language for off, flood and mist.
fn tell_coolant(
    before: Coolant,
    now: Coolant,
    [off, flood, mist]: [&str; 3],
    mut write: impl FnMut(&str) -> Result<(), Unpostable>,
) -> Result<(), Unpostable> {
    let less = before.flood && !now.flood || before.mist && !now.mist;
    if less || !now.flood && !now.mist {
        write(off)?;
    }
    if now.flood && (less || !before.flood) {
        write(flood)?;
    }
    if now.mist && (less || !before.mist) {
        write(mist)?;
    }
    Ok(())
}

/// Refuses a motion of which a programmed axis has no value as it would be written. Axes without a word stay
/// where the machine has them on every control.
fn must_be_known(motion: &Motion, value: impl Fn(usize) -> Option<f64>) -> Result<(), Unpostable> {
    let lost = (0..9).any(|axis| motion.programmed >> axis & 1 == 1 && value(axis).is_none());
    if lost {
        return Err(Unpostable::new(
            "a point in a turned frame of which not all coordinates are known",
            "program X, Y and Z in the first block after the frame",
        ));
    }
    Ok(())
}

/// What the feed counts in a block that turns rotary axes, which each language counts in its own way.
fn feed_counts(counts: FeedCounts, target: Dialect) -> Result<(), Unpostable> {
    let of_target = match target {
        Dialect::Fanuc | Dialect::Haas | Dialect::Iso | Dialect::Heidenhain => {
            FeedCounts { radius: [FeedCounts::DEGREE_IS_MM; 3], ..FeedCounts::LINEAR }
        }
        _ => FeedCounts::LINEAR,
    };
    if counts == of_target {
        return Ok(());
    }
    Err(Unpostable::new(
        "a feed of linear and rotary axes together, which the target counts in another way,",
        "program these blocks by their time (G93), or under tool center point control",
    ))
}

/// A turn about a point ahead of the tip, which only the block that asks for it could say.
fn turns_ahead() -> Unpostable {
    Unpostable::new(
        "a turn of the tool about a point ahead of its tip (MOVE with DIST)",
        "retract, and write DIST0 or TURN",
    )
}

/// The post of a control, which takes no motion in feed before a feed: CL data may have one.
fn fed<'a>(post: impl Post + 'a) -> Box<dyn Post + 'a> {
    Box::new(PostFeeder { post, feed: false })
}

struct PostFeeder<P> {
    post: P,
    feed: bool,
}

impl<P: Post> Post for PostFeeder<P> {
    fn write(&mut self, command: &Command) -> Result<(), PostError> {
        self.feed |= matches!(command.op, Op::Feed(_));
        if !self.feed && matches!(command.op, Op::Linear(_) | Op::Arc(_) | Op::Spline(_) | Op::Probe(_)) {
            let what = "the motion has no feed, and a control wants one";
            return Err(Unpostable::new(what, "give a feed before it, or a default feed").at(&command.location));
        }
        self.post.write(command)
    }

    fn finish(&mut self) -> Result<(), PostError> {
        self.post.finish()
    }
}

/// Which number calls the length of the tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EdgeNumbers {
    /// As the commands say: for a program of the same kind of control.
    #[default]
    AsProgrammed,
    /// The number of the tool, as ISO programs have it (`T5 M6`, `G43 H5`).
    Tool,
    /// 1, as an 840D has it for the first cutting edge.
    One,
}

/// Format of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct PostSettings {
    /// Decimals of lengths, mm or inch.
    pub length_decimals: usize,
    /// Decimals of arc centers.
    pub center_decimals: usize,
    /// Decimals of rotary axes and frame angles, degrees.
    pub angle_decimals: usize,
    /// Decimals of the components of tool vectors.
    pub vector_decimals: usize,
    /// Decimals of feed values.
    pub feed_decimals: usize,
    /// A whole number of a length, angle or feed ends in a decimal point (`X10.`): many ISO controls read
    /// `X10` as 0.010 mm.
    pub decimal_point: bool,
    /// All decimals are written (`X10.000`).
    pub trailing_zeros: bool,
    /// Lengths in inch.
    pub inches: bool,
    /// Arcs of up to a half turn by their radius (R, CR=) instead of their center.
    pub arc_radius: bool,
    /// Coordinates that have not changed, and words that are in force, are left out.
    pub modal: bool,
    /// Distance of the N words; none: no N words. Klartext numbers its blocks in steps of one in any case.
    pub block_number_step: Option<u32>,
    /// Number (`1234`) or name of the program.
    pub program_name: String,
    /// Lines at the start, written unchanged, in place of the usual ones of the dialect.
    pub header: Option<Vec<String>>,
    /// Lines after the end of the program, written unchanged.
    pub footer: Vec<String>,
    /// Which number calls the length of a tool.
    pub edge_numbers: EdgeNumbers,
    /// Values of the work offsets set in the control, as in [`crate::Settings::work_offsets`]: a
    /// frame command gives the whole transform, the text only the part above the work offset.
    pub work_offsets: BTreeMap<String, WorkOffset>,
}

impl Default for PostSettings {
    /// 3 decimals for lengths and angles of axes as shop programs have, 5 for centers, 6 for vectors, no
    /// block numbers, mm, no offsets.
    fn default() -> Self {
        Self {
            length_decimals: 3,
            center_decimals: 5,
            angle_decimals: 3,
            vector_decimals: 6,
            feed_decimals: 1,
            decimal_point: false,
            trailing_zeros: false,
            inches: false,
            arc_radius: false,
            modal: false,
            block_number_step: None,
            program_name: "PROVEOUT".to_owned(),
            header: None,
            footer: Vec::new(),
            edge_numbers: EdgeNumbers::AsProgrammed,
            work_offsets: BTreeMap::new(),
        }
    }
}

impl PostSettings {
    /// What programs of a dialect usually look like, for commands that were read from another one.
    pub fn between(from: Dialect, to: Dialect) -> Self {
        let iso = |d: Dialect| matches!(d, Dialect::Iso | Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc);
        let base = Self { modal: true, ..Self::default() };
        match to {
            _ if iso(to) => Self {
                center_decimals: if to == Dialect::LinuxCnc { 5 } else { 4 },
                decimal_point: true,
                program_name: "1".to_owned(),
                edge_numbers: if iso(from) { EdgeNumbers::AsProgrammed } else { EdgeNumbers::Tool },
                ..base
            },
            Dialect::Siemens840d => Self {
                edge_numbers: if from == to { EdgeNumbers::AsProgrammed } else { EdgeNumbers::One },
                modal: false,
                ..base
            },
            Dialect::Apt => Self {
                length_decimals: 5,
                vector_decimals: 8,
                feed_decimals: 4,
                decimal_point: true,
                modal: false,
                ..base
            },
            _ => base,
        }
    }

    /// The same with one decimal more for lengths and feed, in inch.
    #[must_use]
    pub fn in_inches(self) -> Self {
        Self {
            length_decimals: self.length_decimals + 1,
            center_decimals: self.center_decimals + 1,
            feed_decimals: self.feed_decimals + 2,
            inches: true,
            ..self
        }
    }
}

/// Why a program could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PostError {
    /// The sink failed.
    #[error("the program cannot be written: {0}")]
    Io(#[from] io::Error),
    /// No post writes this dialect.
    #[error("no post writes the dialect {dialect}; choose siemens-840d, fanuc, haas, linuxcnc, iso, heidenhain or apt")]
    NoPost {
        /// Name of the dialect.
        dialect: &'static str,
    },
    /// A command that the language of the post cannot say.
    #[error("{}:{}: {what}; {help}", location.file, location.line)]
    Unsupported {
        /// What cannot be said.
        what: String,
        /// What to do about it.
        help: &'static str,
        /// Place of the command.
        location: Location,
    },
}

/// A command that cannot be said, before it knows its place.
#[derive(Debug)]
pub(crate) enum Unpostable {
    Io(io::Error),
    Unsupported(String, &'static str),
}

impl From<io::Error> for Unpostable {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl Unpostable {
    pub(crate) fn new(what: impl Into<String>, help: &'static str) -> Self {
        Self::Unsupported(what.into(), help)
    }

    pub(crate) fn at(self, location: &Location) -> PostError {
        match self {
            Self::Io(error) => PostError::Io(error),
            Self::Unsupported(what, help) => PostError::Unsupported { what, help, location: location.clone() },
        }
    }
}

/// Location of text that follows the last command.
pub(crate) fn nowhere() -> Location {
    Location { file: "".into(), line: 0, column: 0, length: 0, depth: 0 }
}

/// Number with at most so many decimals, without trailing zeros: `10`, `-0.5`, `0`.
fn decimal(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" { "0".to_owned() } else { text }
}

/// As [`decimal`], with as many decimals as it takes for a value above zero not to become zero.
fn positive(value: f64, decimals: usize) -> String {
    (decimals..decimals + 12).map(|d| decimal(value, d)).find(|text| text != "0").unwrap_or_else(|| "0".to_owned())
}

#[cfg(test)]
mod tests {
    use super::{decimal, positive};

    #[test]
    fn a_small_feed_stays_a_feed() {
        assert_eq!(positive(0.001, 1), "0.001");
        assert_eq!(positive(100.0, 1), "100");
    }

    #[test]
    fn decimals_are_trimmed() {
        assert_eq!(decimal(10.0, 3), "10");
        assert_eq!(decimal(-0.5, 3), "-0.5");
        assert_eq!(decimal(-0.0001, 3), "0");
        assert_eq!(decimal(100.0, 0), "100");
        assert_eq!(decimal(1.23456, 4), "1.2346");
    }
}
