//! Tools in comments and names of programs; statements are in [`super::tool_statements`].
//!
//! | who writes it | form |
//! |---|---|
//! | Fusion 360, HSMWorks | `T1 D=10. CR=0.5 TAPER=45deg - ZMIN=-5. - flat end mill` |
//! | Fusion 360 for a TNC | `#5 D=8 TAPER=118deg - ZMIN=-24.4 - drill` |
//! | `PowerMill`, NX | `TOOL NO: 2`, `TOOL TYPE: BALLNOSED`, `TOOL DIA. 8.0` in consecutive comments |
//! | `PowerMill` | `Tool: EM12 Type: Endmill Dia: 12.000 Rad: 0.0`, before the call of the tool |
//! | Mastercam | `T1 \| 1/2 FLAT ENDMILL \| H1 \| D1 \| TOOL DIA. - .5` |
//! | Mastercam | `1/2 BALL ENDMILL TOOL - 3 DIA. OFF. - 3 LEN. - 3 DIA. - .5` |
//! | SolidCAM and others | `T5 - END MILL D12 R1`, `TOOL 5: BALL DIA 8.0` |
//! | name of a tool | `END_D12`, `BALL_D8`, `BULL_D10_R1` |
//! | after the call | `(12MM)`, `(0.6 INCH)`, `(D10)` |
//! | Vectric | `2 = V-Bit {90 deg 0.5"}` |
//! | names of sizes | `NO. 7 DRILL`, `F DRILL`, `10-32 TAP` |
//!
//! A diameter is taken where a word says that it is one, or where it is the only number in the
//! comment of a tool. TAPER of Fusion is the half angle of a chamfer mill and the full angle of a
//! drill. A length counts in the unit written after it, else in that of the program.

use proveout_tool::{SubstituteBody, ToolDraft, tool_center_cutting_of_words, tool_kind_of_words, tool_teeth_of_words};

use super::tool_sizes::{Named, drill_by_name, thread_by_number, with_points};
use crate::prepare::program_trace::SAME_MM;

/// A corner may be larger than the radius of its tool by this, mm: rounding of inches.
const ROUNDING_MM: f64 = 1e-9;

/// Signed number after a letter or word: `X+10`, `D=10.5`, `DIA 8`.
fn number_at(text: &str) -> Option<f64> {
    number_and_rest(text).map(|(number, _)| number)
}

/// A length, mm. A unit after the number overrides the unit of the program: `6MM` in inches, `1/2"`
/// in millimeters. A fraction is in inches, as millimeters are not written so.
fn length_at(text: &str, unit: f64) -> Option<f64> {
    let (number, rest) = number_and_rest(text)?;
    let fraction = text[..text.len() - rest.len()].contains('/');
    let rest = rest.trim_start();
    let whole_word = |word: &str| rest.strip_prefix(word).is_some_and(|r| !r.starts_with(char::is_alphabetic));
    let mm = if whole_word("MM") {
        1.0
    } else if fraction || rest.starts_with('"') || whole_word("IN") || whole_word("INCH") {
        25.4
    } else {
        unit
    };
    Some(number * mm)
}

/// A signed number, and the text after it.
fn number_and_rest(text: &str) -> Option<(f64, &str)> {
    let text = text.trim_start_matches([' ', '=', ':']);
    // `DIA. - .5` has a dash that is no sign.
    let text = text.strip_prefix("- ").map_or(text, str::trim_start);
    let end = text
        .char_indices()
        .find(|(i, c)| !(c.is_ascii_digit() || *c == '.' || *i == 0 && matches!(c, '+' | '-')))
        .map_or(text.len(), |(i, _)| i);
    let number = text[..end].parse::<f64>().ok().filter(|v| v.is_finite())?;
    // `1/2`.
    let Some(rest) = text[end..].strip_prefix('/') else { return Some((number, &text[end..])) };
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    rest[..end].parse::<f64>().ok().filter(|d| *d > 0.0).map(|d| (number / d, &rest[end..]))
}

/// Number after a single letter that is a word of its own: `X+10` in `X+10 Y+5`.
pub(super) fn letter(text: &str, letter: char) -> Option<f64> {
    behind_letter(text, letter).and_then(number_at)
}

fn behind_letter(text: &str, letter: char) -> Option<&str> {
    text.match_indices(letter).find_map(|(at, _)| {
        let alone = !text[..at].chars().next_back().is_some_and(|c| c.is_alphanumeric());
        let next = text[at + letter.len_utf8()..].trim_start_matches('=').chars().next()?;
        let number = alone && (next.is_ascii_digit() || matches!(next, '+' | '-' | '.'));
        let rest = &text[at + letter.len_utf8()..];
        (number && number_at(rest).is_some()).then_some(rest)
    })
}

/// Number after one of the words.
fn word(text: &str, words: &[&str]) -> Option<f64> {
    behind_word(text, words).and_then(number_at)
}

fn behind_word<'a>(text: &'a str, words: &[&str]) -> Option<&'a str> {
    words.iter().find_map(|w| {
        text.match_indices(w).find_map(|(at, _)| {
            let alone = !text[..at].chars().next_back().is_some_and(char::is_alphanumeric);
            let rest = &text[at + w.len()..];
            (alone && number_at(rest).is_some()).then_some(rest)
        })
    })
}

/// Number of the tool that a comment begins with: `T1`, `TOOL 5`, `TOOL - 3`, `TOOL NO. 4`.
fn tool_number(text: &str) -> Option<(u32, usize)> {
    let digits = |from: usize| {
        let rest = &text[from..];
        let skip = rest.find(|c: char| !matches!(c, ' ' | '-' | '#' | '=' | ':' | '.')).unwrap_or(rest.len());
        let body = &rest[skip..];
        let end = body.find(|c: char| !c.is_ascii_digit()).unwrap_or(body.len());
        // `T1.5`, `T1/2` and `TOOL 12MM` are no tools.
        let after = &body[end..];
        // `TOOL: 10EM` has a name.
        let named = end > 0 && after.starts_with(char::is_alphabetic) && text.contains("DIA");
        let size = named || after.starts_with(['/', '.', '"']) && !after.starts_with(". ") || {
            let word: String = after.trim_start().chars().take_while(|c| c.is_alphabetic()).collect();
            matches!(word.as_str(), "MM" | "INCH") || word == "IN" && after.starts_with("IN")
        };
        (!size).then(|| body[..end].parse().ok())?.map(|n| (n, from + skip + end))
    };
    let start = text.len() - text.trim_start().len();
    let head = &text[start..];
    // `#5 D=8 - ZMIN=-24.4 - drill`.
    if head.starts_with('#') && head.contains(" D=") {
        return digits(start + 1);
    }
    for word in HEADS {
        if head.starts_with(word)
            && let Some(found) = digits(start + word.len())
        {
            return Some(found);
        }
    }
    // `2 = V-BIT {90 DEG}`.
    let end = head.find(|c: char| !c.is_ascii_digit()).unwrap_or(head.len());
    if head[end..].trim_start().starts_with('=')
        && let Ok(number) = head[..end].parse()
    {
        return Some((number, start + end));
    }
    // `OPER: 2  TOOL: 4  0.25 DIA`, `1/2 FLAT ENDMILL TOOL - 3`.
    ["TOOL - ", "TOOL: ", "TOOL #", "TOOL NO"].iter().find_map(|word| {
        let at = text.find(word)?;
        let alone = !text[..at].chars().next_back().is_some_and(char::is_alphanumeric);
        let length = if *word == "TOOL NO" { word.len() } else { "TOOL".len() };
        alone.then(|| digits(at + length))?
    })
}

/// Words before the number of a tool at the beginning of a comment, the longer ones first.
const HEADS: [&str; 13] = [
    "TOOL NUMBER",
    "TOOL NO.",
    "TOOL NO",
    "TOOL",
    "WERKZEUG-NR",
    "WERKZEUG NR",
    "WERKZEUG",
    "WKZ",
    "WZ",
    "OUTIL",
    "UTENSILE",
    "HERRAMIENTA",
    "T",
];

/// A draft from words: kind, teeth, diameter, corner radius.
fn described(text: &str, upper: &str, unit: f64, source: String) -> Option<ToolDraft> {
    let kind = tool_kind_of_words(text);
    let told = before_dia(upper, unit).or_else(|| {
        behind_word(upper, &["D=", "DIA.", "DIAMETER", "DIAM.", "DIAM", "DIA", "TOOL DIA. -", "\u{d8}", "FI"])
            .or_else(|| behind_letter(upper, 'D'))
            .and_then(|rest| length_at(rest, unit))
    });
    let threads = kind.and_then(|(_, substitute)| substitute).is_some_and(SubstituteBody::cuts_threads);
    let diameter = told.or_else(|| kind.and_then(|(kind, _)| size_in_words(upper, unit, kind, threads)));
    let diameter = diameter.filter(|d| *d > 0.0)?;
    let mut draft = ToolDraft::new(0, source);
    draft.description = text.trim().to_owned();
    draft.flutes = tool_teeth_of_words(text);
    draft.center_cutting = tool_center_cutting_of_words(text);
    let corner = behind_word(
        upper,
        &[
            "CR=",
            "RAD=",
            "TIP RADIUS",
            "TIP RAD",
            "TIPRAD",
            "CORNER RAD.",
            "CORNER RADIUS",
            "CR.",
            "CR",
            "RAD",
            "RADIUS",
        ],
    )
    .or_else(|| behind_letter(upper, 'R'))
    .and_then(|rest| length_at(rest, unit))
    .filter(|r| *r > 0.0 && *r <= 0.5 * diameter + ROUNDING_MM);
    let taper = word(upper, &["TAPER=", "ANGLE=", "POINT ANGLE", "ANGLE"]).filter(|a| *a > 0.0 && *a < 180.0);
    draft.put("diameter_mm", diameter);
    match kind {
        Some(("bull_nose", _)) => match corner {
            Some(r) if r > 0.5 * diameter - SAME_MM => draft.kind = Some("ball"),
            Some(r) => {
                draft.kind = Some("bull_nose");
                draft.put("corner_radius_mm", r);
            }
            None => draft.kind = None,
        },
        Some(("flat", None)) if corner.is_some_and(|r| r > 0.5 * diameter - SAME_MM) => draft.kind = Some("ball"),
        Some(("flat", None)) if corner.is_some() => {
            draft.kind = Some("bull_nose");
            draft.put("corner_radius_mm", corner.unwrap_or(0.0));
        }
        Some(("drill", _)) => {
            draft.kind = Some("drill");
            if let Some(angle) = taper {
                draft.put("point_angle_deg", angle);
            }
        }
        Some(("chamfer", _)) => {
            draft.kind = Some("chamfer");
            let lower = text.to_lowercase();
            // Half angle of a chamfer mill, full angle of what drills.
            let full = lower.contains("drill") || lower.contains("anbohr") || lower.contains("zentrier");
            let size = taper.or_else(|| upper.contains("90").then_some(if full { 90.0 } else { 45.0 }));
            let angle = size.map(|a| if full || a > 89.0 { a } else { 2.0 * a });
            // `60 DEG` of an engraver or a countersink is the full point angle; 45 may be either
            // the half or the full one.
            let angle = angle.or_else(|| degrees(upper).filter(|a| (60.0..=150.0).contains(a)));
            draft.put("point_angle_deg", angle.unwrap_or(90.0));
            if angle.is_none() {
                draft.choose(&["point_angle_deg"], "not stated: a usual one");
            }
            draft.put("tip_diameter_mm", 0.0);
            draft.choose(&["tip_diameter_mm"], "not stated: a sharp tip");
        }
        Some(("face_mill", _)) => {
            draft.kind = Some("face_mill");
            draft.put("corner_radius_mm", corner.unwrap_or(0.0));
            let angle = taper.filter(|a| *a < 90.0).map_or(90.0, |a| 90.0 - a);
            draft.put("entering_angle_deg", angle);
            if taper.is_none() {
                draft.choose(
                    &["entering_angle_deg"],
                    "not stated: a square shoulder, the largest body of this diameter",
                );
            }
        }
        Some(("tap", why)) => draft.become_tap(text, None, why.map_or("", SubstituteBody::reason)),
        Some((kind @ ("ball" | "flat"), why)) => {
            draft.kind = Some(kind);
            if let Some(why) = why {
                draft.stand_in(why);
            }
        }
        // A shape that the words do not describe: a taper ball without its angle, a lollipop without its
        // neck.
        Some((_, _)) | None => {
            draft.kind = match corner {
                Some(r) if r > 0.5 * diameter - SAME_MM => Some("ball"),
                Some(r) => {
                    draft.put("corner_radius_mm", r);
                    Some("bull_nose")
                }
                None => None,
            };
        }
    }
    Some(draft)
}

/// A lone number is a diameter up to this, mm; a larger one means something else.
const LARGEST_ALONE: f64 = 100.0;
/// The same for face mills.
const LARGEST_FACE: f64 = 400.0;
/// How far a size next to the name of a drill may be from what the name says.
const SAME_DRILL: f64 = 0.2;

/// A diameter that no word calls one, mm: a lone size, or the name of a size.
fn size_in_words(upper: &str, unit: f64, kind: &str, threads: bool) -> Option<f64> {
    if threads && let Some(d) = thread_by_number(upper) {
        return Some(d);
    }
    let named = match kind {
        "drill" => drill_by_name(upper, Named::Drill),
        "chamfer" if upper.contains("CENTER DR") || upper.contains("CENTRE DR") => {
            drill_by_name(upper, Named::CenterDrill)
        }
        _ => None,
    };
    let largest = if kind == "face_mill" { LARGEST_FACE } else { LARGEST_ALONE };
    if let Some((by_name, rest)) = named {
        // `#7 DRILL .201` says it twice.
        let beside = lone_size(&rest, unit, false).filter(|d| (d / by_name - 1.0).abs() < SAME_DRILL);
        return beside.or(Some(by_name));
    }
    lone_size(upper, unit, threads).filter(|d| *d <= largest)
}

/// `0.375 DIA 4FL`: the number before, mm, where no value of the diameter follows (`DIA. - .25`,
/// `DIA=8`).
fn before_dia(upper: &str, unit: f64) -> Option<f64> {
    upper.match_indices("DIA").find_map(|(at, _)| {
        let rest = upper[at + "DIA".len()..].trim_start_matches("METER");
        let value_follows =
            rest.starts_with(|c: char| c.is_alphanumeric()) || rest.trim_start().starts_with(['.', '=', ':', '-']);
        let before = upper[..at].trim_end();
        let number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '/');
        let digits = before.trim_end_matches("MM").trim_end_matches('"').trim_end();
        let from = digits.trim_end_matches(number).len();
        let alone = from < digits.len() && !digits[..from].ends_with(|c: char| c.is_alphanumeric() || c == '-');
        (!value_follows && alone && upper[..at].ends_with(' ')).then(|| length_at(&before[from..], unit))?
    })
}

/// Words of a comment, without the separators.
fn words(upper: &str) -> Vec<&str> {
    let between = |c: char| c.is_whitespace() || matches!(c, '|' | ',' | '-' | '_' | ';' | '(' | ')' | '{' | '}' | '=');
    upper.split(between).filter(|w| !w.is_empty()).collect()
}

/// Degrees: `90 DEG`, `90-DEG`, `60ST`.
fn degrees(upper: &str) -> Option<f64> {
    let words = words(upper);
    (0..words.len()).find_map(|i| {
        let (number, rest) = number_and_rest(words[i])?;
        let word = if rest.is_empty() { words.get(i + 1).copied().unwrap_or_default() } else { rest };
        is_degrees(word).then_some(number)
    })
}

fn is_degrees(word: &str) -> bool {
    word.starts_with("DEG") || word.starts_with('\u{b0}') || matches!(word, "ST" | "ST." | "GRAD")
}

/// A lone size, mm: `1/2 FLAT ENDMILL`, `10.5 DRILL`, `6MM BALL`, `5 MM DRILL`, `M6X1 TAP`. Teeth
/// and degrees are none.
fn lone_size(upper: &str, unit: f64, threads: bool) -> Option<f64> {
    let mut rest = upper;
    if let Some((_, end)) = tool_number(upper) {
        rest = &upper[end..];
    }
    let words = words(rest);
    (0..words.len()).find_map(|i| {
        let (word, next) = (words[i], words.get(i + 1).copied().unwrap_or_default());
        // A metric thread gives its diameter in millimeters, whatever the program counts in.
        if let Some(thread) = word.strip_prefix('M').filter(|t| threads && t.starts_with(|c: char| c.is_ascii_digit()))
        {
            let end = thread.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(thread.len());
            let pitch = thread[end..].strip_prefix('X').is_some_and(|p| p.parse::<f64>().is_ok());
            return (end == thread.len() || pitch).then(|| thread[..end].parse().ok())?;
        }
        let plain = word.trim_end_matches("MM").trim_end_matches('"').trim_end_matches("IN");
        let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '/');
        let whole = plain.chars().all(digits) && plain.chars().any(|c| c.is_ascii_digit());
        let counted = ["FL", "FLT", "FLUTE", "FLUTES", "TEETH", "TOOTH", "Z"].contains(&next) || is_degrees(next);
        let size = whole && (plain.len() < word.len() || !counted);
        let spelled = if plain.len() == word.len() && matches!(next, "MM" | "IN" | "INCH" | "\"") {
            format!("{word}{next}")
        } else {
            word.to_owned()
        };
        size.then(|| length_at(&spelled, unit))?
    })
}

/// The tool of a comment, with its number where it has one.
pub(super) fn of_comment(text: &str, unit: f64, line: usize) -> Option<(Option<u32>, ToolDraft)> {
    let upper = with_points(&text.to_uppercase());
    let number = tool_number(&upper);
    // Without a number only what is named a tool by its words.
    if number.is_none() && tool_kind_of_words(text).is_none() && !names_with_diameter(&upper) {
        return None;
    }
    let body = number.map_or(upper.as_str(), |(_, end)| &upper[end..]);
    // Mastercam names offsets between: `DIA. OFF. - 3 LEN. - 3 DIA. - .5`.
    let cleaned = body.replace("DIA. OFF.", "").replace("LEN. -", "");
    let mut draft = described(text, &cleaned, unit, format!("comment in line {line}")).or_else(|| {
        described(text, &upper.replace("DIA. OFF.", "").replace("LEN. -", ""), unit, format!("comment in line {line}"))
    })?;
    if let Some((n, _)) = number {
        draft.number = n;
        draft.name = format!("T{n}");
    }
    Some((number.map(|(n, _)| n), draft))
}

/// `TOOL: B6 ... DIA: 6`: a tool by its name, whose diameter is called so.
fn names_with_diameter(upper: &str) -> bool {
    let named = upper.trim_start().strip_prefix("TOOL").map(str::trim_start).is_some_and(|rest| rest.starts_with(':'));
    named && behind_word(upper, &["DIA", "DIAMETER", "DIAM", "DIA."]).is_some()
}

/// The number of a comment that gives nothing else: `TOOL NO: 2`.
pub(super) fn number_alone(text: &str) -> Option<u32> {
    let upper = text.to_uppercase();
    let (number, end) = tool_number(&upper).filter(|_| upper.contains("TOOL"))?;
    upper[end..].trim().is_empty().then_some(number)
}

/// A line of the description of a tool whose number is in another line.
pub(super) fn describes(text: &str) -> bool {
    text.trim_start().to_uppercase().starts_with("TOOL") && number_alone(text).is_none()
}

/// Numbers at the end of a name up to which it may as well be the count of a CAM system.
const MOST_COUNTED: u32 = 3;

/// The whole number at the end of a name that no letter and no word makes a diameter: `MILL 2`,
/// `FREZ WALCOWY 12`.
fn counted(words: &str) -> Option<u32> {
    let told = letter(words, 'D').is_some() || word(words, &["D=", "DIA", "\u{d8}", "FI"]).is_some();
    let last = words.split_whitespace().next_back().filter(|_| !told)?;
    last.parse().ok()
}

/// A comment that is nothing but a size with its unit, after the call of a tool: `(0.6 INCH)`,
/// `(12MM)`, `(D10)`.
pub(super) fn size_alone(text: &str, unit: f64, line: usize) -> Option<ToolDraft> {
    let upper = text.trim().to_uppercase();
    let body = upper.strip_prefix('D').map_or(upper.as_str(), |rest| rest.trim_start_matches('='));
    let (_, rest) = number_and_rest(body)?;
    let with_unit = ["MM", "IN", "INCH", "\""].contains(&rest.trim());
    if !(with_unit || rest.is_empty() && body.len() < upper.len()) {
        return None;
    }
    let diameter = length_at(body, unit).filter(|d| *d > 0.0)?;
    let mut draft = ToolDraft::new(0, format!("comment in line {line}"));
    draft.put("diameter_mm", diameter);
    Some(draft)
}

/// The tool that a name describes.
pub(super) fn of_name(name: &str, unit: f64, line: usize) -> Option<ToolDraft> {
    let spaced = name.replace(['_', '-'], " ");
    let words =
        spaced.to_uppercase().replace("BULL ", "BULL NOSE ").replace("END ", "END MILL ").replace("CUTTER", "END MILL");
    let told =
        letter(&words, 'D').is_some() || word(&words, &["DIA"]).is_some() || tool_kind_of_words(&words).is_some();
    if !told {
        return None;
    }
    let mut draft = described(&words, &words, unit, format!("its name, line {line}"))?;
    if let Some(count) = counted(&words) {
        // CAM systems number their tools so: `MILL_2` is the third one of its kind.
        if count <= MOST_COUNTED {
            return None;
        }
        draft.choose(&["diameter_mm"], "the number at the end of its name; nothing else states its diameter");
    }
    name.clone_into(&mut draft.name);
    draft.description.clear();
    Some(draft)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_behind_a_number_says_what_it_counts() {
        type Case<'a> = (&'a str, f64, Option<&'a str>, f64);
        let cases: [Case<'_>; 21] = [
            ("BALL 6MM", 25.4, Some("ball"), 6.0),
            ("T01 = 1/2\"  END MILL  03-0086", 1.0, Some("flat"), 12.7),
            ("T3 1/4 DRILL", 1.0, Some("drill"), 6.35),
            ("T01 - 90-DEG SPOT DRILL 10", 1.0, Some("chamfer"), 10.0),
            ("T02 - 5 MM TAP DRILL", 25.4, Some("drill"), 5.0),
            ("T03 - M6X1 TAP", 25.4, Some("tap"), 6.0),
            ("T4 1/4-20 TAP", 25.4, Some("tap"), 6.35),
            ("Tool 5: Spot Drill 3 Flutes, Diam = 5mm, Len = 20.00mm", 1.0, Some("chamfer"), 5.0),
            ("T6 END MILL 3 FLUTE DIA 8MM", 25.4, Some("flat"), 8.0),
            ("GLOWICA FI63 5Z", 1.0, Some("face_mill"), 63.0),
            ("FREZ KULISTY FI6", 1.0, Some("ball"), 6.0),
            ("NAWIERTAK FI10 90ST", 1.0, Some("chamfer"), 10.0),
            ("WIERTLO FI6.8", 1.0, Some("drill"), 6.8),
            ("GWINTOWNIK M8X1.25", 1.0, Some("tap"), 8.0),
            ("foret diam 8.5", 1.0, Some("drill"), 8.5),
            ("FRESA SFERICA D6", 1.0, Some("ball"), 6.0),
            ("Tool: EM12 Dia: 12.000", 1.0, Some("flat"), 12.0),
            ("Tool : B6  Type : Ballnosed  Dia : 6.000  Rad : 3.000  Len : 40.0", 1.0, Some("ball"), 6.0),
            ("TOOL: TR12R1 TYPE: TIPRADIUSED DIA: 12. RAD: 1.0 LEN: 60.", 1.0, Some("bull_nose"), 12.0),
            ("TOOL: 10XX DIA: 10", 1.0, None, 10.0),
            ("Tool: WKZ-7 Dia: 8 Tip Radius: 4", 1.0, Some("ball"), 8.0),
        ];
        for (text, unit, kind, diameter) in cases {
            let (_, draft) = comment(text, unit);
            assert_eq!(draft.kind, kind, "{text}");
            assert!((draft.diameter().expect("given") - diameter).abs() < 1e-9, "{text}: {:?}", draft.diameter());
        }
        assert_eq!(comment("GRAWER V 60ST FI6", 1.0).1.get("point_angle_deg"), Some(60.0));
        // An angle alone gives no size.
        assert!(of_comment("T01 - 90-DEG SPOT DRILL", 1.0, 1).is_none());
    }

    fn comment(text: &str, unit: f64) -> (Option<u32>, ToolDraft) {
        of_comment(text, unit, 3).unwrap_or_else(|| panic!("{text} describes a tool"))
    }

    #[test]
    fn comments_of_posts_tell_their_tools() {
        type Case<'a> = (&'a str, f64, Option<u32>, Option<&'a str>, f64, Option<f64>);
        let cases: [Case<'_>; 14] = [
            ("T1 D=10. CR=0. - ZMIN=-5. - flat end mill", 1.0, Some(1), Some("flat"), 10.0, None),
            ("T2 D=9.525 CR=0.8 - ZMIN=-10. - BULL NOSE END MILL", 1.0, Some(2), Some("bull_nose"), 9.525, Some(0.8)),
            ("T12 D=6. CR=3. - ZMIN=-4.25 - ball end mill", 1.0, Some(12), Some("ball"), 6.0, None),
            ("T3 D=8.5 CR=0. TAPER=118deg - ZMIN=-25 - drill", 1.0, Some(3), Some("drill"), 8.5, None),
            ("T4  D=0.5 CR=0.  TAPER=45deg - ZMIN=-0.02 - chamfer mill", 25.4, Some(4), Some("chamfer"), 12.7, None),
            ("T5 D=2. CR=0. - ZMIN=0. - face mill", 25.4, Some(5), Some("face_mill"), 50.8, None),
            ("T1 | 1/2 FLAT ENDMILL | H1 | D1 | TOOL DIA. - .5", 25.4, Some(1), Some("flat"), 12.7, None),
            ("1/4 BALL ENDMILL TOOL - 3 DIA. OFF. - 3 LEN. - 3 DIA. - .25", 25.4, Some(3), Some("ball"), 6.35, None),
            ("TOOL 5: END MILL DIA 12.0 R1.0", 1.0, Some(5), Some("bull_nose"), 12.0, Some(1.0)),
            ("T05 - SPOT DRILL D10 90DEG", 1.0, Some(5), Some("chamfer"), 10.0, None),
            ("1/2 FLAT ENDMILL", 25.4, None, Some("flat"), 12.7, None),
            ("6MM BALL NOSE", 1.0, None, Some("ball"), 6.0, None),
            ("T7 D10", 1.0, Some(7), None, 10.0, None),
            ("Schaftfraeser D12", 1.0, None, Some("flat"), 12.0, None),
        ];
        for (text, unit, number, kind, diameter, corner) in cases {
            let (n, draft) = comment(text, unit);
            assert_eq!((n, draft.kind), (number, kind), "{text}");
            assert!((draft.diameter().expect("given") - diameter).abs() < 1e-9, "{text}: {:?}", draft.diameter());
            if kind == Some("bull_nose") {
                assert!((draft.get("corner_radius_mm").unwrap_or(0.0) - corner.unwrap_or(0.0)).abs() < 1e-9, "{text}");
            }
        }
        assert_eq!(
            comment("T4 D=12. CR=0. TAPER=45deg - ZMIN=-1. - chamfer mill", 1.0).1.get("point_angle_deg"),
            Some(90.0)
        );
        assert_eq!(
            comment("T4 D=12. CR=0. TAPER=90deg - ZMIN=-1. - spot drill", 1.0).1.get("point_angle_deg"),
            Some(90.0)
        );
    }

    #[test]
    fn lists_of_other_posts_tell_their_tools() {
        let (number, draft) = comment("  #5 D=8 TAPER=118deg - ZMIN=-24.403 - ZMAX=+15 - drill", 1.0);
        assert_eq!((number, draft.kind, draft.diameter()), (Some(5), Some("drill"), Some(8.0)));
        assert_eq!(number_alone("TOOL NO: 12 "), Some(12));
        assert_eq!(number_alone("TOOL NUMBER  : 3"), Some(3));
        for text in ["TOOL NO: 12 D10", "#5", "T5", "TOOL TYPE: 3D"] {
            assert_eq!(number_alone(text), None, "{text}");
        }
        let (_, draft) =
            comment("TOOL TYPE: TIPRADIUSED TOOL ID: TR12R1 TOOL DIA. 12.0  TIP RAD 1.0  LENGTH 60.0", 1.0);
        assert_eq!(
            (draft.kind, draft.diameter(), draft.get("corner_radius_mm")),
            (Some("bull_nose"), Some(12.0), Some(1.0))
        );
    }

    #[test]
    fn a_size_is_never_taken_from_what_counts_something_else() {
        type Case<'a> = (&'a str, f64, Option<u32>, Option<&'a str>, f64);
        let cases: [Case<'_>; 15] = [
            ("T2 | NO. 7 DRILL | H2", 25.4, Some(2), Some("drill"), 0.201 * 25.4),
            ("T2 #7 DRILL .201", 25.4, Some(2), Some("drill"), 0.201 * 25.4),
            ("F DRILL", 25.4, None, Some("drill"), 0.257 * 25.4),
            ("T8 10-32 TAP", 25.4, Some(8), Some("tap"), 0.19 * 25.4),
            ("OPER: 2  TOOL: 4  0.25 DIA BALL END MILL", 25.4, Some(4), Some("ball"), 6.35),
            ("WKZ 21 = BOHRER D8,5", 1.0, Some(21), Some("drill"), 8.5),
            ("WKZ 12 = SCHAFTFRAESER D20", 1.0, Some(12), Some("flat"), 20.0),
            ("BOHRER 8,5", 1.0, None, Some("drill"), 8.5),
            ("2 = V-Bit {90 deg 0.5\"}", 25.4, Some(2), Some("chamfer"), 12.7),
            ("1 = End Mill {1/4 inch}", 25.4, Some(1), Some("flat"), 6.35),
            ("T1 .500 EM", 25.4, Some(1), Some("flat"), 12.7),
            ("1/2 EM CRB 4FL 1 LOC", 25.4, None, Some("flat"), 12.7),
            ("TOOL 12MM ENDMILL", 1.0, None, Some("flat"), 12.0),
            ("OPER: 1  TOOL: 3  0.375 DIA 4FL END MILL", 25.4, Some(3), Some("flat"), 9.525),
            ("T3 12MM DIA END MILL", 25.4, Some(3), Some("flat"), 12.0),
        ];
        for (text, unit, number, kind, diameter) in cases {
            let (n, draft) = comment(text, unit);
            assert_eq!((n, draft.kind), (number, kind), "{text}");
            assert!((draft.diameter().expect("given") - diameter).abs() < 1e-9, "{text}: {:?}", draft.diameter());
        }
        // A drill of seven inches is taken for a drill of unknown size.
        for text in ["T2 7 DRILL", "T5 SPOT DRILL 120"] {
            let unit = if text.contains("SPOT") { 1.0 } else { 25.4 };
            assert!(of_comment(text, unit, 1).is_none_or(|(_, d)| d.diameter().is_none()), "{text}");
        }
    }

    #[test]
    fn comments_of_something_else_tell_none() {
        for text in [
            "USING HIGH FEED G1 F5000.",
            "2D CONTOUR1",
            "",
            "T",
            "TOOL",
            "MACHINE VENDOR HAAS",
            "STOCK TOP",
            "T1",
            "DATE 12/03/24",
        ] {
            assert!(of_comment(text, 1.0, 1).is_none(), "{text}");
        }
    }

    #[test]
    fn names_describe_tools() {
        let name = |text: &str| of_name(text, 1.0, 1).map(|d| (d.kind, d.diameter()));
        assert_eq!(name("END_D12"), Some((Some("flat"), Some(12.0))));
        assert_eq!(name("BALL_D8"), Some((Some("ball"), Some(8.0))));
        assert_eq!(name("CUTTER 10"), Some((Some("flat"), Some(10.0))));
        assert_eq!(name("BULL_D10_R1").and_then(|n| n.0), Some("bull_nose"));
        assert_eq!(name("TASTER"), None);
        // The count of a CAM system is no diameter, and a larger number is chosen to be one.
        assert_eq!((name("MILL_2"), name("ENDMILL_1")), (None, None));
        let polish = of_name("Frez_walcowy_12", 1.0, 1).expect("described by its name");
        assert_eq!((polish.kind, polish.diameter(), polish.chosen.len()), (Some("flat"), Some(12.0), 1));
        let size = |text: &str| size_alone(text, 1.0, 1).and_then(|d| d.diameter());
        assert_eq!(
            (size("0.6 INCH"), size("12MM"), size("D10"), size("D=8.5")),
            (Some(0.6 * 25.4), Some(12.0), Some(10.0), Some(8.5))
        );
        for none in ["12", "ROUGH 12MM", "12 MM DEEP", "D", "OP 10", ""] {
            assert_eq!(size(none), None, "{none}");
        }
        let ball = of_name("BALL_4MM", 25.4, 1).expect("described by its name");
        assert_eq!((ball.kind, ball.diameter()), (Some("ball"), Some(4.0)));
    }
}
