//! Which words a path block of Klartext takes. A word that its block does not use is refused by
//! name.
//!
//! After HEIDENHAIN, *TNC 640 Klartext programming*, "Programming contours": CC takes coordinates alone, a
//! direction DR belongs to circles about a pole or with a radius, PR and PA to polar paths, rapid traverse
//! FMAX to straight blocks.

use super::words::{Lead, OldWord, PathFunction, Plane, PlaneKind, Words};
use crate::codes;
use crate::diagnostic::{Fault, Span, twice};

/// Kind of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PathWord {
    Axis(usize),
    PolarRadius,
    PolarAngle,
    /// DR+, DR-
    Turn,
    Feed,
    /// FMAX
    Rapid,
    /// R0, RL, RR
    Side,
    Function,
}

fn takes(path: PathFunction, word: PathWord) -> bool {
    use PathWord::{Axis, Feed, Function, PolarAngle, PolarRadius, Rapid, Side, Turn};
    match path {
        PathFunction::Nothing => matches!(word, Side | Function | Feed | Rapid),
        PathFunction::Line | PathFunction::Normal => !matches!(word, PolarRadius | PolarAngle | Turn),
        // Feed and functions in a CC block get a message of their own.
        PathFunction::Pole => matches!(word, Axis(_) | Feed | Function),
        PathFunction::Arc | PathFunction::Radius => !matches!(word, PolarRadius | PolarAngle | Rapid),
        PathFunction::Tangent => !matches!(word, PolarRadius | PolarAngle | Turn | Rapid),
        PathFunction::PolarLine => word != Turn,
        PathFunction::PolarArc => word != Rapid,
        PathFunction::PolarTangent => !matches!(word, Turn | Rapid),
        PathFunction::Round | PathFunction::Chamfer => !matches!(word, PolarRadius | PolarAngle | Turn | Rapid),
        PathFunction::Approach(_) => word != Turn,
        PathFunction::Depart(Lead::LineCircle) => !matches!(word, Turn | Axis(3..)),
        PathFunction::Depart(_) => !matches!(word, Turn | Axis(3..) | PolarRadius | PolarAngle),
        PathFunction::Free(_) | PathFunction::FreePole => true,
    }
}

/// Refuses a word that the block does not use.
pub(super) fn check(path: PathFunction, word: PathWord, text: &str, span: Span) -> Result<(), Fault> {
    if takes(path, word) {
        return Ok(());
    }
    let text = text.trim();
    let block = name(path);
    let help = match word {
        PathWord::Rapid => "write a feed: only straight blocks run at FMAX",
        PathWord::Turn => "remove it: DR belongs to C, CR and CP",
        PathWord::PolarRadius | PathWord::PolarAngle => "write LP, CP or CTP for polar coordinates",
        PathWord::Axis(_) => "write L in front of the coordinates",
        PathWord::Side | PathWord::Feed | PathWord::Function => "write it in another block",
    };
    Err(Fault::new(codes::CONFLICT, span, format!("{block} does not take `{text}`")).help(help))
}

/// How a block of this kind begins.
fn name(path: PathFunction) -> &'static str {
    match path {
        PathFunction::Nothing => "a block without a path",
        PathFunction::Line => "L",
        PathFunction::Normal => "LN",
        PathFunction::Pole => "CC",
        PathFunction::Arc => "C",
        PathFunction::Radius => "CR",
        PathFunction::Tangent => "CT",
        PathFunction::PolarLine => "LP",
        PathFunction::PolarArc => "CP",
        PathFunction::PolarTangent => "CTP",
        PathFunction::Round => "RND",
        PathFunction::Chamfer => "CHF",
        PathFunction::Approach(_) => "APPR",
        PathFunction::Depart(_) => "DEP",
        PathFunction::Free(_) => "a free contour",
        PathFunction::FreePole => "FPOL",
    }
}

fn refuse(block: &str, word: &str, span: Span) -> Fault {
    Fault::new(codes::CONFLICT, span, format!("{block} does not take `{word}`")).help("write it in another block")
}

/// The first word of a block that is not an axis, a feed or a function.
fn extra(w: &Words) -> Option<&'static str> {
    if w.polar_radius.is_some() {
        return Some("PR");
    }
    if w.polar_angle.is_some() {
        return Some("PA");
    }
    if w.clockwise.is_some() {
        return Some("DR");
    }
    w.side.is_some().then_some("radius compensation")
}

fn functions(w: &Words) -> Option<&'static str> {
    (!w.functions.is_empty()).then_some("M")
}

fn feed(w: &Words) -> Option<&'static str> {
    w.feed.is_some().then_some("F")
}

fn axes(w: &Words, mask: u16) -> Option<&'static str> {
    const NAMES: [&str; 9] = ["X", "Y", "Z", "A", "B", "C", "U", "V", "W"];
    let found = w.programmed & mask;
    NAMES.get(found.trailing_zeros() as usize).filter(|_| found != 0).copied()
}

fn none_of(found: Option<&'static str>, block: &str, span: Span) -> Result<(), Fault> {
    found.map_or(Ok(()), |word| Err(refuse(block, word, span)))
}

/// TRANS DATUM: axes and nothing else.
pub(super) fn axes_alone(w: &Words, block: &str, span: Span) -> Result<(), Fault> {
    none_of(extra(w).or(feed(w)).or(functions(w)), block, span)
}

/// M functions that say how a position is meant, or that call a cycle themselves.
fn called_again(w: &Words) -> Option<&'static str> {
    let names = [(89, "M89"), (91, "M91"), (92, "M92"), (99, "M99")];
    names.into_iter().find(|(code, _)| w.has(*code)).map(|(_, name)| name)
}

/// CYCL CALL: M functions and nothing else.
pub(super) fn functions_alone(w: &Words, block: &str, span: Span) -> Result<(), Fault> {
    none_of(called_again(w), block, span)?;
    none_of(extra(w).or(feed(w)).or(axes(w, u16::MAX)), block, span)
}

/// CYCL CALL PAT: feed and M functions.
pub(super) fn feed_and_functions(w: &Words, block: &str, span: Span) -> Result<(), Fault> {
    none_of(called_again(w), block, span)?;
    none_of(extra(w).or(axes(w, u16::MAX)), block, span)
}

/// CYCL CALL POS: X, Y, Z, feed and M functions.
pub(super) fn point_and_feed(w: &Words, block: &str, span: Span) -> Result<(), Fault> {
    none_of(called_again(w), block, span)?;
    none_of(extra(w).or(axes(w, !0b111)), block, span)
}

/// An angle of PLANE that belongs to this form of it, once.
pub(super) fn plane_angle(plane: &Plane, name: &str, span: Span) -> Result<(), Fault> {
    let (form, own): (&str, &[&str]) = match plane.kind {
        PlaneKind::Spatial => ("SPATIAL", &["SPA", "SPB", "SPC"]),
        PlaneKind::Relative => ("RELATIVE", &["SPA", "SPB", "SPC"]),
        PlaneKind::Projected => ("PROJECTED", &["PROPR", "PROMIN", "ROT", "PROROT"]),
        PlaneKind::Euler => ("EULER", &["EULPR", "EULNU", "EULROT"]),
        PlaneKind::Vector => ("VECTOR", &["BX", "BY", "BZ", "NX", "NY", "NZ"]),
        PlaneKind::Points => ("POINTS", &["P1X", "P1Y", "P1Z", "P2X", "P2Y", "P2Z", "P3X", "P3Y", "P3Z"]),
        PlaneKind::Axial => ("AXIAL", &["A", "B", "C"]),
        PlaneKind::Reset => ("RESET", &[]),
    };
    if plane.angles.iter().any(|(other, _)| other == name) {
        return Err(twice(name, span));
    }
    if own.contains(&name) {
        return Ok(());
    }
    let help = if own.is_empty() {
        "remove it: PLANE RESET takes no angle".to_owned()
    } else {
        format!("write {}", own.join(", "))
    };
    Err(Fault::new(codes::CONFLICT, span, format!("PLANE {form} does not take `{name}`")).help(help))
}

/// Words without a value that belong to paths and planes.
const PATH_WORDS: [&str; 10] = ["DR+", "DR-", "FMAX", "FAUTO", "R0", "RL", "RR", "MOVE", "TURN", "STAY"];

/// Words that a cycle in the old form does not use. Words without a value are its texts, in the
/// language of the control.
pub(super) fn old_cycle(number: u32, words: &[(u32, OldWord)]) -> Result<(), Fault> {
    let unused = |word: &OldWord| {
        let name = if word.name.is_empty() { "the second value" } else { &word.name };
        Fault::new(codes::UNKNOWN_WORD, word.span, format!("CYCL DEF {number} has no use for `{name}`"))
            .help("remove it, or write the cycle as the control shows it")
    };
    // Parts of which each takes one value, by its place.
    let parts = match number {
        9 | 11 | 247 => 1,
        1 => 5,
        2 => 4,
        17 => 3,
        4 => 6,
        5 => 5,
        _ => 0,
    };
    let mut seen = [false; 8];
    let mut named: Vec<&str> = Vec::new();
    for (part, word) in words {
        // Words of paths are not texts of a cycle.
        let of_path = word.value.is_none() && PATH_WORDS.contains(&word.name.as_str());
        let own = match number {
            _ if of_path && number != 19 && !(matches!(number, 4 | 5) && word.name.starts_with("DR")) => false,
            7 if words.iter().any(|(_, w)| w.name == "#") => word.name == "#" && words.len() == 1,
            8 => word.value.is_none(),
            10 => matches!(word.name.as_str(), "ROT" | "IROT"),
            4 | 5 if word.name.starts_with("DR") => *part == parts,
            4 | 5 if word.name == "F" => *part == 3 || *part == parts,
            4 if *part == 4 || *part == 5 => word.name == if *part == 4 { "X" } else { "Y" },
            4 if *part == 6 => matches!(word.name.as_str(), "R" | "RADIUS"),
            5 if *part == 5 => false,
            _ => true,
        };
        let placed = parts > 0 && word.value.is_some() && !(matches!(number, 4 | 5) && word.name == "F");
        let again = placed && seen.get_mut(*part as usize).is_none_or(|seen| std::mem::replace(seen, true));
        let twice_named = !word.name.is_empty() && word.value.is_some() && matches!(number, 7 | 10 | 19 | 26 | 32) && {
            let before = named.contains(&word.name.as_str());
            named.push(&word.name);
            before
        };
        if !own || again || *part > parts && placed || twice_named {
            return Err(unused(word));
        }
    }
    Ok(())
}
