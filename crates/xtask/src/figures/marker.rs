//! Figures in Markdown: the source of a number is next to it, in a remark that a reader does not see, or in
//! the block of the page (`block.rs`).
//!
//! ```text
//!   cut within <!--= cone-frustum deviation.gouge_max_mm .2um +-0.05 -->0.65<!--/--> µm
//!                   |            |                       |     |         |
//!                   run          key in its result       |     bound     text that is filled in
//!                                                        decimals, and the factor to the unit of the page
//! ```
//!
//! *Key*: names with points between them; `[name=limits]` takes the entry of a list whose `name` is that
//! (`_` means a blank), `[2]` the entry at that place. `@command` and `@made` are the run's command and the
//! commit and day of its figures.
//!
//! *Form*: `.2` is a number with two decimals, `s` a text as it is. `um` is for keys in mm that the page has
//! in micrometers, `cm3` for keys in mm³, `pct` for ratios.
//!
//! *Bound*: how far, in the unit of the page, a number of the surface may be off where it is compared. What
//! follows from the motion alone has none: it is compared exactly.

use serde_json::Value;

use crate::TaskError;

const OPEN: &str = "<!--= ";
const BEGIN: &str = " -->";
const CLOSE: &str = "<!--/-->";

/// A figure of a page.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Marker {
    /// Run that it comes from.
    pub(super) run: String,
    /// Place in the run's result.
    pub(super) key: String,
    form: FigureFormat,
    /// How far the number of a surface may be off.
    pub(super) bound: Option<f64>,
    /// Line of the page, from 1.
    pub(super) line: usize,
    /// Text of the figure: bytes of the page.
    pub(super) span: std::ops::Range<usize>,
    /// The same in the block at the end of the page, for a figure that is listed there.
    pub(super) listed: Option<std::ops::Range<usize>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum FigureFormat {
    Number { decimals: usize, factor: f64 },
    Text,
}

impl FigureFormat {
    fn read(text: &str) -> Option<Self> {
        if text == "s" {
            return Some(Self::Text);
        }
        let rest = text.strip_prefix('.')?;
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let factor = match &rest[digits..] {
            "" => 1.0,
            "um" => 1e3,
            "cm3" => 1e-3,
            "pct" => 100.0,
            _ => return None,
        };
        Some(Self::Number { decimals: rest[..digits].parse().ok()?, factor })
    }
}

/// The figures of a page.
///
/// # Errors
/// The first one that is not written as it must be, with its line.
pub(super) fn markers(page: &str, text: &str) -> Result<Vec<Marker>, TaskError> {
    let mut all = Vec::new();
    let mut offset = 0;
    for (line, content) in (1..).zip(text.split_inclusive('\n')) {
        let fault = |what: &str| TaskError(format!("{page}:{line}: {what}: {}", content.trim_end()));
        let mut at = 0;
        while let Some(open) = content[at..].find(OPEN) {
            let head = at + open + OPEN.len();
            let begin = head + content[head..].find(BEGIN).ok_or_else(|| fault("a figure's comment does not end"))?;
            let start = begin + BEGIN.len();
            let end =
                start + content[start..].find(CLOSE).ok_or_else(|| fault("a figure lacks its <!--/--> on the line"))?;
            let words: Vec<&str> = content[head..begin].split_whitespace().collect();
            let (run, key, form, bound) = match words.as_slice() {
                [run, key] if key.starts_with('@') => (run, key, "s", None),
                [run, key, form] => (run, key, *form, None),
                [run, key, form, bound] => (run, key, *form, Some(*bound)),
                _ => return Err(fault("a figure needs: run, key, form, and a bound if it is of a surface")),
            };
            let form =
                FigureFormat::read(form).ok_or_else(|| fault("the form must be one of .1, .2um, .1cm3, .1pct, s"))?;
            let bound = bound.map(|b| b.strip_prefix("+-").and_then(|b| b.parse::<f64>().ok()).filter(|b| *b >= 0.0));
            if bound == Some(None) {
                return Err(fault("the bound must be written as +-0.1"));
            }
            all.push(Marker {
                run: (*run).to_owned(),
                key: (*key).to_owned(),
                form,
                bound: bound.flatten(),
                line,
                span: offset + start..offset + end,
                listed: None,
            });
            at = end + CLOSE.len();
        }
        offset += content.len();
    }
    Ok(all)
}

/// The text with other figures, in text and block; `texts` are those of the markers in their order.
pub(super) fn filled(text: &str, markers: &[Marker], texts: &[Option<String>]) -> String {
    let mut places: Vec<(&std::ops::Range<usize>, &str)> = Vec::new();
    for (marker, new) in markers.iter().zip(texts) {
        let Some(new) = new else { continue };
        places.push((&marker.span, new.as_str()));
        places.extend(marker.listed.iter().map(|listed| (listed, new.as_str())));
    }
    places.sort_by_key(|(span, _)| span.start);
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for (span, new) in places {
        out += &text[at..span.start];
        out += new;
        at = span.end;
    }
    out + &text[at..]
}

impl Marker {
    /// Whether the cells of the stock decide the value, not the motion alone.
    pub(super) fn of_surface(&self) -> bool {
        const SURFACE: [&str; 7] =
            ["deviation", "surface", "removal", "difference", "clearance", "inspection", "verdict"];
        let word = |part: &str| SURFACE.contains(&part) || part.starts_with("scallop") || part.starts_with("volume");
        parts(&self.key).iter().any(|part| word(part.split('[').next().unwrap_or_default()))
    }

    /// The text of a value.
    ///
    /// # Errors
    /// The value is no number where one is wanted, or not known.
    pub(super) fn text(&self, value: &Value) -> Result<String, String> {
        match (self.form, value) {
            (FigureFormat::Text, Value::String(text)) => Ok(text.clone()),
            (FigureFormat::Text, other) => Err(format!("{} is not a text: {other}", self.key)),
            (FigureFormat::Number { decimals, factor }, value) => {
                let number = value.as_f64().ok_or_else(|| format!("{} is not a number: {value}", self.key))?;
                let text = format!("{:.decimals$}", number * factor);
                // What rounds to zero has no sign.
                let zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
                Ok(if zero { text.trim_start_matches('-').to_owned() } else { text })
            }
        }
    }

    /// Whether two texts are the same figure: equal, or numbers within the bound.
    pub(super) fn agree(&self, page: &str, run: &str) -> bool {
        if page == run {
            return true;
        }
        let Some(bound) = self.bound else { return false };
        match (page.parse::<f64>(), run.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= bound + 1e-12,
            _ => false,
        }
    }
}

/// A key at its points; points in brackets belong to a name.
fn parts(key: &str) -> Vec<&str> {
    let (mut out, mut start, mut depth) = (Vec::new(), 0, 0);
    for (i, c) in key.char_indices() {
        match c {
            '[' => depth += 1,
            ']' => depth -= 1,
            '.' if depth == 0 => {
                out.push(&key[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    out.push(&key[start..]);
    out
}

/// The value at a key.
///
/// # Errors
/// The part of the key that is not there, and what is.
pub(super) fn value<'a>(result: &'a Value, key: &str) -> Result<&'a Value, String> {
    let mut at = result;
    for part in parts(key) {
        let (name, entry) = match part.split_once('[') {
            Some((name, entry)) => (name, Some(entry.trim_end_matches(']'))),
            None => (part, None),
        };
        let there =
            |v: &Value| v.as_object().map_or_else(String::new, |o| o.keys().cloned().collect::<Vec<_>>().join(", "));
        at = at.get(name).ok_or_else(|| format!("{key}: no {name}; available: {}", there(at)))?;
        let Some(entry) = entry else { continue };
        let list = at.as_array().ok_or_else(|| format!("{key}: {name} is not a list"))?;
        let found = match entry.split_once('=') {
            None => entry.parse::<usize>().ok().and_then(|i| list.get(i)),
            Some((field, wanted)) => {
                let is =
                    |v: &&Value| v.get(field).and_then(Value::as_str).is_some_and(|s| s.replace(' ', "_") == wanted);
                list.iter().find(is)
            }
        };
        at = found.ok_or_else(|| format!("{key}: {name} has no entry {entry}"))?;
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn one(text: &str) -> Marker {
        markers("p.md", text).expect("a figure").remove(0)
    }

    #[test]
    fn a_figure_is_found_filled_and_left_where_its_run_is_not_made() {
        let text = "a <!--= r deviation.gouge_max_mm .2um +-0.05 -->1.00<!--/--> µm, <!--= q time.total_s .1 -->5<!--/--> s\nb\n";
        let found = markers("p.md", text).expect("figures");
        assert_eq!(found.len(), 2);
        assert_eq!(&text[found[0].span.clone()], "1.00");
        assert_eq!(filled(text, &found, &[Some("0.65".into()), None]), text.replace("1.00", "0.65"));
        assert_eq!((found[0].of_surface(), found[1].of_surface()), (true, false));
        assert!(one("\n\n<!--= r @made --><!--/-->").line == 3);
    }

    #[test]
    fn what_is_not_written_as_it_must_be_is_a_fault_with_its_line() {
        for (text, word) in [
            ("\n<!--= r time.total_s .1 -->5", "p.md:2: a figure lacks"),
            ("<!--= r time.total_s .1", "does not end"),
            ("<!--= r time.total_s -->5<!--/-->", "a figure needs"),
            ("<!--= r time.total_s 1 -->5<!--/-->", "form"),
            ("<!--= r time.total_s .1 0.1 -->5<!--/-->", "bound"),
        ] {
            let TaskError(told) = markers("p.md", text).expect_err(text);
            assert!(told.contains(word), "{text}: {told}");
        }
    }

    #[test]
    fn numbers_are_rounded_in_the_unit_of_the_page() {
        let text = |form: &str, v: Value| one(&format!("<!--= r a {form} -->x<!--/-->")).text(&v);
        assert_eq!(text(".2um", json!(0.000_653)), Ok("0.65".into()));
        assert_eq!(text(".1cm3", json!(118_790.0)), Ok("118.8".into()));
        assert_eq!(text(".1pct", json!(0.9994)), Ok("99.9".into()));
        assert_eq!(text(".0", json!(34_268)), Ok("34268".into()));
        assert_eq!(text(".1", json!(-0.04)), Ok("0.0".into()), "no negative zero");
        assert_eq!(text("s", json!("pass")), Ok("pass".into()));
        assert!(text(".1", json!(null)).is_err() && text("s", json!(1)).is_err(), "what is not known is no figure");
    }

    #[test]
    fn keys_go_into_lists_by_name_and_by_place() {
        let v = json!({"programs": {"s-theta": {"axes": [{"name": "A, velocity", "value": 3.5}]}}});
        assert_eq!(value(&v, "programs.s-theta.axes[name=A,_velocity].value"), Ok(&json!(3.5)));
        assert_eq!(value(&v, "programs.s-theta.axes[0].value"), Ok(&json!(3.5)));
        assert!(value(&v, "programs.s-gamma").expect_err("no such program").contains("s-theta"));
        assert!(value(&v, "programs.s-theta.axes[name=B].value").is_err());
        assert!(value(&v, "programs[0]").is_err(), "no list");
    }

    #[test]
    fn motion_is_compared_exactly_and_the_surface_within_its_bound() {
        let m = one("<!--= r deviation.gouge_max_mm .2um +-0.05 -->0.65<!--/-->");
        assert!(m.agree("0.65", "0.65") && m.agree("0.65", "0.70") && !m.agree("0.65", "0.71"));
        let m = one("<!--= r time.total_s .1 -->164.2<!--/-->");
        assert!(!m.agree("164.2", "164.3"), "no bound: the same text");
    }
}
