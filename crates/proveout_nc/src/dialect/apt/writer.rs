//! What CL data says about itself, read before it is run: the system that wrote it, the sense of
//! its circles, the unit of its lengths.
//!
//! ```text
//!   CIRCLE/ x,y,z, i,j,k, r          Creo, CAMWorks: counter-clockwise about i,j,k (right hand)
//!   CIRCLE/ ..., t, f, d, e          NX, 11 values: "assuming a clockwise direction" about i,j,k
//! ```
//!
//! The sense of Creo after PTC, "CL output for circular interpolation"; that of NX after Siemens,
//! *CLSF Manager*, "CIRCLE". The path before and after a circle is nearly always tangent to it, and
//! the tangents check the sense. Lengths without UNITS count in the unit of the feeds. Where no
//! feed names a unit either, mm is assumed.

use super::reader::INCH;
use super::statement::{self, AptStatement, Token};
use crate::frame;
use crate::source::{Mark, Source};

/// Cosine of the angle within which two directions are tangent, one degree.
const TANGENT: f64 = 0.999_847_7;
/// Most circles that are evaluated.
const MAX_CIRCLES: usize = 5000;

/// What the text contains.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClDataFacts {
    /// CIRCLE runs clockwise about its normal.
    pub(crate) clockwise: bool,
    /// The assumption about the sense of circles.
    pub(crate) sense_assumed: Option<String>,
    /// mm of a length before UNITS; none where the control states it, or UNITS comes before the
    /// first length.
    pub(crate) unit: Option<f64>,
    /// The assumption about the unit of lengths.
    pub(crate) unit_assumed: Option<String>,
    /// The note that lengths are in mm because the feeds are.
    pub(crate) unit_told: Option<String>,
    /// Lines of an inch feed and of a mm feed, when no UNITS covers the lengths.
    pub(crate) unit_contradicts: Option<[u32; 2]>,
}

/// The system that wrote CL data, as far as it makes a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ClDataWriter {
    Nx,
    /// Creo, `CAMWorks`, CATIA, and what this program writes.
    RightHand(&'static str),
    Unknown,
}

/// Counts of circles tangent to the path before and after them, by sense.
#[derive(Clone, Copy, Debug, Default)]
struct Votes {
    clockwise: usize,
    counter_clockwise: usize,
    circles: usize,
}

/// A circle of the text with its points.
#[derive(Clone, Copy, Debug)]
struct ClDataCircle {
    center: [f64; 3],
    normal: [f64; 3],
    start: [f64; 3],
    end: Option<[f64; 3]>,
    before: Option<[f64; 3]>,
}

impl Votes {
    fn take(&mut self, circle: &ClDataCircle, behind: Option<[f64; 3]>) {
        let Some(end) = circle.end else { return };
        let at = |point: [f64; 3], along: Option<[f64; 3]>| {
            let tangent = frame::unit(frame::cross(circle.normal, frame::sub(point, circle.center)))?;
            let along = frame::unit(along?)?;
            let cosine = frame::dot(tangent, along);
            (cosine.abs() > TANGENT).then_some(cosine > 0.0)
        };
        self.circles += 1;
        match (at(circle.start, circle.before), at(end, behind)) {
            (Some(true), None | Some(true)) | (None, Some(true)) => self.counter_clockwise += 1,
            (Some(false), None | Some(false)) | (None, Some(false)) => self.clockwise += 1,
            _ => {}
        }
    }
}

/// Reads the whole text.
pub(crate) fn facts(source: &Source, stated_clockwise: Option<bool>, stated_unit: Option<f64>) -> ClDataFacts {
    let mut look = ClDataScan::default();
    let (mut st, mut at) = (AptStatement::default(), Mark::START);
    let circles = contains(&source.text, "CIRCLE");
    while let Some((result, next)) = statement::read(source, at, &mut st) {
        if result.is_ok() && !st.assignment {
            look.statement(source, &st, at.line, circles);
        } else if st.major.is_empty() {
            look.remark(source, at);
        }
        at = next;
        // Without circles only the unit is looked for, and UNITS is mostly at the beginning.
        if !circles && look.covered {
            break;
        }
    }
    let mut found = ClDataFacts::default();
    look.sense(stated_clockwise, &mut found);
    look.unit(stated_unit, &mut found);
    found
}

fn contains(text: &str, word: &str) -> bool {
    text.as_bytes().windows(word.len()).any(|w| w.eq_ignore_ascii_case(word.as_bytes()))
}

#[derive(Debug, Default)]
struct ClDataScan {
    nx: u32,
    eleven: u32,
    right_hand: Option<&'static str>,
    votes: Votes,
    here: Option<[f64; 3]>,
    /// Direction of the last straight motion.
    along: Option<[f64; 3]>,
    open: Option<ClDataCircle>,
    rapid: bool,
    /// UNITS comes before the first length.
    covered: bool,
    has_length: bool,
    inch_feed: Option<u32>,
    mm_feed: Option<u32>,
}

impl ClDataScan {
    fn remark(&mut self, source: &Source, at: Mark) {
        let line = source.line(at).map_or("", |(line, _)| line).trim_start();
        if line.starts_with("$$*") && contains(line, "Pro/CLfile") || line.starts_with("$$->") {
            self.right_hand = Some("Creo");
        } else if contains(line, "written by Proveout") {
            self.right_hand = Some("Proveout");
        } else if contains(line, "CATIA") {
            self.right_hand = Some("CATIA");
        }
    }

    fn statement(&mut self, source: &Source, st: &AptStatement, line: u32, circles: bool) {
        match st.major.as_str() {
            "" => self.remark(source, st.head.mark),
            "TOOL PATH" | "TLDATA" | "PAINT" | "END-OF-PATH" | "MSYS" => {
                self.nx += 1;
                (self.along, self.open) = (None, None);
            }
            "TRNTYP" | "UNIT" if self.right_hand.is_none() => {
                self.right_hand = Some("CAMWorks");
                self.covered |= st.major == "UNIT" && !self.has_length;
            }
            major if major.starts_with("CSI_SET_") => self.right_hand = Some("CAMWorks"),
            "UNIT" | "UNITS" => self.covered |= !self.has_length,
            "FEDRAT" | "CYCLE" => self.feed_words(source, st, line),
            "RAPID" => self.rapid = true,
            "TRANS" | "CSYS" => (self.along, self.here, self.open) = (None, None, None),
            "CIRCLE" => {
                self.has_length = true;
                if circles {
                    self.circle(st);
                }
            }
            "GOTO" | "FROM" | "GODLTA" | "GOHOME" | "MOVARC" | "TLON,GOFWD" => {
                self.has_length = true;
                if circles {
                    self.motion(st);
                }
            }
            _ => {}
        }
    }

    fn feed_words(&mut self, source: &Source, st: &AptStatement, line: u32) {
        for item in st.items.iter().filter(|item| item.token == Token::Word) {
            match item.place.text(source).to_ascii_uppercase().as_str() {
                "IPM" | "IPR" | "FPM" => _ = self.inch_feed.get_or_insert(line),
                "MMPM" | "MMPR" => _ = self.mm_feed.get_or_insert(line),
                _ => {}
            }
        }
    }

    fn circle(&mut self, st: &AptStatement) {
        let values = numbers(st);
        if values.len() >= 11 {
            self.eleven += 1;
        }
        // Another circle follows: its tangent says nothing without the sense.
        self.close(None);
        let (Some(here), [x, y, z, i, j, k, ..]) = (self.here, values.as_slice()) else { return };
        let Some(normal) = frame::unit([*i, *j, *k]) else { return };
        if self.votes.circles < MAX_CIRCLES {
            self.open =
                Some(ClDataCircle { center: [*x, *y, *z], normal, start: here, end: None, before: self.along.take() });
        }
    }

    fn motion(&mut self, st: &AptStatement) {
        let rapid = std::mem::take(&mut self.rapid);
        let values = numbers(st);
        let point = match (st.major.as_str(), values.as_slice()) {
            ("GOTO" | "FROM", [x, y, z, ..]) => Some([*x, *y, *z]),
            ("GODLTA", [x, y, z]) => self.here.map(|here| frame::add_scaled(here, [*x, *y, *z], 1.0)),
            _ => None,
        };
        let straight = point.zip(self.here).map(|(to, from)| frame::sub(to, from)).filter(|_| !rapid);
        match &mut self.open {
            Some(circle) if circle.end.is_none() && point.is_some() => {
                circle.end = point;
                self.along = None;
            }
            _ => {
                self.close(straight);
                self.along = straight.filter(|_| st.major != "FROM");
            }
        }
        self.here = point;
    }

    fn close(&mut self, behind: Option<[f64; 3]>) {
        if let Some(circle) = self.open.take() {
            self.votes.take(&circle, behind);
        }
    }

    fn sense(&mut self, stated: Option<bool>, found: &mut ClDataFacts) {
        self.close(None);
        let writer = match (self.right_hand, self.nx > 0 || self.eleven > 0) {
            (None, true) => ClDataWriter::Nx,
            (Some(name), _) => ClDataWriter::RightHand(name),
            (None, false) => ClDataWriter::Unknown,
        };
        if let Some(clockwise) = stated {
            found.clockwise = clockwise;
            return;
        }
        let Votes { clockwise, counter_clockwise, circles } = self.votes;
        let tangents = format!(
            "of {circles} circles {clockwise} are tangent to the path clockwise about their axis and {counter_clockwise} counter-clockwise"
        );
        let key = "state it as arcs.clsf_sense of the control file";
        let by_tangents = clockwise > counter_clockwise;
        let name = |clockwise: bool| if clockwise { "clockwise" } else { "counter-clockwise" };
        let (by_head, head) = match writer {
            ClDataWriter::Nx => (Some(true), "NX writes them clockwise"),
            ClDataWriter::RightHand("Creo") => (Some(false), "Creo writes them counter-clockwise"),
            ClDataWriter::RightHand(_) => {
                (Some(false), "the system that wrote this file writes them counter-clockwise")
            }
            ClDataWriter::Unknown => (None, "the file does not state which system wrote it"),
        };
        let decided = clockwise != counter_clockwise;
        found.clockwise = if decided { by_tangents } else { by_head.unwrap_or(false) };
        if circles == 0 {
            return;
        }
        let taken = name(found.clockwise);
        found.sense_assumed = match by_head {
            Some(by_head) if !decided || by_head == by_tangents => None,
            Some(_) => {
                Some(format!("circles run {taken} about their axis, by their tangents: {head}, and {tangents}; {key}"))
            }
            None if decided && !by_tangents => None,
            None => Some(format!("circles run {taken} about their axis: {head}, and {tangents}; {key}")),
        };
    }

    fn unit(&self, stated: Option<f64>, found: &mut ClDataFacts) {
        if self.covered || !self.has_length || stated.is_some() {
            return;
        }
        let key = "write UNITS/MM or UNITS/INCHES, or state start.unit in the control file";
        let (unit, why) = match (self.inch_feed, self.mm_feed) {
            (Some(inch), Some(mm)) => {
                found.unit_contradicts = Some([inch, mm]);
                return;
            }
            (Some(line), None) => {
                (INCH, format!("lengths count in inch, as the feeds do (line {line}): no UNITS states it"))
            }
            (None, Some(line)) => {
                found.unit = Some(1.0);
                found.unit_told = Some(format!(
                    "lengths count in mm, as the feeds do (line {line}): no UNITS states \
                                                it"
                ));
                return;
            }
            (None, None) => (1.0, "lengths count in mm: neither UNITS nor a feed states the unit".to_owned()),
        };
        found.unit = Some(unit);
        found.unit_assumed = Some(format!("{why}; {key}"));
    }
}

/// The numbers that a statement begins with.
fn numbers(st: &AptStatement) -> Vec<f64> {
    let number = |item: &statement::Item| match item.token {
        Token::Number(value) if value.is_finite() => Some(value),
        _ => None,
    };
    st.items.iter().map_while(number).collect()
}
