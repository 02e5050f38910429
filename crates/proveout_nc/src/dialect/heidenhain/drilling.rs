//! Drilling cycles, expanded to the motions of the control.
//!
//! Courses after HEIDENHAIN, *TNC 640 Programming of machining cycles*, chapters "Drilling" and "Tapping":
//! 200 drilling, 201 reaming, 203 universal drilling, 205 universal pecking, 206 and 207 tapping, 209 tapping
//! with chip breaking, 240 centering, 241 single-fluted deep-hole drilling; 1, 2 and 17 of older controls.
//! The boring cycles 202 and 204 are in [`super::boring`]. All lengths run along the tool axis:
//!
//! ```text
//!   2nd set-up clearance   Q203 + Q204
//!   set-up clearance       Q203 + Q200   the cycle starts and ends here
//!   surface                Q203
//!   depth                  Q203 + Q201   (Q201 negative: towards the workpiece)
//! ```

use super::boring;
use super::interpreter::{Heidenhain, Interpreter};
use super::motion::Goal;
use crate::channel::milling::{Heights, SAME_HEIGHT_MM};
use crate::channel::{Holes, Stroke, direction_of, direction_of_thread, opposite};
use crate::codes;
use crate::cycle::{Given, Values};
use crate::diagnostic::{Fault, Span};
use crate::{Feed, Motion, SpindleDirection};

/// Most infeeds of one hole.
const MAX_INFEEDS: u32 = 10_000;
/// Least infeed where the decrement would leave less, mm.
const LEAST_INFEED_MM: f64 = 1e-6;

impl Holes for Heidenhain {
    fn stands_at(channel: &Interpreter, to: f64) -> bool {
        channel.position.work.get(channel.modal.normal) == Some(to)
    }

    fn stroke(channel: &mut Interpreter, to: f64, rapid: bool, span: Span) -> Result<(), Fault> {
        channel.straight(channel.on_axis(to), rapid, span)
    }

    fn thread_stroke(channel: &mut Interpreter, to: f64, span: Span) -> Result<Motion, Fault> {
        let motion = channel.complete(channel.on_axis(to), span)?;
        channel.modal.tangent = None;
        Ok(motion)
    }
}

/// Checks the parameters of a cycle for holes when it is defined: refuses unsupported ones, a missing Q200
/// and a depth of zero.
pub(super) fn check_hole(v: &Values) -> Result<(), Fault> {
    let zeros = [
        (
            395,
            "depth counted from the cylinder of the drill",
            "it needs the point angle of the tool: write the depth of the tip and Q395=0",
        ),
        (343, "depth from the diameter", "it needs the point angle of the tool: write the depth in Q201 and Q343=0"),
        (435, "dwell at depth", "write Q435=0"),
        (401, "feed factor", "write Q401=0"),
    ];
    for (key, what, remedy) in zeros {
        match v.given(key) {
            Some(Given::Number(number)) if *number != 0.0 && (key, *number) != (401, 100.0) => {
                return Err(super::lexer::refused(&format!("Q{key}={number} ({what})"), v.span, remedy));
            }
            _ => {}
        }
    }
    v.value(200)?;
    if v.name() == "204" { boring::check_back_boring(v) } else { check_depth(v) }
}

/// Refuses a depth of zero.
pub(super) fn check_depth(v: &Values) -> Result<(), Fault> {
    if v.value(201)? != 0.0 {
        return Ok(());
    }
    let message = format!("the depth Q201 of cycle {} is zero", v.name());
    Err(v.fault(codes::ARGUMENTS, message, "write a depth below zero"))
}

fn too_many(v: &Values, check: &'static str) -> Fault {
    v.fault(codes::ARGUMENTS, format!("the cycle would need more than {MAX_INFEEDS} infeeds"), check)
}

impl Interpreter {
    pub(super) fn heights(&self, v: &Values) -> Result<Heights, Fault> {
        let clearance = v.value(200)?;
        let surface = if v.name().len() < 3 {
            let axis = self.modal.normal;
            self.position.work.get(axis).map(|z| z - clearance).ok_or_else(|| {
                let message = "the cycle starts at the position of the tool axis, which is not known";
                v.fault(codes::POSITION_UNKNOWN, message, "program the tool axis before the cycle")
            })?
        } else {
            v.value(203)? + v.lift
        };
        let depth = if v.name() == "204" { boring::lowest(v)? } else { v.value(201)? };
        let second = surface + v.value(204)?;
        let clear = surface + clearance;
        Ok(Heights {
            clear,
            // The second clearance has an effect only above the first.
            second: second.max(clear),
            surface,
            depth: surface + depth,
            down: if depth < 0.0 { -1.0 } else { 1.0 },
        })
    }

    /// A goal on the axis of the hole.
    fn on_axis(&self, to: f64) -> Goal {
        let axis = self.modal.normal;
        let mut goal = Goal { end: self.position.work, programmed: 1 << axis, tool_axis: None };
        goal.end.put(axis, to);
        goal
    }

    /// Moves to a hole and runs the cycle there. A tool below the clearance first goes up.
    pub(crate) fn hole(&mut self, v: &Values, point: [f64; 2], rapid: bool) -> Result<(), Fault> {
        let [first, second, n] = self.modal.plane_axes();
        let heights = self.heights(v)?;
        let feed = if rapid { None } else { self.technology.feed };
        if self.position.work.get(n).is_some_and(|z| z < heights.clear) {
            self.course(&[Stroke::at(heights.clear, feed)], v.span)?;
        }
        let mut goal = Goal { end: self.position.work, programmed: 1 << first | 1 << second, tool_axis: None };
        goal.end.put(first, point[0]);
        goal.end.put(second, point[1]);
        self.straight(goal, rapid || feed.is_none(), v.span)?;
        self.drill(v)
    }

    /// Runs a drilling or milling cycle at the tool position.
    pub(crate) fn drill(&mut self, v: &Values) -> Result<(), Fault> {
        if super::milling::is_milling(v.name()) {
            return self.mill(v);
        }
        if matches!(v.name(), "4" | "5") {
            return self.old_pocket_here(v);
        }
        let h = self.heights(v)?;
        let before = self.technology.feed;
        // From below the clearance the tool first goes up; from above it comes down in rapid.
        self.course(&[h.approach()], v.span)?;
        match v.name() {
            "200" | "1" | "203" | "205" => self.peck(v, h)?,
            "240" | "201" | "202" => {
                let down = self.cycle_feed(v, 206)?.or(before);
                self.course(&[Stroke::at(h.depth, down), Stroke::wait(Some(v.value(211)?))], v.span)?;
                match v.name() {
                    "240" => self.course(&[h.approach()], v.span)?,
                    "201" => {
                        let up = self.retraction_feed(v, down)?;
                        self.course(&[Stroke::at(h.clear, up)], v.span)?;
                    }
                    _ => self.bore_back(v, h, down)?,
                }
            }
            "206" | "2" => {
                let feed = self.cycle_feed(v, 206)?.or(before);
                self.course(&[Stroke::at(h.depth, feed), Stroke::wait(Some(v.value(211)?))], v.span)?;
                let direction = self.technology.direction;
                self.turn_spindle(opposite(direction));
                self.course(&[Stroke::at(h.clear, feed)], v.span)?;
                self.turn_spindle(direction);
            }
            "204" => self.back_bore(v, h)?,
            "207" | "17" => self.tap(v, h, None)?,
            "209" => {
                let infeed = v.value(257)?.abs();
                self.tap(v, h, (infeed > 0.0).then_some(infeed))?;
            }
            _ => self.deep(v, h)?,
        }
        self.technology.feed = before;
        self.course(&[h.out()], v.span)
    }

    /// Q208: feed of retraction. 0 means as down; MAX and none mean rapid.
    pub(super) fn retraction_feed(&self, v: &Values, down: Option<Feed>) -> Result<Option<Feed>, Fault> {
        match v.given(208) {
            None | Some(Given::Max) => Ok(None),
            Some(Given::Number(feed)) if *feed == 0.0 => Ok(down),
            // The control reads the input limit as rapid.
            Some(Given::Number(feed)) if *feed >= 99999.0 => Ok(None),
            _ => self.cycle_feed(v, 208),
        }
    }

    /// Cycles 200, 203, 205 and 1: infeeds with full retraction or chip breaking.
    fn peck(&mut self, v: &Values, h: Heights) -> Result<(), Fault> {
        let span = v.span;
        let (universal, pecking) = (v.name() == "203", v.name() == "205");
        let feed = self.cycle_feed(v, 206)?.or(self.technology.feed);
        let up = if universal || pecking { self.retraction_feed(v, feed)? } else { None };
        let dwell_bottom = v.value(211)?;
        let dwell_top = if pecking { 0.0 } else { v.value(210)? };
        // Deepened starting point of 205: the hole begins at Q379 and is reached with Q253.
        let begin = if pecking { v.value(379)?.abs() } else { 0.0 };
        let total = (h.depth - h.surface).abs();
        let infeed = v.value(202)?.abs();
        let mut step = if infeed > 0.0 { infeed } else { total };
        let (decrement, least) =
            if universal || pecking { (v.value(212)?.abs(), v.value(205)?.abs()) } else { (0.0, 0.0) };
        let breaks = if universal { v.value(213)?.max(0.0) as u32 } else { 0 };
        let break_after = if pecking { v.value(257)?.abs() } else { 0.0 };
        let break_back = v.value(256)?.abs();
        let clearance = (h.clear - h.surface).abs();
        let (ahead_first, ahead_last) = match v.name() {
            "205" => (v.value(258)?.abs(), v.value(259)?.abs()),
            // Chosen by the control: 0.6 mm up to 30 mm depth, then depth/50, at most 7 mm.
            "1" => {
                let t = if total <= 30.0 { 0.6 } else { (total / 50.0).min(7.0) };
                (t, t)
            }
            _ => (clearance, clearance),
        };
        let at = |reached: f64| h.surface + h.down * reached;
        let mut reached = 0.0;
        if begin > 0.0 && begin < total {
            let approach = self.feed_if_written(v, 253)?;
            self.course(&[Stroke::at(at(begin) - h.down * clearance, approach)], span)?;
            reached = begin;
        }
        let mut count = 0u32;
        let mut broken = 0u32;
        loop {
            count += 1;
            if count > MAX_INFEEDS || step <= SAME_HEIGHT_MM {
                return Err(too_many(v, "check the infeed Q202 and the decrement Q212"));
            }
            let target = if reached + step >= total - SAME_HEIGHT_MM { total } else { reached + step };
            if break_after > 0.0 {
                // 205: the chip is broken each time Q257 has been drilled.
                let mut part = reached + break_after;
                while part < target - SAME_HEIGHT_MM {
                    count += 1;
                    if count > MAX_INFEEDS {
                        break;
                    }
                    let lift = Stroke::at(at(part) - h.down * break_back, feed);
                    self.course(&[Stroke::at(at(part), feed), lift], span)?;
                    part += break_after;
                }
            }
            let depth = if target == total { h.depth } else { at(target) };
            self.course(&[Stroke::at(depth, feed)], span)?;
            reached = target;
            if reached == total {
                break;
            }
            if broken < breaks {
                broken += 1;
                self.course(&[Stroke::at(at(reached) - h.down * break_back, feed)], span)?;
            } else {
                broken = 0;
                let ahead = ahead_first + (ahead_last - ahead_first) * (reached / total);
                let back = Stroke::Rapid(at((reached - ahead).max(-clearance)));
                self.course(&[Stroke::at(h.clear, up), Stroke::wait(Some(dwell_top)), back], span)?;
            }
            let next = step - decrement;
            step = if next < least { least.max(LEAST_INFEED_MM).min(step) } else { next };
        }
        self.course(&[Stroke::wait(Some(dwell_bottom)), Stroke::at(h.clear, up)], span)
    }

    /// Rigid tapping: down and up coupled to the spindle; with infeeds the chip is broken.
    fn tap(&mut self, v: &Values, h: Heights, infeed: Option<f64>) -> Result<(), Fault> {
        let span = v.span;
        let pitch = v.value(239)?;
        if pitch == 0.0 || !pitch.is_finite() {
            let help = "write the pitch, negative for a left-hand thread";
            return Err(v.fault(codes::ARGUMENTS, "the pitch Q239 is zero", help));
        }
        let cut = direction_of_thread(pitch);
        let out = opposite(cut);
        let pitch = pitch.abs();
        let thread = |to: f64, turn: SpindleDirection| Stroke::Thread { to, pitch, turn };
        // A factor of the pitch.
        let back = v.raw(256)?.unwrap_or(0.0).abs() * pitch;
        let total = (h.depth - h.surface).abs();
        let mut reached = 0.0;
        if let Some(infeed) = infeed {
            let mut count = 0u32;
            while reached + infeed < total - SAME_HEIGHT_MM {
                count += 1;
                if count > MAX_INFEEDS {
                    return Err(too_many(v, "check Q257"));
                }
                reached += infeed;
                // Q256 zero: retracts out of the hole to clear the chips.
                let to = if back > 0.0 { h.surface + h.down * (reached - back) } else { h.clear };
                self.course(&[thread(h.surface + h.down * reached, cut), thread(to, out)], span)?;
            }
        }
        self.course(&[thread(h.depth, cut), thread(h.clear, out)], span)?;
        // The spindle runs on as before the cycle.
        self.tell_spindle();
        Ok(())
    }

    /// 241: in at low speed to the starting point, drilling, out at low speed.
    fn deep(&mut self, v: &Values, h: Heights) -> Result<(), Fault> {
        let span = v.span;
        let (direction, speed) = (self.technology.direction, self.technology.speed);
        let entry = direction_of(v.value(426)?);
        let (slow, fast) = (v.value(427)?, v.value(428)?);
        let feed = self.cycle_feed(v, 206)?.or(self.technology.feed);
        let begin = v.value(379)?.abs();
        let approach = if v.given(253).is_some() { self.cycle_feed(v, 253)? } else { feed };
        self.technology.direction = entry;
        self.technology.speed = Some(slow);
        self.tell_spindle();
        let clearance = (h.clear - h.surface).abs();
        if begin > 0.0 {
            self.course(&[Stroke::at(h.surface + h.down * (begin - clearance), approach)], span)?;
        }
        self.technology.direction =
            if direction == SpindleDirection::Off { SpindleDirection::Clockwise } else { direction };
        self.technology.speed = if fast > 0.0 { Some(fast) } else { speed };
        self.tell_spindle();
        self.cycle_coolant(v, 429);
        self.course(&[Stroke::at(h.depth, feed), Stroke::wait(Some(v.value(211)?))], span)?;
        self.cycle_coolant(v, 430);
        self.technology.direction = entry;
        self.technology.speed = Some(slow);
        self.tell_spindle();
        let up = self.retraction_feed(v, feed)?;
        self.course(&[Stroke::at(h.clear, up)], span)?;
        self.technology.direction = direction;
        self.technology.speed = speed;
        self.tell_spindle();
        Ok(())
    }

    /// The M word that a parameter names.
    fn cycle_coolant(&mut self, v: &Values, key: u32) {
        match v.given(key) {
            Some(Given::Number(code @ (7.0 | 8.0 | 9.0))) => self.coolant(*code as u32),
            Some(Given::Number(other)) => self.note(format!("M{other}")),
            _ => {}
        }
    }
}
