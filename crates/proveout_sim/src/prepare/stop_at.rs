//! What ends a run early (`run --stop-at`).

use std::{fmt, str::FromStr};

use proveout_input::nearest;

use crate::verdict::finding::{self, CODES, Code};

/// Longest time that is taken, s: a hundred days of machining.
const MOST_S: f64 = 8.64e6;

/// What ends a run early.
#[derive(Clone, Debug, PartialEq)]
pub enum StopAt {
    /// The first finding of a code; none for the first that fails a gate.
    Finding(Option<&'static str>),
    /// The end of the first pass through a line of the program, from 1.
    Line(u32),
    /// The piece of motion that holds this simulated time, s.
    Time(f64),
}

/// Codes that are judged when the program is at its end: no run can stop at them.
const AT_THE_END: [Code; 11] = [
    finding::GOUGE,
    finding::EXCESS,
    finding::FILM,
    finding::THREAD,
    finding::INSPECTION,
    finding::ROUGHNESS,
    finding::SCALLOP,
    finding::TEXT_LOST,
    finding::TEXT_UNPROVEN,
    finding::TEXT_SKIPPED,
    finding::TEXT_NOT_CALLED,
];

impl FromStr for StopAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "any" {
            return Ok(Self::Finding(None));
        }
        if let Some(code) = CODES.iter().find(|c| c.code == text) {
            if AT_THE_END.iter().any(|c| c.code == code.code) {
                return Err(format!("{text} is judged at the end of the program: a run cannot stop there"));
            }
            return Ok(Self::Finding(Some(code.code)));
        }
        if text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.')) {
            return number(text);
        }
        let hint =
            nearest(text, CODES.iter().map(|c| c.code)).map_or_else(String::new, |c| format!("; did you mean {c}?"));
        Err(format!(
            "no finding has this code{hint} (give `any`, a code of docs/findings, a line such as 120, or a time such \
             as 12.5s)"
        ))
    }
}

/// A line, or a time with its `s`.
fn number(text: &str) -> Result<StopAt, String> {
    let Some(time) = text.strip_suffix('s') else {
        return match text.parse::<u32>() {
            Ok(line) if line > 0 => Ok(StopAt::Line(line)),
            _ => Err("a line is a whole number from 1; a time has its unit, such as 12.5s".to_owned()),
        };
    };
    match time.trim_end().parse::<f64>() {
        Ok(t) if t > 0.0 && t <= MOST_S => Ok(StopAt::Time(t)),
        _ => Err(format!("a time is more than 0s, and at most {MOST_S}s")),
    }
}

impl fmt::Display for StopAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finding(None) => f.write_str("any"),
            Self::Finding(Some(code)) => f.write_str(code),
            Self::Line(line) => write!(f, "{line}"),
            Self::Time(t) => write!(f, "{t}s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_is_a_code_a_line_or_a_time() {
        let read = |text: &str| text.parse::<StopAt>();
        assert_eq!(read("any"), Ok(StopAt::Finding(None)));
        assert_eq!(read("collision-bodies"), Ok(StopAt::Finding(Some("collision-bodies"))));
        assert_eq!(read("120"), Ok(StopAt::Line(120)));
        assert_eq!(read("12.5s"), Ok(StopAt::Time(12.5)));
        for wrong in
            ["", "0", "-3", "1.5", "nan", "NaNs", "-1s", "0s", "infs", "1e99s", "99999999999", "collison-bodies"]
        {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert!(read("collison-bodies").is_err_and(|e| e.contains("did you mean collision-bodies?")));
        assert!(read("geometry-gouge").is_err_and(|e| e.contains("at the end of the program")));
        for text in ["any", "limits-overtravel", "7", "0.25s"] {
            assert_eq!(read(text).map(|s| s.to_string()).as_deref(), Ok(text));
        }
    }
}
