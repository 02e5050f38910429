//! Lines of the program files of a run, as findings and blocks name them.

use std::{collections::BTreeSet, fs};

use proveout_nc::{OperationHead, ProgramText, operation_heads};

use crate::observe::observer::Setup;

/// Largest file that is looked into, bytes: lines are shown to people.
const MOST_BYTES: u64 = 64 << 20;
/// Longest line that is shown, characters.
const MOST_CHARS: usize = 240;

/// Which lines of a file are wanted.
#[derive(Clone, Debug)]
pub enum Wanted {
    /// All of them.
    All,
    /// These, from 1.
    Lines(BTreeSet<u32>),
}

/// Some lines of a program file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listing {
    /// The file as findings name it.
    pub file: String,
    /// Lines of the whole file.
    pub lines: u32,
    /// Number, from 1, and text of each line that is here, in order. Long ones are cut off and end in `…`.
    pub shown: Vec<(u32, String)>,
}

/// Sizes of the program files of a run in bytes, with their names in findings; files that are gone are left
/// out.
pub fn files(setup: &Setup<'_>) -> Vec<(String, u64)> {
    let made = setup.made.map(|m| (m.file.clone(), m.text.len() as u64));
    let read = |(opened, shown): (&String, &std::sync::Arc<str>)| {
        fs::metadata(opened).ok().map(|m| (shown.to_string(), m.len()))
    };
    made.into_iter().chain(setup.sources.iter().filter_map(read)).collect()
}

/// Lines of a file by its name in findings; none where it cannot be read any more or is above 64 MiB.
pub fn lines(setup: &Setup<'_>, file: &str, wanted: &Wanted) -> Option<Listing> {
    if let Some(made) = setup.made.filter(|m| m.file == file) {
        let all: Vec<&str> = made.text.lines().collect();
        return Some(picked(file, all.len(), wanted, |n| all.get(n - 1).copied()));
    }
    let (opened, _) = setup.sources.iter().find(|(_, shown)| ***shown == *file)?;
    if fs::metadata(opened).ok()?.len() > MOST_BYTES {
        return None;
    }
    let text = ProgramText::open(opened).ok()?;
    let all: Vec<&str> = text.all().collect();
    Some(picked(file, all.len(), wanted, |n| all.get(n - 1).copied()))
}

/// Operations of a file by its name in findings: line of each head, from 1, and name; none where the file
/// cannot be read any more or is above 64 MiB.
pub fn operations(setup: &Setup<'_>, file: &str) -> Vec<(u32, String)> {
    let told = |heads: Vec<OperationHead>| heads.into_iter().map(|head| (head.line, head.name)).collect();
    if let Some(made) = setup.made.filter(|m| m.file == file) {
        return told(operation_heads(made.text.lines()));
    }
    let Some((opened, _)) = setup.sources.iter().find(|(_, shown)| ***shown == *file) else { return Vec::new() };
    if !fs::metadata(opened).is_ok_and(|about| about.len() <= MOST_BYTES) {
        return Vec::new();
    }
    ProgramText::open(opened).map_or_else(|_| Vec::new(), |text| told(operation_heads(text.all())))
}

fn picked<'t>(file: &str, count: usize, wanted: &Wanted, line: impl Fn(usize) -> Option<&'t str>) -> Listing {
    let short = |text: &str| {
        let text = text.trim_end();
        match text.char_indices().nth(MOST_CHARS) {
            Some((at, _)) => format!("{}…", &text[..at]),
            None => text.to_owned(),
        }
    };
    let take = |n: usize| line(n).map(|text| (n as u32, short(text)));
    let shown = match wanted {
        Wanted::All => (1..=count).filter_map(take).collect(),
        Wanted::Lines(numbers) => {
            numbers.iter().map(|n| *n as usize).filter(|n| (1..=count).contains(n)).filter_map(take).collect()
        }
    };
    Listing { file: file.to_owned(), lines: count as u32, shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_outside_of_a_text_are_left_out_and_long_ones_are_cut() {
        let long = "X".repeat(500);
        let text = ["N1 G0", long.as_str(), "M30  "];
        let get = |n: usize| text.get(n - 1).copied();
        let some = picked("a.mpf", 3, &Wanted::Lines([0, 2, 3, 4].into()), get);
        assert_eq!(some.shown.iter().map(|l| l.0).collect::<Vec<_>>(), [2, 3]);
        assert_eq!((some.shown[0].1.chars().count(), some.shown[1].1.as_str()), (241, "M30"));
        assert_eq!(picked("a.mpf", 3, &Wanted::All, get).shown.len(), 3);
        assert_eq!(picked("a.mpf", 0, &Wanted::All, |_| None), Listing { file: "a.mpf".into(), ..Listing::default() });
    }
}
