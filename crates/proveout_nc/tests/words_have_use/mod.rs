//! Every word that a language knows, in every kind of its blocks: the block uses it, refuses it by name, or
//! names it in a note.
//!
//! ```text
//!   before      block                 after
//!   ...         G1 X10                ...        commands A
//!   ...         G1 X10  + one word    ...        a fault, or commands other than A
//! ```
//!
//! What comes after the block depends on all that a block can leave in force (feed, pole, plane,
//! compensation), so that a word that acts later is seen there.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panic")]

mod apt;
mod heidenhain;
mod iso;
mod siemens;

use proveout_nc::{Op, Program, Settings};

/// A language with its blocks and words.
struct Family<'a> {
    name: &'a str,
    settings: Settings,
    before: &'a str,
    blocks: &'a [&'a str],
    words: &'a [&'a str],
    behind: &'a str,
    /// Puts a word into a block.
    put: fn(&str, &str) -> String,
    /// A word that says in this block what holds without it.
    says_nothing_new: fn(&str, &str) -> bool,
}

/// The commands of a text, or its fault.
fn commands(text: &str, settings: &Settings) -> Result<Vec<Op>, String> {
    let program = Program::from_text("program", text, settings).map_err(|e| e.to_string())?;
    program.map(|command| command.map(|c| c.op).map_err(|e| e.to_string())).collect()
}

impl Family<'_> {
    fn text(&self, block: &str) -> String {
        format!("{}{block}\n{}", self.before, self.behind)
    }

    /// Words that a block takes without a trace.
    fn dropped(&self) -> Vec<String> {
        let mut dropped = Vec::new();
        for block in self.blocks {
            let plain = commands(&self.text(block), &self.settings)
                .unwrap_or_else(|e| panic!("{}: the block {block:?} is refused by itself: {e}", self.name));
            for word in self.words {
                if (self.says_nothing_new)(block, word) {
                    continue;
                }
                let more = (self.put)(block, word);
                if commands(&self.text(&more), &self.settings).is_ok_and(|with| with == plain) {
                    dropped.push(format!("{}: {more}", self.name));
                }
            }
        }
        dropped
    }
}

fn no_word_is_dropped(families: &[Family<'_>]) {
    let dropped: Vec<String> = families.iter().flat_map(Family::dropped).collect();
    assert!(dropped.is_empty(), "{} words are read and have no effect:\n{}", dropped.len(), dropped.join("\n"));
}

/// A word after a block, with a blank.
fn behind(block: &str, word: &str) -> String {
    format!("{block} {word}")
}
