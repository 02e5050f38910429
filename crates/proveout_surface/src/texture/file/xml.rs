//! As much of XML as X3P writes: elements, text, CDATA, remarks, the five entities and characters by number.
//! Attributes and prefixes are passed over; document types are refused.

use super::FileFault;

const HELP: &str = "write the file again from the measuring program";
/// Elements within elements.
const DEEPEST: usize = 32;

/// An element by its name without prefix.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct XmlElement {
    pub(super) name: String,
    pub(super) text: String,
    pub(super) children: Vec<Self>,
}

impl XmlElement {
    pub(super) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|c| c.name == name)
    }

    /// Text of an element beneath, without blanks at its ends.
    pub(super) fn text_of(&self, path: &[&str]) -> Option<&str> {
        path.iter().try_fold(self, |e, name| e.child(name)).map(|e| e.text.trim())
    }
}

/// The root element.
pub(super) fn parse(text: &str) -> Result<XmlElement, FileFault> {
    let line = |rest: &str| text[..text.len() - rest.len()].matches('\n').count() + 1;
    let wrong = |rest: &str, what: String| FileFault::new(format!("main.xml, line {}: {what}", line(rest)), HELP);
    let (mut rest, mut open, mut root) = (text, Vec::<XmlElement>::new(), None);
    while !rest.is_empty() {
        let here = rest;
        let skipped = |end: &str, what: &str| {
            here.find(end).map(|k| &here[k + end.len()..]).ok_or_else(|| wrong(here, format!("{what} has no end")))
        };
        if rest.starts_with("<?") {
            rest = skipped("?>", "a declaration")?;
        } else if rest.starts_with("<!--") {
            rest = skipped("-->", "a remark")?;
        } else if let Some(data) = rest.strip_prefix("<![CDATA[") {
            rest = skipped("]]>", "a stretch of data")?;
            if let Some(element) = open.last_mut() {
                element.text.push_str(&data[..data.len() - rest.len() - 3]);
            }
        } else if rest.starts_with("<!") {
            return Err(wrong(rest, "a document type is not read".to_owned()));
        } else if rest.starts_with("</") {
            rest = skipped(">", "an end tag")?;
            let name = local(here[2..here.len() - rest.len() - 1].trim());
            match open.pop() {
                Some(element) if element.name == name => match open.last_mut() {
                    Some(parent) => parent.children.push(element),
                    None => root = Some(element),
                },
                other => {
                    let of = other.map_or_else(String::new, |e| e.name);
                    return Err(wrong(here, format!("</{name}> ends <{of}>")));
                }
            }
        } else if let Some(tag) = rest.strip_prefix('<') {
            let end = end_of_tag(tag).ok_or_else(|| wrong(here, "a tag has no end".to_owned()))?;
            let (inside, closed) = match tag[..end].strip_suffix('/') {
                Some(inside) => (inside, true),
                None => (&tag[..end], false),
            };
            let name = local(inside.split_whitespace().next().unwrap_or_default());
            if name.is_empty() {
                return Err(wrong(here, "a tag without a name".to_owned()));
            }
            if root.is_some() {
                return Err(wrong(here, format!("<{name}> after the end")));
            }
            rest = &tag[end + 1..];
            let element = XmlElement { name, ..XmlElement::default() };
            if !closed {
                if open.len() == DEEPEST {
                    return Err(wrong(here, format!("more than {DEEPEST} elements within each other")));
                }
                open.push(element);
            } else if let Some(parent) = open.last_mut() {
                parent.children.push(element);
            } else {
                root = Some(element);
            }
        } else {
            let end = rest.find('<').unwrap_or(rest.len());
            let (words, after) = rest.split_at(end);
            let decoded = decode(words).map_err(|entity| wrong(here, format!("entity {entity:?} is not known")))?;
            match open.last_mut() {
                Some(element) => element.text.push_str(&decoded),
                None if decoded.trim().trim_start_matches('\u{feff}').is_empty() => {}
                None => return Err(wrong(here, "text outside of all elements".to_owned())),
            }
            rest = after;
        }
    }
    match (root, open.pop()) {
        (_, Some(element)) => Err(FileFault::new(format!("main.xml: <{}> has no end", element.name), HELP)),
        (Some(root), None) => Ok(root),
        (None, None) => Err(FileFault::new("main.xml has no element", HELP)),
    }
}

/// Where a tag ends, quotes passed over.
fn end_of_tag(tag: &str) -> Option<usize> {
    let mut quote = None;
    tag.char_indices().find_map(|(k, c)| {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '>') => return Some(k),
            _ => {}
        }
        None
    })
}

fn local(name: &str) -> String {
    name.rsplit(':').next().unwrap_or_default().chars().take(64).collect()
}

/// Text with its entities as characters; an unknown one is the error.
fn decode(text: &str) -> Result<String, String> {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(k) = rest.find('&') {
        out.push_str(&rest[..k]);
        let Some(end) = rest[k..].find(';') else { return Err(rest[k..].chars().take(16).collect()) };
        let entity = &rest[k + 1..k + end];
        let character = match entity {
            "lt" => Some('<'),
            "gt" => Some('>'),
            "amp" => Some('&'),
            "quot" => Some('"'),
            "apos" => Some('\''),
            _ => entity.strip_prefix('#').and_then(|number| {
                let code = match number.strip_prefix('x') {
                    Some(hex) => u32::from_str_radix(hex, 16).ok(),
                    None => number.parse().ok(),
                };
                code.and_then(char::from_u32)
            }),
        };
        out.push(character.ok_or_else(|| entity.chars().take(16).collect::<String>())?);
        rest = &rest[k + end + 1..];
    }
    out.push_str(rest);
    Ok(out)
}
