//! The passes as a Siemens 840D program.

use std::fmt::Write as _;

use super::{
    geometry::{Location, Rotaries},
    plan::{
        BASE_DEPTH, BASE_RADIUS, CLEARANCE, ConeCutter, ConePass, HALF_ANGLE_DEG, LEAD_DEG, OVERLAP_DEG, PLUNGE_MM_MIN,
        SAFE_HEIGHT, TILT_DEG, greatest_depth, passes,
    },
};

/// Decimals of X, Y and Z in mm.
pub(crate) const LENGTH_DECIMALS: usize = 4;
/// Decimals of the rotary words in degrees.
pub(crate) const ANGLE_DECIMALS: usize = 5;

/// What differs from machine to machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ProgramTarget {
    /// Name of the program in the scene, and of its file.
    pub(crate) name: &'static str,
    /// Words for the head of the program.
    pub(crate) description: &'static str,
    /// Rotary axes.
    pub(crate) rotaries: Rotaries,
    /// Machine coordinates X, Y, Z of the place for tool changes, mm.
    pub(crate) home: [f64; 3],
}

/// Tool change position of both machines: that of the production programs of the Spinner U5-620.
const HOME: [f64; 3] = [-365.0, 224.0, 610.0];

/// The programs of the scene.
pub(crate) const TARGETS: [ProgramTarget; 2] = [
    ProgramTarget { name: "bc", description: "C table on a B trunnion", rotaries: Rotaries::Bc, home: HOME },
    ProgramTarget { name: "ac", description: "C table on an A trunnion", rotaries: Rotaries::Ac, home: HOME },
];

/// What the generator says about a pass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PassReport {
    /// Words.
    pub(crate) name: String,
    /// Blocks of a full turn.
    pub(crate) blocks_per_turn: u32,
    /// Largest entry into the allowance between two blocks, mm.
    pub(crate) entry: f64,
    /// Distance off the cone at start and end, beyond the allowance, mm.
    pub(crate) clear_offset: f64,
}

/// A program and what its making found.
pub(crate) struct ConeProgram {
    /// The text, with a line feed after each block.
    pub(crate) text: String,
    /// One entry a pass.
    pub(crate) passes: Vec<PassReport>,
}

/// A number as written in a program: fixed decimals, no zeros at the end, no sign before zero, always a
/// point.
pub(crate) fn word(value: f64, decimals: usize) -> String {
    let fixed = format!("{value:.decimals$}");
    let short = if fixed.contains('.') { fixed.trim_end_matches('0') } else { &fixed };
    match short {
        "-0." => "0.0".to_owned(),
        s if s.ends_with('.') => format!("{s}0"),
        s => s.to_owned(),
    }
}

struct ProgramWriter {
    text: String,
    number: u32,
}

impl ProgramWriter {
    fn block(&mut self, words: &str) {
        self.number += 10;
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "N{} {words}", self.number);
    }
}

fn xyz(location: &Location) -> String {
    let [x, y, z] = location.tip.map(|v| word(v, LENGTH_DECIMALS));
    format!("X{x} Y{y} Z{z}")
}

/// Writes the program for a machine.
pub(crate) fn write(target: &ProgramTarget) -> ConeProgram {
    let mut out = ProgramWriter { text: String::new(), number: 0 };
    let mut reports = Vec::new();
    head(&mut out, target);
    let mut cutter = None;
    for (index, pass) in passes().iter().enumerate() {
        if cutter != Some(pass.cutter) {
            change_tool(&mut out, target.rotaries, &pass.cutter);
            cutter = Some(pass.cutter);
        }
        reports.push(write_pass(&mut out, target.rotaries, index, pass));
    }
    foot(&mut out, target.rotaries);
    ConeProgram { text: out.text, passes: reports }
}

fn head(out: &mut ProgramWriter, target: &ProgramTarget) {
    let tilt = target.rotaries.tilt_letter();
    let [x, y, z] = target.home.map(|v| word(v, LENGTH_DECIMALS));
    out.block(&format!(";TILTED CONE FRUSTUM, FIVE-AXIS FLANK CUT, {}", target.description));
    out.block(";Written by: cargo xtask cone-frustum. Do not edit by hand.");
    out.block(&format!(";Half apex angle {HALF_ANGLE_DEG} deg, axis tilted {TILT_DEG} deg from +Z toward +X"));
    out.block(&format!(";Base circle radius {BASE_RADIUS} mm, center X0 Y0 Z-{BASE_DEPTH}; Z0 is the top face"));
    out.block(&format!(";Flutes must be longer than {:.1} mm", greatest_depth()));
    for name in ["_camtolerance".to_owned(), format!("_X_HOME, _Y_HOME, _Z_HOME, _{tilt}_HOME, _C_HOME")] {
        out.block(&format!("DEF REAL {name}"));
    }
    out.block("G40 G17 G710 G94 G90 G60 G601 FNORM");
    out.block("CYCLE800()");
    out.block(&format!("_X_HOME={x} _Y_HOME={y} _Z_HOME={z}"));
    out.block(&format!("_{tilt}_HOME=0.0 _C_HOME=0.0"));
}

fn change_tool(out: &mut ProgramWriter, rotaries: Rotaries, cutter: &ConeCutter) {
    out.block("M9");
    go_home(out, rotaries);
    out.block("M5");
    out.block(&format!("T=\"{}\"", cutter.name));
    out.block("M6");
    go_home(out, rotaries);
}

fn go_home(out: &mut ProgramWriter, rotaries: Rotaries) {
    let tilt = rotaries.tilt_letter();
    out.block("TRAFOOF");
    out.block("SUPA G0 Z=_Z_HOME D0");
    out.block("SUPA G0 X=_X_HOME Y=_Y_HOME");
    out.block(&format!("SUPA G0 {tilt}=_{tilt}_HOME C=_C_HOME D1"));
}

fn foot(out: &mut ProgramWriter, rotaries: Rotaries) {
    out.block("M9");
    go_home(out, rotaries);
    out.block("CYCLE832()");
    out.block("M5");
    out.block("M30");
}

/// One pass: rotary axes to the start while the spindle is up, down at the side of the blank, roll in, one
/// turn, roll out, up.
///
/// The turn runs clockwise seen from above, which is climb milling with a right-hand cutter. C is wound
/// back between the passes with the transformation off, so that no interpolation of orientations has to
/// make a full turn.
fn write_pass(out: &mut ProgramWriter, rotaries: Rotaries, index: usize, pass: &ConePass) -> PassReport {
    let tilt_letter = rotaries.tilt_letter();
    let blocks_per_turn = pass.blocks_per_turn(rotaries);
    let clear_offset = pass.clear_offset();
    let step = std::f64::consts::TAU / f64::from(blocks_per_turn);
    let steps_of = |degrees: f64| (degrees.to_radians() / step).ceil() as i32;
    let lead = steps_of(LEAD_DEG);
    let turn_end = -(blocks_per_turn as i32) - steps_of(OVERLAP_DEG);
    // Distance off the cone falls with the square of the angle to go: the path is tangential where it meets
    // the turn.
    let extra = |i: i32| {
        let to_go = f64::from((i.max(0)).max(turn_end - i)) / f64::from(lead);
        clear_offset * to_go * to_go
    };
    let at = |i: i32| pass.location(f64::from(i) * step, extra(i));

    let start = at(lead);
    // Half a turn on each side of zero keeps C small.
    let mut c = std::f64::consts::PI;
    let mut rotary_words = |location: &Location| {
        let [tilt, c_new] = rotaries.angles(location.axis, c);
        c = c_new;
        let [tilt, c_new] = [tilt, c_new].map(|v| word(v.to_degrees(), ANGLE_DECIMALS));
        format!("{tilt_letter}{tilt} C{c_new}")
    };
    let number = index + 1;
    let name = format!("{number} {}, allowance {} mm", pass.name, pass.allowance);
    let start_rotary = rotary_words(&start);
    let (start_high, start_low) = (start.raised_to(SAFE_HEIGHT), start.raised_to(CLEARANCE));

    out.block(&format!(";Pass {name}, lower end {:.3} mm from the apex", pass.lower_end));
    out.block(&format!(";{blocks_per_turn} blocks a turn: at most {} mm between blocks", pass.chord_bound));
    out.block(&format!("MSG(\"{} {number}\")", pass.name));
    out.block(&format!("_camtolerance={}", word(pass.path_tolerance, LENGTH_DECIMALS)));
    out.block("TRAFOOF");
    out.block("SUPA G0 Z=_Z_HOME D0");
    out.block(&format!("SUPA G0 {start_rotary} D1"));
    out.block("CYCLE832(_camtolerance,1,1)");
    out.block("TRAORI");
    out.block("G54");
    out.block(&format!("G0 {} {start_rotary} S{} D1 M3 M8", xyz(&start_high), pass.cutter.spindle_rpm));
    out.block(&format!("G0 {} {start_rotary}", xyz(&start_low)));
    out.block(&format!("G1 {} {start_rotary} F{}", xyz(&start), word(PLUNGE_MM_MIN, 1)));
    for i in (turn_end - lead..lead).rev() {
        let location = at(i);
        let feed = if i == lead - 1 { format!(" F{}", word(pass.cutter.feed_mm_min, 1)) } else { String::new() };
        let rotary = rotary_words(&location);
        out.block(&format!("{} {rotary}{feed}", xyz(&location)));
    }
    let end = at(turn_end - lead).raised_to(SAFE_HEIGHT);
    let end_rotary = rotary_words(&end);
    out.block(&format!("G0 {} {end_rotary}", xyz(&end)));
    PassReport { name, blocks_per_turn, entry: pass.entry(rotaries, blocks_per_turn), clear_offset }
}
