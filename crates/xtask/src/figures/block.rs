//! Figures of a page that are listed in one block at its end, so that the raw text and its tables can be
//! read.
//!
//! ```text
//!   Re-scheduling saves 17.8 ± 3.6 percent.            the text has the numbers alone
//!
//!   <!-- figures: updated by cargo xtask figures
//!   [17.8] = li gains.s-theta.stretch_time.percent .1
//!   ± [3.6] = li gains.s-theta.stretch_time.error_percent .1
//!   -->
//! ```
//!
//! *Entry*: the figure in brackets, then run, key, form and bound as in a remark (`marker.rs`). *Order*: that
//! of the page; each figure is searched after the one before it. *Words*: where the same number comes again
//! before the next figure, or comes earlier, the words in front of the bracket decide which one is meant.

use super::marker::{Marker, markers};
use crate::TaskError;

/// First line of the block.
const OPEN: &str = "\n<!-- figures: updated by cargo xtask figures\n";
/// Last line of the block.
const CLOSE: &str = "-->";

/// An entry of the block.
struct Entry<'a> {
    /// Words in front of the figure, with the blank after them.
    words: &'a str,
    /// The figure as the page has it.
    figure: &'a str,
    /// Run, key, form and bound.
    source: &'a str,
}

impl<'a> Entry<'a> {
    fn read(line: &'a str) -> Option<Self> {
        let (left, source) = line.split_once("] = ")?;
        let (words, figure) = left.rsplit_once('[')?;
        (!figure.is_empty()).then_some(Self { words, figure, source })
    }
}

/// The figures of a page: those between remarks, and those of its block.
///
/// # Errors
/// The first one that is not written as it must be, or that the page does not have, with its line.
pub(super) fn all_markers(page: &str, text: &str) -> Result<Vec<Marker>, TaskError> {
    let mut all = markers(page, text)?;
    let Some(open) = text.find(OPEN) else { return Ok(all) };
    let fault = |line: usize, what: &str| TaskError(format!("{page}:{line}: {what}"));
    let begin = open + OPEN.len();
    let first_line = text[..begin].matches('\n').count() + 1;
    let length = text[begin..].find(CLOSE).ok_or_else(|| fault(first_line - 1, "the block of figures does not end"))?;
    let mut place = begin;
    // The figure before: what was searched, where it ends, and its line in the block.
    let mut before = (String::new(), 0, first_line);
    for (line, content) in (first_line..).zip(text[begin..begin + length].split_inclusive('\n')) {
        let entry = Entry::read(content.trim_end()).ok_or_else(|| {
            fault(line, "an entry is written as [17.8] = run key form, with a bound if it is of a surface")
        })?;
        let searched = format!("{}{}", entry.words, entry.figure);
        let (_, from, _) = before;
        let found = next(&text[..open], &searched, from)
            .ok_or_else(|| fault(line, &format!("the page has no {searched:?} after the figure before")))?;
        is_single(&text[..found], &before).map_err(|what| fault(before.2, &what))?;
        let shown = found + entry.words.len();
        let listed = place + entry.words.len() + 1;
        let remark = format!("{}<!--= {} -->{}<!--/-->", "\n".repeat(line - 1), entry.source, entry.figure);
        for mut marker in markers(page, &remark)? {
            marker.span = shown..shown + entry.figure.len();
            marker.listed = Some(listed..listed + entry.figure.len());
            all.push(marker);
        }
        before = (searched, shown + entry.figure.len(), line);
        place += content.len();
    }
    is_single(&text[..open], &before).map_err(|what| fault(before.2, &what))?;
    Ok(all)
}

/// Refuses a figure whose text comes once more before the end of `text`, the place of the next one.
fn is_single(text: &str, (searched, end, _): &(String, usize, usize)) -> Result<(), String> {
    if next(text, searched, *end).is_some() {
        return Err(format!("{searched:?} comes again before the next figure: put words in front of its bracket"));
    }
    Ok(())
}

/// Place of the next `searched` from `from` on that is no part of a longer word or number.
fn next(text: &str, searched: &str, from: usize) -> Option<usize> {
    let step = searched.chars().next()?.len_utf8();
    let mut at = from;
    loop {
        let begin = at + text.get(at..)?.find(searched)?;
        if is_apart(&text[..begin], &text[begin + searched.len()..]) {
            return Some(begin);
        }
        at = begin + step;
    }
}

/// Whether what is between the two texts is a word or number of its own.
fn is_apart(before: &str, after: &str) -> bool {
    let joins = |c: char| c.is_alphanumeric() || c == '_';
    let mut following = after.chars();
    let ends = match (following.next(), following.next()) {
        (Some('.'), Some(digit)) => !digit.is_ascii_digit(),
        (Some(c), _) => !joins(c),
        (None, _) => true,
    };
    ends && before.chars().next_back().is_none_or(|c| !joins(c) && !matches!(c, '.' | '-'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::marker::filled;

    fn page(text: &str, entries: &str) -> String {
        format!("{text}{OPEN}{entries}{CLOSE}\n")
    }

    #[test]
    fn figures_of_a_block_are_found_and_filled_in_text_and_block() {
        let text = page("It saves 17.8 ± 3.6 percent, 117.8 in all.\n", "[17.8] = r a .1\n± [3.6] = r b .1\n");
        let found = all_markers("p.md", &text).expect("figures");
        assert_eq!(found.iter().map(|m| &text[m.span.clone()]).collect::<Vec<_>>(), ["17.8", "3.6"]);
        assert_eq!((found[0].key.as_str(), found[0].line, found[1].line), ("a", 4, 5));
        let now = filled(&text, &found, &[Some("18.0".into()), Some("4".into())]);
        assert_eq!(now, page("It saves 18.0 ± 4 percent, 117.8 in all.\n", "[18.0] = r a .1\n± [4] = r b .1\n"));
        assert_eq!(filled(&text, &found, &[None, None]), text);
    }

    #[test]
    fn a_figure_that_is_missing_or_comes_twice_is_a_fault_with_its_line() {
        let message = |text: &str, entries: &str| all_markers("p.md", &page(text, entries)).expect_err(entries).0;
        assert!(message("a 1.5\n", "[2.5] = r a .1\n").contains("p.md:4: the page has no \"2.5\""));
        assert!(message("a 1.5 b 1.5\n", "[1.5] = r a .1\n").contains("p.md:4: \"1.5\" comes again"));
        assert!(message("a 1.5\n", "1.5 = r a .1\n").contains("p.md:4: an entry is written"));
        assert!(message("a 1.5\n", "[1.5] = r a 1\n").contains("p.md:4: the form"));
        assert!(all_markers("p.md", &page("a 1.5 b 1.5\n", "b [1.5] = r a .1\n")).is_ok());
        assert!(all_markers("p.md", &page("a 1.5 b 1.5\n", "[1.5] = r a .1\n[1.5] = r b .1\n")).is_ok());
        assert!(all_markers("p.md", &format!("a 1.5\n{OPEN}[1.5] = r a .1\n")).is_err(), "no end");
    }
}
