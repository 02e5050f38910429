//! Comments that name a tool: whose tool they describe.
//!
//! | comment | is of |
//! |---|---|
//! | `T="DRILL_D8" D8 DRILL`, `TOOL CALL "DRILL_D8"` | `DRILL_D8`, whatever tool is called next |
//! | `T=DRILL_D8 8 MM` | `DRILL_D8`, whatever tool is called next |
//! | `DRILL_D8: D8 DRILL 140 DEG`, where the program calls a tool of that name | `DRILL_D8` |
//! | `MILL_D10 BEFORE DRILL_D8` | several tools, so it describes none |
//! | `"ROUGHING" D10 END MILL`, where no tool has that name | the tool whose call is next to it |
//!
//! Text in quotes is a name, and no dimension: the quote after `"DRILL_D8"` is no inch sign. A
//! quote after a number is one: `1/2"`.

use std::collections::BTreeSet;

use proveout_nc::ToolName;
use proveout_tool::ToolDraft;

use super::tool_words;

/// Tools that a program calls by name.
#[derive(Debug, Default)]
pub(super) struct Known(BTreeSet<String>);

/// Whose tool a comment describes.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Told {
    /// The tool of this name; what the comment says besides.
    Of(String, String),
    /// More than one tool.
    OfSeveral,
    /// None by name; the comment without its quotes, but for those that are inch signs.
    OfNone(String),
}

/// A character of a name.
fn in_name(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-' | '.')
}

/// Texts in quotes, with their places, quotes included. A quote after a digit is an inch sign.
fn quoted(text: &str) -> Vec<(usize, usize, &str)> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(open) = text[from..].find('"').map(|i| i + from) {
        from = open + 1;
        let before = text[..open].trim_end().chars().next_back();
        if text[..open].ends_with(|c: char| c.is_ascii_digit() || c == '.') || before == Some('/') {
            continue;
        }
        let Some(close) = text[open + 1..].find('"').map(|i| i + open + 1) else { break };
        found.push((open, close + 1, &text[open + 1..close]));
        from = close + 1;
    }
    found
}

/// The word after `T=`, if it is no number, with its place.
fn behind_t(text: &str) -> Option<(usize, usize, &str)> {
    text.match_indices(['T', 't']).find_map(|(at, _)| {
        let alone = !text[..at].chars().next_back().is_some_and(in_name);
        let rest = text[at + 1..].trim_start().strip_prefix('=').filter(|_| alone)?;
        let word = rest.trim_start();
        let from = text.len() - word.len();
        let end = word.find(|c: char| !in_name(c)).unwrap_or(word.len());
        let word = word[..end].trim_end_matches(['.', '-']);
        let is_name = word.starts_with(char::is_alphabetic) && word.len() > 1;
        is_name.then_some((from, from + word.len(), word))
    })
}

impl Known {
    /// The names of these tools.
    pub(super) fn of(called: impl Iterator<Item = ToolName>) -> Self {
        let name = |tool| if let ToolName::Name(name) = tool { Some(name) } else { None };
        Self(called.filter_map(name).filter(|name| !name.is_empty()).collect())
    }

    /// Places at which a text has one of the names as a whole word, in capitals or not, the longest name
    /// first.
    fn places(&self, text: &str) -> Vec<(usize, usize, &str)> {
        let lower = text.to_lowercase();
        // Letters that change their length would move the places.
        let lower = if lower.len() == text.len() { lower } else { text.to_owned() };
        let mut names: Vec<&String> = self.0.iter().collect();
        names.sort_by_key(|name| std::cmp::Reverse(name.len()));
        let mut found: Vec<(usize, usize, &str)> = Vec::new();
        for name in names {
            for (at, _) in lower.match_indices(&name.to_lowercase()) {
                let end = at + name.len();
                let (Some(before), Some(behind)) = (text.get(..at), text.get(end..)) else { continue };
                let whole = !before.chars().next_back().is_some_and(in_name)
                    && !behind.chars().next().is_some_and(|c| in_name(c) && c != '.' && c != '-');
                let free = found.iter().all(|(from, to, _)| end <= *from || at >= *to);
                // A name that is a word of the trade is one here, too: `DRILL` names no tool where
                // it gives the kind of another.
                let distinct = name.contains(|c: char| !c.is_alphabetic());
                if whole && free && distinct {
                    found.push((at, end, name));
                }
            }
        }
        found
    }

    /// Whose tool a comment describes.
    pub(super) fn told(&self, comment: &str) -> Told {
        let quotes = quoted(comment);
        let behind_t = behind_t(comment).filter(|(at, ..)| quotes.iter().all(|(from, to, _)| at < from || at >= to));
        let mut names: BTreeSet<String> = BTreeSet::new();
        let mut cuts: Vec<(usize, usize)> = quotes.iter().map(|(from, to, _)| (*from, *to)).collect();
        let called =
            |text: &str| text.trim_end().ends_with('=') || text.trim_end().to_uppercase().ends_with("TOOL CALL");
        for (from, _, name) in &quotes {
            if self.0.contains(*name) || called(&comment[..*from]) {
                names.insert((*name).to_owned());
            }
        }
        if let Some((from, to, name)) = behind_t {
            let known = self.0.iter().find(|known| known.eq_ignore_ascii_case(name));
            names.insert(known.cloned().unwrap_or_else(|| name.to_owned()));
            cuts.push((from, to));
        }
        let written = self.places(comment);
        for (from, to, name) in written {
            if cuts.iter().all(|(a, b)| to <= *a || from >= *b) {
                names.insert(name.to_owned());
                cuts.push((from, to));
            }
        }
        let mut names = names.into_iter();
        match (names.next(), names.next()) {
            (None, _) => Told::OfNone(unquoted(comment, &quotes)),
            (Some(name), None) => Told::Of(name, without(comment, cuts)),
            _ => Told::OfSeveral,
        }
    }
}

/// A text without its quotation marks.
fn unquoted(text: &str, quotes: &[(usize, usize, &str)]) -> String {
    let mark = |at: usize| quotes.iter().any(|(from, to, _)| at == *from || at + 1 == *to);
    text.char_indices().map(|(at, c)| if mark(at) { ' ' } else { c }).collect()
}

/// A text without these places of it; `T=` before one goes with it.
fn without(text: &str, mut cuts: Vec<(usize, usize)>) -> String {
    cuts.sort_unstable();
    let mut rest = String::with_capacity(text.len());
    let mut from = 0;
    for (a, b) in cuts {
        let kept = text.get(from..a).unwrap_or_default();
        let bare = kept.trim_end();
        let call = bare.strip_suffix('=').map(str::trim_end);
        rest += match call.and_then(|t| t.strip_suffix(['T', 't'])) {
            Some(before) if !before.ends_with(char::is_alphanumeric) => before,
            _ => kept,
        };
        rest.push(' ');
        from = from.max(b);
    }
    rest += text.get(from..).unwrap_or_default();
    rest
}

/// The tool that a comment describes, which names it: `rest` is the comment without the name. Where that has
/// no size, the name may have it.
pub(super) fn described(name: &str, comment: &str, rest: &str, unit: f64, line: usize) -> Option<ToolDraft> {
    let of_rest = tool_words::of_comment(rest, unit, line).map(|(_, draft)| draft);
    let of_rest = of_rest.or_else(|| tool_words::of_comment(&format!("T1 {rest}"), unit, line).map(|(_, draft)| draft));
    let mut draft = of_rest.filter(|draft| draft.diameter().is_some()).or_else(|| {
        let mut draft = tool_words::of_name(name, unit, line)?;
        let told = proveout_tool::tool_kind_of_words(rest).filter(|_| draft.kind.is_none());
        draft.kind = draft.kind.or(told.and_then(|(kind, why)| (why.is_none() && kind != "bull_nose").then_some(kind)));
        Some(draft)
    })?;
    draft.number = 0;
    name.clone_into(&mut draft.name);
    draft.source = format!("comment in line {line}");
    comment.trim().clone_into(&mut draft.description);
    Some(draft)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known() -> Known {
        let names = ["MILL_D10", "DRILL_D8", "END_D12", "END_D12_R1", "DRILL"];
        Known::of(names.into_iter().map(|name| ToolName::Name(name.into())).chain([ToolName::Number(3)]))
    }

    #[test]
    fn a_comment_is_of_the_tool_that_it_names() {
        let of = |name: &'static str| Some(name);
        let cases: [(&str, Option<&str>); 16] = [
            ("T=\"MILL_D10\" D10 FLAT ENDMILL", of("MILL_D10")),
            ("T=MILL_D10 D10 FLAT ENDMILL", of("MILL_D10")),
            ("t = mill_d10 D10", of("MILL_D10")),
            ("MILL_D10: D10 FLAT ENDMILL", of("MILL_D10")),
            ("\"MILL_D10\" 10 MM", of("MILL_D10")),
            ("TOOL CALL \"REAMER_D8\" D8 REAMER", of("REAMER_D8")),
            ("T=\"REAMER_D8\" D8 REAMER", of("REAMER_D8")),
            ("END_D12_R1 BULL NOSE", of("END_D12_R1")),
            ("END_D12 END MILL", of("END_D12")),
            ("Mill_D10, then the rest", of("MILL_D10")),
            // Not a name of a tool, or not a whole one.
            ("DRILL_D80 D8 DRILL", None),
            ("D8 DRILL", None),
            ("1/2\" END MILL 3/4\" LONG", None),
            ("\"ROUGHING\" D10 END MILL", None),
            ("T5 D10 END MILL", None),
            ("T=5 D10 END MILL", None),
        ];
        for (comment, wanted) in cases {
            match (known().told(comment), wanted) {
                (Told::Of(name, rest), Some(wanted)) => {
                    assert_eq!(name, wanted, "{comment}");
                    assert!(!rest.contains(wanted), "{comment}: {rest}");
                }
                (Told::OfNone(_), None) => {}
                (told, _) => panic!("{comment}: {told:?}"),
            }
        }
        assert_eq!(known().told("MILL_D10 before DRILL_D8"), Told::OfSeveral);
        assert_eq!(known().told("\"ROUGHING\" D10"), Told::OfNone(" ROUGHING  D10".into()));
    }

    #[test]
    fn a_quote_behind_a_name_is_no_inch_sign() {
        // Every name and size, in quotes and not, before and after the words.
        for (name, kind) in [("MILL_D10", "FLAT ENDMILL"), ("DRILL_D8", "DRILL"), ("END_D12", "END MILL")] {
            let size: f64 = name.rsplit('D').next().and_then(|d| d.parse().ok()).expect("a size");
            for comment in [
                format!("T=\"{name}\" D{size} {kind}"),
                format!("\"{name}\" {kind}"),
                format!("{kind} \"{name}\""),
                format!("{kind} D{size} T=\"{name}\""),
                format!("T=\"{name}\" {kind}"),
                format!("T={name} D{size} {kind}"),
            ] {
                let Told::Of(own, rest) = known().told(&comment) else { panic!("{comment} names a tool") };
                let draft =
                    described(&own, &comment, &rest, 1.0, 1).unwrap_or_else(|| panic!("{comment} describes a tool"));
                assert_eq!((own.as_str(), draft.diameter()), (name, Some(size)), "{comment}");
                assert_eq!(draft.kind, Some(if kind == "DRILL" { "drill" } else { "flat" }), "{comment}");
            }
        }
    }
}
