//! Tools as XML: DIN 4000, hyperMILL, SolidCAM. The root element decides which one it is.

use std::path::Path;

use proveout_input::{InputError, element_with_more_attributes, read_regular_file};
use roxmltree::{Document, Node, ParsingOptions};

use super::catalog::{self, CatalogKeys, CatalogTool};
use super::{ImportCall, Imported, LengthUnit};

/// Largest file, bytes: its tree takes some thirty times as much.
const MAX_BYTES: u64 = 32 << 20;
/// Most elements and texts.
const MAX_NODES: u32 = 4_000_000;
/// Most attributes of an element.
const MAX_ATTRIBUTES: usize = 100;
/// The class of DIN 4000 whose letters are known: end mills of one piece. Other classes use the same letters
/// for other lengths.
const DIN_CLASS: &str = "DIN4000-82";

const DIN: CatalogKeys = CatalogKeys {
    format: "DIN 4000 file",
    diameter: &["A1"],
    corner_radius: &[],
    flute_length: &["B2"],
    shank: &["C3"],
    overall: &["B5"],
    stick_out: &[],
    point_angle: &[],
    teeth: &["F21"],
};

const HYPERMILL: CatalogKeys = CatalogKeys {
    format: "hyperMILL library",
    diameter: &["toolDiameter"],
    corner_radius: &["cornerRadius"],
    flute_length: &["cuttingLength"],
    shank: &["toolShaftDiameter"],
    overall: &["toolTotalLength"],
    stick_out: &[],
    point_angle: &[],
    teeth: &["cuttingEdges"],
};

const SOLIDCAM: CatalogKeys = CatalogKeys {
    format: "SolidCAM library",
    diameter: &["diameter"],
    corner_radius: &["corner radius"],
    flute_length: &["cutting edge length"],
    shank: &["arbor diameter"],
    overall: &["total length"],
    stick_out: &["outside holder length"],
    point_angle: &[],
    teeth: &["number of teeth"],
};

pub(super) fn read(file: &Path, call: &ImportCall) -> Result<Imported, InputError> {
    let refused = |message: String, help: &str| InputError::file(file, message, help);
    let bytes = read_regular_file(file, MAX_BYTES)
        .map_err(|e| refused(format!("the file cannot be read: {e}"), "check the path, or export fewer tools"))?;
    let text = decoded(bytes);
    if let Some((at, count)) = element_with_more_attributes(&text, MAX_ATTRIBUTES) {
        let line = 1 + text[..at].matches('\n').count();
        let message = format!("an element has {count} attributes; the limit is {MAX_ATTRIBUTES}");
        return Err(refused(message, "export the library again").with_line(line));
    }
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).map_err(|e| {
        let line = e.pos().row as usize;
        refused(format!("the text is not XML: {e}"), "export the library again").with_line(line)
    })?;
    let root = document.root_element();
    let wrong = |message: String| refused(message, "correct the file, or export the library again");
    match root.tag_name().name() {
        "Tool-Data" => catalog::drafts(file, &din(root).map_err(wrong)?, &DIN, call),
        "omtdx" => catalog::drafts(file, &hypermill(root).map_err(wrong)?, &HYPERMILL, call),
        "Results" => catalog::drafts(file, &solidcam(root).map_err(wrong)?, &SOLIDCAM, call),
        other => Err(refused(
            format!("the XML begins with <{other}>, which is no tool library of a known format"),
            "give DIN 4000 (<Tool-Data>), hyperMILL (<omtdx>) or SolidCAM (<Results>)",
        )),
    }
}

/// UTF-8, or else one byte a character, as older exports declare it.
fn decoded(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|e| e.into_bytes().into_iter().map(char::from).collect())
}

/// Elements of a name below another one, itself left out.
fn below<'a, 'b>(node: Node<'a, 'b>, name: &'static str) -> impl Iterator<Item = Node<'a, 'b>> {
    node.descendants().filter(move |n| n.has_tag_name(name) && *n != node)
}

fn child_text<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.children().find(|n| n.has_tag_name(name))?.text().map(str::trim)
}

fn din(root: Node<'_, '_>) -> Result<Vec<CatalogTool>, String> {
    let mut tools = Vec::new();
    for element in below(root, "Tool") {
        let mut tool = CatalogTool::default();
        let mut class = None;
        let number = tools.len() + 1;
        for property in below(element, "Property-Data").chain(below(element, "Category-Data")) {
            let (Some(name), Some(value)) = (child_text(property, "PropertyName"), child_text(property, "Value"))
            else {
                continue;
            };
            match name {
                "NSM" => class = Some(value),
                "J22" => tool.words.insert(0, value.to_owned()),
                "J23" => tool.words.push(value.to_owned()),
                "F3" => tool.left_handed = value == "L",
                _ => tool.values.push((name.to_owned(), value.to_owned(), 1.0)),
            }
        }
        match class {
            Some(DIN_CLASS) => tools.push(tool),
            Some(other) => {
                return Err(format!("tool {number} of the file is of class {other}; {DIN_CLASS} (end mills) is read"));
            }
            None => return Err(format!("tool {number} of the file states no class (NSM)")),
        }
    }
    // All tools of the class are end mills; their names say more.
    tools.iter_mut().for_each(|tool| {
        if super::words::kind_of(&tool.words.join(" ")).is_none() {
            tool.kind = "end mill".into();
        }
    });
    Ok(tools)
}

/// The value of a parameter of a tool, those of its cutting data left out.
fn parameters<'a>(tool: Node<'a, 'a>) -> Vec<(&'a str, &'a str)> {
    let own = tool.children().filter(|n| n.has_tag_name("param"));
    own.filter_map(|p| Some((p.attribute("name")?, p.attribute("value")?))).collect()
}

/// Millimeters of the unit of a tool.
fn unit_of(all: &[(&str, &str)], keys: &[&str], number: usize) -> Result<f64, String> {
    let words: Vec<&str> = all.iter().filter(|(k, _)| keys.contains(k)).map(|(_, v)| *v).collect();
    let Some(word) = words.first() else {
        return Err(format!("tool {number} of the file states no unit ({})", keys[0]));
    };
    if let Some(other) = words.iter().find(|w| *w != word) {
        return Err(format!("tool {number} of the file has two units: {word} and {other}"));
    }
    let known =
        LengthUnit::from_name(word).ok_or_else(|| format!("tool {number} of the file: unit {word:?} is not known"));
    known.map(LengthUnit::mm)
}

/// `endMill` as words.
fn spaced(name: &str) -> String {
    name.chars().flat_map(|c| c.is_uppercase().then_some(' ').into_iter().chain(c.to_lowercase())).collect()
}

fn hypermill(root: Node<'_, '_>) -> Result<Vec<CatalogTool>, String> {
    let mut tools = Vec::new();
    for element in below(root, "tool") {
        let all = parameters(element);
        let mm = unit_of(&all, &["lengthOfUnit"], tools.len() + 1)?;
        let values = all.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned(), mm)).collect();
        let left_handed = all.iter().any(|(k, v)| *k == "spindleRotation" && v.contains("counter"));
        tools.push(CatalogTool {
            words: element.attribute("name").map(str::to_owned).into_iter().collect(),
            kind: spaced(element.attribute("type").unwrap_or_default()),
            values,
            left_handed,
        });
    }
    Ok(tools)
}

fn solidcam(root: Node<'_, '_>) -> Result<Vec<CatalogTool>, String> {
    let mut tools = Vec::new();
    for element in below(root, "Tool") {
        let all = parameters(element);
        let mm = unit_of(&all, &["unit", "units"], tools.len() + 1)?;
        let values = all.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned(), mm)).collect();
        let name = element.attribute("UserType").map(str::to_owned);
        tools.push(CatalogTool {
            words: name.into_iter().collect(),
            kind: spaced(element.attribute("SubType").unwrap_or_default()),
            values,
            left_handed: false,
        });
    }
    Ok(tools)
}
