//! Drilling cycles, expanded to motions.
//!
//! ```text
//!   initial level  ----o=====>o        G98 comes back here
//!                             :
//!   R plane        - - - - - -:- - -   G99 comes back here
//!                             |
//!   depth Z        ___________v
//! ```
//!
//! Sources: Fanuc, *Series 30i operator's manual*, "Canned cycle for drilling"; Haas, *Mill operator's
//! manual*; `LinuxCNC`, *G-code reference*, "Canned cycles", and its interpreter (`convert_cycle_xy` in
//! `interp_cycles.cc`, which keeps the initial level in `cycle_il` until another motion mode or G80). With
//! G91, R counts from the initial level and Z from R, however often the cycle is repeated and whatever level
//! the tool has come back to.

use super::flavor::Flavor;
use super::interpreter::{Interpreter, Iso};
use super::modal::{CycleValues, FeedMode};
use super::motion::SAME_ANGLE;
use super::pending::{AXES, Pending};
use super::words::{self, Group};
use crate::channel::milling::SAME_HEIGHT_MM;
use crate::channel::{Holes, Stroke, opposite, unknown_axis};
use crate::codes;
use crate::control::ReturnLevel;
use crate::cycle::iso::{CycleSet, MULTIPLE_OF_SPEED, R_PLANE, REPETITIONS};
use crate::cycle::{Key, Unit};
use crate::diagnostic::{Fault, Span};
use crate::g_code::*;
use crate::{AxisValues, Motion, SpindleDirection};

/// A cycle of less depth below its R plane cuts nothing, mm.
const NO_DEPTH_MM: f64 = 1e-9;
/// Most infeeds of one hole.
const MAX_INFEEDS: usize = 10_000;
/// Way out between the infeeds of tapping, mm: chosen, controls have it as a parameter.
const TAP_LIFT_MM: f64 = 1.0;
/// Most commands of one block: they stay in memory until they are handed out.
const MAX_COMMANDS: usize = 200_000;
/// Most repetitions of one block.
const MAX_REPEATS: f64 = 9999.0;

/// Levels of one hole along the normal of the plane, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    pub(super) initial: Option<f64>,
    pub(super) r: f64,
    pub(super) depth: f64,
}

impl Interpreter {
    /// A cycle comes into force, or G80 ends it.
    pub(crate) fn cycle_word(&mut self, code: GCode) {
        if code == G80 {
            if self.modal.cycle.take().is_some() {
                self.own.cycle = CycleValues::default();
            }
            return;
        }
        if self.modal.cycle.is_none() {
            self.own.cycle = CycleValues::default();
        }
        self.modal.cycle = Some(code);
    }

    /// A block under a cycle: takes its values, and drills where the block has a position.
    pub(crate) fn cycle_block(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let Some(code) = self.modal.cycle else { return Ok(()) };
        if self.settings.control.depth_in_i && matches!(code, G69 | G87 | G88) {
            return self.fagor_cycle_block(code, p, span);
        }
        let normal = self.modal.normal;
        let axes = p.axes();
        // On a LinuxCNC R alone is no hole, and is that of another word.
        let drills = axes != 0 || p.has_polar() || p.any_free(b"R") && !self.is_rs274();
        if !drills && self.is_rs274() {
            // P, Q, R and L of a block without a place are those of another word: a cycle in force is not
            // called there.
            return Ok(());
        }
        if drills {
            self.before_motion(axes, p, span)?;
        }
        if self.own.cycle.initial.is_none() {
            self.own.cycle.initial = self.position.work.get(normal);
        }
        self.no_rotary_motion(p, code, span)?;
        self.unit_of_cycle(code, span)?;
        let repeats = self.cycle_values(p, code, span)?;
        if !drills || repeats == 0 {
            if repeats == 0 {
                p.use_up(b"XYZABCUVW");
            }
            return Ok(());
        }
        if self.own.no_cycle {
            return self.over_hole(p, span);
        }
        self.r_plane_at_tool(code);
        let levels = self.levels(code, self.own.cycle.initial, span)?;
        if self.is_rs274() && levels.initial.is_none() {
            // The way to the hole and the level to come back to begin at the level of the tool.
            return Err(unknown_axis(normal, span));
        }
        self.return_level_at_start(levels);
        if self.own.flavor.is_linuxcnc()
            && let Some(initial) = levels.initial
        {
            return self.holes_of_interpreter(p, code, levels, initial, repeats, span);
        }
        if levels.depth > levels.r && !matches!(code, G77 | G87) {
            self.note(format!("{} feeds upward, from R{} to {}", code, levels.r, levels.depth));
        }
        let place = p.clone();
        for _ in 0..repeats {
            *p = place.clone();
            self.over_hole(p, span)?;
            self.drill(code, levels, span)?;
        }
        Ok(())
    }

    /// The holes of a block on a `LinuxCNC`: the tool moves to a hole at its present level, or
    /// slants up to the return level (`convert_cycle_xy`, `CYCLE_MACRO` of its interpreter).
    fn holes_of_interpreter(
        &mut self,
        p: &mut Pending,
        code: GCode,
        levels: Levels,
        initial: f64,
        repeats: u32,
        span: Span,
    ) -> Result<(), Fault> {
        let normal = self.modal.normal;
        if initial < levels.r {
            self.course(&[Stroke::Rapid(levels.r)], span)?;
        }
        let clear = self.return_level(levels, span)?;
        let place = p.clone();
        for _ in 0..repeats {
            *p = place.clone();
            let (mut end, programmed) = self.targets(p, span)?;
            // Never below the level to come back to.
            let level = self.position.work.get(normal).map_or(clear, |now| now.max(clear));
            end.put(normal, level);
            if (0..9).any(|axis| end.get(axis) != self.position.work.get(axis)) {
                self.cycle_motion(end, programmed | 1 << normal, true, span)?;
            }
            self.drill(code, levels, span)?;
        }
        Ok(())
    }

    /// A `LinuxCNC` keeps the numbers of a cycle, and reads them in another unit after a G20 or G21
    /// in between.
    fn unit_of_cycle(&mut self, code: GCode, span: Span) -> Result<(), Fault> {
        let unit = self.modal.unit();
        let before = self.own.cycle.unit.replace(unit);
        if self.own.flavor.is_linuxcnc() && before.is_some_and(|before| before != unit) {
            let message = format!("the unit changes under {code}, whose values the control would read in the new one");
            return Err(Fault::new(codes::CONFLICT, span, message).help("write G80, the unit, and the cycle again"));
        }
        Ok(())
    }

    /// The cycles of the control.
    pub(super) fn cycles(&self) -> &'static CycleSet {
        words::cycles_of(self.own.flavor, &self.settings.control)
    }

    /// R is optional on a Haas (*Mill operator's manual*, list of the words of G81).
    fn may_leave_out_r(&self, code: GCode) -> bool {
        self.cycles().named(code, b'R', R_PLANE).is_some_and(|word| !word.written)
    }

    /// Where R is left out the hole begins at the present height.
    fn r_plane_at_tool(&mut self, code: GCode) {
        if !self.may_leave_out_r(code) || self.own.cycle.r.is_some() {
            return;
        }
        if let Some(initial) = self.own.cycle.initial {
            self.assume(format!("{code} without R feeds from the current level of the tool"));
            self.own.cycle.r = Some((initial, false));
        }
    }

    /// Where a cycle comes back to before the first G98 or G99. A `LinuxCNC` begins with the R plane, unless
    /// its startup code or the program before has said G98; others begin with the initial level.
    fn return_level_at_start(&mut self, levels: Levels) {
        if self.modal.return_to_r.is_some() || self.settings.control.stated_returns {
            return;
        }
        let stated = self.settings.control.parameters.return_level;
        let to_r = match stated {
            Some(level) => level == ReturnLevel::RPlane,
            None => self.own.flavor.is_linuxcnc(),
        };
        self.modal.return_to_r = Some(to_r);
        if stated.is_none() && to_r && levels.initial.is_none_or(|initial| initial > levels.r) {
            self.assume(
                "before the first G98 or G99 the cycle comes back to the R plane; a startup code or the program before may have said \
                 G98: write the word, or state it as parameters.return_level of the control file",
            );
        }
    }

    /// Above the hole of the block, at rapid rate and at the level of the tool.
    fn over_hole(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let (end, programmed) = self.targets(p, span)?;
        let moves = (0..9).any(|axis| programmed >> axis & 1 == 1 && end.get(axis) != self.position.work.get(axis));
        if moves { self.cycle_motion(end, programmed, true, span) } else { Ok(()) }
    }

    /// On a `LinuxCNC` rotary axes do not move in a cycle: a word of one must name its present
    /// position (*G-code reference*, "Canned cycles", errors). On a Fanuc and a Haas they take part
    /// in the positioning.
    fn no_rotary_motion(&self, p: &Pending, code: GCode, span: Span) -> Result<(), Fault> {
        if !self.own.flavor.is_linuxcnc() {
            return Ok(());
        }
        for (axis, &letter) in AXES.iter().enumerate().skip(3).take(3) {
            let Some(value) = p.peek(letter) else { continue };
            let value = value.to_radians();
            let stays = match self.position.work.get(axis) {
                Some(_) if self.modal.incremental => value == 0.0,
                Some(now) => (now - value).abs() < SAME_ANGLE,
                None => self.modal.incremental && value == 0.0,
            };
            if !stays {
                let message = format!("the rotary axis {} moves in {}", char::from(letter), code);
                return Err(
                    Fault::new(codes::CONFLICT, span, message).help("turn it in a block of its own, before the cycle")
                );
            }
        }
        Ok(())
    }

    /// Takes Z R Q P I J K; gives the number of repetitions.
    fn cycle_values(&mut self, p: &mut Pending, code: GCode, span: Span) -> Result<u32, Fault> {
        let normal = self.modal.normal;
        if self.settings.control.depth_in_i {
            self.depth_in_i(p, code, span)?;
        }
        if p.any_free(&[AXES[normal]]) {
            self.own.cycle.z = self.length_of(p, AXES[normal]).map(|z| (z, self.modal.incremental));
        }
        if p.any_free(b"R") {
            self.own.cycle.r = self.length_of(p, b'R').map(|r| (r, self.modal.incremental));
        }
        if p.any_free(b"Q") {
            self.own.cycle.q = self.length_of(p, b'Q');
        }
        if p.any_free(b"P") {
            let point = p.has_point(b'P');
            self.own.cycle.p = match p.take(b'P') {
                Some(value) => Some(self.seconds(value, point, span)?),
                None => None,
            };
        }
        self.tell_idle_words(p, code);
        let mut times = None;
        let cycles = self.cycles();
        for letter in [b'L', b'K'] {
            if cycles.named(code, letter, REPETITIONS).is_some() && p.any_free(&[letter]) {
                times = p.take(letter);
            }
        }
        if cycles.named(code, b'J', MULTIPLE_OF_SPEED).is_some()
            && let Some(factor) = p.take(b'J')
        {
            self.note(format!("{code} J{factor}: retraction at a multiple of the speed"));
        }
        let in_ijk = !self.settings.control.depth_in_i && cycles.word(code, b'I').is_some();
        for (at, letter) in [b'I', b'J', b'K'].into_iter().enumerate() {
            if in_ijk && p.any_free(&[letter]) {
                self.own.cycle.ijk[at] = self.length_of(p, letter);
            }
        }
        match times {
            None => Ok(1),
            Some(times) if times.fract() == 0.0 && (0.0..=MAX_REPEATS).contains(&times) => Ok(times as u32),
            Some(times) => {
                Err(Fault::new(codes::BAD_VALUE, span, format!("a cycle runs 0 to {MAX_REPEATS} times, not {times}"))
                    .help("write a whole number"))
            }
        }
    }

    /// Notes words of a hole that this cycle has no use for; the control keeps P and Q for a later
    /// one.
    fn tell_idle_words(&mut self, p: &Pending, code: GCode) {
        let cycles = self.cycles();
        if !cycles.notes_idle_words || self.settings.control.stated_returns {
            return;
        }
        for word in cycles.words(code) {
            if let (Key::Letter(letter), Unit::Unread) = (word.key, word.unit)
                && p.has(letter)
            {
                self.note(format!("{} has no effect in {code}", char::from(letter)));
            }
        }
    }

    /// Fagor: Z is the plane above the hole, I the depth, K the dwell; R of G84 says how the tap follows the
    /// spindle.
    fn depth_in_i(&mut self, p: &mut Pending, code: GCode, span: Span) -> Result<(), Fault> {
        let unsupported = |what: String| {
            Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("{what} is not supported on this control"))
                .help("write the motions of the cycle"))
        };
        if code == G83 {
            return self.depth_in_infeeds(p, span);
        }
        if self.cycles().spec(code).is_none() {
            return unsupported(format!("`{code}`"));
        }
        if p.g(Group::Cycle).is_some() {
            // A definition keeps nothing of the one before: without K there is no dwell.
            self.own.cycle.p = None;
        }
        let normal = AXES[self.modal.normal];
        if self.modal.incremental && p.any_free(&[normal, b'I']) {
            return unsupported(format!("`{code}` with G91"));
        }
        if p.any_free(&[normal]) {
            self.own.cycle.r = self.length_of(p, normal).map(|r| (r, false));
        }
        if p.any_free(b"I") {
            self.own.cycle.z = self.length_of(p, b'I').map(|z| (z, false));
        }
        if p.any_free(b"K") {
            let point = p.has_point(b'K');
            let unit = self.settings.control.dwell_unit(b'K');
            self.own.cycle.p = p.take(b'K').zip(unit).map(|(value, unit)| unit.seconds(value, point));
        }
        match p.peek(b'R') {
            Some(kind) if code == G84 && matches!(kind, 0.0 | 1.0) => {
                p.use_up(b"R");
                Ok(())
            }
            Some(_) => unsupported(format!("`R` of {code}")),
            None => Ok(()),
        }
    }

    /// G83 of a Fagor: Z is the plane above the hole, I each infeed and J their number. After each
    /// infeed the tool comes out to the plane, and goes back at rapid rate to 1 mm above the last
    /// depth (CNC 8055, *Programming manual*, "G83. Deep-hole drilling canned cycle with constant
    /// peck").
    fn depth_in_infeeds(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let normal = AXES[self.modal.normal];
        let given = p.any_free(&[normal, b'I', b'J']);
        if given && self.modal.incremental {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "`G83` with G91 is not supported on this control")
                .help("write the cycle with G90"));
        }
        if p.any_free(&[normal]) {
            self.own.cycle.r = self.length_of(p, normal).map(|r| (r, false));
        }
        if let Some(infeed) = self.length_of(p, b'I') {
            self.own.cycle.ijk[0] = Some(infeed);
        }
        if let Some(count) = p.take(b'J') {
            self.own.cycle.ijk[1] = Some(count);
        }
        let wrong = |message: String| {
            Err(Fault::new(codes::ARGUMENTS, span, message).help("write G83 G98 X10 Y20 Z2 I-5 J3: three infeeds of 5"))
        };
        let [infeed, count, _] = self.own.cycle.ijk;
        let (Some(infeed), Some(count), Some((plane, _))) = (infeed, count, self.own.cycle.r) else {
            return wrong("G83 needs its plane Z, the infeed I and the number of infeeds J".to_owned());
        };
        if !(infeed < 0.0 && infeed.is_finite() && (1.0..=9999.0).contains(&count) && count.fract() == 0.0) {
            return wrong(format!("G83 has the infeed I{infeed}, in mm, and the number of infeeds J{count}"));
        }
        self.own.cycle.q = Some(-infeed);
        self.own.cycle.p = None;
        self.own.cycle.z = Some((plane + infeed * count, false));
        Ok(())
    }

    pub(super) fn levels(&self, code: GCode, reference: Option<f64>, span: Span) -> Result<Levels, Fault> {
        let name = code.to_string();
        let missing = |letter: char| {
            let help = if letter == 'R' && self.own.flavor == Flavor::Fanuc {
                "write depth and R plane of the cycle; a Haas begins at the level of the tool where R is missing: --control haas-ngc"
            } else {
                "write depth and R plane of the cycle"
            };
            Fault::new(codes::MISSING_VALUE, span, format!("{name} has no `{letter}`")).help(help)
        };
        let z = self.own.cycle.z.ok_or_else(|| missing(char::from(AXES[self.modal.normal])))?;
        let r = self.own.cycle.r.ok_or_else(|| {
            if !self.may_leave_out_r(code) || self.own.cycle.initial.is_some() {
                return missing('R');
            }
            let message = format!("{name} without R begins at the level of the tool, which the program has not set");
            Fault::new(codes::POSITION_UNKNOWN, span, message).help("write R, or program Z before the cycle")
        })?;
        // A LinuxCNC reads stored numbers by the G90 or G91 now in force, other controls by the one
        // in force where they were written.
        let linuxcnc = self.own.flavor.is_linuxcnc();
        let incremental = |word: (f64, bool)| if linuxcnc { self.modal.incremental } else { word.1 };
        let level = if incremental(r) {
            let message = format!("{name} with G91 needs the level of the tool, which the program has not set");
            let unknown = Fault::new(codes::POSITION_UNKNOWN, span, message).help("program Z before the cycle");
            reference.ok_or(unknown)? + r.0
        } else {
            r.0
        };
        let depth = if incremental(z) { level + z.0 } else { z.0 };
        let levels = Levels { initial: self.own.cycle.initial, r: level, depth };
        let back = matches!(code, G77 | G87);
        let either = self.cycles().feeds_either_way && matches!(code, G81 | G82 | G85 | G86 | G89);
        if (levels.depth > levels.r) != back && levels.depth != levels.r && !either
            || !levels.depth.is_finite()
            || !levels.r.is_finite()
        {
            let side = if back { "above" } else { "below" };
            let message = format!("the depth {} of {name} does not lie {side} the R plane {}", levels.depth, levels.r);
            let letter = char::from(AXES[self.modal.normal]);
            return Err(Fault::new(codes::ARGUMENTS, span, message).help(format!("check {letter} and R")));
        }
        Ok(levels)
    }

    /// The level to come back to.
    fn return_level(&self, levels: Levels, span: Span) -> Result<f64, Fault> {
        if self.settings.control.stated_returns {
            return self.stated_return(levels, span);
        }
        if self.modal.return_to_r.unwrap_or(false) {
            return Ok(levels.r);
        }
        let Some(initial) = levels.initial else {
            return Err(Fault::new(
                codes::POSITION_UNKNOWN,
                span,
                "G98 comes back to the initial level, which the program has not set",
            )
            .help("program Z before the cycle, or use G99"));
        };
        Ok(if self.own.flavor.is_linuxcnc() { initial.max(levels.r) } else { initial })
    }

    /// M53: the level of G71; M54: the R plane.
    fn stated_return(&self, levels: Levels, span: Span) -> Result<f64, Fault> {
        let missing = |message: &str, help: &str| Err(Fault::new(codes::MISSING_VALUE, span, message).help(help));
        match (self.modal.back_to_level, self.modal.stated_level) {
            (Some(false), _) => Ok(levels.r),
            (Some(true), Some(level)) if level >= levels.r => Ok(level),
            (Some(true), Some(level)) => {
                let message = format!("the level {level} of G71 lies below the R plane {}", levels.r);
                Err(Fault::new(codes::ARGUMENTS, span, message).help("check G71 Z and R"))
            }
            (Some(true), None) => missing(
                "M53 comes back to the level of G71, which the program has not set",
                "write G71 Z before the cycle",
            ),
            (None, _) => {
                missing("neither M53 nor M54 states the return level of the cycle", "write M53 or M54 in its block")
            }
        }
    }

    /// G71 Z, on a control with this word.
    pub(super) fn return_level_word(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let level = self.length_of(p, AXES[self.modal.normal]).filter(|level| level.is_finite());
        let Some(level) = level else {
            return Err(Fault::new(codes::MISSING_VALUE, span, "G71 has no level").help("write G71 Z50."));
        };
        if self.modal.incremental {
            return Err(
                Fault::new(codes::UNSUPPORTED_WORD, span, "`G71` with G91 is not supported").help("write G90 G71 Z")
            );
        }
        self.modal.stated_level = Some(level);
        Ok(())
    }

    pub(super) fn drill(&mut self, code: GCode, levels: Levels, span: Span) -> Result<(), Fault> {
        if (levels.depth - levels.r).abs() < NO_DEPTH_MM {
            self.note(format!(
                "{} cuts nothing here: its depth {} is its R plane; Z in the line of a hole is a new depth",
                code, levels.depth
            ));
        }
        if matches!(code, G77 | G87) {
            return self.back_bore(levels, span);
        }
        let back = self.return_level(levels, span)?;
        let (down, up) = (Stroke::Feed(levels.depth), Stroke::Feed(levels.r));
        let (out, wait) = (Stroke::Rapid(back), Stroke::wait(self.own.cycle.p));
        self.course(&[Stroke::Rapid(levels.r)], span)?;
        match code {
            G73 | G83 => self.peck(code, levels, span)?,
            G74 | G84 => self.tap(code, levels, back, span)?,
            G76 => return self.fine_bore(levels, back, span),
            G82 => self.course(&[down, wait], span)?,
            G85 => self.course(&[down, up], span)?,
            G86 => {
                let again = Stroke::Turn(self.technology.direction);
                self.course(&[down, wait, Stroke::Turn(SpindleDirection::Off), out, again], span)?;
            }
            G89 if self.cycles().feeds_out_to_return => self.course(&[down, wait, Stroke::Feed(back)], span)?,
            G89 => self.course(&[down, wait, up], span)?,
            _ => self.course(&[down], span)?,
        }
        self.course(&[out], span)
    }

    /// G73 and G83.
    fn peck(&mut self, code: GCode, levels: Levels, span: Span) -> Result<(), Fault> {
        let total = levels.r - levels.depth;
        let cycles = self.cycles();
        let clearance = cycles.peck_clearance_mm;
        let stated = self.settings.control.stated_returns;
        if stated && self.modal.incremental {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, format!("`{code}` with G91 is not supported"))
                .help("write the cycle with G90"));
        }
        let [first, less, least] = self.own.cycle.ijk;
        // Okuma: I is the infeed of G73, and each time J is reached the tool comes out to the R plane.
        let mut out_after = less.map(f64::abs).filter(|j| stated && code == G73 && *j > 0.0);
        if self.own.flavor == Flavor::Haas && first.is_none() && (less.is_some() || least.is_some()) {
            // G73 with K and Q comes out to the R plane each time the infeeds add up to K (Haas, *Mill
            // operator's manual*, G73).
            out_after = least.map(f64::abs).filter(|k| code == G73 && less.is_none() && *k > 0.0);
            if out_after.is_none() {
                let message = format!("{code} has J or K, which belong to a first infeed I");
                return Err(Fault::new(codes::ARGUMENTS, span, message).help("write I J K, or Q"));
            }
        }
        let mut since_out = 0.0;
        let wrong =
            |message: String| Err(Fault::new(codes::ARGUMENTS, span, message).help("write the infeed Q above zero"));
        let variable = self.own.flavor == Flavor::Haas && first.is_some();
        let mut infeed =
            match if variable || stated && code == G73 { first.or(self.own.cycle.q) } else { self.own.cycle.q } {
                Some(q) if q.abs() > 0.0 => q.abs(),
                _ => return wrong(format!("{code} has no infeed Q")),
            };
        let mut reached = 0.0;
        for _ in 0..MAX_INFEEDS {
            reached += infeed;
            since_out += infeed;
            // Rounding must not leave a last infeed of nothing.
            let last = reached >= total - SAME_HEIGHT_MM;
            let depth = if last { levels.depth } else { levels.r - reached };
            self.course(&[Stroke::Feed(depth)], span)?;
            if last {
                let dwell = self.own.cycle.p.filter(|_| cycles.pecks_dwell);
                return self.course(&[Stroke::wait(dwell)], span);
            }
            let ahead = Stroke::Rapid((depth + clearance).min(levels.r));
            let comes_out = out_after.is_some_and(|j| since_out >= j - SAME_HEIGHT_MM);
            if comes_out {
                since_out = 0.0;
            }
            if code == G73 && !comes_out {
                self.course(&[ahead], span)?;
            } else {
                self.course(&[Stroke::Rapid(levels.r), ahead], span)?;
            }
            if variable {
                infeed = (infeed - less.unwrap_or(0.0).abs()).max(least.unwrap_or(0.0).abs());
                if infeed <= SAME_HEIGHT_MM {
                    return wrong("the infeeds of the cycle become zero".to_owned());
                }
            }
        }
        wrong(format!("{code} would need more than {MAX_INFEEDS} infeeds"))
    }

    /// G84 and G74: the path follows the spindle in and out.
    fn tap(&mut self, code: GCode, levels: Levels, back: f64, span: Span) -> Result<(), Fault> {
        let Some(feed) = self.own.feed else { return Err(self.no_feed(span)) };
        let speed = self.technology.speed.filter(|s| *s > 0.0);
        let pitch = match (self.modal.feed_mode, speed) {
            (FeedMode::PerRevolution, _) => feed * self.own.feed_unit,
            (FeedMode::PerTime, Some(speed)) => feed * self.own.feed_unit / speed,
            (FeedMode::PerTime, None) => {
                return Err(Fault::new(
                    codes::MISSING_VALUE,
                    span,
                    format!("{code} has no spindle speed: the pitch is F over S"),
                )
                .help("write S before the cycle"));
            }
            (FeedMode::InverseTime, _) => {
                return Err(Fault::new(codes::CONFLICT, span, "tapping with inverse time feed has no pitch")
                    .help("write G94 or G95"));
            }
        };
        let turn = if code == G84 { SpindleDirection::Clockwise } else { SpindleDirection::CounterClockwise };
        self.tap_steps(levels, pitch, turn, span)?;
        let cycles = self.cycles();
        let out = if cycles.feeds_out_to_return { back } else { levels.r };
        let wait = Stroke::wait(self.own.cycle.p);
        let down = Stroke::Thread { to: levels.depth, pitch, turn };
        let up = Stroke::Thread { to: out, pitch, turn: opposite(turn) };
        if cycles.tap_dwells_at_bottom_only {
            return self.course(&[down, wait, up], span);
        }
        self.course(&[down, wait, up, wait], span)
    }

    /// The infeeds before the last one where Q gives them: in by Q, and out to break the chip
    /// (Fanuc, *Operator's manual*, "Peck rigid tapping cycle"; bit 5 of parameter 5200 selects how
    /// far out, parameter 5213 gives the distance).
    fn tap_steps(&mut self, levels: Levels, pitch: f64, turn: SpindleDirection, span: Span) -> Result<(), Fault> {
        let Some(infeed) = self.own.cycle.q.map(f64::abs).filter(|q| *q > 0.0) else { return Ok(()) };
        if self.own.flavor.is_linuxcnc() {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "`Q` of tapping is not a word of LinuxCNC")
                .help("tap in one stroke"));
        }
        let total = levels.r - levels.depth;
        if total / infeed > MAX_INFEEDS as f64 {
            return Err(Fault::new(
                codes::ARGUMENTS,
                span,
                format!("tapping would need more than {MAX_INFEEDS} infeeds"),
            )
            .help("write a larger infeed Q"));
        }
        self.assume(format!(
            "tapping in steps comes out by {TAP_LIFT_MM} mm after each; the control is set up for a distance, or for the R plane (parameters 5200 and 5213 of a Fanuc)"
        ));
        let mut reached = infeed;
        while reached < total - SAME_HEIGHT_MM {
            let down = Stroke::Thread { to: levels.r - reached, pitch, turn };
            let lift = (levels.r - reached + TAP_LIFT_MM).min(levels.r);
            self.course(&[down, Stroke::Thread { to: lift, pitch, turn: opposite(turn) }], span)?;
            reached += infeed;
        }
        Ok(())
    }

    /// Work coordinates of a point on the axis of the hole.
    fn on_axis(&self, to: f64) -> AxisValues {
        let mut end = self.position.work;
        end.put(self.modal.normal, to);
        end
    }

    pub(super) fn cycle_motion(
        &mut self,
        end: AxisValues,
        programmed: u16,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        if self.queue.len() > MAX_COMMANDS {
            let message = format!("the cycle gives more than {MAX_COMMANDS} commands in one block");
            return Err(Fault::new(codes::LOOP_LIMIT, span, message).help("check the infeed Q and the repetitions"));
        }
        if rapid {
            return self.rapid(end, programmed, false, span);
        }
        self.need_feed(programmed, span)?;
        let motion = self.complete(end, programmed, false, span)?;
        self.go(motion, false);
        Ok(())
    }
}

impl Holes for Iso {
    fn stands_at(channel: &Interpreter, to: f64) -> bool {
        channel.position.work.get(channel.modal.normal) == Some(to)
    }

    fn stroke(channel: &mut Interpreter, to: f64, rapid: bool, span: Span) -> Result<(), Fault> {
        channel.cycle_motion(channel.on_axis(to), 1 << channel.modal.normal, rapid, span)
    }

    fn thread_stroke(channel: &mut Interpreter, to: f64, span: Span) -> Result<Motion, Fault> {
        channel.complete(channel.on_axis(to), 1 << channel.modal.normal, false, span)
    }
}
