//! Sizes that go by a name: number and letter drills, number sizes of inch threads; decimal commas;
//! comments that describe several tools.

/// Diameters of the drills number 1 to 80, inch (ASME B94.11M).
const NUMBERED: [f64; 80] = [
    0.2280, 0.2210, 0.2130, 0.2090, 0.2055, 0.2040, 0.2010, 0.1990, 0.1960, 0.1935, 0.1910, 0.1890, 0.1850, 0.1820,
    0.1800, 0.1770, 0.1730, 0.1695, 0.1660, 0.1610, 0.1590, 0.1570, 0.1540, 0.1520, 0.1495, 0.1470, 0.1440, 0.1405,
    0.1360, 0.1285, 0.1200, 0.1160, 0.1130, 0.1110, 0.1100, 0.1065, 0.1040, 0.1015, 0.0995, 0.0980, 0.0960, 0.0935,
    0.0890, 0.0860, 0.0820, 0.0810, 0.0785, 0.0760, 0.0730, 0.0700, 0.0670, 0.0635, 0.0595, 0.0550, 0.0520, 0.0465,
    0.0430, 0.0420, 0.0410, 0.0400, 0.0390, 0.0380, 0.0370, 0.0360, 0.0350, 0.0330, 0.0320, 0.0310, 0.0292, 0.0280,
    0.0260, 0.0250, 0.0240, 0.0225, 0.0210, 0.0200, 0.0180, 0.0160, 0.0145, 0.0135,
];
/// Diameters of the drills A to Z, inch (ASME B94.11M).
const LETTERED: [f64; 26] = [
    0.234, 0.238, 0.242, 0.246, 0.250, 0.257, 0.261, 0.266, 0.272, 0.277, 0.281, 0.290, 0.295, 0.302, 0.316, 0.323,
    0.332, 0.339, 0.348, 0.358, 0.368, 0.377, 0.386, 0.397, 0.404, 0.413,
];
/// Bodies of plain center drills number 1 to 8, inch (ASME B94.11M).
const CENTERED: [f64; 8] = [0.125, 0.1875, 0.25, 0.3125, 0.4375, 0.5, 0.625, 0.75];
/// The largest number size of an inch thread.
const MOST_NUMBERED_THREAD: u32 = 12;
/// Threads an inch from which a number before the dash is a number size: 12-24 is one, 1-12 an inch.
const FINEST_INCH: u32 = 24;

/// What goes by the name of its size.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Named {
    Drill,
    CenterDrill,
}

/// Diameter of `NO. 7 DRILL`, `#7 DRILL`, `LETTER F DRILL`, `F DRILL`, mm, and the text without that name.
pub(super) fn drill_by_name(upper: &str, what: Named) -> Option<(f64, String)> {
    let without = |from: usize, to: usize| format!("{} {}", &upper[..from], &upper[to..]);
    for mark in ["NUMBER", "NO.", "NO", "#"] {
        for (at, _) in upper.match_indices(mark) {
            let before = upper[..at].trim_end();
            // `TOOL NO. 7` counts tools.
            let alone = !upper[..at].chars().next_back().is_some_and(char::is_alphanumeric);
            if !alone || ["TOOL", "T", "WERKZEUG"].iter().any(|w| before.ends_with(w)) {
                continue;
            }
            let rest = &upper[at + mark.len()..];
            let body = rest.trim_start();
            let end = body.find(|c: char| !c.is_ascii_digit()).unwrap_or(body.len());
            let Ok(number) = body[..end].parse::<usize>() else { continue };
            if matches!(body[end..].chars().next(), Some('.' | '/' | '-')) {
                continue;
            }
            let table: &[f64] = if what == Named::CenterDrill { &CENTERED } else { &NUMBERED };
            let to = upper.len() - body.len() + end;
            if let Some(inch) = number.checked_sub(1).and_then(|i| table.get(i)) {
                return Some((inch * 25.4, without(at, to)));
            }
        }
    }
    let words: Vec<&str> = upper.split_whitespace().collect();
    let at = words.iter().position(|w| w.starts_with("DRILL"))?;
    let letter = words.get(at.checked_sub(1)?).filter(|_| what == Named::Drill)?;
    let [c @ b'A'..=b'Z'] = letter.as_bytes() else { return None };
    let inch = LETTERED.get(usize::from(c - b'A'))?;
    Some((inch * 25.4, words[..at - 1].join(" ")))
}

/// Diameter of an inch thread by its number size, mm: `10-32 TAP`, `#8-32`, `4-40`.
pub(super) fn thread_by_number(upper: &str) -> Option<f64> {
    let digits = |c: char| c.is_ascii_digit();
    upper.match_indices('-').find_map(|(at, _)| {
        let (before, after) = (&upper[..at], &upper[at + 1..]);
        let size = &before[before.trim_end_matches(digits).len()..];
        let pitch = &after[..after.find(|c: char| !digits(c)).unwrap_or(after.len())];
        let left = before[..before.len() - size.len()].chars().next_back();
        let alone = !left.is_some_and(|c| c.is_alphanumeric() || matches!(c, '/' | '.' | '-'));
        let (size, pitch) = (size.parse::<u32>().ok()?, pitch.parse::<u32>().ok()?);
        (alone && size <= MOST_NUMBERED_THREAD && pitch >= FINEST_INCH)
            .then(|| (0.060 + 0.013 * f64::from(size)) * 25.4)
    })
}

/// Decimal commas as points: `D8,5`. A comma of a list stays.
pub(super) fn with_points(text: &str) -> String {
    let bytes = text.as_bytes();
    let digit = |i: Option<usize>| i.and_then(|i| bytes.get(i)).is_some_and(u8::is_ascii_digit);
    let decimal = |at: usize| {
        let before = text[..at].trim_end_matches(|c: char| c.is_ascii_digit());
        let after = text[at + 1..].trim_start_matches(|c: char| c.is_ascii_digit());
        digit(at.checked_sub(1))
            && digit(Some(at + 1))
            && !before.ends_with(['.', ','])
            && !after.starts_with(['.', ','])
    };
    text.char_indices().map(|(i, c)| if c == ',' && decimal(i) { '.' } else { c }).collect()
}

/// The tools of a comment one by one: `T5 = 6.8MM DRILL  T6 = M8 TAP`. A comment that begins otherwise stays
/// whole.
pub(super) fn one_by_one(comment: &str) -> Vec<&str> {
    let heads: Vec<usize> = comment
        .char_indices()
        .filter(|(at, c)| {
            let alone = !comment[..*at].chars().next_back().is_some_and(char::is_alphanumeric);
            let rest = &comment[at + c.len_utf8()..];
            let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
            let next = rest[end..].chars().next();
            matches!(c, 'T' | 't')
                && alone
                && end > 0
                && !next.is_some_and(|c| c.is_alphanumeric() || matches!(c, '.' | '/'))
        })
        .map(|(at, _)| at)
        .collect();
    let begins = heads.first().is_some_and(|at| comment[..*at].trim().is_empty());
    if heads.len() < 2 || !begins {
        return vec![comment];
    }
    let ends = heads.iter().skip(1).copied().chain([comment.len()]);
    heads
        .iter()
        .zip(ends)
        .map(|(from, to)| comment[*from..to].trim_end_matches([' ', ',', ';', '/', '|', '-']))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drills_go_by_number_and_letter() {
        assert!(NUMBERED.windows(2).all(|w| w[0] > w[1]) && LETTERED.windows(2).all(|w| w[0] < w[1]));
        let inch = |text: &str, what| drill_by_name(text, what).map(|(mm, _)| (mm / 25.4 * 1e4).round() / 1e4);
        for (text, want) in [
            ("NO. 7 DRILL", Some(0.201)),
            ("NO.29 DRILL", Some(0.136)),
            ("#7 DRILL", Some(0.201)),
            ("T2 | NO. 7 DRILL | H2", Some(0.201)),
            ("LETTER F DRILL", Some(0.257)),
            ("Q DRILL", Some(0.332)),
            ("TOOL NO. 7 DRILL", None),
            ("#10-32 TAP DRILL", None),
            ("NO. 99 DRILL", None),
            ("1/4 DRILL", None),
        ] {
            assert_eq!(inch(text, Named::Drill), want, "{text}");
        }
        assert_eq!(inch("#3 CENTER DRILL", Named::CenterDrill), Some(0.25));
    }

    #[test]
    fn threads_go_by_number() {
        let inch = |text: &str| thread_by_number(text).map(|mm| (mm / 25.4 * 1e3).round() / 1e3);
        for (text, want) in [
            ("10-32 TAP", Some(0.19)),
            ("#8-32 TAP", Some(0.164)),
            ("T4 4-40 SPIRAL TAP", Some(0.112)),
            ("1/4-20 TAP", None),
            ("1-12 TAP", None),
            ("1/4-28 TAP", None),
            ("3/8-24", None),
        ] {
            assert_eq!(inch(text), want, "{text}");
        }
    }

    #[test]
    fn commas_and_lists_are_distinguished() {
        assert_eq!(with_points("BOHRER D8,5"), "BOHRER D8.5");
        assert_eq!(with_points("D10,R1 1,2,3 20.0,5.0"), "D10,R1 1,2,3 20.0,5.0");
        assert_eq!(one_by_one("T5 = 6.8MM DRILL  T6 = M8 TAP"), ["T5 = 6.8MM DRILL", "T6 = M8 TAP"]);
        assert_eq!(one_by_one(" T1 Planfr\u{e4}ser D50, T2 Bohrer D8").len(), 2);
        for whole in ["T1 | 1/2 FLAT ENDMILL | H1 | D1", "TR12R1 T5", "USE T1 AND T2", "T1.5 T2"] {
            assert_eq!(one_by_one(whole), [whole]);
        }
    }
}
