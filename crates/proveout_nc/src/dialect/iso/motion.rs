//! Straight motions, threads, probing, splines; arcs are in [`super::arcs`].

use super::calls::whole;
use super::flavor::Flavor;
use super::modal::{MotionMode, Plane};
use super::pending::{AXES, Pending};
use super::run_state::Interpreter;
use super::technology::LINEAR;
use super::words::Group;
use crate::channel::{finite, unknown_axes};
use crate::codes;
use crate::control::WholeNumbers;
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};
use crate::g_code::*;
use crate::{AxisValues, Motion, Op, ProbeMotion, SpindleDirection, SplineMotion};

/// Most repetitions of the motion of a block.
const MOST_REPEATS: f64 = 9999.0;
/// A way to probe that is shorter is refused (`convert_probe` of the interpreter of `LinuxCNC`): 0.01 inch.
const LEAST_PROBING_MM: f64 = 0.254;
/// Bits of A, B and C.
const ROTARY: u16 = 0b111000;
/// A rotary axis that is this near to its present position stays, radian.
pub(super) const SAME_ANGLE: f64 = 1e-9;

impl Interpreter {
    /// Executes the motion of a block, if it has one.
    pub(crate) fn motion(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        if self.modal.cycle.is_some() {
            return self.cycle_block(p, span);
        }
        if self.own.no_cycle {
            return Err(Fault::new(codes::CONFLICT, span, "NCYL positions in a cycle, and none is in force")
                .help("write it in a block with a cycle, or G0"));
        }
        let axes = p.axes();
        if self.modal.motion == Some(MotionMode::Nurbs) {
            return self.nurbs_block(p, span);
        }
        let unset = self.modal.motion.is_none() && self.settings.control.start.motion.is_none();
        if unset && axes != 0 && !self.own.flavor.is_linuxcnc() {
            self.motion_at_power_on();
        }
        let Some(mode) = self.modal.motion else { return Ok(()) };
        let vector = self.modal.vectors && p.any_free(b"IJK");
        let arc = matches!(mode, MotionMode::Clockwise | MotionMode::CounterClockwise);
        if mode == MotionMode::Probe && axes == 0 && p.g(Group::Motion).is_some() {
            let message = format!("{} names no axis", self.modal.motion_code);
            return Err(
                Fault::new(codes::MISSING_VALUE, span, message).help("write the point that is probed for: G38.2 Z-5")
            );
        }
        let polar = p.has_polar() || self.is_fagor_polar(p, arc);
        if !(axes != 0 || polar || vector || arc && p.any_free(b"IJKR")) {
            return Ok(());
        }
        self.before_motion(axes, p, span)?;
        for _ in 1..self.repeats(mode, p, span)? {
            self.move_once(mode, &mut p.clone(), span)?;
        }
        self.move_once(mode, p, span)
    }

    /// L of a Haas: how often the motion of the block is made, as in its example of single-point thread
    /// milling (*Mill operator's manual*, G02). Other controls have no such word.
    fn repeats(&self, mode: MotionMode, p: &mut Pending, span: Span) -> Result<u32, Fault> {
        let feed = matches!(mode, MotionMode::Linear | MotionMode::Clockwise | MotionMode::CounterClockwise);
        if self.own.flavor != Flavor::Haas || !feed || !p.any_free(b"L") {
            return Ok(1);
        }
        let times = whole(p.take(b'L').unwrap_or(1.0), "L", MOST_REPEATS, span)?;
        if times == 0 || times > 1 && p.corner_waits_in_block() {
            let message = "L repeats the motion at least once, and not with a chamfer or rounding";
            return Err(Fault::new(codes::BAD_VALUE, span, message).help("write L2 or more, or remove L"));
        }
        Ok(times)
    }

    fn move_once(&mut self, mode: MotionMode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        match mode {
            MotionMode::Rapid => self.straight(p, true, span),
            MotionMode::Linear => self.straight(p, false, span),
            MotionMode::Clockwise | MotionMode::CounterClockwise => self.arc(p, mode == MotionMode::Clockwise, span),
            MotionMode::Thread => self.thread(p, span),
            MotionMode::Spline => self.spline(p, span),
            MotionMode::Probe => self.probe(p, self.modal.motion_code, span),
            MotionMode::Nurbs => Ok(()),
        }
    }

    /// Axis words before any G0 or G1. A Haas begins with G0 (*Mill operator's manual*, list of G
    /// codes). On a Fanuc bit 0 of parameter 3402 decides, G0 where it is not set.
    fn motion_at_power_on(&mut self) {
        self.modal.motion = Some(MotionMode::Rapid);
        self.modal.motion_code = G0;
        self.assume(
            "no G0 or G1 before the first axis word: it is read as G0, which is in force at power-on unless the \
             control is set up to begin with G1",
        );
    }

    /// What is settled before a block moves linear axes.
    pub(crate) fn before_motion(&mut self, axes: u16, p: &Pending, span: Span) -> Result<(), Fault> {
        self.begin_motion();
        self.tell_length(axes);
        if self.modal.plane == Plane::Defined && axes & LINEAR != 0 {
            // No G53.1: the rotary axes are where the program has put them.
            self.modal.plane = Plane::Engaged;
            self.tell_tcp();
        }
        if self.modal.plane == Plane::Dynamic && axes & ROTARY != 0 && !self.rotary_axes_stay(axes, p) {
            return Err(Fault::new(codes::CONFLICT, span, "a rotary axis is programmed while G254 is in force")
                .help("write G255 before the rotary axes turn, and G254 after it"));
        }
        let scaled = self.modal.frames.scale != Frame::IDENTITY;
        if scaled
            && (axes & ROTARY != 0 || self.modal.cycle.is_some_and(|code| !matches!(code, G81 | G82 | G85 | G86 | G89)))
        {
            return Err(Fault::new(
                codes::UNSUPPORTED_WORD,
                span,
                "rotary axes, and cycles with infeeds, threads or shifts, under G51 are not supported",
            )
            .help("write G50 before them"));
        }
        if self.settings.whole_numbers == WholeNumbers::Refused && !self.own.flavor.is_linuxcnc() {
            self.refuse_whole_numbers(axes, p, span)?;
        }
        let reported = self.settings.whole_numbers == WholeNumbers::Told;
        let assumed = reported || self.settings.whole_numbers == WholeNumbers::Assumed;
        if !self.own.noted_integers && !self.own.flavor.is_linuxcnc() && assumed {
            let whole = |letter: &&u8| !p.has_point(**letter) && p.peek(**letter).is_some_and(|v| v != 0.0);
            let of_axes = AXES.iter().enumerate().filter(|(i, _)| axes >> i & 1 == 1).map(|(_, letter)| letter);
            if let Some(&letter) = of_axes.chain(self.length_letters()).find(whole) {
                self.own.noted_integers = true;
                let (letter, value) = (char::from(letter), p.peek(letter).unwrap_or(0.0));
                let text = format!(
                    "{letter}{value} without a decimal point is read as {value} units, not as {value} least increments"
                );
                if reported {
                    self.assume(format!("{text}: a setting of the machine decides, state it as numbers.without_point of its control file"));
                } else {
                    self.note(text);
                }
            }
        }
        Ok(())
    }

    /// Letters other than those of the axes that are lengths in the block: centers and radius of an
    /// arc, planes and infeeds of a cycle.
    fn length_letters(&self) -> &'static [u8] {
        match (self.modal.cycle, self.modal.motion) {
            // K and L of a drilling cycle are a number of holes, P is a time.
            (Some(G73 | G76 | G77 | G83 | G87), _) => b"RQIJ",
            (Some(_), _) => b"RQ",
            (None, Some(MotionMode::Clockwise | MotionMode::CounterClockwise)) => b"IJKR",
            (None, Some(MotionMode::Spline)) => b"IJPQ",
            _ => b"",
        }
    }

    /// Every rotary word of the block names the present position of its axis.
    fn rotary_axes_stay(&self, axes: u16, p: &Pending) -> bool {
        (3..6).filter(|axis| axes >> axis & 1 == 1).all(|axis| {
            let value = self.rotary_of(&mut p.clone(), AXES[axis]);
            let target = if self.modal.incremental {
                value.filter(|v| *v == 0.0).and(self.position.work.get(axis))
            } else {
                value
            };
            matches!((target, self.position.work.get(axis)), (Some(to), Some(now)) if (to - now).abs() < SAME_ANGLE)
        })
    }

    /// Numbers without a decimal point that are not zero, on a control that does not say how it reads them.
    fn refuse_whole_numbers(&self, axes: u16, p: &Pending, span: Span) -> Result<(), Fault> {
        let letters = AXES.iter().enumerate().filter(|(i, _)| axes >> i & 1 == 1).map(|(_, letter)| letter);
        let letters = letters.chain(if self.modal.cycle.is_some() { b"RQIJ" } else { b"IJKR" });
        let mut whole = letters
            .filter_map(|&letter| p.peek(letter).filter(|v| *v != 0.0 && !p.has_point(letter)).map(|v| (letter, v)));
        match whole.next() {
            None => Ok(()),
            Some((letter, value)) => {
                let message =
                    format!("{}{value} has no decimal point, and what it counts is not known", char::from(letter));
                Err(Fault::new(codes::BAD_VALUE, span, message)
                    .help("write the point, or say in the control file what numbers without one count (numbers.without_point)"))
            }
        }
    }

    fn straight(&mut self, p: &mut Pending, rapid: bool, span: Span) -> Result<(), Fault> {
        let axes = p.axes();
        let vector = self.vector(p, axes, span)?;
        let (end, programmed) = self.targets(p, span)?;
        if programmed == 0 && vector.is_none() {
            return Ok(());
        }
        let exact_stop = p.g(Group::ExactStop).is_some();
        self.surface_speed(end.get(0));
        if rapid && vector.is_none() {
            return self.rapid(end, programmed, exact_stop, span);
        }
        if !rapid {
            self.need_feed(if vector.is_some() { LINEAR } else { programmed }, span)?;
        }
        let (mut end, mut programmed) = (end, programmed);
        if programmed & LINEAR != 0 {
            self.with_kept(&mut end, &mut programmed);
            if end.xyz().is_some() {
                self.forget_kept();
            }
        }
        let mut motion = self.complete(end, programmed, exact_stop, span)?;
        if let Some(axis) = vector {
            motion.tool_axis = Some(axis);
            motion.tool_axis_base = frame::unit(self.position.frame().apply_vector(axis));
            for axis in 3..6 {
                motion.end.clear(axis);
                motion.end_base.clear(axis);
            }
        }
        self.go(motion, rapid);
        Ok(())
    }

    /// Unit tool axis from I J K after G43.5.
    fn vector(&self, p: &mut Pending, axes: u16, span: Span) -> Result<Option<[f64; 3]>, Fault> {
        if !self.modal.vectors || !p.any_free(b"IJK") {
            return Ok(None);
        }
        if axes & ROTARY != 0 {
            return Err(Fault::new(codes::ORIENTATION, span, "rotary axes and a tool vector in the same block")
                .help("program one of the two"));
        }
        let components = [b'I', b'J', b'K'].map(|letter| p.take(letter).unwrap_or(0.0));
        frame::unit(components).map(Some).ok_or_else(|| {
            Fault::new(codes::ORIENTATION, span, "the tool vector has no length")
                .help("give the direction from the tip to the holder")
        })
    }

    /// Work coordinates at the end of the block: programmed axes replaced, the others as they are; and the
    /// programmed axes.
    pub(crate) fn targets(&mut self, p: &mut Pending, span: Span) -> Result<(AxisValues, u16), Fault> {
        let mut end = self.position.work;
        let axes = p.axes();
        let mut programmed = axes;
        if self.modal.polar && axes & LINEAR != 0 {
            programmed = self.polar_target(p, &mut end, span)?;
        }
        if self.is_fagor_polar(p, true) || self.is_fagor_polar(p, false) && !self.modal.is_arc() {
            programmed |= self.fagor_polar(p, &mut end, span)?;
        }
        if p.has_polar() {
            programmed |= self.polar_words(p, &mut end, span)?;
        }
        let mut left = p.axes();
        while left != 0 {
            let axis = left.trailing_zeros() as usize;
            left &= left - 1;
            let letter = AXES[axis];
            let rotary = (3..6).contains(&axis);
            let value = if rotary {
                self.rotary_of(p, letter).unwrap_or(0.0)
            } else {
                self.length_of(p, letter).unwrap_or(0.0)
            };
            if self.modal.incremental && value == 0.0 && self.position.work.get(axis).is_none() {
                // An increment of zero needs no position.
                programmed &= !(1 << axis);
                continue;
            }
            let target = match (self.modal.incremental, rotary) {
                (true, _) => self.known(axis, span)? + value,
                (false, true) => self.rolled(axis, value),
                (false, false) => value,
            };
            end.put(axis, finite(axis, target, span)?);
        }
        Ok((end, programmed))
    }

    /// G16: the first axis of the plane is a radius, the second an angle about the work origin.
    fn polar_target(&mut self, p: &mut Pending, end: &mut AxisValues, span: Span) -> Result<u16, Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let axes = p.axes();
        if axes & (1 << u | 1 << v) == 0 {
            return Ok(axes);
        }
        let radius = self.length_of(p, AXES[u]);
        if radius.is_some() && self.modal.incremental {
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, "a polar radius with G91 is not supported")
                .help("write the radius with G90; the angle may be an increment"));
        }
        let angle = p.take(AXES[v]);
        let need = |what: &str| {
            Fault::new(codes::MISSING_VALUE, span, format!("the polar {what} has never been programmed"))
                .help("write both words after G16")
        };
        let radius = radius.or(self.modal.polar_radius).ok_or_else(|| need("radius"))?;
        let angle = match (angle, self.modal.polar_angle) {
            (Some(angle), Some(before)) if self.modal.incremental => before + angle,
            (Some(angle), _) => angle,
            (None, before) => before.ok_or_else(|| need("angle"))?,
        };
        (self.modal.polar_radius, self.modal.polar_angle) = (Some(radius), Some(angle));
        let (s, c) = frame::sin_cos_degrees(angle);
        end.put(u, radius * c);
        end.put(v, radius * s);
        Ok(axes | 1 << u | 1 << v)
    }

    /// A rapid motion. On a tilted plane programs position X and Y first, and Z after the tool
    /// length: while Z is unknown to the program, the axes without a word stay where the machine
    /// has them. The coordinates of such motions are kept for the motion that gives the rest, even
    /// where a tool length is switched on between them along the tool.
    pub(crate) fn rapid(
        &mut self,
        mut end: AxisValues,
        mut programmed: u16,
        exact_stop: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let words = programmed;
        self.with_kept(&mut end, &mut programmed);
        let tilted = matches!(self.modal.plane, Plane::Engaged | Plane::Dynamic);
        if tilted && programmed & LINEAR != 0 && end.xyz().is_none() {
            for axis in (0..3).filter(|axis| programmed >> axis & 1 == 1) {
                if let Some(value) = end.get(axis) {
                    self.own.held.put(axis, value);
                }
            }
            match self.motion_to(end, words) {
                // What is open depends on no word of the block.
                Ok(motion) => self.go(Motion { exact_stop, ..motion }, true),
                Err(_) => self.go_left_open(end, words, exact_stop),
            }
            return Ok(());
        }
        self.own.held = AxisValues::NONE;
        let motion = self.complete(end, programmed, exact_stop, span)?;
        self.go(motion, true);
        Ok(())
    }

    /// Adds the coordinates of earlier rapid motions on a plane to the end of the motion that gives
    /// the rest.
    fn with_kept(&self, end: &mut AxisValues, programmed: &mut u16) {
        for axis in 0..3 {
            if let Some(value) = self.own.held.get(axis)
                && *programmed >> axis & 1 == 0
            {
                end.put(axis, value);
                *programmed |= 1 << axis;
            }
        }
    }

    /// Drops the coordinates of earlier rapid motions on a plane: coordinates have another meaning
    /// from here on.
    pub(crate) fn forget_kept(&mut self) {
        self.own.held = AxisValues::NONE;
    }

    /// Base coordinates of the end of a motion.
    pub(crate) fn complete(
        &self,
        end: AxisValues,
        programmed: u16,
        exact_stop: bool,
        span: Span,
    ) -> Result<Motion, Fault> {
        let mut motion = self.motion_to(end, programmed).map_err(|missing| unknown_axes(&missing, span))?;
        motion.exact_stop = exact_stop;
        Ok(motion)
    }

    /// G33 and G33.1: `LinuxCNC` with the pitch in K, Fanuc in F.
    fn thread(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let letter = if self.own.flavor.is_linuxcnc() { b'K' } else { b'F' };
        let pitch = p.take(letter).map(|v| v * self.modal.unit());
        let Some(pitch) = pitch.filter(|v| *v > 0.0) else {
            let message = format!("the thread has no pitch `{}` above zero", char::from(letter));
            return Err(Fault::new(codes::MISSING_VALUE, span, message).help("write the pitch in the block"));
        };
        let (end, programmed) = self.targets(p, span)?;
        let start = self.position.work;
        if self.modal.motion_code == G33_1 {
            // The tool comes back there.
            for axis in (0..9).filter(|axis| programmed >> axis & 1 == 1) {
                self.known(axis, span)?;
            }
        }
        let motion = self.complete(end, programmed, false, span)?;
        self.go_thread(motion, pitch, None);
        if self.modal.motion_code == G33_1 {
            let back = self.complete(start, programmed, false, span)?;
            let reversed = match self.technology.direction {
                SpindleDirection::CounterClockwise => SpindleDirection::Clockwise,
                _ => SpindleDirection::CounterClockwise,
            };
            self.go_thread(back, pitch, Some(reversed));
        }
        Ok(())
    }

    /// G31, G38.2 to G38.5.
    pub(crate) fn probe(&mut self, p: &mut Pending, code: GCode, span: Span) -> Result<(), Fault> {
        let (end, programmed) = self.targets(p, span)?;
        // Haas: M79 makes a miss an alarm.
        let must_switch = matches!(code, G38_2 | G38_4) || p.has_m(79);
        self.need_feed(programmed, span)?;
        if self.is_rs274() {
            let way = (0..3).map(|axis| end.get(axis).zip(self.position.work.get(axis)).map(|(to, from)| to - from));
            let square: Option<f64> = way.map(|d| d.map(|d| d * d)).sum();
            if square.is_some_and(|square| square.sqrt() < LEAST_PROBING_MM) {
                let message = format!("{code} has less than {LEAST_PROBING_MM} mm to go");
                return Err(Fault::new(codes::BAD_VALUE, span, message).help("begin farther away from the point"));
            }
        }
        let motion = self.complete(end, programmed, false, span)?;
        self.position.move_to(motion.end, motion.end_base);
        self.begin_motion();
        self.emit(Op::Probe(ProbeMotion { motion, away: matches!(code, G38_4 | G38_5), must_switch }));
        Ok(())
    }

    /// G5 X Y I J P Q: cubic, I J from the start, P Q from the end. G5.1 X Y I J: quadratic, raised to cubic.
    fn spline(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        if self.modal.normal != 2 {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "G5 needs the plane G17").help("write G17"));
        }
        if p.axes() & !0b011 != 0 {
            return Err(Fault::new(codes::ARC_GEOMETRY, span, "G5 takes X and Y")
                .help("program the other axes in a block of their own"));
        }
        let start = self.start_point("the spline", span)?;
        let [i, j, from_end_x, from_end_y] = *b"IJPQ";
        let first = (self.length_of(p, i), self.length_of(p, j));
        let missing = |words: &str| {
            Fault::new(codes::MISSING_VALUE, span, format!("the spline needs {words}")).help("write the control points")
        };
        let quadratic = self.modal.motion_code == G5_1;
        let second = if quadratic {
            None
        } else {
            let second = (self.length_of(p, from_end_x), self.length_of(p, from_end_y));
            let (Some(x), Some(y)) = second else { return Err(missing("P and Q")) };
            Some([x, y])
        };
        let first = match first {
            (Some(x), Some(y)) => [x, y],
            (x, y) if quadratic && (x.is_some() || y.is_some()) => [x.unwrap_or(0.0), y.unwrap_or(0.0)],
            (None, None) if !quadratic => {
                self.own.spline_end.map(|v| v.map(|c| -c)).ok_or_else(|| missing("I and J"))?
            }
            _ => return Err(missing("I and J")),
        };
        let (end, programmed) = self.targets(p, span)?;
        self.need_feed(LINEAR, span)?;
        let motion = self.complete(end, programmed, false, span)?;
        let to = motion.end.xyz().unwrap_or(start);
        let control = match second {
            Some(second) => {
                [[start[0] + first[0], start[1] + first[1], start[2]], [to[0] + second[0], to[1] + second[1], to[2]]]
            }
            None => {
                let middle = [start[0] + first[0], start[1] + first[1], start[2]];
                let third = |from: [f64; 3]| std::array::from_fn(|k| from[k] + 2.0 / 3.0 * (middle[k] - from[k]));
                [third(start), third(to)]
            }
        };
        self.own.spline_end = second;
        let control_base = control.map(|point| self.position.point_in_base(point));
        self.position.move_to(motion.end, motion.end_base);
        self.begin_motion();
        self.emit(Op::Spline(SplineMotion { motion, control, control_base }));
        Ok(())
    }
}
