/// The first element of a text of XML with more than `most` attributes: its place in bytes, and their number.
/// Parsers compare each attribute with each, so that this is asked before one runs.
pub fn element_with_more_attributes(text: &str, most: usize) -> Option<(usize, usize)> {
    let mut at = 0;
    // No value contains a `<`, so the attributes of an element are in one piece.
    for piece in text.split_inclusive('<') {
        let values = piece.split('=').skip(1).filter(|v| v.trim_start().starts_with(['"', '\''])).count();
        if values > most {
            return Some((at, values));
        }
        at += piece.len();
    }
    None
}
