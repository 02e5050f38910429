//! What a control file says, as far as it is the same for all languages: words that only say
//! something, subprograms that may be missing, the feed before the first F.

use super::{Channel, Language};
use crate::control::Meaning;
use crate::control::words::ListedWord;
use crate::dialect::listed::{call_not_run, ignored, left_out};
use crate::{Feed, Op};

/// Bits of all axes.
const EVERY_AXIS: u16 = 0x1ff;

impl<L: Language> Channel<L> {
    /// Emits what the control file says of a word: the word at a place of its table, and the values
    /// that belong to it.
    pub(crate) fn tell_listed(&mut self, at: usize, values: &str) {
        let Some(ListedWord { word, meaning, .. }) = self.settings.control.words.at(at).cloned() else { return };
        match meaning {
            Meaning::Message(text) => self.emit(Op::Message(text)),
            Meaning::Note(text) => self.note(format!("{word}{values}: {text}")),
            Meaning::Ignore(reason) if self.told_words.insert(at) => {
                self.note(ignored(&self.settings.control, &word, &reason));
            }
            _ => {}
        }
    }

    /// A subprogram that is called does not exist: left out, where the control allows it. The tool
    /// position after the call is unknown.
    pub(crate) fn leave_out(&mut self, name: &str) -> bool {
        let Some(text) = left_out(&self.settings, name) else { return false };
        self.note(text);
        if let Some(level) = self.stack.last() {
            self.missing.push(call_not_run(&level.loaded.source, self.location.line, name));
        }
        self.position.forget(EVERY_AXIS);
        self.technology.feed = None;
        true
    }

    /// The feed of the settings, mm/min, for a motion before the first F; emits the assumption.
    pub(crate) fn default_feed(&mut self) -> Option<f64> {
        let mm_min = self.settings.default_feed_mm_per_min?;
        self.assume(format!(
            "no F before the motion: the default feed of {mm_min} mm/min (--feed or the control file) applies"
        ));
        self.technology.feed = Some(Feed::PerTime(mm_min / 60.0));
        Some(mm_min)
    }
}
