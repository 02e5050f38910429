//! The text of an X3P file as a tree: elements by their names without prefix. What the parser takes much time
//! for is bounded before it runs; document types are refused.

use proveout_input::element_with_more_attributes;
use roxmltree::{Document, Node};

use super::FileFault;

const HELP: &str = "write the file again from the measuring program";
/// Most attributes of an element; the parser compares each with each.
const MOST_ATTRIBUTES: usize = 200;
/// Most declarations of namespaces; each element below has all of them.
const MOST_NAMESPACES: usize = 100;

pub(super) fn parse(text: &str) -> Result<Document<'_>, FileFault> {
    let wrong = |line: usize, what: String| FileFault::new(format!("main.xml, line {line}: {what}"), HELP);
    let line = |at: usize| text[..at].matches('\n').count() + 1;
    if let Some((at, count)) = element_with_more_attributes(text, MOST_ATTRIBUTES) {
        return Err(wrong(line(at), format!("an element has {count} attributes; the limit is {MOST_ATTRIBUTES}")));
    }
    if let Some((at, _)) = text.match_indices("xmlns").nth(MOST_NAMESPACES) {
        return Err(wrong(line(at), format!("more than {MOST_NAMESPACES} namespaces are declared")));
    }
    Document::parse(text).map_err(|e| wrong(e.pos().row as usize, e.to_string().chars().take(160).collect()))
}

pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|c| c.is_element() && c.tag_name().name() == name)
}

/// Text of an element beneath, without blanks at its ends.
pub(super) fn text_of(node: Node<'_, '_>, path: &[&str]) -> Option<String> {
    path.iter().try_fold(node, |e, name| child(e, name)).map(text)
}

/// Text of an element, without blanks at its ends.
pub(super) fn text(node: Node<'_, '_>) -> String {
    let texts: String = node.children().filter(Node::is_text).filter_map(|t| t.text()).collect();
    texts.trim().to_owned()
}
