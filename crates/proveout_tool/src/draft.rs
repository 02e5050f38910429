//! A tool from another program's file, on its way into a library: given dimensions, missing dimensions, and
//! why a missing one has its value.
//!
//! A draft keeps read and assumed values apart. [`ToolDraft::complete`] assumes what a library requires
//! (flute length, gauge length) and gives the reason. [`library_text`] writes everything as a library file
//! and names the assumed keys with their reasons.

use std::fmt::Write as _;

use crate::import::words::SubstituteBody;
use crate::{HolderSection, Thread, ThreadSize, thread_of};

/// Flute length in diameters where it is not given: that of a usual end mill. A deeper cut is a finding, so
/// a longer tool is never assumed.
const FLUTES_OVER_DIAMETER: f64 = 3.0;
/// Flutes of a tool of which only the point cuts, over its height.
const FLUTES_OVER_POINT: f64 = 1.0;
/// Projection beyond the flutes where it is not given, mm.
const BEHIND_FLUTES_MM: f64 = 15.0;
/// Projection beyond the deepest cut where the projection is not given, mm.
const ABOVE_CUT_MM: f64 = 5.0;
/// Lengths that differ by less are one, mm.
pub(crate) const SAME_MM: f64 = 1e-6;
/// Gauge length without a holder, mm: a usual projection of tool and holder together.
const BARE_GAUGE_MM: f64 = 150.0;
/// Full point angle of a drill where it is not given, degrees: that of a usual twist drill.
const DRILL_POINT_DEG: f64 = 118.0;
/// A thread is that of a tool whose diameter differs by no more than this part.
const SAME_THREAD: f64 = 0.02;
/// Entering angle of a face mill where it is not given, degrees: a square shoulder, the fullest body of its
/// diameter.
const SQUARE_DEG: f64 = 90.0;

/// One tool as read, mm and degrees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolDraft {
    /// Place in the tool table.
    pub number: u32,
    /// Name; `T7` where none is given.
    pub name: String,
    /// Words for people.
    pub description: String,
    /// `kind` of the library; `None` where the shape is not given.
    pub kind: Option<&'static str>,
    /// Keys of the shape with their values, in the order in which they are written.
    pub shape: Vec<(&'static str, f64)>,
    /// Curve of a `profile`, ends and centers `[radius, height]`.
    pub segments: Vec<([f64; 2], Option<[f64; 2]>)>,
    /// Length of the flutes.
    pub flute_length: Option<f64>,
    /// Diameter and length of the neck above the flutes.
    pub neck: Option<(f64, f64)>,
    /// Diameter of the shank.
    pub shank: Option<f64>,
    /// Length of the tool without its holder.
    pub overall: Option<f64>,
    /// Length from the tip to the holder's nose.
    pub stick_out: Option<f64>,
    /// From the tip to the gauge line.
    pub gauge: Option<f64>,
    /// Number of teeth.
    pub flutes: Option<u32>,
    /// Whether its edges reach the center of its end; `None` where not given.
    pub center_cutting: Option<bool>,
    /// The tool cuts when the spindle turns counter-clockwise.
    pub left_handed: bool,
    /// Name of the holder.
    pub holder_name: String,
    /// Holder from its nose up; empty where not given.
    pub holder: Vec<HolderSection>,
    /// Where the numbers come from.
    pub source: String,
    /// Keys with assumed values, and the reasons.
    pub chosen: Vec<(Vec<&'static str>, String)>,
    /// A thread mill, drawn as the cylinder around its teeth.
    pub thread_mill: bool,
    /// A tap whose pitch nothing gives.
    pub lacks_pitch: bool,
}

/// Holder that a call gives to tools without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainHolder {
    /// Diameter, mm.
    pub diameter: f64,
    /// From its nose to the gauge line, mm.
    pub length: f64,
}

/// What is said of a tap without a pitch.
const NO_PITCH: &str = "no pitch is given: write `pitch_mm`, or thread and feed are not checked";

impl ToolDraft {
    /// A tool of which nothing is known but its number.
    pub fn new(number: u32, source: impl Into<String>) -> Self {
        Self { number, name: format!("T{number}"), source: source.into(), ..Self::default() }
    }

    /// Value of a key of its shape.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.shape.iter().find(|(known, _)| *known == key).map(|(_, value)| *value)
    }

    /// Gives the shape a value; one that is there is replaced.
    pub fn put(&mut self, key: &'static str, value: f64) {
        match self.shape.iter_mut().find(|(known, _)| *known == key) {
            Some((_, old)) => *old = value,
            None => self.shape.push((key, value)),
        }
    }

    /// Cutting diameter, mm, if known.
    pub fn diameter(&self) -> Option<f64> {
        let outline = self.segments.iter().map(|([r, _], _)| 2.0 * r).fold(0.0, f64::max);
        self.get("diameter_mm").or((outline > 0.0).then_some(outline))
    }

    /// Makes this tool a tap. The pitch is `pitch` (mm), or else that of a thread named in `text`. Without
    /// a valid pitch the tap has none, with the reason `why`: its thread is then not known. A named thread
    /// whose diameter differs from the tool's is ignored.
    pub fn become_tap(&mut self, text: &str, pitch: Option<f64>, why: &str) {
        let named = thread_of(text);
        if let (None, Some(size)) = (self.diameter(), named) {
            self.put("diameter_mm", size.diameter);
        }
        let diameter = self.diameter().unwrap_or(0.0);
        let same = |size: &ThreadSize| (size.diameter - diameter).abs() <= SAME_THREAD * diameter;
        let named = named.filter(same);
        let pitch = pitch.or(named.map(|size| size.pitch)).filter(|p| Thread::new(diameter, *p).is_ok());
        let Some(pitch) = pitch else {
            (self.kind, self.lacks_pitch) = (Some("tap"), true);
            self.choose(&["kind"], format!("{why}; {NO_PITCH}"));
            return;
        };
        self.kind = Some("tap");
        self.put("pitch_mm", pitch);
        if named.is_some_and(|size| !size.pitch_told && size.pitch == pitch) {
            self.choose(&["pitch_mm"], "a size without a pitch is the coarse one of ISO 261");
        }
    }

    /// Takes the body of this kind for a tool whose own the library lacks.
    pub fn stand_in(&mut self, body: SubstituteBody) {
        self.thread_mill = body == SubstituteBody::ThreadMill;
        self.choose(&["kind"], body.reason());
    }

    /// Marks keys as chosen.
    pub fn choose(&mut self, keys: &[&'static str], reason: impl Into<String>) {
        self.chosen.push((keys.to_vec(), reason.into()));
    }

    /// Height of the cutting end: below it the flutes cannot end, mm.
    fn end_height(&self) -> f64 {
        let d = self.diameter().unwrap_or(0.0);
        let point = |angle: f64, tip: f64| 0.5 * (d - tip) / (0.5 * angle).to_radians().tan();
        match self.kind {
            Some("ball") => 0.5 * d,
            Some("bull_nose" | "face_mill") => self.get("corner_radius_mm").unwrap_or(0.0),
            Some("drill") => point(self.get("point_angle_deg").unwrap_or(DRILL_POINT_DEG), 0.0),
            Some("chamfer") => {
                point(self.get("point_angle_deg").unwrap_or(90.0), self.get("tip_diameter_mm").unwrap_or(0.0))
            }
            Some("taper_ball") => {
                let half = self.get("half_angle_deg").unwrap_or(1.0).to_radians();
                let tip = self.get("tip_diameter_mm").unwrap_or(0.0);
                // Ball up to its tangent circle, then the cone.
                0.5 * tip * (1.0 - half.sin()) + (0.5 * d - 0.5 * tip * half.cos()) / half.tan()
            }
            Some("oval" | "lens" | "barrel" | "drum_wheel") => 0.5 * d,
            _ => self.segments.iter().map(|([_, z], _)| *z).fold(0.0, f64::max),
        }
    }

    /// Assumes what a library requires and the file does not give; every assumption has its reason.
    /// `holder` is that of the call, for a tool without one. With `None` the tool stays without, and what
    /// needs a holder stays unchecked.
    ///
    /// # Errors
    /// What cannot be assumed: a tool with neither a diameter nor a shape.
    pub fn complete(&mut self, holder: Option<PlainHolder>) -> Result<(), String> {
        let Some(diameter) = self.diameter() else {
            return Err(format!("no diameter is given for tool T{}", self.number));
        };
        if self.kind.is_none() {
            self.kind = Some("flat");
            let reason = "no shape is given: a flat end is the largest body of this diameter";
            self.choose(&["kind"], reason);
        }
        if self.kind == Some("tap") && self.get("pitch_mm").is_none() && !self.lacks_pitch {
            let words = format!("{} {}", self.name, self.description);
            self.become_tap(&words, None, SubstituteBody::Tap.reason());
        }
        let lacking = |this: &Self, key| this.get(key).is_none();
        if self.kind == Some("drill") && lacking(self, "point_angle_deg") {
            self.put("point_angle_deg", DRILL_POINT_DEG);
            self.choose(&["point_angle_deg"], "not given: the point of a usual twist drill");
        }
        if self.kind == Some("face_mill") && lacking(self, "entering_angle_deg") {
            self.put("entering_angle_deg", SQUARE_DEG);
            self.choose(&["entering_angle_deg"], "not given: a square shoulder is the largest body of this diameter");
        }
        if self.kind == Some("face_mill") && lacking(self, "corner_radius_mm") {
            self.put("corner_radius_mm", 0.0);
            self.choose(&["corner_radius_mm"], "not given: a sharp corner is the largest body");
        }
        let end = self.end_height();
        self.give_holder(holder);
        let held: f64 = self.holder.iter().map(|s| s.length).sum();
        // A given gauge length leaves this much below the holder.
        let below = self.gauge.map(|gauge| gauge - held);
        if let (Some(gauge), Some(below)) = (self.gauge, below)
            && held > 0.0
            && (below <= SAME_MM || below + SAME_MM < end.max(self.flute_length.unwrap_or(0.0)))
        {
            return Err(format!(
                "T{} is {} mm long to the gauge line ({}), and its holder {} mm: the tool does not project far enough",
                self.number,
                plain_number(gauge),
                self.source,
                plain_number(held)
            ));
        }
        if self.flute_length.is_none() && self.kind != Some("profile") {
            let length = match self.kind {
                Some("chamfer") => FLUTES_OVER_POINT * end,
                Some("face_mill") => (0.2 * diameter).max(end + 1.0),
                _ => (FLUTES_OVER_DIAMETER * diameter).max(end + 1.0),
            };
            let length = rounded(length);
            self.flute_length = Some(below.map_or(length, |below| length.min(below)));
            let reason =
                format!("not given: a usual length for {diameter} mm; write your own, since a deeper cut is a finding");
            self.choose(&["flute_length_mm"], reason);
        }
        let cutter = self.flute_length.unwrap_or(0.0).max(end);
        let reach = cutter + self.neck.map_or(0.0, |(_, length)| length);
        if self.gauge.is_none() {
            if let (Some(out), true) = (self.stick_out, held > 0.0) {
                self.gauge = Some(out + held);
            } else {
                let out = self.stick_out.unwrap_or(rounded(reach + BEHIND_FLUTES_MM));
                let length = if held > 0.0 { out + held } else { BARE_GAUGE_MM.max(out + 50.0) };
                self.gauge = Some(length);
                let reason = if held > 0.0 {
                    format!("no projection is given: {BEHIND_FLUTES_MM} mm more than the flute length")
                } else {
                    "no length to the gauge line is given: a usual one; measure yours before you trust travel limits"
                        .into()
                };
                self.choose(&["gauge_length_mm"], reason);
            }
        }
        // It proves that the tool reaches into its holder; without one there is nothing to reach.
        if held <= 0.0 && self.overall < self.gauge {
            self.overall = None;
        }
        self.without_short_overall();
        Ok(())
    }

    /// Drops an overall length that ends before the holder if the projection is assumed. One of the two
    /// lengths does not mean what it is taken for, and only the overall length may be left out.
    fn without_short_overall(&mut self) {
        let out = self.gauge.unwrap_or(0.0) - self.holder.iter().map(|s| s.length).sum::<f64>();
        let chosen = self.chosen.iter().any(|(keys, _)| keys.contains(&"gauge_length_mm"));
        if let Some(overall) = self.overall.filter(|overall| chosen && *overall < out) {
            self.overall = None;
            let reason = format!(
                "no projection is given; the given length of {} mm ends before the holder and is left out",
                plain_number(overall)
            );
            self.explain("gauge_length_mm", &reason);
        }
    }

    /// Gives a tool without a holder that of the call.
    fn give_holder(&mut self, holder: Option<PlainHolder>) {
        if let (true, Some(PlainHolder { diameter, length })) = (self.holder.is_empty(), holder) {
            self.holder = vec![HolderSection { diameter, top_diameter: diameter, length }];
            self.holder_name = "of the call".into();
            self.choose(&["holder"], "the answer `holder`: one holder for all tools without a holder of their own");
        }
    }

    /// Lengthens a tool of assumed projection until it reaches `depth` below the material's top, mm: no one
    /// clamps a tool so short that its holder would hit the part. The assumed flutes of a drill grow by as
    /// much; those of a mill do not, since a cut deeper than the flutes is a finding. Returns whether a
    /// length changed.
    pub fn reach(&mut self, depth: f64) -> bool {
        let is_chosen = |this: &Self, key: &str| this.chosen.iter().any(|(keys, _)| keys.contains(&key));
        let mut changed = false;
        if self.kind == Some("drill") && is_chosen(self, "flute_length_mm") {
            let flutes = rounded(depth + self.end_height());
            if self.flute_length.is_some_and(|own| own < flutes) {
                self.flute_length = Some(flutes);
                self.explain("flute_length_mm", "not given: as long as the deepest hole needs");
                changed = true;
            }
        }
        if !is_chosen(self, "gauge_length_mm") {
            return changed;
        }
        let held: f64 = self.holder.iter().map(|s| s.length).sum();
        let out = rounded(depth + ABOVE_CUT_MM).max(rounded(self.flute_length.unwrap_or(0.0)));
        let length = out + if held > 0.0 { held } else { 50.0 };
        if self.gauge.is_some_and(|own| own < length) {
            self.gauge = Some(length);
            let reason = format!("no projection is given: {ABOVE_CUT_MM} mm more than its deepest cut");
            self.explain("gauge_length_mm", &reason);
            changed = true;
        }
        self.without_short_overall();
        changed
    }

    /// Another reason for a key that was chosen.
    fn explain(&mut self, key: &'static str, reason: &str) {
        self.chosen.iter_mut().for_each(|(keys, _)| keys.retain(|k| *k != key));
        self.chosen.retain(|(keys, _)| !keys.is_empty());
        self.choose(&[key], reason);
    }
}

/// Up to the next half millimeter.
fn rounded(length: f64) -> f64 {
    (2.0 * length).ceil() / 2.0
}

/// A number as a library file has it: no more digits than it needs to be the same to a nanometer.
pub fn plain_number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text in quotes of TOML.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A library file of these tools, in their order.
pub fn library_text(heading: &str, description: &str, tools: &[ToolDraft]) -> String {
    let mut out = String::new();
    for line in heading.lines() {
        let _ = writeln!(out, "# {}", line.trim_end());
    }
    let _ = writeln!(out, "\ndescription = {}", quoted(description));
    for tool in tools {
        write_tool(&mut out, tool);
    }
    out
}

fn write_tool(out: &mut String, tool: &ToolDraft) {
    let n = plain_number;
    let mut line = |text: String| {
        out.push_str(&text);
        out.push('\n');
    };
    line(String::new());
    line("[[tool]]".into());
    line(format!("number = {}", tool.number));
    line(format!("name = {}", quoted(tool.name.trim())));
    if !tool.description.is_empty() {
        line(format!("description = {}", quoted(&tool.description)));
    }
    line(format!("kind = \"{}\"", tool.kind.unwrap_or("flat")));
    for (key, value) in &tool.shape {
        line(format!("{key} = {}", n(*value)));
    }
    if !tool.segments.is_empty() {
        line("segments = [".into());
        for ([r, z], center) in &tool.segments {
            let center = center.map_or_else(String::new, |[r, z]| format!(", center_mm = [{}, {}]", n(r), n(z)));
            line(format!("    {{ to_mm = [{}, {}]{center} }},", n(*r), n(*z)));
        }
        line("]".into());
    }
    let lengths = [
        ("flute_length_mm", tool.flute_length),
        ("neck_diameter_mm", tool.neck.map(|(d, _)| d)),
        ("neck_length_mm", tool.neck.map(|(_, l)| l)),
        ("shank_diameter_mm", tool.shank),
        ("overall_length_mm", tool.overall),
        ("gauge_length_mm", tool.gauge),
    ];
    for (key, value) in lengths {
        if let Some(value) = value {
            line(format!("{key} = {}", n(value)));
        }
    }
    if let Some(flutes) = tool.flutes {
        line(format!("flutes = {flutes}"));
    }
    if tool.thread_mill {
        line("thread_mill = true".into());
    }
    if let Some(yes) = tool.center_cutting {
        line(format!("center_cutting = {yes}"));
    }
    if tool.left_handed {
        line("hand = \"left\"".into());
    }
    if !tool.source.is_empty() {
        line(format!("source = {}", quoted(&tool.source)));
    }
    if !tool.chosen.is_empty() {
        line("chosen = [".into());
        for (keys, reason) in &tool.chosen {
            let keys: Vec<String> = keys.iter().map(|k| quoted(k)).collect();
            line(format!("    {{ keys = [{}], reason = {} }},", keys.join(", "), quoted(reason)));
        }
        line("]".into());
    }
    if !tool.holder.is_empty() {
        line(String::new());
        line("[tool.holder]".into());
        line(format!("name = {}", quoted(&tool.holder_name)));
        line("sections = [".into());
        for s in &tool.holder {
            let top = if s.top_diameter == s.diameter {
                String::new()
            } else {
                format!("top_diameter_mm = {}, ", n(s.top_diameter))
            };
            line(format!("    {{ diameter_mm = {}, {top}length_mm = {} }},", n(s.diameter), n(s.length)));
        }
        line("]".into());
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::ToolLibrary;

    fn draft(kind: &'static str, shape: &[(&'static str, f64)]) -> ToolDraft {
        ToolDraft { kind: Some(kind), shape: shape.to_vec(), ..ToolDraft::new(7, "a comment") }
    }

    #[test]
    fn what_is_chosen_reaches_the_deepest_cut_and_what_is_given_stays() {
        let holder = Some(PlainHolder { diameter: 40.0, length: 60.0 });
        let mut drill = draft("drill", &[("diameter_mm", 8.0)]);
        drill.complete(holder).expect("chosen");
        assert_eq!((drill.flute_length, drill.gauge), (Some(24.0), Some(99.0)));
        assert!(!drill.reach(10.0));
        assert!(drill.reach(50.0));
        // A point of 118 degrees is 2.404 mm high.
        assert_eq!((drill.flute_length, drill.gauge), (Some(52.5), Some(115.0)));
        assert_eq!(drill.chosen.iter().filter(|(keys, _)| keys.contains(&"gauge_length_mm")).count(), 1);
        let mut mill = ToolDraft { gauge: Some(75.0), ..draft("flat", &[("diameter_mm", 8.0)]) };
        mill.complete(holder).expect("given");
        assert_eq!(mill.flute_length, Some(15.0), "no longer than the overhang");
        assert!(!mill.reach(50.0) && mill.gauge == Some(75.0));
        // A library whose tools project from the holder by exactly their flutes.
        let flush = ToolDraft { gauge: Some(80.0), flute_length: Some(20.0), ..draft("flat", &[("diameter_mm", 8.0)]) };
        assert!(flush.clone().complete(holder).is_ok());
        let short = ToolDraft { gauge: Some(30.0), ..draft("flat", &[("diameter_mm", 8.0)]) }.complete(holder);
        assert!(
            short.expect_err("too short").contains("30 mm long to the gauge line (a comment), and its holder 60 mm")
        );
    }

    #[test]
    fn every_completed_kind_is_a_tool_of_the_library() {
        let kinds = [
            draft("ball", &[("diameter_mm", 8.0)]),
            draft("flat", &[("diameter_mm", 12.7)]),
            draft("bull_nose", &[("diameter_mm", 50.0), ("corner_radius_mm", 6.0)]),
            draft("drill", &[("diameter_mm", 0.3)]),
            draft("chamfer", &[("diameter_mm", 10.0), ("point_angle_deg", 90.0), ("tip_diameter_mm", 0.0)]),
            draft("taper_ball", &[("tip_diameter_mm", 2.0), ("half_angle_deg", 4.0), ("diameter_mm", 6.0)]),
            draft("face_mill", &[("diameter_mm", 63.0)]),
            draft("tap", &[("diameter_mm", 8.0), ("pitch_mm", 1.25)]),
            draft("lens", &[("diameter_mm", 10.0), ("lens_radius_mm", 20.0), ("corner_radius_mm", 0.5)]),
            ToolDraft { shape: vec![("diameter_mm", 10.0)], ..ToolDraft::new(7, "") },
        ];
        let holders = [None, Some(PlainHolder { diameter: 40.0, length: 60.0 })];
        for (mut tool, holder) in kinds.into_iter().flat_map(|k| holders.map(|h| (k.clone(), h))) {
            tool.complete(holder).expect("a diameter is given");
            let text = library_text("Made", "made", std::slice::from_ref(&tool));
            let library =
                ToolLibrary::from_text(Path::new("tools.toml"), &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let read = &library.tools[0];
            assert_eq!(read.has_holder, holder.is_some());
            assert!(
                (2.0 * read.cutting().map(|b| b.profile.max_radius()).fold(0.0, f64::max)
                    - tool.diameter().expect("given"))
                .abs()
                    < 1e-6
            );
            let chosen: Vec<&str> =
                library.notes[0].chosen.iter().flat_map(|(keys, _)| keys).map(String::as_str).collect();
            assert!(chosen.contains(&"gauge_length_mm") && chosen.contains(&"flute_length_mm"), "{text}");
        }
    }

    #[test]
    fn a_tool_without_a_diameter_is_not_made_up() {
        let mut nothing = ToolDraft::new(3, "");
        assert!(nothing.complete(None).expect_err("no diameter").contains("T3"));
    }

    #[test]
    fn given_lengths_stay_and_are_not_marked() {
        let mut tool = draft("flat", &[("diameter_mm", 10.0)]);
        tool.flute_length = Some(22.0);
        tool.stick_out = Some(45.0);
        tool.holder = vec![HolderSection { diameter: 30.0, top_diameter: 40.0, length: 70.0 }];
        tool.complete(None).expect("given");
        assert_eq!((tool.gauge, tool.chosen.len()), (Some(115.0), 0));
    }

    #[test]
    fn numbers_and_texts_are_toml() {
        assert_eq!(plain_number(12.700_000_01), "12.7");
        assert_eq!(plain_number(-0.0), "0");
        assert_eq!(quoted("a \"b\" \\ c\n"), "\"a \\\"b\\\" \\\\ c \"");
    }
}
