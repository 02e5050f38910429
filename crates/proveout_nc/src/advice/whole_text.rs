//! What a text says as a whole: whether its end looks like one, lines that are no blocks, tools in comments.

use std::ops::Range;

use super::draft::quoted;
use crate::diagnostic::Diagnostic;

/// Blocks at the end that are looked at.
const LAST_BLOCKS: usize = 4;
/// Lines at either end that may be no blocks.
const FRAME_LINES: usize = 40;
/// Letters in a row of a word of people's language: words of programs in letters and numbers have fewer.
const WORD_OF_TEXT: usize = 4;
/// Tool diameters of milling, mm.
const DIAMETERS_MM: Range<f64> = 0.1..500.0;

/// The end of the text as the end of the program, where its last blocks are what programs end with; a text
/// that stops in the middle of a cut has lost its end.
pub(super) fn end(fault: &Diagnostic, texts: &[String]) -> Option<(String, String)> {
    let line = (fault.line as usize).checked_sub(1)?;
    let text = texts.iter().find(|text| text.lines().nth(line) == Some(&*fault.source_line))?;
    let blocks = text.lines().rev().map(code_of).filter(|code| !code.is_empty()).take(LAST_BLOCKS);
    for code in blocks {
        if let Some(said) = ending(&code) {
            let why = format!("the text has no word for its end, and its last blocks are those of an end: {said}");
            return Some(("\"text\"".to_owned(), why));
        }
        // A block that cuts: what comes before it is no end.
        if !is_rapid(&code) && code.contains(['X', 'Y', 'Z']) {
            return None;
        }
    }
    None
}

fn is_rapid(code: &str) -> bool {
    has_word(code, "G0") || has_word(code, "G00")
}

/// Whether the block has the word, not followed by a digit.
fn has_word(code: &str, wanted: &str) -> bool {
    code.match_indices(wanted).any(|(at, _)| {
        let behind = code.get(at + wanted.len()..).and_then(|rest| rest.chars().next());
        behind.is_none_or(|c| !c.is_ascii_digit() && c != '.')
    })
}

/// What in a block says that the program is over, apart from the word for it.
fn ending(code: &str) -> Option<&'static str> {
    const WORDS: [(&[&str], &str); 4] = [
        (&["%"], "a `%` closes the tape"),
        (&["M5", "M05"], "the spindle stops"),
        (&["M9", "M09"], "coolant is switched off"),
        (&["G28", "G30", "G53"], "the axes go to their reference point"),
    ];
    let said = WORDS.iter().find(|(words, _)| words.iter().any(|wanted| has_word(code, wanted)));
    // Away from the part: along Z alone, and not below zero.
    let retracts = is_rapid(code) && code.contains('Z') && !code.contains("Z-") && !code.contains(['X', 'Y']);
    said.map(|(_, says)| *says).or(retracts.then_some("the tool retracts at rapid rate"))
}

/// A line without comments, number and blanks, in upper case.
fn code_of(line: &str) -> String {
    let mut depth = 0_usize;
    let mut out = String::new();
    for c in line.chars() {
        match c {
            ';' if depth == 0 => break,
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            c if depth == 0 && !c.is_whitespace() => out.push(c.to_ascii_uppercase()),
            _ => {}
        }
    }
    match out.strip_prefix('N') {
        Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()).to_owned(),
        None => out,
    }
}

/// A line before the first block or after the last one that is words of people: as a pattern of the head or
/// of the trailer.
pub(super) fn frame(fault: &Diagnostic, texts: &[String]) -> Option<(&'static str, String, String)> {
    let at = (fault.line as usize).checked_sub(1)?;
    let text = texts.iter().find(|text| text.lines().nth(at) == Some(&*fault.source_line))?;
    let lines: Vec<&str> = text.lines().collect();
    if !is_prose(&fault.source_line) {
        return None;
    }
    let pattern = |lines: &[&str]| {
        let all: Vec<String> = lines.iter().filter(|l| is_prose(l)).map(|l| quoted(l.trim())).collect();
        format!("[{}]", all.join(", "))
    };
    let before = lines.get(..at)?;
    if at < FRAME_LINES && before.iter().all(|line| !is_block(line)) {
        let head = lines.iter().take_while(|line| !is_block(line)).copied().collect::<Vec<_>>();
        let why = "the lines stand before the first block and are words of people".to_owned();
        return Some(("program.header", pattern(&head), why));
    }
    let behind = lines.get(at + 1..)?;
    if behind.len() < FRAME_LINES && behind.iter().all(|line| !is_block(line)) {
        let tail: Vec<&str> = lines.iter().rev().take_while(|line| !is_block(line)).copied().collect();
        let tail: Vec<&str> = tail.into_iter().rev().collect();
        let why = "the lines stand after the last block and are words of people".to_owned();
        return Some(("program.trailer", pattern(&tail), why));
    }
    None
}

/// A line that a control would execute: it begins with a letter and a number, or with a word of a language
/// that is followed by one.
fn is_block(line: &str) -> bool {
    let code = code_of(line);
    let mut chars = code.chars();
    let address = chars.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '#');
    address && chars.next().is_some_and(|c| c.is_ascii_digit() || "+-.#[=".contains(c)) && !is_prose(line)
}

/// A line of words of people: at least two words of letters alone, one of several letters, and no address
/// with a number.
fn is_prose(line: &str) -> bool {
    let trimmed = line.trim();
    if !trimmed.starts_with(char::is_alphabetic) || trimmed.contains(['=', '#', '[']) {
        return false;
    }
    let tokens: Vec<&str> = trimmed.split(|c: char| !c.is_alphanumeric()).filter(|token| !token.is_empty()).collect();
    let letters = |token: &&&str| token.chars().all(char::is_alphabetic) && token.chars().count() >= 2;
    let address = |token: &&str| {
        let mut chars = token.chars();
        chars.next().is_some_and(|c| c.is_ascii_alphabetic()) && chars.next().is_some_and(|c| c.is_ascii_digit())
    };
    let words: Vec<&&str> = tokens.iter().filter(letters).collect();
    words.len() >= 2 && words.iter().any(|word| word.chars().count() >= WORD_OF_TEXT) && !tokens.iter().any(address)
}

/// The radius of the tool, where comments of the texts state one diameter alone, mm.
pub(super) fn tool_radius(texts: &[String]) -> Option<f64> {
    let mut found: Option<f64> = None;
    for diameter in texts.iter().flat_map(|text| text.lines()).flat_map(diameters) {
        match found {
            Some(other) if other != diameter => return None,
            _ => found = Some(diameter),
        }
    }
    found.map(|diameter| 0.5 * diameter)
}

/// Diameters in the comment of a line: `D=10`, `DM=10`, `D10`.
fn diameters(line: &str) -> Vec<f64> {
    let comment = match line.find(['(', ';']) {
        Some(at) => line[at..].to_ascii_uppercase(),
        None => return Vec::new(),
    };
    let words = comment.split(|c: char| !(c.is_ascii_alphanumeric() || ".=".contains(c)));
    let value = |word: &str| -> Option<f64> {
        let number = ["DM=", "DIA=", "D="].iter().find_map(|mark| word.strip_prefix(mark))?;
        number.trim_end_matches("MM").trim_end_matches('.').parse().ok().filter(|d| DIAMETERS_MM.contains(d))
    };
    words.filter_map(value).collect()
}
