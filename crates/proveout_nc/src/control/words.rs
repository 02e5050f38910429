//! The table of words: looked up once for each G and M word of a program, by its number.

use std::collections::BTreeMap;

use crate::g_code::GCode;

/// A word that the reader of the language executes without a control file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Builtin {
    G(GCode),
    M(u32),
}

/// What a word means on a control.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Meaning {
    /// What these words of the language do.
    Does(Vec<Builtin>),
    TcpOn,
    TcpOff,
    /// A subprogram of this name, as M98 calls it.
    Call(String),
    /// A macro of this name, with the words of the block as arguments, as G65 calls it; the O word subprogram
    /// of this label, with the words of the table's `values` as named parameters, as a remapped word of a
    /// `LinuxCNC` does.
    Macro(String),
    /// The work offset whose number the word of this letter gives.
    Offset(u8),
    /// The same for its block alone; 0 is the machine.
    OffsetOnce(u8),
    /// A text for the operator.
    Message(String),
    /// Named each time, without effect on the twin.
    Note(String),
    /// Named once with the reason, without effect on the twin.
    Ignore(String),
    /// With the remedy.
    Refuse(String),
}

/// A word with its meaning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ListedWord {
    /// As it is written: `M25`, `G38.2`, `CYCLE999`.
    pub(crate) word: String,
    pub(crate) meaning: Meaning,
    /// Letters of the words of the block that belong to it.
    pub(crate) values: Vec<u8>,
}

/// A name for a word, as the key of a control file writes it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum WordKey {
    G(GCode),
    M(u32),
    /// Upper case.
    Name(String),
}

impl std::fmt::Display for WordKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::G(code) => write!(f, "{code}"),
            Self::M(code) => write!(f, "M{code}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

/// Highest number of an M word that is looked up by its number alone; builders of machines stay below it.
const DENSE_M: u32 = 1000;

/// Words with their meanings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WordTable {
    entries: Vec<ListedWord>,
    /// One more than the place in `entries`, by ten times the number; zero for a word that is not listed.
    g: Vec<u16>,
    m: Vec<u16>,
    large_m: BTreeMap<u32, u16>,
    names: BTreeMap<String, u16>,
}

impl WordTable {
    /// Lists a word; one of the same key is replaced.
    pub(crate) fn put(&mut self, key: &WordKey, listed: ListedWord) {
        let place = self.place(key);
        if place > 0 {
            self.entries[usize::from(place) - 1] = listed;
            return;
        }
        // The file reader allows fewer words than places.
        let Ok(place) = u16::try_from(self.entries.len() + 1) else { return };
        self.entries.push(listed);
        match key {
            WordKey::G(code) => set(&mut self.g, code.tenths(), place),
            WordKey::M(code) if *code < DENSE_M => set(&mut self.m, *code, place),
            WordKey::M(code) => {
                self.large_m.insert(*code, place);
            }
            WordKey::Name(name) => {
                self.names.insert(name.clone(), place);
            }
        }
    }

    fn place(&self, key: &WordKey) -> u16 {
        match key {
            WordKey::G(code) => self.g.get(code.tenths() as usize).copied().unwrap_or(0),
            WordKey::M(code) if *code < DENSE_M => self.m.get(*code as usize).copied().unwrap_or(0),
            WordKey::M(code) => self.large_m.get(code).copied().unwrap_or(0),
            WordKey::Name(name) => self.names.get(name).copied().unwrap_or(0),
        }
    }

    fn entry(&self, place: u16) -> Option<(usize, &ListedWord)> {
        let at = usize::from(place.checked_sub(1)?);
        self.entries.get(at).map(|listed| (at, listed))
    }

    /// A G word, with its place in the table.
    pub(crate) fn g(&self, code: GCode) -> Option<(usize, &ListedWord)> {
        self.entry(self.g.get(code.tenths() as usize).copied().unwrap_or(0))
    }

    /// The M word of this number.
    pub(crate) fn m(&self, code: u32) -> Option<(usize, &ListedWord)> {
        let place = match self.m.get(code as usize) {
            Some(place) => *place,
            None if self.large_m.is_empty() => 0,
            None => self.large_m.get(&code).copied().unwrap_or(0),
        };
        self.entry(place)
    }

    /// The word of this name, in upper case.
    pub(crate) fn name(&self, name: &str) -> Option<(usize, &ListedWord)> {
        if self.names.is_empty() {
            return None;
        }
        self.entry(self.names.get(name).copied().unwrap_or(0))
    }

    /// The word at a place in the table.
    pub(crate) fn at(&self, at: usize) -> Option<&ListedWord> {
        self.entries.get(at)
    }
}

fn set(table: &mut Vec<u16>, code: u32, place: u16) {
    let at = code as usize;
    if table.len() <= at {
        table.resize(at + 1, 0);
    }
    table[at] = place;
}

/// `M25`, `G38.2` or, for languages with words, a name; none where the text is no word of any of these.
pub(crate) fn word_key(text: &str) -> Option<WordKey> {
    let text = text.trim().to_ascii_uppercase();
    let number = text.get(1..).unwrap_or_default();
    let digits = |s: &str, most: usize| !s.is_empty() && s.len() <= most && s.bytes().all(|b| b.is_ascii_digit());
    match text.as_bytes().first()? {
        b'M' if digits(number, 8) => return number.parse().ok().map(WordKey::M),
        b'G' => {
            if let Ok(code) = text.parse() {
                return Some(WordKey::G(code));
            }
        }
        _ => {}
    }
    let name = text.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b))
        && text.len() > 1
        && text.as_bytes()[0].is_ascii_alphabetic()
        && !digits(number, usize::MAX);
    name.then_some(WordKey::Name(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::g_code::{G1, G38_2};

    #[test]
    fn words_have_one_key_however_they_are_written() {
        assert_eq!(word_key("m03"), Some(WordKey::M(3)));
        assert_eq!(word_key(" M3 "), Some(WordKey::M(3)));
        assert_eq!(word_key("G1"), Some(WordKey::G(G1)));
        assert_eq!(word_key("g01"), Some(WordKey::G(G1)));
        assert_eq!(word_key("G38.2"), Some(WordKey::G(G38_2)));
        assert_eq!(word_key("CYCLE999"), Some(WordKey::Name("CYCLE999".to_owned())));
        for wrong in ["", "M", "G", "X10", "M3.5", "G38.21", "M1 M2", "M123456789", "3"] {
            assert!(word_key(wrong).is_none(), "{wrong}: {:?}", word_key(wrong));
        }
    }

    #[test]
    fn a_table_gives_back_what_was_put_last() {
        let listed =
            |text: &str| ListedWord { word: text.to_owned(), meaning: Meaning::Note(text.to_owned()), values: vec![] };
        let mut table = WordTable::default();
        for (word, text) in [("M3", "a"), ("M12345", "b"), ("G38.2", "c"), ("FOO", "d"), ("M03", "e")] {
            table.put(&word_key(word).expect("word"), listed(text));
        }
        let text = |found: Option<(usize, &ListedWord)>| found.map(|(_, listed)| listed.word.clone());
        assert_eq!(text(table.m(3)).as_deref(), Some("e"));
        assert_eq!(text(table.m(12345)).as_deref(), Some("b"));
        assert_eq!(text(table.g(G38_2)).as_deref(), Some("c"));
        assert_eq!(text(table.name("FOO")).as_deref(), Some("d"));
        assert_eq!((table.m(4), table.m(99_999), table.g(GCode(38, 0)), table.name("BAR")), (None, None, None, None));
    }
}
