//! Joins lines to blocks: continuation with `~`, and cycles with each parameter on a line of its
//! own.

use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::source::{Mark, Source};

/// Most bytes of one block with its continuation lines.
const MAX_BLOCK_BYTES: usize = 1 << 20;

/// A block of text: one line, or several joined by line feeds.
#[derive(Debug)]
pub(crate) struct BlockText<'a> {
    /// The line itself, or the joined lines of `buffer`.
    pub(crate) text: &'a str,
    pub(crate) next: Mark,
    /// The block has several lines.
    pub(crate) joined: bool,
}

/// `~` ends the line, or comes right before its comment.
fn continued(line: &str) -> bool {
    let ends = |text: &str| text.trim_end().ends_with('~');
    ends(line) || line.split_once(';').is_some_and(|(code, _)| ends(code))
}

/// `CYCL DEF 2nn` without a parameter on its line: the next lines `Q200=...` belong to it.
fn open_cycle(line: &str) -> bool {
    let rest = line.trim_start_matches(|c: char| c.is_ascii_digit() || c.is_ascii_whitespace() || c == '/');
    let after = |word: &str| {
        rest.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word)).then(|| &rest[word.len()..])
    };
    after("CYCL DEF").or_else(|| after("CYCLE DEF")).is_some_and(|rest| {
        let rest = rest.trim_start();
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        digits == 3 && !rest[digits..].starts_with('.') && !rest.split(';').next().unwrap_or_default().contains('=')
    })
}

fn parameter_line(line: &str) -> bool {
    let line = line.trim_start();
    let Some(rest) = line.strip_prefix(['Q', 'q']) else { return false };
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let behind = rest[digits..].trim_start();
    let feed = |word: &str| behind.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    digits > 0 && (behind.starts_with('=') || ["FAUTO", "FMAX", "FU"].iter().any(|word| feed(word)))
}

/// The block that starts at the mark; `buffer` holds joined lines.
pub(crate) fn block<'a>(source: &'a Source, at: Mark, buffer: &'a mut String) -> Option<BlockText<'a>> {
    let (line, mut next) = source.line(at)?;
    // The common case first: a plain block shows no sign of a continuation.
    let last = line.as_bytes().last().copied().unwrap_or(0);
    let joins = (matches!(last, b'~' | b' ' | b'\t') || line.contains('~')) && continued(line);
    let cycle = !joins
        && matches!(line.as_bytes().iter().find(|b| b.is_ascii_alphabetic()), Some(b'C' | b'c'))
        && open_cycle(line);
    if !joins && !cycle {
        return Some(BlockText { text: line, next, joined: false });
    }
    buffer.clear();
    buffer.push_str(line);
    let mut more = joins;
    while buffer.len() < MAX_BLOCK_BYTES {
        let Some((line, after)) = source.line(next) else { break };
        let belongs = more || cycle && parameter_line(line);
        if !belongs {
            break;
        }
        buffer.push('\n');
        buffer.push_str(line);
        next = after;
        more = continued(line);
    }
    Some(BlockText { text: buffer, next, joined: true })
}

/// Line of the block, counted from its first, and the span in that line.
fn place(text: &str, span: Span) -> (u32, &str, Span) {
    let mut start = 0;
    for (at, line) in text.split('\n').enumerate() {
        let end = start + line.len();
        if (span.start as usize) <= end || end == text.len() {
            let line = line.strip_suffix('\r').unwrap_or(line);
            let in_line = |p: u32| (p as usize).saturating_sub(start).min(line.len());
            return (at as u32, line, Span::new(in_line(span.start), in_line(span.end)));
        }
        start = end + 1;
    }
    (0, text, span)
}

/// Places a fault of a block in its line.
pub(crate) fn locate(fault: Fault, source: &Source, at: Mark, text: &str) -> Diagnostic {
    let (line, content, span) = place(text, fault.span);
    Fault { span, ..fault }.at(&source.name, at.line + line, content)
}
