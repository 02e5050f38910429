//! The text as a tree of elements, within bounds: what a file may hold is decided before it is parsed.

use proveout_input::{InputError, element_with_more_attributes};
use roxmltree::{Document, Error, ParsingOptions};

use super::source::UrdfSource;

/// Most elements, texts and comments of a file: thousands of links.
const MAX_NODES: u32 = 500_000;
/// Most attributes of an element; the parser compares each with each.
const MAX_ATTRIBUTES: usize = 200;
/// Most declarations of namespaces in a file; each element below has all of them.
const MAX_NAMESPACES: usize = 100;

/// Parses the text.
pub(super) fn document<'t>(source: &UrdfSource<'t>) -> Result<Document<'t>, InputError> {
    let text = source.text;
    if text.trim().is_empty() {
        return Err(source.whole("the file is empty", "name a URDF file"));
    }
    if let Some((at, values)) = element_with_more_attributes(text, MAX_ATTRIBUTES) {
        let message = format!("an element has {values} attributes; the limit is {MAX_ATTRIBUTES}");
        return Err(source.at(&(at..at), message, "name a URDF file"));
    }
    if let Some((at, _)) = text.match_indices("xmlns").nth(MAX_NAMESPACES) {
        let message = format!("more than {MAX_NAMESPACES} namespaces (xmlns) are declared");
        return Err(source.at(&(at..at), message, "declare each once, in <robot>"));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|e| refused(source, &e))
}

/// What the reader of XML refuses, in words of this file.
fn refused(source: &UrdfSource<'_>, error: &Error) -> InputError {
    let text = source.text;
    let end = text.trim_end().len();
    let at = |offset: usize, message: &str, remedy: &str| source.at(&(offset..offset), message, remedy);
    match error {
        Error::DtdDetected => at(
            text.find("<!DOCTYPE").unwrap_or(0),
            "the file declares entities (<!DOCTYPE>), which are not read",
            "save it without them",
        ),
        Error::NodesLimitReached => source.whole(
            format!("the file has more than {MAX_NODES} elements"),
            "leave out all elements that are not the machine",
        ),
        Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
            at(end, "the file ends before its elements are closed", "save it whole")
        }
        Error::NoRootNode => at(0, "the file has no element", "name a URDF file"),
        other => {
            let pos = other.pos();
            let start =
                text.split_inclusive('\n').take(pos.row.saturating_sub(1) as usize).map(str::len).sum::<usize>();
            let line = text.get(start..).unwrap_or_default();
            let column = line.char_indices().nth(pos.col.saturating_sub(1) as usize).map_or(line.len(), |(i, _)| i);
            let words: String = other.to_string().replace(&format!(" at {pos}"), "").chars().take(160).collect();
            at(start + column, &format!("the file is not valid XML: {words}"), "name a URDF file, or correct the place")
        }
    }
}
