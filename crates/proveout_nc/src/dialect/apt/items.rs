//! Items of statements that nothing uses: they are refused by name, like a word without a meaning.

use super::reader::AptReader;
use super::statement::{AptStatement, Bad, Token};
use crate::codes;
use crate::source::Source;

/// Refuses the first item of a statement that exceeds what it takes.
pub(super) fn all_used(source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
    let most = match st.major.as_str() {
        "STOP" | "OPSTOP" | "GOHOME" => 0,
        "UNIT" | "UNITS" | "MULTAX" => 1,
        "DELAY" => 2,
        "CYCLE" => match st.items.first().map(|item| AptReader::word(source, item)).as_deref() {
            Some("OFF" | "NOMORE" | "ON") => 1,
            _ => return once_each(source, st, usize::MAX),
        },
        "CUTCOM" => return once_each(source, st, 1),
        "SPINDL" | "FEDRAT" | "COOLNT" => return once_each(source, st, 2),
        _ => return Ok(()),
    };
    match st.items.get(most) {
        None => Ok(()),
        Some(item) => Err(item.place.bad(
            codes::UNSUPPORTED_WORD,
            format!("`{}` in {} is not supported", item.place.text(source), st.major),
            "remove it, or write it in a statement of its own",
        )),
    }
}

/// Refuses a number beyond those that the statement takes, and a word that appears twice.
fn once_each(source: &Source, st: &AptStatement, most: usize) -> Result<(), Box<Bad>> {
    let mut numbers = st.items.iter().filter(|item| matches!(item.token, Token::Number(_)));
    let extra = numbers.nth(most);
    let mut seen: Vec<String> = Vec::new();
    for item in st.items.iter().filter(|item| item.token == Token::Word) {
        let word = AptReader::word(source, item);
        if seen.contains(&word) {
            return Err(item.place.bad(
                codes::CONFLICT,
                format!("`{word}` appears twice in {}", st.major),
                "remove one",
            ));
        }
        seen.push(word);
    }
    match extra {
        None => Ok(()),
        Some(item) => Err(item.place.bad(
            codes::UNSUPPORTED_WORD,
            format!("the value `{}` in {} is not supported", item.place.text(source), st.major),
            "remove it, or write it in a statement of its own",
        )),
    }
}

/// Items of a tool statement after the number and its offset: lengths, positions in the magazine.
pub(super) fn dimensions_of_tool(source: &Source, st: &AptStatement) -> Vec<String> {
    let skip = usize::from(st.items.first().is_some_and(|item| AptReader::word(source, item) == "TOOL"));
    let mut rest = st.items.iter().skip(skip + 1).peekable();
    let mut beside = Vec::new();
    while let Some(item) = rest.next() {
        let word = AptReader::word(source, item);
        if matches!(word.as_str(), "ADJUST" | "OSETNO" | "OFSTNO") && rest.next().is_some() {
            continue;
        }
        beside.push(word);
    }
    beside
}
