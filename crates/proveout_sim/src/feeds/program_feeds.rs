//! The feeds of a program text: which lines may get another one, and the text with new ones.
//!
//! Nothing of the language is known here. A new text is read again: every command but the feeds must be the
//! same, and every motion must have the feed that is meant for it. Where a motion takes over a feed that was
//! changed before it, its line gets its own feed back; where its line may not be written (a cycle, a
//! subprogram), the change before it is given up.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

use proveout_input::{InputError, InputFault};
use proveout_nc::{
    Command, Dialect, Feed, FeedMotion, FeedText, FeedTextFault, FeedWord, Op, Override, Program, Settings,
    feed_motions, same_but_feeds,
};

use crate::prepare::{error::SimError, prepared::Prepared};

/// Units of F words for each mm/s: mm/min and inch/min.
const UNITS: [f64; 2] = [60.0, 60.0 / 25.4];
/// Relative difference of two feeds that are the same number of a text.
const SAME: f64 = 1e-9;
/// Relative difference of a feed that was read from the one that was meant, and of a new feed from a number
/// that it is rounded down to all the same.
const MEANT: f64 = 1e-6;
/// Digits of a new feed that count: a part in a hundred at the most.
const DIGITS: i32 = 3;
/// Attempts to give the motions after changed lines their own feeds again.
const ATTEMPTS: usize = 200;

/// Why a line keeps its feed, whatever cuts there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum KeptWhy {
    /// Its block moves more than one way: a cycle, or a corner that the control inserts.
    Cycle,
    /// It belongs to a subprogram, whose calls may differ.
    Subprogram,
    /// Feed per revolution (G95).
    PerRevolution,
    /// Inverse time (G93).
    InverseTime,
    /// It runs with several feeds, in a loop.
    SeveralFeeds,
    /// Its feed is no F word of the text: scaled on an arc, from a cycle or a tool call.
    NoWord,
    /// A cycle or subprogram after it takes over its feed.
    TakenOver,
    /// The cutter goes straight down.
    Plunge,
    /// Its feed is not the speed of the tool tip: rotary axes count in it.
    NotTheTip,
    /// The spindle does not turn.
    SpindleAtRest,
    /// The limits do not name its tool.
    NoLimits,
}

impl KeptWhy {
    /// Words for it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Cycle => "cycle or inserted corner",
            Self::Subprogram => "subprogram",
            Self::PerRevolution => "feed per revolution (G95)",
            Self::InverseTime => "inverse time (G93)",
            Self::SeveralFeeds => "several feeds in a loop",
            Self::NoWord => "feed of no F word",
            Self::TakenOver => "its feed is taken over by a cycle or subprogram",
            Self::Plunge => "plunge",
            Self::NotTheTip => "feed is not the speed of the tip",
            Self::SpindleAtRest => "the spindle does not turn",
            Self::NoLimits => "tool without limits",
        }
    }
}

/// A line that may get another feed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FeedLine {
    /// Feed in force, mm/s.
    feed: f64,
    /// The word that it comes from, and units of the program for each mm/s.
    word: String,
    unit: f64,
}

/// A program and its feeds.
#[derive(Debug)]
pub(crate) struct ProgramFeeds {
    path: PathBuf,
    name: String,
    settings: Settings,
    text: FeedText,
    commands: Vec<Command>,
    motions: Vec<FeedMotion>,
    /// Lines of the main program with motion in feed.
    lines: BTreeMap<u32, Result<FeedLine, KeptWhy>>,
}

/// A text with new feeds.
#[derive(Debug)]
pub(crate) struct WrittenFeeds {
    pub(crate) bytes: Vec<u8>,
    pub(crate) text: String,
    /// Scales as written, after rounding, by line.
    pub(crate) scales: BTreeMap<u32, f64>,
    /// Lines whose change was given up.
    pub(crate) taken_over: BTreeSet<u32>,
}

impl ProgramFeeds {
    /// Reads the text of a prepared program.
    ///
    /// # Errors
    /// A program that is made by the scene, CL data, UTF-16.
    pub(crate) fn read(prepared: &Prepared) -> Result<Self, SimError> {
        let path = prepared.program_path.clone();
        let whole = |message: &str, help: &str| SimError::from(InputError::file(&path, message, help));
        if prepared.made.is_some() {
            let help = "write its text with `proveout reschedule`, and give that with --nc";
            return Err(whole(
                "the scene makes this program by re-scheduling it: it has no text whose feeds can change",
                help,
            ));
        }
        let bytes = std::fs::read(&path).map_err(|e| whole(&format!("cannot be read: {e}"), "check the rights"))?;
        let dialect = prepared.program()?.dialect();
        let text = FeedText::new(bytes, dialect).map_err(|fault| match fault {
            FeedTextFault::Wide => whole("the text is UTF-16, and its feeds are not rewritten", "save it as UTF-8"),
            FeedTextFault::ClData => {
                whole("feeds of CL data (APT) are not rewritten", "post the program first, and give the posted text")
            }
        })?;
        let mut settings = prepared.nc_settings.clone();
        settings.subprogram_folders.insert(0, path.parent().map_or_else(PathBuf::new, PathBuf::from));
        if settings.dialect == Dialect::Auto {
            settings.dialect = dialect;
        }
        let name = path.display().to_string();
        let mut feeds =
            Self { path, name, settings, text, commands: Vec::new(), motions: Vec::new(), lines: BTreeMap::new() };
        feeds.commands = feeds.commands_of(&decoded(feeds.text.bytes()))?;
        feeds.motions = feed_motions(&feeds.commands);
        feeds.lines = feeds.lines();
        Ok(feeds)
    }

    fn commands_of(&self, text: &str) -> Result<Vec<Command>, SimError> {
        let program = Program::from_text(&self.name, text, &self.settings)?;
        Ok(program.collect::<Result<Vec<_>, _>>()?)
    }

    /// An error at a line of the program.
    pub(crate) fn error(&self, code: &'static str, line: u32, message: String, remedy: &str) -> SimError {
        let text = decoded(self.text.bytes());
        let source_line = text.lines().nth((line as usize).saturating_sub(1)).unwrap_or_default().to_owned();
        let file = self.path.clone();
        let line = line as usize;
        InputError::from(InputFault {
            code,
            file,
            line,
            message,
            remedy: remedy.to_owned(),
            source_line,
            ..InputFault::default()
        })
        .into()
    }

    /// Refuses a text whose feeds are not for another program to decide.
    ///
    /// # Errors
    /// A feed that the control computes; an override that is switched off.
    pub(crate) fn check_writable(&self) -> Result<(), SimError> {
        for line in 1..=self.text.lines() {
            if let Some(FeedWord::Computed(value)) = self.text.word(line) {
                let message = format!("the feed F {value} is computed by the control: nothing is written");
                let help = "write the feeds of this program as numbers";
                return Err(self.error("feeds-computed", line, message, help));
            }
        }
        let off = |c: &&Command| matches!(c.op, Op::Override(Override { enabled: false, .. }));
        if let Some(command) = self.commands.iter().find(off) {
            let message = "the program switches the feed override off: an operator cannot lower a new feed, and nothing is written";
            let help = "take the word out while new feeds are tried";
            return Err(self.error("feeds-override-off", command.location.line, message.to_owned(), help));
        }
        Ok(())
    }

    /// Why a line keeps its feed; none where it may get another one.
    pub(crate) fn kept(&self, line: u32) -> Option<KeptWhy> {
        match self.lines.get(&line) {
            Some(Ok(_)) => None,
            Some(Err(why)) => Some(*why),
            None => Some(KeptWhy::Subprogram),
        }
    }

    /// Lines of the main program with motion in feed, and where their feed comes from.
    fn lines(&self) -> BTreeMap<u32, Result<FeedLine, KeptWhy>> {
        let own = |m: &&FeedMotion| *m.file == *self.name;
        let called: BTreeSet<u32> = self.motions.iter().filter(own).filter(|m| m.depth > 0).map(|m| m.line).collect();
        let mut feeds: BTreeMap<u32, Result<f64, KeptWhy>> = BTreeMap::new();
        for motion in self.motions.iter().filter(own) {
            let feed = match motion.feed {
                _ if called.contains(&motion.line) => Err(KeptWhy::Subprogram),
                _ if !motion.plain => Err(KeptWhy::Cycle),
                Some(Feed::PerTime(feed)) => Ok(feed),
                Some(Feed::PerRevolution(_)) => Err(KeptWhy::PerRevolution),
                Some(Feed::InverseTime(_)) => Err(KeptWhy::InverseTime),
                None => Err(KeptWhy::NoWord),
            };
            let several = |a: &Result<f64, KeptWhy>, b: &Result<f64, KeptWhy>| match (a, b) {
                (Ok(a), Ok(b)) if !near(*a, *b, SAME) => Err(KeptWhy::SeveralFeeds),
                (Err(why), _) | (_, Err(why)) => Err(*why),
                (Ok(a), Ok(_)) => Ok(*a),
            };
            feeds.entry(motion.line).and_modify(|known| *known = several(known, &feed)).or_insert(feed);
        }
        let mut words: Vec<(f64, String)> = Vec::new();
        let mut read_to = 0;
        let mut lines = BTreeMap::new();
        for (line, feed) in feeds {
            while read_to < line {
                read_to += 1;
                if let Some(FeedWord::Number { value, text }) = self.text.word(read_to) {
                    words.retain(|(known, _)| known.to_bits() != value.to_bits());
                    words.push((value, text));
                }
            }
            let of = |feed: f64| {
                let word = words.iter().rev().find_map(|(value, text)| {
                    let unit = UNITS.into_iter().find(|unit| near(feed * unit, *value, SAME))?;
                    Some(FeedLine { feed, word: text.clone(), unit })
                });
                word.ok_or(KeptWhy::NoWord)
            };
            lines.insert(line, feed.and_then(of));
        }
        lines
    }

    /// The text in which these lines have `scale` times their feeds, rounded down; all others as they are.
    ///
    /// # Errors
    /// A text that says more than other feeds.
    pub(crate) fn write(&self, scales: &BTreeMap<u32, f64>) -> Result<WrittenFeeds, SimError> {
        let mut wanted: BTreeMap<u32, (String, f64)> = BTreeMap::new();
        for (line, scale) in scales {
            if let Some(Ok(of_line)) = self.lines.get(line) {
                let text = rounded_down(of_line.feed * scale * of_line.unit, of_line.word.contains('.'));
                let value = text.parse::<f64>().unwrap_or(0.0) / of_line.unit;
                if value > 0.0 {
                    wanted.insert(*line, (text, value));
                }
            }
        }
        let mut restored: BTreeMap<u32, String> = BTreeMap::new();
        let mut taken_over = BTreeSet::new();
        for _ in 0..ATTEMPTS {
            let words = wanted.iter().map(|(line, (text, _))| (*line, text.clone()));
            let words: BTreeMap<u32, String> = restored.clone().into_iter().chain(words).collect();
            let bytes = self.text.with_feeds(&words);
            let text = decoded(&bytes);
            let commands = self.commands_of(&text)?;
            if let Err(line) = same_but_feeds(&self.commands, &commands) {
                let message = "an F word in this block changes more than its feed: nothing is written".to_owned();
                return Err(self.error("feeds-not-alone", line, message, "write F on a block of its own"));
            }
            let mut settled = true;
            let mut wrong: Option<(f64, f64)> = None;
            let mut last_changed = None;
            let mut give_up = None;
            for (old, new) in self.motions.iter().zip(feed_motions(&commands)) {
                let own = old.depth == 0 && *old.file == *self.name;
                let meant = wanted.get(&old.line).filter(|_| own);
                let (Some(Feed::PerTime(before)), Some(Feed::PerTime(now))) = (old.feed, new.feed) else {
                    wrong = None;
                    continue;
                };
                let want = meant.map_or(before, |(_, value)| *value);
                if near(now, want, MEANT) {
                    wrong = None;
                } else if wrong != Some((now, want)) {
                    settled = false;
                    match self.lines.get(&old.line).filter(|_| own) {
                        Some(Ok(line)) if meant.is_none() => {
                            restored.insert(old.line, line.word.clone());
                        }
                        _ => {
                            give_up = last_changed;
                            break;
                        }
                    }
                    wrong = Some((now, want));
                }
                if meant.is_some() {
                    last_changed = Some(old.line);
                }
            }
            if settled {
                let scale = |line: u32, value: f64| match self.lines.get(&line) {
                    Some(Ok(of_line)) => value / of_line.feed,
                    _ => 1.0,
                };
                let scales = wanted.iter().map(|(line, (_, value))| (*line, scale(*line, *value))).collect();
                return Ok(WrittenFeeds { bytes, text, scales, taken_over });
            }
            if let Some(line) = give_up {
                wanted.remove(&line);
                restored.clear();
                taken_over.insert(line);
            }
        }
        let message =
            format!("after {ATTEMPTS} attempts some motion still has the feed of another block: nothing is written");
        Err(self.error("feeds-not-alone", 1, message, "write F on each block of the program"))
    }
}

fn near(a: f64, b: f64, part: f64) -> bool {
    (a - b).abs() <= part * a.abs().max(b.abs())
}

/// The text as the reader takes it: UTF-8, else Latin-1.
fn decoded(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|b| char::from(*b)).collect(), str::to_owned)
}

/// A feed above zero with its first digits, never above it.
fn rounded_down(value: f64, point: bool) -> String {
    if !(value > 0.0 && value.is_finite()) {
        return "0".to_owned();
    }
    let decimals = (DIGITS - 1 - value.log10().floor() as i32).clamp(0, 6);
    let factor = 10_f64.powi(decimals);
    // What the search leaves of a round number is that number.
    let value = (value * (1.0 + MEANT) * factor).floor() / factor;
    let text = format!("{value:.*}", decimals as usize);
    match (text.contains('.'), point) {
        (true, true) => text.trim_end_matches('0').to_owned(),
        (true, false) => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        (false, true) => text + ".",
        (false, false) => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_feed_is_rounded_down_to_three_digits() {
        for (value, point, want) in [
            (1234.9, false, "1234"),
            (523.7, true, "523."),
            (52.379, false, "52.3"),
            (5.2379, true, "5.23"),
            (0.052379, false, "0.0523"),
            (800.0, false, "800"),
            (799.999_9, false, "800"),
            (20.0, false, "20"),
            (20.0, true, "20."),
            (f64::NAN, false, "0"),
        ] {
            assert_eq!(rounded_down(value, point), want, "{value}");
        }
    }
}
