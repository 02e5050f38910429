//! Questions that no text answers, and their answers: from a file, from options, or from whoever sits at the
//! terminal. Nothing is taken silently.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use proveout_input::{InputError, nearest, read_input};
use proveout_tool::PlainHolder;
use serde::Serialize;

/// A question that only the user can answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Question {
    /// Key of the answer, `stock`.
    pub key: String,
    /// What is asked, with the form of the answer.
    pub text: String,
    /// The answer that the word `proposed` accepts.
    pub proposed: Option<String>,
}

/// Asks the user; none where no one is at the terminal.
pub type Ask<'a> = dyn FnMut(&Question) -> Option<String> + 'a;

/// Word that takes what is proposed.
pub(crate) const PROPOSED: &str = "proposed";

/// Answers as they come, questions that stay open.
pub(crate) struct Interview<'a, 'b> {
    given: BTreeMap<String, String>,
    asked: BTreeSet<String>,
    known: BTreeSet<String>,
    ask: &'a mut Ask<'b>,
    /// What is to be known before the first answer.
    pub(crate) note: Option<String>,
    pub(crate) open: Vec<Question>,
    /// Questions that somebody has answered.
    pub(crate) answered: usize,
}

impl<'a, 'b> Interview<'a, 'b> {
    pub(crate) fn new(given: BTreeMap<String, String>, ask: &'a mut Ask<'b>) -> Self {
        Self { given, asked: BTreeSet::new(), known: BTreeSet::new(), ask, note: None, open: Vec::new(), answered: 0 }
    }

    /// The answer to a question; none where it stays open.
    pub(crate) fn get(&mut self, key: &str, text: String, proposed: Option<String>) -> Option<String> {
        self.asked.insert(key.to_owned());
        let note = if self.given.contains_key(key) { None } else { self.note.take() };
        let text = note.map_or_else(|| text.clone(), |note| format!("{text} (note: {note})"));
        let question = Question { key: key.to_owned(), text, proposed };
        let answer = self.given.get(key).cloned().or_else(|| (self.ask)(&question));
        let Some(answer) = answer.map(|a| a.trim().to_owned()).filter(|a| !a.is_empty()) else {
            self.open.push(question);
            return None;
        };
        self.answered += 1;
        Some(answer)
    }

    /// The answer to a question that may stay open.
    pub(crate) fn may_be_open(&mut self, key: &str, text: String) -> Option<String> {
        self.asked.insert(key.to_owned());
        let question = Question { key: key.to_owned(), text, proposed: None };
        let answer = self.given.get(key).cloned().or_else(|| (self.ask)(&question));
        let answer = answer.map(|a| a.trim().to_owned()).filter(|a| !a.is_empty())?;
        self.answered += 1;
        Some(answer)
    }

    /// An answer that is given, before it is asked for.
    pub(crate) fn ahead(&self, key: &str) -> Option<&str> {
        self.given.get(key).map(String::as_str)
    }

    /// An answer that is given without being asked for.
    pub(crate) fn given(&mut self, key: &str) -> Option<String> {
        self.known.insert(key.to_owned());
        let answer = self.given.get(key).cloned()?;
        self.asked.insert(key.to_owned());
        Some(answer)
    }

    /// Answers for several things of one kind: one question for all of them, `G55: 0,120,0; G56: 0,240,0`.
    /// `wanted` are their names with what is proposed for each; none where the question stays open.
    ///
    /// # Errors
    /// What is wrong with the answer: a name that nothing asks for, is there twice or is missing.
    pub(crate) fn get_each(
        &mut self,
        key: &str,
        text: String,
        wanted: &[(String, Option<String>)],
    ) -> Result<Option<BTreeMap<String, String>>, String> {
        let all: Option<Vec<String>> =
            wanted.iter().map(|(name, proposed)| Some(format!("{name}: {}", proposed.as_ref()?))).collect();
        let proposed = all.map(|all| all.join("; "));
        let Some(answer) = self.get(key, text, proposed.clone()) else { return Ok(None) };
        let answer = match (answer.as_str(), proposed) {
            (PROPOSED, Some(proposed)) => proposed,
            _ => answer,
        };
        let mut each = BTreeMap::new();
        for part in answer.split(';').map(str::trim).filter(|p| !p.is_empty()) {
            let Some((name, value)) = part.split_once(':') else {
                return Err(format!("{part:?} does not begin with a name and a colon"));
            };
            let name = name.trim().trim_matches('"');
            if !wanted.iter().any(|(known, _)| known == name) {
                let names: Vec<&str> = wanted.iter().map(|(known, _)| known.as_str()).collect();
                return Err(format!("there is no question for {name:?}: it is one of {}", names.join(", ")));
            }
            if each.insert(name.to_owned(), value.trim().to_owned()).is_some() {
                return Err(format!("{name} is given twice"));
            }
        }
        match wanted.iter().find(|(name, _)| !each.contains_key(name)) {
            Some((missing, _)) => Err(format!("{missing} is missing")),
            None => Ok(Some(each)),
        }
    }

    /// An answer that nothing asks for, with the key that may be meant.
    pub(crate) fn stray(&self) -> Option<(String, Option<String>)> {
        let stray = self.given.keys().find(|k| !self.asked.contains(*k))?;
        let near = nearest(stray, self.asked.iter().chain(&self.known).map(String::as_str));
        Some((stray.clone(), near.map(str::to_owned)))
    }
}

/// Reads a file of answers: a flat TOML table, tables `offset` and `tool` below it.
///
/// # Errors
/// [`InputError`] where the text is no TOML, or an answer is neither text, number nor a list of numbers.
pub fn read_answers(path: &Path) -> Result<BTreeMap<String, String>, InputError> {
    let text = read_input(path)?;
    let table: toml::Table = toml::from_str(&text).map_err(|e| {
        let at = e.span().map_or(0, |s| s.start);
        InputError::at(
            path,
            &text,
            at,
            format!("the text is not TOML: {}", e.message()),
            "write lines such as stock = \"proposed\"",
        )
    })?;
    let mut all = BTreeMap::new();
    flatten(path, "", &table, &mut all)?;
    Ok(all)
}

fn flatten(
    path: &Path,
    prefix: &str,
    table: &toml::Table,
    all: &mut BTreeMap<String, String>,
) -> Result<(), InputError> {
    for (key, value) in table {
        let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        let refused = || {
            InputError::file(path, format!("`{key}` is not an answer"), "write a text, a number, or a list of numbers")
        };
        let number = |v: &toml::Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)).map(|n| n.to_string());
        let answer = match value {
            toml::Value::Table(below) if prefix.is_empty() => {
                flatten(path, &key, below, all)?;
                continue;
            }
            toml::Value::String(text) => text.clone(),
            toml::Value::Array(list) => {
                let numbers: Option<Vec<String>> = list.iter().map(number).collect();
                numbers.ok_or_else(refused)?.join(",")
            }
            other => number(other).ok_or_else(refused)?,
        };
        all.insert(key, answer);
    }
    Ok(())
}

/// Millimeters of the unit that an answer ends in, and the answer without it.
pub(crate) fn unit(text: &str) -> (&str, f64) {
    let text = text.trim();
    for (word, mm) in [("inch", 25.4), ("in", 25.4), ("\"", 25.4), ("mm", 1.0)] {
        if let Some(rest) = text.strip_suffix(word) {
            return (rest.trim_end(), mm);
        }
    }
    (text, 1.0)
}

/// The axis at the end of a cylinder, `along X`, and the answer without it; Z where it names none.
pub(crate) fn along(text: &str) -> (&str, usize) {
    let text = text.trim();
    let lower = text.to_ascii_lowercase();
    let at = ["x", "y", "z"].into_iter().enumerate().find_map(|(index, axis)| {
        let head = lower.strip_suffix(axis)?.trim_end().strip_suffix("along")?;
        Some((head.len(), index))
    });
    at.map_or((text, 2), |(end, index)| (text[..end].trim_end(), index))
}

/// So many numbers with commas between, mm.
pub(crate) fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let (text, mm) = unit(text);
    let all: Option<Vec<f64>> =
        text.split(',').map(|t| t.trim().parse::<f64>().ok().filter(|v| v.is_finite())).collect();
    let all: [f64; N] = all?.try_into().ok()?;
    Some(all.map(|v| v * mm))
}

/// `none` or `40x60`: diameter and length.
pub fn holder(text: &str) -> Option<Option<PlainHolder>> {
    if text.eq_ignore_ascii_case("none") {
        return Some(None);
    }
    let (text, mm) = unit(text);
    let (diameter, length) = text.split_once(['x', 'X'])?;
    let positive = |t: &str| t.trim().parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite()).map(|v| v * mm);
    Some(Some(PlainHolder { diameter: positive(diameter)?, length: positive(length)? }))
}

/// A tool in words: `flat D10 L25`, `bull_nose D12 R1`, `drill D8.5 A118`, with D diameter, R corner radius,
/// A point angle, L length of the flutes, G length to the gauge line, `inch` at its end for inches. None
/// where it is none.
pub(crate) fn tool(text: &str, number: u32) -> Option<proveout_tool::ToolDraft> {
    let (text, mm) = unit(text);
    let mut words = text.split_whitespace();
    let kind = words.next()?;
    let kind =
        ["flat", "ball", "bull_nose", "drill", "chamfer", "face_mill", "tap"].into_iter().find(|k| *k == kind)?;
    let mut draft = proveout_tool::ToolDraft::new(number, "the answer of the call");
    draft.kind = Some(kind);
    for word in words {
        let mut letters = word.chars();
        let letter = letters.next()?;
        let value = letters.as_str().parse::<f64>().ok().filter(|v| v.is_finite() && *v >= 0.0)?;
        match letter.to_ascii_uppercase() {
            'D' => draft.put("diameter_mm", value * mm),
            'R' if matches!(kind, "bull_nose" | "face_mill") => draft.put("corner_radius_mm", value * mm),
            'A' if matches!(kind, "drill" | "chamfer") => draft.put("point_angle_deg", value),
            'A' if kind == "face_mill" => draft.put("entering_angle_deg", value),
            'P' if kind == "tap" => draft.put("pitch_mm", value * mm),
            'L' => draft.flute_length = Some(value * mm),
            'G' => draft.gauge = Some(value * mm),
            _ => return None,
        }
    }
    if kind == "chamfer" {
        draft.put("tip_diameter_mm", 0.0);
        draft.choose(&["tip_diameter_mm"], "not in the answer: a sharp tip");
    }
    let whole = draft.diameter().is_some()
        && (kind != "bull_nose" || draft.get("corner_radius_mm").is_some())
        && (kind != "tap" || draft.get("pitch_mm").is_some())
        && (kind != "chamfer" || draft.get("point_angle_deg").is_some());
    whole.then_some(draft)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read_in_both_units() {
        assert_eq!(numbers::<3>("1, 2,-3"), Some([1.0, 2.0, -3.0]));
        assert_eq!(numbers::<3>("0,0,1 inch"), Some([0.0, 0.0, 25.4]));
        assert_eq!(numbers::<3>("1,2"), None);
        assert_eq!(numbers::<2>("1,nan"), None);
        assert_eq!(along("0,0,-1,2,4 inch along X"), ("0,0,-1,2,4 inch", 0));
        assert_eq!((along("1,2,3,4,5 alongy").1, along("1,2,3,4,5"), along("x").1), (1, ("1,2,3,4,5", 2), 2));
        assert_eq!(holder("none"), Some(None));
        assert_eq!(holder("2x3 in"), Some(Some(PlainHolder { diameter: 50.8, length: 3.0 * 25.4 })));
        assert_eq!((holder("40"), holder("40x-1")), (None, None));
        assert_eq!(tool("flat D0.5 L1 inch", 3).and_then(|t| t.diameter()), Some(12.7));
        assert_eq!(tool("tap D8 P1.25", 3).and_then(|t| t.get("pitch_mm")), Some(1.25));
        for wrong in
            ["", "flat", "flat R2", "cube D3", "bull_nose D10", "flat Dx", "chamfer D10", "tap D8", "flat D8 P1"]
        {
            assert!(tool(wrong, 1).is_none(), "{wrong}");
        }
    }

    #[test]
    fn one_answer_tells_several_things_by_their_names() {
        let wanted = [("G55".to_owned(), Some("0,0,0".to_owned())), ("G56".to_owned(), Some("0,0,0".to_owned()))];
        let ask = |answer: &str| {
            let mut somebody = |_: &Question| Some(answer.to_owned());
            Interview::new(BTreeMap::new(), &mut somebody).get_each("offsets", String::new(), &wanted)
        };
        let both = ask("G56: 0,9,0; G55:1,2,3 inch").expect("read").expect("answered");
        assert_eq!((both["G55"].as_str(), both["G56"].as_str()), ("1,2,3 inch", "0,9,0"));
        assert_eq!(ask(PROPOSED).expect("read").expect("answered")["G56"], "0,0,0");
        for (wrong, word) in [
            ("G55: 1,2,3", "G56 is missing"),
            ("G55: 1,2,3; G55: 1,2,3; G56: 0,0,0", "G55 is given twice"),
            ("G57: 1,2,3", "one of G55, G56"),
            ("1,2,3", "a name and a colon"),
        ] {
            let error = ask(wrong).expect_err(wrong);
            assert!(error.contains(word), "{error}");
        }
        assert_eq!(ask(""), Ok(None));
    }

    #[test]
    fn an_answer_that_was_not_asked_for_is_reported_with_the_nearest_key() {
        let mut nobody = |_: &Question| None;
        let given = BTreeMap::from([("stok".to_owned(), "proposed".to_owned())]);
        let mut interview = Interview::new(given, &mut nobody);
        assert_eq!(interview.get("stock", String::new(), None), None);
        assert_eq!(interview.open.len(), 1);
        assert_eq!(interview.stray(), Some(("stok".into(), Some("stock".into()))));
    }
}
