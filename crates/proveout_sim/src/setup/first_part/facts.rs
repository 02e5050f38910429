//! What the comments and headers of a program say: unit, stock, tools. Comments of posts are read
//! line by line; nothing in them decides how the program runs.

use std::collections::BTreeMap;

use proveout_nc::{Dialect, ProgramText, ToolName};
use proveout_tool::{LengthUnit, ToolDraft};

use super::{tool_names, tool_sizes, tool_statements, tool_words};

/// Lines of a program that are searched for comments: the head and the calls of the tools.
const MAX_LINES: usize = 2_000_000;
/// A comment without a number belongs to the tool that is called within this many lines.
const BEFORE_CALL: usize = 4;
/// A comment without a number describes the tool just changed in if it follows the change by at
/// most this many lines.
const BEHIND_CHANGE: usize = 1;

/// Stock as a program states it, workpiece frame, mm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Stock {
    Box {
        min: [f64; 3],
        max: [f64; 3],
    },
    /// Along the axis of this index.
    Cylinder {
        base: [f64; 3],
        radius: f64,
        height: f64,
        along: usize,
    },
}

/// Facts of a text.
#[derive(Clone, Debug, Default)]
pub(crate) struct Facts {
    /// Unit of length, and the word that says it.
    pub(crate) unit: Option<(LengthUnit, String)>,
    /// The first line with a comment that mentions inches.
    pub(crate) inch_comment: Option<usize>,
    /// Stock, the line and the word that states it.
    pub(crate) stock: Option<(Stock, usize, &'static str)>,
    /// Tools, by number or by name.
    pub(crate) tools: BTreeMap<ToolName, ToolDraft>,
    /// Further descriptions of a tool that contradict an earlier one, in the order of the text.
    pub(crate) otherwise: Vec<(ToolName, ToolDraft)>,
    /// A word of the text names a tool: `T5`, `TOOL CALL`.
    pub(crate) names_tool: bool,
}

/// A description in lines of its own that is under way.
struct Heading {
    number: u32,
    /// What its lines have said so far.
    told: String,
    /// What was known of the tool before it.
    before: Option<ToolDraft>,
    /// The last of `otherwise` is this description.
    contradicts: bool,
}

/// Reads a text. `unit`: that of numbers where the text has no word for it.
pub(crate) fn of_text(text: &ProgramText, dialect: Dialect, start: LengthUnit) -> Facts {
    let mut facts = Facts { unit: unit_of(text, dialect), ..Facts::default() };
    let unit = facts.unit.as_ref().map_or(start, |(u, _)| *u).mm();
    let lines = || (1..).zip(text.all().take(MAX_LINES));
    let mut blank = [None, None];
    // A comment without a number, waiting for its tool.
    let mut waiting: Option<(usize, ToolDraft)> = None;
    // The number of a tool whose description follows in comments of its own, and what they have
    // said so far.
    let mut heading: Option<Heading> = None;
    let changes = with_changes(text, dialect);
    let names = tool_names::Known::of(lines().filter_map(|(_, line)| called(line, dialect)));
    // The tool that is named last, and the one that is changed in last, with its line.
    let mut named: Option<(ToolName, usize)> = None;
    let mut changed: Option<(ToolName, usize)> = None;
    // Descriptions without a number, of a text that calls no tool.
    let mut loose: Vec<ToolDraft> = Vec::new();
    for (n, line) in lines() {
        let upper = line.to_uppercase();
        if facts.stock.is_none() {
            facts.stock = stock_of(&upper, dialect, unit, &mut blank).map(|(stock, word)| (stock, n, word));
        }
        if dialect.family() == Dialect::Heidenhain
            && let Some(draft) = tool_statements::tool_def(&upper, unit, n)
        {
            // The control reads this one, and not the comments.
            let name = ToolName::Number(draft.number);
            if let Some(before) = facts.tools.insert(name.clone(), draft)
                && facts.tools.get(&name).is_some_and(|now| contradict(now, &before))
            {
                facts.otherwise.push((name, before));
            }
            continue;
        }
        if dialect == Dialect::Apt
            && let Some(draft) = tool_statements::cutter_statement(&upper, unit, n)
        {
            waiting = Some((n, draft));
        }
        let word = called(line, dialect);
        if let Some(name) = &word {
            facts.names_tool = true;
            named = Some((name.clone(), n));
        }
        // Where tools are changed in by M6, a T alone makes one ready: a description before it
        // belongs to the next change.
        let call = if changes && has_change(line, dialect) {
            word.or_else(|| named.take().filter(|(_, at)| n - at <= BEFORE_CALL).map(|(name, _)| name))
        } else {
            word.filter(|name| !(changes && matches!(name, ToolName::Number(_))))
        };
        let all = comments(line, dialect);
        for comment in all.iter().flat_map(|c| tool_sizes::one_by_one(c)) {
            let comment = comment.to_owned();
            if let Some(number) = tool_words::number_alone(&comment) {
                let before = facts.tools.get(&ToolName::Number(number)).cloned();
                heading = Some(Heading { number, told: String::new(), before, contradicts: false });
                continue;
            }
            let described = heading.as_mut().filter(|_| tool_words::describes(&comment));
            if let Some(Heading { number, told, before, contradicts }) = described {
                *told += &format!("{} ", comment.trim());
                if let Some((_, mut draft)) = tool_words::of_comment(told, unit, n) {
                    draft.number = *number;
                    draft.name = format!("T{number}");
                    draft.source = format!("comments up to line {n}");
                    let name = ToolName::Number(*number);
                    match before.as_ref().filter(|known| known.diameter().is_some()) {
                        Some(known) => {
                            // The lines of one description complete each other.
                            let from = facts.otherwise.len() - usize::from(*contradicts);
                            facts.otherwise.truncate(from);
                            *contradicts = contradict(known, &draft);
                            if *contradicts {
                                facts.otherwise.push((name, draft));
                            }
                        }
                        None => {
                            facts.tools.insert(name, draft);
                        }
                    }
                }
                continue;
            }
            heading = None;
            // A comment that names a tool belongs to that tool, wherever it is.
            let (own, comment) = match names.told(&comment) {
                tool_names::Told::Of(name, rest) => {
                    if let Some(draft) = tool_names::described(&name, &comment, &rest, unit, n) {
                        facts.merge(ToolName::Name(name.clone()), draft);
                    }
                    (Some(name), rest)
                }
                tool_names::Told::OfSeveral => continue,
                tool_names::Told::OfNone(rest) => (None, rest),
            };
            if facts.inch_comment.is_none() && says_inch(&comment) {
                facts.inch_comment = Some(n);
            }
            if own.is_some() {
                continue;
            }
            match tool_words::of_comment(&comment, unit, n) {
                Some((Some(number), draft)) => {
                    facts.merge(ToolName::Number(number), draft);
                }
                Some((None, draft)) => {
                    loose.push(draft.clone());
                    // Right after a change it is the tool that has come, and not the next one.
                    match changed.as_ref().filter(|(_, at)| call.is_none() && n - at <= BEHIND_CHANGE) {
                        Some((name, _)) if !says_next(&comment) => {
                            facts.of_call(name.clone(), draft);
                        }
                        _ => waiting = Some((n, draft)),
                    }
                }
                None if call.is_some() && waiting.is_none() => {
                    waiting = tool_words::size_alone(&comment, unit, n).map(|draft| (n, draft));
                }
                None => {}
            }
        }
        if let Some(name) = call {
            changed = (dialect != Dialect::Apt).then(|| (name.clone(), n));
            let near = waiting.take().filter(|(at, _)| n - at <= BEFORE_CALL || dialect == Dialect::Apt);
            // A name may describe the tool itself: "END_D12", "KUGEL_D8". Where a comment that
            // names no tool contradicts it, the name takes precedence.
            let by_name = match &name {
                ToolName::Name(word) => tool_words::of_name(word, unit, n),
                _ => None,
            };
            let near = near.map(|(_, draft)| draft);
            let (told, guessed): (Vec<ToolDraft>, _) = match by_name {
                Some(own) if !own.chosen.is_empty() => (near.into_iter().collect(), Some(own)),
                Some(own) if near.as_ref().is_some_and(|draft| contradict(&own, draft)) => {
                    ([own].into_iter().chain(near).collect(), None)
                }
                own => (near.into_iter().chain(own).collect(), None),
            };
            for draft in told {
                facts.of_call(name.clone(), draft);
            }
            // A number at the end of a name is the diameter where nothing else states one.
            if let Some(own) = guessed.filter(|_| !facts.tools.contains_key(&name)) {
                facts.tools.insert(name, own);
            }
        }
    }
    // What a text that calls none describes is in the spindle, where all of it is one tool.
    if !facts.names_tool
        && facts.tools.is_empty()
        && let [first, rest @ ..] = &loose[..]
        && rest.iter().all(|d| d.diameter() == first.diameter() && (d.kind.is_none() || d.kind == first.kind))
    {
        facts.tools.insert(ToolName::Number(1), with_number(first.clone(), &ToolName::Number(1)));
    }
    facts
}

/// A draft with the number of its tool.
fn with_number(mut draft: ToolDraft, name: &ToolName) -> ToolDraft {
    if let ToolName::Number(number) = name {
        draft.number = *number;
        draft.name = format!("T{number}");
    }
    draft
}

/// A comment about the tool that is made ready.
fn says_next(comment: &str) -> bool {
    comment.split(|c: char| !c.is_alphabetic()).any(|w| w.eq_ignore_ascii_case("NEXT"))
}

/// Whether tools are changed in by a word of their own, and not by the one that names them.
fn with_changes(text: &ProgramText, dialect: Dialect) -> bool {
    text.all().take(MAX_LINES).any(|line| has_change(line, dialect))
}

/// M6, M06 in a line.
fn has_change(line: &str, dialect: Dialect) -> bool {
    if matches!(dialect, Dialect::Heidenhain | Dialect::HeidenhainIso | Dialect::Apt) || !line.contains(['M', 'm']) {
        return false;
    }
    let code = code(line, dialect).to_ascii_uppercase();
    code.match_indices('M').any(|(at, _)| {
        let rest = code[at + 1..].trim_start_matches('0');
        let alone = !code[..at].chars().next_back().is_some_and(char::is_alphabetic);
        alone && rest.strip_prefix('6').is_some_and(|r| !r.starts_with(|c: char| c.is_ascii_digit() || c == '='))
    })
}

impl Facts {
    /// A comment that says more of a tool than an earlier one completes it; what is there stays.
    fn merge(&mut self, name: ToolName, draft: ToolDraft) {
        match self.tools.get_mut(&name) {
            None => {
                self.tools.insert(name, draft);
            }
            Some(known) if known.diameter().is_none() && draft.diameter().is_some() => *known = draft,
            Some(known) if contradict(known, &draft) => self.also(name, draft),
            Some(known) => {
                known.kind = known.kind.or(draft.kind);
                known.flutes = known.flutes.or(draft.flutes);
            }
        }
    }

    /// Another description of a tool, once.
    fn also(&mut self, name: ToolName, draft: ToolDraft) {
        let same =
            |(own, d): &(ToolName, ToolDraft)| *own == name && d.diameter() == draft.diameter() && d.kind == draft.kind;
        if !self.otherwise.iter().any(same) {
            self.otherwise.push((name, draft));
        }
    }

    /// A comment without a number next to the call of a tool.
    fn of_call(&mut self, name: ToolName, draft: ToolDraft) {
        let draft = with_number(draft, &name);
        match self.tools.get_mut(&name) {
            None => {
                self.tools.insert(name, draft);
            }
            Some(known) if contradict(known, &draft) => self.also(name, draft),
            Some(known) => {
                known.kind = known.kind.or(draft.kind);
                known.flutes = known.flutes.or(draft.flutes);
            }
        }
    }
}

/// Diameters that differ by less are rounded ones of the same tool: 9.53 for 3/8 inch.
const SAME_DIAMETER: f64 = 0.005;

/// Two descriptions that cannot both be of the tool: another diameter, or another kind of end.
pub(super) fn contradict(a: &ToolDraft, b: &ToolDraft) -> bool {
    let diameters = a.diameter().zip(b.diameter());
    // `T5 D5 H5` names offsets.
    let offset = |d: &ToolDraft| d.kind.is_none() && d.diameter() == Some(f64::from(d.number));
    let other_size = diameters.is_some_and(|(a, b)| (a - b).abs() > SAME_DIAMETER * a.max(b));
    // Comments often leave the corner radius out, so these three count as one kind.
    let family = |kind: &'static str| if matches!(kind, "bull_nose" | "face_mill") { "flat" } else { kind };
    let other_kind = a.kind.map(family).zip(b.kind.map(family)).is_some_and(|(a, b)| a != b);
    !offset(a) && !offset(b) && (other_size || other_kind)
}

/// Whether a comment mentions inches.
fn says_inch(comment: &str) -> bool {
    comment
        .split(|c: char| !c.is_alphanumeric())
        .any(|w| ["INCH", "INCHES", "IPM"].iter().any(|i| w.eq_ignore_ascii_case(i)))
}

/// The comments of a line.
fn comments(line: &str, dialect: Dialect) -> Vec<String> {
    let mut all = Vec::new();
    match dialect {
        Dialect::Siemens840d => all.extend(line.split_once(';').map(|(_, c)| c.to_owned())),
        Dialect::Heidenhain | Dialect::HeidenhainIso => {
            all.extend(line.split_once(';').map(|(_, c)| c.to_owned()));
            let text = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
            all.extend(text.strip_prefix("* -").map(str::to_owned));
        }
        Dialect::Apt => {
            let upper = line.to_uppercase();
            for word in ["PPRINT", "TPRINT/", "PPRINT/", "$$"] {
                all.extend(upper.find(word).map(|at| line[at + word.len()..].to_owned()));
            }
        }
        _ => {
            let mut rest = line;
            while let Some(open) = rest.find('(') {
                let Some(close) = rest[open..].find(')') else { break };
                all.push(rest[open + 1..open + close].to_owned());
                rest = &rest[open + close + 1..];
            }
            all.extend(rest.split_once(';').map(|(_, c)| c.to_owned()));
        }
    }
    all
}

/// The code of a line without its comments.
fn code(line: &str, dialect: Dialect) -> String {
    let mut out = String::new();
    let mut depth = 0_u32;
    for c in line.chars() {
        match c {
            ';' if depth == 0 => break,
            '(' if dialect.family() == Dialect::Iso => depth += 1,
            ')' if dialect.family() == Dialect::Iso => depth = depth.saturating_sub(1),
            c if depth == 0 => out.push(c),
            _ => {}
        }
    }
    out
}

/// The tool that a line names: `T5`, `T="END"`, `TOOL CALL 5`, `LOADTL/5`.
fn called(line: &str, dialect: Dialect) -> Option<ToolName> {
    // Names keep their letters as they are.
    let written = code(line, dialect);
    let code = written.to_ascii_uppercase();
    let digits = |text: &str| {
        let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
        text[..end].parse::<u32>().ok().map(ToolName::Number)
    };
    let quoted = |text: &str| text.strip_prefix('"')?.split_once('"').map(|(name, _)| ToolName::Name(name.to_owned()));
    match dialect {
        Dialect::Heidenhain => {
            let rest = written[code.find("TOOL CALL ")? + "TOOL CALL ".len()..].trim_start();
            digits(rest).or_else(|| quoted(rest))
        }
        Dialect::Apt => {
            let at = ["LOADTL/", "LOAD/TOOL,", "LOADTL /"].iter().find_map(|w| Some(code.find(w)? + w.len()))?;
            digits(code[at..].trim_start())
        }
        _ => {
            let mut from = 0;
            while let Some(at) = code[from..].find('T').map(|i| i + from) {
                let alone = !code[..at].chars().next_back().is_some_and(char::is_alphabetic);
                let rest = written[at + 1..].trim_start();
                let rest = rest.strip_prefix('=').unwrap_or(rest).trim_start();
                if alone && let Some(name) = digits(rest).or_else(|| quoted(rest)) {
                    return Some(name);
                }
                from = at + 1;
            }
            None
        }
    }
}

/// The first word of a program that says its unit.
fn unit_of(text: &ProgramText, dialect: Dialect) -> Option<(LengthUnit, String)> {
    use LengthUnit::{Inch, Millimeter};
    let words: &[(&str, LengthUnit)] = match dialect {
        Dialect::Siemens840d => &[("G700", Inch), ("G710", Millimeter), ("G70", Inch), ("G71", Millimeter)],
        Dialect::Heidenhain => &[(" INCH", Inch), (" MM", Millimeter)],
        Dialect::HeidenhainIso => &[("G70", Inch), ("G71", Millimeter)],
        Dialect::Apt => &[("INCHES", Inch), ("INCH", Inch), ("MM", Millimeter)],
        _ => &[("G20", Inch), ("G21", Millimeter)],
    };
    let told = first_unit(text, dialect, words);
    // Posts of NX write G70 and G71, for controls that take them, where no other word states the
    // unit.
    if told.is_none() && dialect.family() == Dialect::Iso {
        return first_unit(text, dialect, &[("G70", Inch), ("G71", Millimeter)]);
    }
    if told.is_none() && dialect == Dialect::Apt {
        return unit_of_feeds(text);
    }
    told
}

/// CL data without UNITS counts lengths in inch where its feeds do, as the reader takes it.
fn unit_of_feeds(text: &ProgramText) -> Option<(LengthUnit, String)> {
    let feeds = |words: [&str; 2]| {
        (1_usize..).zip(text.all().take(MAX_LINES)).find_map(|(n, line)| {
            let line = line.to_uppercase();
            (line.contains("FEDRAT") && words.iter().any(|w| line.contains(w))).then_some(n)
        })
    };
    let line = feeds(["IPM", "IPR"])?;
    feeds(["MMPM", "MMPR"]).is_none().then(|| (LengthUnit::Inch, format!("the feed in line {line}, without UNITS")))
}

/// The first of the words.
fn first_unit(text: &ProgramText, dialect: Dialect, words: &[(&str, LengthUnit)]) -> Option<(LengthUnit, String)> {
    (1_usize..).zip(text.all().take(MAX_LINES)).find_map(|(n, line)| {
        let line = code(&line.to_uppercase(), dialect);
        if dialect == Dialect::Heidenhain && !line.contains("BEGIN PGM")
            || dialect == Dialect::Apt && !line.contains("UNITS")
        {
            return None;
        }
        words
            .iter()
            .find(|(word, _)| {
                line.match_indices(word).any(|(at, _)| {
                    let next = line[at + word.len()..].chars().next();
                    !next.is_some_and(|c| c.is_ascii_digit() || c == '.' || c.is_alphabetic() && !word.starts_with('G'))
                })
            })
            .map(|(word, unit)| (*unit, format!("{} in line {n}", word.trim())))
    })
}

/// Numbers of a list `a,b,,c`; an empty member has none.
fn list(text: &str) -> Vec<Option<f64>> {
    text.split(',').map(|t| t.trim().parse::<f64>().ok().filter(|v| v.is_finite())).collect()
}

fn stock_of(
    upper: &str,
    dialect: Dialect,
    unit: f64,
    blank: &mut [Option<[f64; 3]>; 2],
) -> Option<(Stock, &'static str)> {
    match dialect {
        Dialect::Siemens840d => workpiece(upper, unit).map(|s| (s, "WORKPIECE")),
        Dialect::Heidenhain => {
            let at = upper.find("BLK FORM ")?;
            let rest = &upper[at + "BLK FORM ".len()..];
            let axis = |letter: char| tool_words::letter(rest, letter).map(|v| v * unit);
            if let Some(rest) = rest.trim_start().strip_prefix("CYLINDER") {
                let value = |letter: char| tool_words::letter(rest, letter).map(|v| v * unit);
                let radius = value('R').or_else(|| value('D').map(|d| 0.5 * d))?;
                // L grows from the top down to below; DIST is the way from the datum to its top.
                let height = value('L')?.abs();
                let top =
                    rest.find("DIST").and_then(|at| rest[at + 4..].split_whitespace().next()?.parse::<f64>().ok());
                let top = top.unwrap_or(0.0) * unit;
                // `CYLINDER X D60 L100`: the axis of the bar comes before its sizes.
                let along = "XYZ".find(rest.trim_start().chars().next()?)?;
                let mut base = [0.0; 3];
                base[along] = top - height;
                return Some((Stock::Cylinder { base, radius, height, along }, "BLK FORM CYLINDER"));
            }
            let corner = usize::from(rest.trim_start().strip_prefix("0.2").is_some());
            if corner == 0 && rest.trim_start().strip_prefix("0.1").is_none() {
                return None;
            }
            let point = [axis('X')?, axis('Y')?, if corner == 0 { last_letter(rest, 'Z')? * unit } else { axis('Z')? }];
            blank[corner] = Some(point);
            let (Some(min), Some(max)) = (blank[0], blank[1]) else { return None };
            let solid = (0..3).all(|i| min[i] < max[i]);
            solid.then_some((Stock::Box { min, max }, "BLK FORM"))
        }
        _ => None,
    }
}

/// `0.1 Z X+0 Y+0 Z-20`: the first Z names the spindle axis and has no number.
fn last_letter(text: &str, letter: char) -> Option<f64> {
    let at = text.rfind(letter)?;
    tool_words::letter(&text[at..], letter)
}

/// `WORKPIECE(,"",,"BOX",MODE,Z0,Z1,ZB,X0,Y0,X1,Y1)`, `"CYLINDER",MODE,Z0,Z1,ZB,D`.
///
/// In MODE bit 4 and 5 say that X1 and Y1 are coordinates (else lengths from X0, Y0), bit 6 that Z1 is one
/// (else a length from Z0).
fn workpiece(upper: &str, unit: f64) -> Option<Stock> {
    let at = upper.find("WORKPIECE(")?;
    let inside = upper[at + "WORKPIECE(".len()..].split(')').next()?;
    let (kind, rest) = ["\"BOX\"", "\"CYLINDER\""].iter().find_map(|k| Some((*k, inside.split_once(k)?.1)))?;
    let n = list(rest.trim_start_matches(','));
    let mm = |i: usize| n.get(i).copied().flatten().map(|v| v * unit);
    let mode = n.first().copied().flatten().unwrap_or(0.0) as u32;
    let z0 = mm(1)?;
    let z1 = if mode >> 6 & 1 == 1 { mm(2)? } else { z0 + mm(2)? };
    let [low, high] = [z0.min(z1), z0.max(z1)];
    if high <= low {
        return None;
    }
    if kind == "\"CYLINDER\"" {
        let radius = 0.5 * mm(4)?;
        return (radius > 0.0).then_some(Stock::Cylinder {
            base: [0.0, 0.0, low],
            radius,
            height: high - low,
            along: 2,
        });
    }
    let [x0, y0] = [mm(4)?, mm(5)?];
    let x1 = if mode >> 4 & 1 == 1 { mm(6)? } else { x0 + mm(6)? };
    let y1 = if mode >> 5 & 1 == 1 { mm(7)? } else { y0 + mm(7)? };
    let min = [x0.min(x1), y0.min(y1), low];
    let max = [x0.max(x1), y0.max(y1), high];
    (0..3).all(|i| min[i] < max[i]).then_some(Stock::Box { min, max })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blank_of_840d_and_klartext_is_read_in_both_ways_of_counting() {
        let absolute = workpiece("WORKPIECE(,\"\",,\"BOX\",112,0,-50,-80,0,0,100,80)", 1.0);
        assert_eq!(absolute, Some(Stock::Box { min: [0.0, 0.0, -50.0], max: [100.0, 80.0, 0.0] }));
        let lengths = workpiece("N5 WORKPIECE(,\"\",,\"BOX\",0,2,-30,-80,-2,-2,184,170)", 1.0);
        assert_eq!(lengths, Some(Stock::Box { min: [-2.0, -2.0, -28.0], max: [182.0, 168.0, 2.0] }));
        let turned = workpiece("WORKPIECE(,,,\"CYLINDER\",192,1,-40,-30,50)", 1.0);
        assert_eq!(turned, Some(Stock::Cylinder { base: [0.0, 0.0, -40.0], radius: 25.0, height: 41.0, along: 2 }));
        assert_eq!(workpiece("WORKPIECE(,\"\",,\"BOX\",112,0,0,0,0,0,0,0)", 1.0), None);
        let mut blank = [None, None];
        let d = Dialect::Heidenhain;
        assert_eq!(stock_of("1 BLK FORM 0.1 Z X+0 Y-5 Z-20", d, 1.0, &mut blank), None);
        let (stock, _) = stock_of("2 BLK FORM 0.2 X+100 Y+60 Z+0", d, 1.0, &mut blank).expect("both corners");
        assert_eq!(stock, Stock::Box { min: [0.0, -5.0, -20.0], max: [100.0, 60.0, 0.0] });
        let (round, _) = stock_of("1 BLK FORM CYLINDER Z D80 L60 DIST+1", d, 1.0, &mut [None, None]).expect("round");
        assert_eq!(round, Stock::Cylinder { base: [0.0, 0.0, -59.0], radius: 40.0, height: 60.0, along: 2 });
        let (lying, _) = stock_of("1 BLK FORM CYLINDER X R30 L100 DIST+100", d, 1.0, &mut [None, None]).expect("round");
        assert_eq!(lying, Stock::Cylinder { base: [0.0, 0.0, 0.0], radius: 30.0, height: 100.0, along: 0 });
    }
}
