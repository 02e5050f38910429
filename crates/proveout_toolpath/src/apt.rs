//! Reads the statements of APT CL files.
//!
//! Words after ISO 4343:2000 (numerical control processor output, minor words of post-processor statements) as far as
//! they move the tool or change what removes material.

use std::sync::Arc;

use proveout_geom::{Point, ToolPose, Vector};

use crate::{
    ClError, ClFile, ClRecord, ClStatement, CoolantState, SpindleState,
    apt_words::{Word, Words, statements},
};

/// Millimeters of an inch.
const INCH: f64 = 25.4;
/// How far the length of a programmed tool axis may be from one: files carry six digits.
const AXIS_LENGTH: f64 = 1e-3;

/// Statements that say nothing about motion, removal or time.
const KEPT: [&str; 22] = [
    "CUTTER", "MACHIN", "INTOL", "OUTTOL", "TOLER", "TOOL", "CUTCOM", "TMARK", "SET", "MODE", "ORIGIN", "TRANS",
    "CLEARP", "AUXFUN", "PREFUN", "SEQNO", "ARCSLP", "TLON", "SYN", "INSERT", "DISPLAY", "PAINT",
];
/// Statements whose motion is not in the CL data.
const REFUSED: [&str; 12] =
    ["CIRCLE", "GO", "GOLFT", "GORGT", "GOFWD", "GOBACK", "GROUP", "GODOWN", "INDIRV", "INDIRP", "CYCLE", "COPY"];

struct Reader {
    file: Arc<str>,
    /// mm of a length unit of the file.
    unit: f64,
    pose: Option<ToolPose>,
    rapid: bool,
    records: Vec<ClRecord>,
}

impl ClFile {
    /// Reads APT CL text; `file` is its name in errors.
    ///
    /// Lengths are in mm until `UNITS/INCHES`. `GOTO` with three numbers keeps the tool axis, which is +z at the begin.
    ///
    /// # Errors
    /// The first statement that is not understood, or whose numbers are not numbers, with its place.
    pub fn from_apt(file: &str, text: &str) -> Result<Self, ClError> {
        let mut reader = Reader { file: Arc::from(file), unit: 1.0, pose: None, rapid: false, records: Vec::new() };
        for words in statements(text) {
            let comment = words.comment.clone().filter(|c| !c.is_empty());
            if !words.major.is_empty() {
                reader.statement(&words)?;
            }
            if let Some(text) = comment {
                reader.push(words.line, ClStatement::Text(text));
            }
        }
        Ok(Self { file: reader.file, records: reader.records })
    }
}

impl Reader {
    fn push(&mut self, line: u32, statement: ClStatement) {
        self.records.push(ClRecord { line, statement });
    }

    fn error(&self, line: u32, column: u32, message: String, help: &str) -> ClError {
        ClError { file: self.file.clone(), line, column, message, help: help.to_owned() }
    }

    fn at(&self, w: &Words, message: String, help: &str) -> ClError {
        self.error(w.line, w.column, message, help)
    }

    fn number(&self, word: &Word) -> Result<f64, ClError> {
        match word.text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => Err(self.error(
                word.line,
                word.column,
                format!("\"{}\" is not a number", word.text),
                "write a decimal number",
            )),
        }
    }

    fn statement(&mut self, w: &Words) -> Result<(), ClError> {
        match w.major.as_str() {
            "GOTO" => {
                let pose = self.pose_of(w)?;
                self.go(w.line, pose);
            }
            "FROM" => {
                let pose = self.pose_of(w)?;
                self.pose = Some(pose);
                self.push(w.line, ClStatement::From(pose));
            }
            "GODLTA" => {
                let Some(from) = self.pose else {
                    return Err(self.at(w, "GODLTA before any position".into(), "begin with FROM or GOTO"));
                };
                let n = self.numbers(w)?;
                let step = match n.as_slice() {
                    [z] => from.axis * (*z * self.unit),
                    [x, y, z] => Vector::new(*x, *y, *z) * self.unit,
                    other => {
                        let message = format!("GODLTA with {} numbers", other.len());
                        return Err(self.at(w, message, "give one number (along the axis) or three"));
                    }
                };
                self.go(w.line, ToolPose { tip: from.tip + step, ..from });
            }
            "RAPID" => self.rapid = true,
            "FEDRAT" => self.feed(w)?,
            "LOADTL" => {
                let n = self.first(w)?;
                if n < 0.0 || n.fract() != 0.0 || n > f64::from(u32::MAX) {
                    return Err(self.at(w, format!("tool number {n}"), "give a whole number of zero or more"));
                }
                self.push(w.line, ClStatement::LoadTool { number: n as u32 });
            }
            "SPINDL" => self.spindle(w)?,
            "COOLNT" => {
                let state = match w.minors.first().map(|m| m.text.to_uppercase()).as_deref() {
                    Some("OFF") => CoolantState::Off,
                    Some("ON" | "FLOOD") => CoolantState::Flood,
                    Some("MIST") => CoolantState::Mist,
                    other => {
                        let message = format!("coolant \"{}\"", other.unwrap_or(""));
                        return Err(self.at(w, message, "write ON, OFF, FLOOD or MIST"));
                    }
                };
                self.push(w.line, ClStatement::Coolant(state));
            }
            "DELAY" => {
                let seconds = self.first(w)?;
                if seconds < 0.0 {
                    return Err(self.at(w, format!("a delay of {seconds} s"), "give a time of zero or more"));
                }
                self.push(w.line, ClStatement::Delay(seconds));
            }
            "STOP" => self.push(w.line, ClStatement::Stop { optional: false }),
            "OPSTOP" => self.push(w.line, ClStatement::Stop { optional: true }),
            "END" | "FINI" => self.push(w.line, ClStatement::End),
            "UNITS" => match w.minors.first().map(|m| m.text.to_uppercase()).as_deref() {
                Some("MM") => self.unit = 1.0,
                Some("INCHES" | "INCH") => self.unit = INCH,
                other => {
                    let message = format!("units \"{}\"", other.unwrap_or(""));
                    return Err(self.at(w, message, "write UNITS/MM or UNITS/INCHES"));
                }
            },
            "MULTAX" => {}
            "PARTNO" | "PPRINT" | "TOOL PATH" | "REMARK" => {
                let text = w.raw.split_once('/').map_or("", |(_, t)| t).trim().to_owned();
                let text = if text.is_empty() { w.raw.clone() } else { text };
                self.push(w.line, ClStatement::Text(text));
            }
            major if KEPT.contains(&major) || major.starts_with("PARTNO ") || major.starts_with("PPRINT ") => {
                self.push(w.line, ClStatement::Kept(w.raw.clone()));
            }
            major if REFUSED.contains(&major) => {
                let message = format!("{major} moves the tool in a way that is not written in the file");
                return Err(self.at(w, message, "write the path as GOTO points (linearized output of the CAM system)"));
            }
            major => {
                let message = format!("unknown statement \"{major}\"");
                return Err(self.at(w, message, "correct the word, or put it into a comment ($$) if it has no effect"));
            }
        }
        Ok(())
    }

    fn go(&mut self, line: u32, pose: ToolPose) {
        let rapid = std::mem::take(&mut self.rapid); // RAPID holds for the next motion
        self.pose = Some(pose);
        self.push(line, ClStatement::Goto { pose, rapid });
    }

    fn numbers(&self, w: &Words) -> Result<Vec<f64>, ClError> {
        w.minors.iter().map(|m| self.number(m)).collect()
    }

    fn first(&self, w: &Words) -> Result<f64, ClError> {
        match w.minors.first() {
            Some(word) => self.number(word),
            None => Err(self.at(w, format!("{} without a number", w.major), "give the number behind a slash")),
        }
    }

    fn pose_of(&self, w: &Words) -> Result<ToolPose, ClError> {
        let n = self.numbers(w)?;
        let axis = match n.len() {
            3 => self.pose.map_or(Vector::z(), |p| p.axis),
            6 => {
                let axis = Vector::new(n[3], n[4], n[5]);
                let length = axis.norm();
                if (length - 1.0).abs() > AXIS_LENGTH {
                    let message = format!("the tool axis {}, {}, {} has length {length}", n[3], n[4], n[5]);
                    return Err(self.at(w, message, "write a unit vector from the tip to the holder"));
                }
                axis / length
            }
            other => {
                let message = format!("{} with {other} numbers", w.major);
                return Err(self.at(w, message, "give x, y, z or x, y, z, i, j, k"));
            }
        };
        Ok(ToolPose { tip: Point::new(n[0], n[1], n[2]) * self.unit, axis })
    }

    fn feed(&mut self, w: &Words) -> Result<(), ClError> {
        let mut value = None;
        let mut unit = None;
        for m in &w.minors {
            match m.text.to_uppercase().as_str() {
                "MMPM" | "PERMIN" | "IPM" | "MMPR" | "PERREV" | "IPR" => unit = Some(m.text.to_uppercase()),
                _ if value.is_none() => value = Some(self.number(m)?),
                other => {
                    let message = format!("\"{other}\" in a feed");
                    let help = "write FEDRAT/value with MMPM, IPM, PERMIN, MMPR, IPR or PERREV";
                    return Err(self.error(m.line, m.column, message, help));
                }
            }
        }
        let Some(value) = value.filter(|v| *v > 0.0) else {
            return Err(self.at(w, "a feed must be above zero".into(), "write FEDRAT/value"));
        };
        let statement = match unit.as_deref() {
            None | Some("PERMIN") => ClStatement::Feed(value * self.unit / 60.0),
            Some("MMPM") => ClStatement::Feed(value / 60.0),
            Some("IPM") => ClStatement::Feed(value * INCH / 60.0),
            Some("MMPR") => ClStatement::FeedPerRevolution(value),
            Some("IPR") => ClStatement::FeedPerRevolution(value * INCH),
            Some(_) => ClStatement::FeedPerRevolution(value * self.unit),
        };
        self.push(w.line, statement);
        Ok(())
    }

    fn spindle(&mut self, w: &Words) -> Result<(), ClError> {
        let mut state = SpindleState::Clockwise;
        let mut speed_rpm = None;
        for m in &w.minors {
            match m.text.to_uppercase().as_str() {
                "OFF" => state = SpindleState::Off,
                "ON" | "CLW" => state = SpindleState::Clockwise,
                "CCLW" => state = SpindleState::CounterClockwise,
                "RPM" => {}
                _ => speed_rpm = Some(self.number(m)?),
            }
        }
        if let Some(speed) = speed_rpm
            && speed < 0.0
        {
            let message = format!("a spindle speed of {speed} 1/min");
            return Err(self.at(w, message, "give the speed without sign and CLW or CCLW"));
        }
        self.push(w.line, ClStatement::Spindle { state, speed_rpm });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
PARTNO/BLADE 7
UNITS/MM
MULTAX/ON
$$ roughing
LOADTL/5
SPINDL/12000,RPM,CLW
COOLNT/ON
RAPID
GOTO/0,0,50,0,0,1
FEDRAT/1200.,MMPM
GOTO/10.5,-2,40,0.6,0,$
0.8
GOTO/11,-2,40
GODLTA/-2
CUTTER/10,1.5
DELAY/0.5
FINI
";

    fn read(text: &str) -> Result<ClFile, ClError> {
        ClFile::from_apt("path.cls", text)
    }

    #[test]
    fn a_path_is_read_word_by_word() {
        let cl = read(TEXT).expect("a good file");
        let motions: Vec<_> = cl.motions().collect();
        assert_eq!(motions.len(), 4);
        assert_eq!((motions[0].0, motions[0].2), (9, true));
        assert!(!motions[1].2);
        assert_eq!(motions[1].0, 11);
        assert!((motions[1].1.axis - Vector::new(0.6, 0.0, 0.8)).norm() < 1e-15);
        assert_eq!(motions[2].1.axis, motions[1].1.axis); // three numbers keep the axis
        assert!((motions[3].1.tip - Point::new(11.0 - 1.2, -2.0, 40.0 - 1.6)).norm() < 1e-12);
        assert!(cl.records.iter().any(|r| r.statement == ClStatement::Feed(20.0)));
        assert!(cl.records.iter().any(|r| r.statement == ClStatement::LoadTool { number: 5 }));
        assert!(cl.records.iter().any(|r| r.statement == ClStatement::Text("roughing".into())));
        assert!(cl.records.iter().any(|r| r.statement == ClStatement::Kept("CUTTER/10,1.5".into())));
        let steps = [(10.5_f64 * 10.5 + 4.0 + 100.0).sqrt(), 0.5, 2.0];
        assert!((cl.length_mm() - steps.iter().sum::<f64>()).abs() < 1e-12);
    }

    #[test]
    fn writing_and_reading_is_the_identity() {
        let cl = read(TEXT).expect("a good file");
        let again = read(&cl.to_apt()).expect("what was written");
        let (a, b): (Vec<_>, Vec<_>) = (cl.motions().collect(), again.motions().collect());
        assert_eq!(a.len(), b.len());
        for (x, y) in a.iter().zip(&b) {
            assert_eq!(x.1.tip, y.1.tip);
            assert!((x.1.axis - y.1.axis).norm() < 1e-15);
            assert_eq!(x.2, y.2);
        }
        let rest = |cl: &ClFile| {
            let other = cl.records.iter().filter(|r| !matches!(r.statement, ClStatement::Goto { .. }));
            other.map(|r| r.statement.clone()).collect::<Vec<_>>()
        };
        assert_eq!(rest(&cl), rest(&again));
    }

    #[test]
    fn inches_become_millimeters() {
        let cl = read("UNITS/INCHES\nFEDRAT/10\nGOTO/1,2,3\nFEDRAT/60,MMPM").expect("a good file");
        assert_eq!(cl.motions().next().expect("a motion").1.tip, Point::new(25.4, 50.8, 25.4 * 3.0));
        assert_eq!(cl.records[0].statement, ClStatement::Feed(254.0 / 60.0));
        assert_eq!(cl.records[2].statement, ClStatement::Feed(1.0));
    }

    #[test]
    fn errors_name_place_value_and_remedy() {
        let place = |text: &str| read(text).map_err(|e| (e.line, e.column, e.message)).expect_err("must be refused");
        assert_eq!(place("GOTO/0,0,1\n  GOTO/1,x2,3"), (2, 10, "\"x2\" is not a number".into()));
        assert_eq!(place("GOTO/1,2").2, "GOTO with 2 numbers");
        assert_eq!(place("GOTO/1,NaN,3").2, "\"NaN\" is not a number");
        assert_eq!(place("GOTO/0,0,0,0,0,2").2, "the tool axis 0, 0, 2 has length 2");
        assert_eq!(place("\nFOO/1"), (2, 1, "unknown statement \"FOO\"".into()));
        assert_eq!(place("GODLTA/1").2, "GODLTA before any position");
        assert_eq!(place("FEDRAT/0").2, "a feed must be above zero");
        assert!(place("CIRCLE/1,2,3").2.starts_with("CIRCLE moves the tool"));
        let e = read("LOADTL/1.5").expect_err("must be refused");
        assert_eq!(e.to_string(), "path.cls:1:1: tool number 1.5 (help: give a whole number of zero or more)");
    }

    #[test]
    fn any_text_is_refused_or_read_without_panic() {
        let mut state = 7_u64;
        for _ in 0..2000 {
            let text: String = (0..40)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    let set = "GOTO/,.-+e09$\n RAPIDFEÄ\u{3b1}";
                    set.chars().nth((state >> 40) as usize % set.chars().count()).unwrap_or('$')
                })
                .collect();
            if let Ok(cl) = read(&text) {
                assert!(cl.motions().all(|m| m.1.tip.iter().all(|v| v.is_finite())));
            }
        }
    }
}
