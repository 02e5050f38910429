//! The tools that programs call: from a library, from the text, or from answers.

use std::collections::{BTreeMap, BTreeSet};

use proveout_nc::{Location, ToolName};
use proveout_tool::{ImportCall, ToolDraft, ToolLibrary, import_tools};

use super::{
    FirstPart, FirstPartError, Tools, facts,
    interview::{self, Interview, PROPOSED},
    refused,
};
use crate::prepare::program_extent::Reading;

/// Scale of the four decimals that a diameter is shown with.
const FOUR_DECIMALS: f64 = 1e4;

impl Tools {
    /// Gauge lengths by number and name, mm.
    pub(crate) fn lengths(&self) -> BTreeMap<ToolName, f64> {
        let mut all = BTreeMap::new();
        match self {
            Self::Drafts(drafts) => {
                for d in drafts {
                    all.insert(ToolName::Number(d.number), d.gauge.unwrap_or(0.0));
                    all.insert(ToolName::Name(d.name.clone()), d.gauge.unwrap_or(0.0));
                }
            }
            Self::Library(path) => {
                for t in ToolLibrary::read(path).map(|l| l.tools).unwrap_or_default() {
                    all.insert(ToolName::Number(t.number), t.gauge_length);
                    all.insert(ToolName::Name(t.name), t.gauge_length);
                }
            }
        }
        all
    }

    /// Whether a tool is a face mill, by its draft.
    pub(crate) fn faces(&self, name: &ToolName) -> bool {
        let Self::Drafts(drafts) = self else { return false };
        let own = |d: &&ToolDraft| *name == ToolName::Number(d.number) || *name == ToolName::Name(d.name.clone());
        drafts.iter().find(own).is_some_and(|d| d.kind == Some("face_mill"))
    }

    /// Lengthens tools whose overhang is not given until they reach their cuts; `depths`
    /// says how deep each tool goes, by name, mm. Returns whether a length changed.
    pub(crate) fn reach(&mut self, depths: &[(ToolName, f64)]) -> bool {
        let Self::Drafts(drafts) = self else { return false };
        let mut changed = false;
        for (name, depth) in depths {
            let own = drafts
                .iter_mut()
                .filter(|d| *name == ToolName::Number(d.number) || *name == ToolName::Name(d.name.clone()));
            own.for_each(|d| changed |= d.reach(*depth));
        }
        changed
    }

    /// Diameter and length of the widest holder, mm, where drafts have one.
    pub(crate) fn widest_holder(&self) -> Option<(f64, f64)> {
        let Self::Drafts(drafts) = self else { return None };
        let size = |d: &ToolDraft| {
            let width = d.holder.iter().map(|s| s.diameter.max(s.top_diameter)).fold(0.0, f64::max);
            (width > 0.0).then(|| (width, d.holder.iter().map(|s| s.length).sum::<f64>()))
        };
        drafts.iter().filter_map(size).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Radius of a tool, mm.
    pub(crate) fn radius(&self, name: &ToolName) -> f64 {
        match self {
            Self::Drafts(drafts) => drafts
                .iter()
                .find(|d| *name == ToolName::Number(d.number) || *name == ToolName::Name(d.name.clone()))
                .and_then(ToolDraft::diameter)
                .map_or(0.0, |d| 0.5 * d),
            Self::Library(path) => ToolLibrary::read(path)
                .map(|l| l.tools)
                .unwrap_or_default()
                .iter()
                .find(|t| *name == ToolName::Number(t.number) || *name == ToolName::Name(t.name.clone()))
                .map_or(0.0, |t| t.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max)),
        }
    }
}

/// Tools that the programs call, from a library, the text, or answers; a tool of which a question stays open
/// is left out, and an open holder is none.
pub(super) fn tools(
    call: &FirstPart,
    readings: &[Reading],
    all_facts: &[facts::Facts],
    start: Option<&(u32, String)>,
    interview: &mut Interview<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<Tools, FirstPartError> {
    let mut called: Vec<(ToolName, Option<Location>)> = Vec::new();
    for tool in readings.iter().flat_map(|r| &r.tools) {
        let name = match (&tool.name, start) {
            (ToolName::Empty, Some((number, _))) => ToolName::Number(*number),
            (ToolName::Empty, None) => continue,
            (name, _) => name.clone(),
        };
        if !called.iter().any(|(known, _)| *known == name) {
            called.push((name, Some(tool.at.clone())));
        }
    }
    // A text that changes no tool in names them all the same, and the control looks each of them up.
    for (name, at) in readings.iter().filter(|r| !r.changes).flat_map(|r| &r.selected) {
        if *name != ToolName::Empty && !called.iter().any(|(known, _)| known == name) {
            called.push((name.clone(), Some(at.clone())));
        }
    }
    let mut library: Vec<ToolDraft> = Vec::new();
    if let Some(path) = &call.tools {
        if path.extension().is_some_and(|e| e == "toml") {
            let own = ToolLibrary::read(path)?;
            let missing = called.iter().find(|(name, _)| match name {
                ToolName::Empty => false,
                ToolName::Number(n) => !own.tools.iter().any(|t| t.number == *n),
                ToolName::Name(n) => !own.tools.iter().any(|t| t.name == *n),
            });
            if let Some((name, at)) = missing {
                let line =
                    at.as_ref().map_or_else(String::new, |at| format!(", called in line {} of {}", at.line, at.file));
                let message = format!("tool {}{line}, is not in {}", shown(name), path.display());
                return Err(refused(
                    message,
                    "add it to the library, or leave --tools out to take the tools from the program text",
                ));
            }
            return Ok(Tools::Library(path.clone()));
        }
        let numbers: BTreeSet<u32> =
            called.iter().filter_map(|(n, _)| if let ToolName::Number(n) = n { Some(*n) } else { None }).collect();
        let by_name = called.iter().any(|(n, _)| matches!(n, ToolName::Name(_)));
        let wanted = (!by_name).then_some(numbers);
        let imported = import_tools(path, &ImportCall { unit: call.unit, wanted })?;
        notes.extend(imported.notes);
        library = imported.tools;
    }
    let mut drafts: Vec<(ToolName, ToolDraft)> = Vec::new();
    // Tools whose diameter is given by neither text, nor library, nor an answer of their own.
    let mut bare: Vec<(ToolName, ToolDraft, String)> = Vec::new();
    for (name, at) in &called {
        let from_library = library.iter().find(|d| match name {
            ToolName::Number(n) => d.number == *n,
            ToolName::Name(n) => d.name == *n,
            ToolName::Empty => false,
        });
        let of_text = all_facts.iter().find_map(|f| f.tools.get(name));
        if interview.given(&key_of(name)).is_none() && from_library.is_none() {
            notes.extend(told_otherwise(name, call, all_facts));
        }
        let number = match name {
            ToolName::Number(n) => *n,
            _ => from_library.map_or(0, |d| d.number),
        };
        let key = key_of(name);
        let draft = match (interview.given(&key), from_library, of_text) {
            (Some(answer), ..) => tool_of_answer(&key, &answer, number)?,
            (None, Some(from), of_text) => {
                let mut draft = from.clone();
                // What the library leaves open the text may give.
                if draft.diameter().is_none()
                    && let Some(text) = of_text
                {
                    let (gauge, number, name) = (draft.gauge, draft.number, draft.name);
                    draft = ToolDraft { number, name, gauge: gauge.or(text.gauge), ..text.clone() };
                }
                draft
            }
            (None, None, Some(text)) => text.clone(),
            (None, None, None) => ToolDraft::new(number, ""),
        };
        if draft.diameter().is_some() {
            drafts.push((name.clone(), draft));
        } else {
            let line = at.as_ref().map_or_else(String::new, |at| format!(" (line {} of {})", at.line, at.file));
            bare.push((name.clone(), draft, line));
        }
    }
    // Tools of which a question is open want a holder as well.
    let mut unknown: Vec<String> = Vec::new();
    for (name, draft, answer) in answered(bare, interview)? {
        match answer {
            Some((key, answer)) => {
                let own = tool_of_answer(&key, &answer, draft.number)?;
                drafts.push((name, ToolDraft { gauge: own.gauge.or(draft.gauge), ..own }));
            }
            None => unknown.push(shown(&name)),
        }
    }
    let mut drafts = numbered(drafts, &called);
    // One holder for all tools for which none is given.
    let mut holder = None;
    if !unknown.is_empty() || drafts.iter().any(|d| d.holder.is_empty()) {
        let key = "holder";
        let which = drafts
            .iter()
            .filter(|d| d.holder.is_empty())
            .map(|d| format!("T{}", d.number))
            .chain(unknown)
            .collect::<Vec<_>>()
            .join(" ");
        let text = format!(
            "What holder for {which}? Diameter and length to the gauge line in mm such as 40x60, or none: what needs the holder is then unchecked"
        );
        let answer = interview.get(key, text, Some("none".into())).unwrap_or_else(|| PROPOSED.into());
        let answer = if answer == PROPOSED { "none".to_owned() } else { answer };
        holder = interview::holder(&answer).ok_or_else(|| {
            refused(format!("`{key}` = {answer:?} is not a holder"), "write none, or diameter and length: 40x60")
        })?;
    }
    for draft in &mut drafts {
        draft.complete(holder).map_err(|e| {
            let help = format!(
                "answer for the tool: `tool.{}` = \"flat D10 L25\", or `holder` with a shorter one or none, or name a library with --tools",
                if draft.name.is_empty() { format!("T{}", draft.number) } else { draft.name.clone() }
            );
            refused(e, help)
        })?;
    }
    drafts.sort_by_key(|d| d.number);
    Ok(Tools::Drafts(drafts))
}

/// What the texts say of a tool that cannot both be true, and which of it is taken.
fn told_otherwise(name: &ToolName, call: &FirstPart, all_facts: &[facts::Facts]) -> Option<String> {
    let several = all_facts.len() > 1;
    let mut first: Option<(usize, &ToolDraft)> = None;
    let mut others: Vec<String> = Vec::new();
    let shape = |at: usize, draft: &ToolDraft| {
        let size =
            draft.diameter().map_or_else(String::new, |d| format!(" D{}", (d * FOUR_DECIMALS).round() / FOUR_DECIMALS));
        let file = call.programs.get(at).filter(|_| several).and_then(|path| path.file_name());
        let file = file.map_or_else(String::new, |name| format!(" of {}", name.to_string_lossy()));
        format!("{}{size} ({}{file})", draft.kind.unwrap_or("a tool of"), draft.source)
    };
    for (at, facts) in all_facts.iter().enumerate() {
        let own = facts.tools.get(name);
        match (first, own) {
            (None, Some(draft)) => first = Some((at, draft)),
            (Some((_, taken)), Some(draft)) if facts::contradict(taken, draft) => others.push(shape(at, draft)),
            _ => {}
        }
        let also = facts.otherwise.iter().filter(|(other, _)| other == name);
        let also = also.filter(|(_, draft)| first.is_none_or(|(_, taken)| facts::contradict(taken, draft)));
        others.extend(also.map(|(_, draft)| shape(at, draft)));
    }
    let (at, taken) = first?;
    others.dedup();
    if others.is_empty() {
        return None;
    }
    Some(format!(
        "the program describes tool {} in two ways: {} is used, not {}; the answer {} overrides it",
        shown(name),
        shape(at, taken),
        others.join(", "),
        key_of(name)
    ))
}

/// Key of the answer for a tool.
fn key_of(name: &ToolName) -> String {
    format!("tool.{}", shown(name).trim_matches('"'))
}

/// Key and answer of a tool, where its question is not open.
type Answered = (ToolName, ToolDraft, Option<(String, String)>);

/// Asks for tools of which nothing is known: for one by its own key, for several in one question.
fn answered(
    bare: Vec<(ToolName, ToolDraft, String)>,
    interview: &mut Interview<'_, '_>,
) -> Result<Vec<Answered>, FirstPartError> {
    let how = "Kind and millimeters such as \"flat D10 L25\", \"bull_nose D12 R1\", \"drill D8.5 A118\" (inches: \"flat D0.5 inch\")";
    let library = "or name a library with --tools";
    if bare.len() < 2 {
        let ask = |(name, draft, line): (ToolName, ToolDraft, String)| {
            let key = key_of(&name);
            let text = format!("What is tool {}{line}? {how}; {library}", shown(&name));
            let answer = interview.get(&key, text, None).map(|answer| (key, answer));
            (name, draft, answer)
        };
        return Ok(bare.into_iter().map(ask).collect());
    }
    let key = "tools";
    let named = |name: &ToolName| shown(name).trim_matches('"').to_owned();
    let names: Vec<String> = bare.iter().map(|(name, _, line)| format!("{}{line}", shown(name))).collect();
    let text = format!(
        "What are the tools {}? Each with its name and semicolons between, \"T1: flat D10 L25; T2: drill D8.5\". {how}; {library}",
        names.join(", ")
    );
    let wanted: Vec<(String, Option<String>)> = bare.iter().map(|(name, ..)| (named(name), None)).collect();
    let each = interview.get_each(key, text, &wanted).map_err(|e| {
        refused(format!("`{key}`: {e}"), "write each tool with its name: T1: flat D10 L25; T2: drill D8.5")
    })?;
    let with = |(name, draft, _): (ToolName, ToolDraft, String)| {
        let answer = each.as_ref().and_then(|each| each.get(&named(&name)));
        let answer = answer.map(|answer| (key.to_owned(), answer.clone()));
        (name, draft, answer)
    };
    Ok(bare.into_iter().map(with).collect())
}

/// Drafts with the number or the name that the program calls; names get numbers that are free.
fn numbered(drafts: Vec<(ToolName, ToolDraft)>, called: &[(ToolName, Option<Location>)]) -> Vec<ToolDraft> {
    let mut all: Vec<ToolDraft> = Vec::new();
    let mut free = 1_u32;
    for (name, mut draft) in drafts {
        match name {
            ToolName::Number(n) => draft.number = n,
            ToolName::Name(word) => {
                draft.name = word;
                if draft.number == 0 {
                    while called.iter().any(|(n, _)| *n == ToolName::Number(free))
                        || all.iter().any(|d| d.number == free)
                    {
                        free += 1;
                    }
                    draft.number = free;
                }
            }
            ToolName::Empty => {}
        }
        all.push(draft);
    }
    all
}

fn tool_of_answer(key: &str, answer: &str, number: u32) -> Result<ToolDraft, FirstPartError> {
    interview::tool(answer, number).ok_or_else(|| {
        let help = "write kind and dimensions: flat D10 L25, ball D8, bull_nose D12 R1, drill D8.5 A118, chamfer D10 A90, face_mill D50, tap D8 P1.25";
        refused(format!("`{key}` = {answer:?} is not a tool"), help)
    })
}

/// A tool as a program names it.
pub(crate) fn shown(name: &ToolName) -> String {
    match name {
        ToolName::Empty => "T0".to_owned(),
        ToolName::Number(n) => format!("T{n}"),
        ToolName::Name(n) => format!("\"{n}\""),
    }
}
