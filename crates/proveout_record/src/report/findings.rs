//! Findings as the page shows them: grouped by code and cause, errors first, with what to do about each.

use std::collections::BTreeMap;

use proveout_sim::{
    finding::{self, CODES, Code, Family, Finding, INSPECTION, NEAR_MISS, OVERTRAVEL, Severity},
    listing::Listing,
};
use serde::Serialize;

use crate::contact::ContactPicture;
use crate::report::format::{compact, count, duration, file_name, fixed, length};

/// Rows of one cause that are shown; all are in `verdict.json`.
const ROWS: usize = 200;
/// Causes of one code that are shown.
const CAUSES: usize = 60;
/// Lines that a row of equal notes names.
const LINES: usize = 12;
/// Marks on the part: more hide it.
const MARKS: usize = 150;

/// What a run knows about a finding in addition to the finding itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct FindingContext {
    /// The tool in the spindle.
    pub(crate) tool: String,
    /// Where the limit comes from, and whether it is published or chosen.
    pub(crate) basis: String,
    /// Number of its line among those of all files; 0 where it has none.
    pub(crate) line: u32,
}

/// Everything of one code.
#[derive(Serialize)]
pub(crate) struct FindingGroup {
    class: &'static str,
    severity: &'static str,
    code: String,
    summary: String,
    remedy: &'static str,
    count: String,
    /// Notes are rows of one table.
    rows: Vec<FindingRow>,
    causes: Vec<Cause>,
    left_out: String,
}

/// Findings of one cause: one code, the same bodies and tool, or the same words where no body is named.
#[derive(Serialize)]
struct Cause {
    /// Of the worst finding.
    id: String,
    title: String,
    count: String,
    lines: String,
    value: String,
    limit: String,
    basis: String,
    tool: String,
    message: String,
    more: String,
    time: String,
    /// Time on the timeline of the recording, s.
    recorded: String,
    axes: String,
    marked: bool,
    line: u32,
    /// Whether a picture is there, by its number.
    picture: Option<usize>,
    program: Vec<ProgramLine>,
    file: String,
    /// All findings of it, when they are more than one.
    rows: Vec<FindingRow>,
    left_out: String,
}

#[derive(Serialize)]
struct ProgramLine {
    number: u32,
    text: String,
    here: bool,
}

#[derive(Serialize)]
struct FindingRow {
    id: String,
    number: usize,
    marked: bool,
    line: u32,
    place: String,
    file: String,
    time: String,
    message: String,
    more: String,
    value: String,
    limit: String,
    axes: String,
}

#[derive(Serialize)]
pub(crate) struct FindingMark {
    id: String,
    label: String,
    title: String,
    severity: &'static str,
    point: [f64; 3],
}

/// What the groups are made from.
pub(crate) struct FindingData<'a> {
    pub(crate) findings: &'a [Finding],
    /// As many as findings, or none.
    pub(crate) explained: &'a [FindingContext],
    /// Order of the axes in a row.
    pub(crate) joints: &'a [&'a str],
    pub(crate) listings: &'a [Listing],
    pub(crate) contacts: &'a [ContactPicture],
}

pub(crate) fn class(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Info => "info",
    }
}

pub(crate) fn id(index: usize) -> String {
    format!("finding-{}", index + 1)
}

/// What a depth is counted from, in words: holder, neck and shank are more often at the side of material
/// than above it.
fn deep(code: &str) -> &'static str {
    let aside = [finding::HOLDER_IN_STOCK, finding::NECK_RUBS, finding::SHANK_RUBS];
    if aside.iter().any(|c| c.code == code) { "from the free surface" } else { "deep" }
}

/// What a machinist or programmer can do about a code.
const REMEDIES: [(Code, &str); 28] = [
    (finding::STOPPED, "Correct the named block; nothing after it was run."),
    (finding::TEXT_LOST, "Remove the end word if the program goes on, or remove the text after it."),
    (finding::TEXT_UNPROVEN, "Give each main program a file of its own, and prove each of them."),
    (finding::TEXT_SKIPPED, "Run the program with the other values too, or remove the text."),
    (
        finding::LONG_DWELL,
        "Write the dwell in the unit of the control, or state the unit as `dwell` of the control file.",
    ),
    (
        OVERTRAVEL,
        "`proveout check` of the scene shows the cause, and whether another mounting brings the axis back into its travel.",
    ),
    (finding::UNREACHABLE, "The rotary axes cannot take this tilt: lower it or set the part up at another angle."),
    (
        finding::OFF_CIRCLE,
        "Name the tool axis instead of the rotary axes, split the block, or turn the part so that its tilts stay in reach.",
    ),
    (
        finding::POLE_CROSSED,
        "Nothing, where the angle is below what the surface allows; otherwise a smaller cone, or a tilt that keeps away from the pole.",
    ),
    (
        finding::DRIVE_SATURATED,
        "Lower the acceleration or jerk of the joint or the feed of the block, or correct force limit, masses and friction of its drive.",
    ),
    (
        finding::PLANNED_MOTION,
        "A defect of the control's plan: report it with program and machine. A lower feed or an exact stop leads around it.",
    ),
    (finding::SPINDLE_SPEED, "Lower the programmed speed, or use a tool or spindle that allows it."),
    (finding::RAPID_IN_MATERIAL, "Move in feed here, or raise the retract plane above the stock at this block."),
    (finding::SPINDLE_OFF, "Start the spindle before the tool reaches the material."),
    (
        finding::SPINDLE_WRONG_WAY,
        "Turn the spindle the way the tool cuts (M3 for right-handed, M4 for left-handed tools).",
    ),
    (finding::NO_TOOL, "Call a tool before this block."),
    (
        finding::NECK_RUBS,
        "Cut less deep in one pass, use a tool with longer flutes or relieved neck, or tilt the tool away from the wall.",
    ),
    (
        finding::SHANK_RUBS,
        "Cut less deep in one pass, use a tool with longer flutes or relieved neck, or tilt the tool away from the wall.",
    ),
    (
        finding::HOLDER_IN_STOCK,
        "Run again with --find-stickout: it finds the least length that clears, where one does. Or cut less deep, or tilt the tool away from the wall.",
    ),
    (
        finding::COLLISION,
        "Change the depth or the way of this block at the place named here, or the fixture there; where the finding names the mounting, that too.",
    ),
    (NEAR_MISS, "Check the real clamping here before the first part."),
    (finding::OVERCUT, "Use a smaller tool for this part of the contour, or leave the narrow place out."),
    (finding::CONTOUR_TOUCHED, "Begin and end one tool radius away from the contour, or lead in and out on arcs."),
    (finding::GOUGE, "Check cutter compensation, tool length and radius, and the path at the marked point."),
    (finding::EXCESS, "Finish the marked area with another pass or a smaller tool."),
    (finding::FILM, "Nothing fails for it; let the passes overlap if they meet edge to edge."),
    (finding::THREAD, "None is needed: the design has the holes before their threads."),
    (INSPECTION, "Compare the block that made the feature with the drawing."),
];

/// What a machinist or programmer can do about a code; empty where nothing is to be done.
fn remedy(code: &str) -> &'static str {
    REMEDIES.iter().find(|(own, _)| own.code == code).map_or("", |(_, text)| text)
}

/// Groups by code: errors, then warnings, then notes; within a weight in order of first time, near misses
/// last, since all that hits comes near before. Within a code one entry a cause.
pub(crate) fn groups(told: &FindingData<'_>) -> Vec<FindingGroup> {
    let findings = told.findings;
    let marked: Vec<String> = marks(findings).into_iter().map(|m| m.id).collect();
    let mut by_code: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (i, f) in findings.iter().enumerate() {
        by_code.entry(&f.code).or_default().push(i);
    }
    let mut order: Vec<(&str, Vec<usize>)> = by_code.into_iter().collect();
    order.sort_by_key(|(code, list)| (std::cmp::Reverse(findings[list[0]].severity), *code == NEAR_MISS.code, list[0]));
    let group = |(code, list): (&str, Vec<usize>)| {
        let severity = findings[list[0]].severity;
        let summary = CODES.iter().find(|c| c.code == code).map_or(code, |c| c.summary.trim_end_matches('.'));
        let notes = severity == Severity::Info;
        let mut rows = if notes { joined(&list, findings) } else { Vec::new() };
        let mut causes = if notes { Vec::new() } else { causes(&list, told, &marked) };
        let more = rows.len().saturating_sub(ROWS) + causes.len().saturating_sub(CAUSES);
        rows.truncate(ROWS);
        causes.truncate(CAUSES);
        FindingGroup {
            class: class(severity),
            severity: match severity {
                Severity::Error => "Error",
                Severity::Warning => "Warning",
                Severity::Info => "Note",
            },
            code: code.into(),
            summary: summary.into(),
            remedy: remedy(code),
            count: places(&list, findings),
            left_out: if more > 0 {
                format!("{} more are in verdict.json.", count(more as u64))
            } else {
                String::new()
            },
            rows,
            causes,
        }
    };
    order.into_iter().map(group).collect()
}

/// The number of places, and the number of blocks where one finding covers several.
fn places(list: &[usize], findings: &[Finding]) -> String {
    let repeats: u64 = list.iter().map(|&i| u64::from(findings[i].repeats)).sum();
    let places = count(list.len() as u64) + if list.len() == 1 { " place" } else { " places" };
    if repeats > 0 { format!("{places}, {} blocks", count(list.len() as u64 + repeats)) } else { places }
}

/// Bodies or words of a cause, and its tool.
type Key<'a> = (Vec<&'a str>, &'a str);

/// The findings of a code by cause, in order of their first ones.
fn causes(list: &[usize], told: &FindingData<'_>, marked: &[String]) -> Vec<Cause> {
    let mut all: Vec<(Key<'_>, Vec<usize>)> = Vec::new();
    for &i in list {
        let f = &told.findings[i];
        let tool = told.explained.get(i).map_or("", |e| e.tool.as_str());
        let of_part = of_part(f);
        let key = match f.bodies.as_slice() {
            [] if of_part => Vec::new(),
            [] => vec![f.message.as_str()],
            bodies => bodies.iter().map(String::as_str).collect(),
        };
        let key = (key, if of_part { "" } else { tool });
        match all.iter_mut().find(|(known, _)| *known == key) {
            Some((_, members)) => members.push(i),
            None => all.push((key, vec![i])),
        }
    }
    all.into_iter().map(|(_, members)| cause(&members, told, marked)).collect()
}

/// A gouge or an excess is a place of the part and names no body: all of them are one cause.
fn of_part(f: &Finding) -> bool {
    f.family == Family::Geometry && f.point_mm.is_some() && f.code != INSPECTION.code
}

/// How bad a finding is among those of its cause.
fn badness(f: &Finding) -> f64 {
    let past = f.value.zip(f.limit).map(|(v, l)| (v - l).abs());
    f.penetration_mm.or(f.clearance_mm.map(|c| -c)).or(past).or(f.value.map(f64::abs)).unwrap_or(0.0)
}

fn cause(members: &[usize], told: &FindingData<'_>, marked: &[String]) -> Cause {
    let findings = told.findings;
    let worst =
        members.iter().copied().reduce(|a, b| if badness(&findings[b]) > badness(&findings[a]) { b } else { a });
    let worst = worst.unwrap_or(0);
    let f = &findings[worst];
    let is_marked = |i: usize| marked.contains(&id(i));
    let line_of = |i: usize| told.explained.get(i).map_or(0, |e| e.line);
    let of_row = |i: usize| FindingRow { line: line_of(i), ..row(i, &findings[i], is_marked(i), told.joints) };
    let shown = of_row(worst);
    let explained = told.explained.get(worst).cloned().unwrap_or_default();
    let mut lines: Vec<u32> = members.iter().filter_map(|&i| findings[i].line).collect();
    lines.sort_unstable();
    let lines = match (lines.first(), lines.last()) {
        (Some(a), Some(b)) if a == b => format!("line {a}"),
        (Some(a), Some(b)) => format!("lines {a} to {b}"),
        _ => String::new(),
    };
    let title = match f.bodies.as_slice() {
        [] if of_part(f) => "On the part".into(),
        [] => f.message.clone(),
        bodies => bodies.join(" and "),
    };
    let of_picture = |p: &ContactPicture| p.code == f.code && p.bodies.as_slice() == f.bodies.as_slice();
    let mut rows: Vec<FindingRow> =
        if members.len() > 1 { members.iter().map(|&i| of_row(i)).collect() } else { Vec::new() };
    let left = rows.len().saturating_sub(ROWS);
    rows.truncate(ROWS);
    Cause {
        id: shown.id,
        title,
        count: places(members, findings),
        lines,
        value: shown.value,
        limit: shown.limit,
        basis: explained.basis,
        tool: explained.tool,
        message: shown.message,
        more: shown.more,
        time: shown.time,
        recorded: f.time_s.map_or_else(String::new, |t| fixed(t, 3)),
        axes: shown.axes,
        marked: shown.marked,
        line: shown.line,
        picture: told.contacts.iter().position(of_picture),
        program: program_lines(f, told.listings),
        file: shown.file,
        rows,
        left_out: if left > 0 { format!("{} more are in verdict.json.", count(left as u64)) } else { String::new() },
    }
}

/// The line of a finding with the one before and the one after it.
fn program_lines(f: &Finding, listings: &[Listing]) -> Vec<ProgramLine> {
    let Some((line, listing)) = f.line.zip(listings.iter().find(|l| Some(&l.file) == f.file.as_ref())) else {
        return Vec::new();
    };
    let near = listing.shown.iter().filter(|(n, _)| n.abs_diff(line) <= 1);
    near.map(|(n, text)| ProgramLine { number: *n, text: text.clone(), here: *n == line }).collect()
}

/// Notes with the same text in one row with all their lines.
fn joined(list: &[usize], findings: &[Finding]) -> Vec<FindingRow> {
    let mut texts: Vec<(&Finding, usize, Vec<u32>)> = Vec::new();
    for &i in list {
        let f = &findings[i];
        let lines = f.line.iter().copied();
        match texts.iter_mut().find(|(first, ..)| first.message == f.message && first.file == f.file) {
            Some((_, _, all)) => all.extend(lines),
            None => texts.push((f, i, lines.collect())),
        }
    }
    let row_of = |(f, index, lines): (&Finding, usize, Vec<u32>)| {
        let list: Vec<String> = lines.iter().take(LINES).map(ToString::to_string).collect();
        let more = if lines.len() > LINES { format!(" and {} more", lines.len() - LINES) } else { String::new() };
        let place = match lines.len() {
            0 => String::new(),
            1 => format!("line {}", list[0]),
            _ => format!("lines {}{more}", list.join(", ")),
        };
        let alone = Finding { axes: BTreeMap::new(), repeats: 0, ..f.clone() };
        let time = if lines.len() > 1 { "from ".to_owned() } else { String::new() };
        let base = row(index, &alone, false, &[]);
        FindingRow { place, time: format!("{time}{}", base.time), ..base }
    };
    texts.into_iter().map(row_of).collect()
}

fn row(index: usize, f: &Finding, marked: bool, joints: &[&str]) -> FindingRow {
    let place = match (f.line, f.block) {
        (Some(line), _) => format!("line {line}"),
        (None, Some(block)) => format!("block {block}"),
        (None, None) => String::new(),
    };
    let unit = f.unit.as_deref().unwrap_or("");
    let with_unit = |v: f64| match unit {
        "mm" => length(v),
        "deg" => format!("{}°", compact(v)),
        _ => format!("{} {unit}", compact(v)).trim_end().to_owned(),
    };
    // Of a travel that is left, how far says more than where.
    let past = f.value.zip(f.limit).filter(|_| f.code == OVERTRAVEL.code);
    let value = past
        .map(|(value, limit)| format!("{} past", with_unit((value - limit).abs())))
        .or_else(|| f.value.map(with_unit))
        .or_else(|| f.penetration_mm.map(|p| format!("{} {}", length(p), deep(&f.code))))
        .or_else(|| f.clearance_mm.map(|c| format!("{} apart", length(c))));
    let mut axes: Vec<(&String, &f64)> = f.axes.iter().collect();
    axes.sort_by_key(|(name, _)| joints.iter().position(|j| j == name).unwrap_or(usize::MAX));
    // A no-break space keeps letter and value together.
    let axes: Vec<String> = axes.iter().map(|(name, v)| format!("{name}\u{a0}{}", fixed(**v, 3))).collect();
    FindingRow {
        id: id(index),
        number: index + 1,
        marked,
        line: 0,
        place,
        file: f.file.as_deref().map_or_else(String::new, |n| file_name(n).to_owned()),
        time: f.time_s.map_or_else(String::new, duration),
        message: f.message.clone(),
        more: match f.repeats {
            0 => String::new(),
            1 => "(and in the block after it)".into(),
            n => format!("(and in {} blocks after it)", count(u64::from(n))),
        },
        value: value.unwrap_or_default(),
        limit: f.limit.map_or_else(String::new, with_unit),
        axes: axes.join(" "),
    }
}

/// Errors and warnings with a place on the workpiece, errors first, as marks on the 3D view.
pub(crate) fn marks(findings: &[Finding]) -> Vec<FindingMark> {
    let mut list: Vec<(usize, [f64; 3])> = findings
        .iter()
        .enumerate()
        .filter(|(_, f)| f.severity != Severity::Info)
        .filter_map(|(i, f)| f.point_mm.filter(|p| p.iter().all(|v| v.is_finite())).map(|p| (i, p)))
        .collect();
    list.sort_by_key(|(i, _)| (std::cmp::Reverse(findings[*i].severity), *i));
    list.into_iter()
        .take(MARKS)
        .map(|(i, point)| FindingMark {
            id: id(i),
            label: (i + 1).to_string(),
            title: findings[i].message.clone(),
            severity: class(findings[i].severity),
            point,
        })
        .collect()
}
