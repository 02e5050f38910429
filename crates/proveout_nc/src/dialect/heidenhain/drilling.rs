//! Drilling cycles, expanded to the motions of the control.
//!
//! Courses after HEIDENHAIN, *TNC 640 Programming of machining cycles*, chapters "Drilling" and "Tapping": 200 drilling, 201 reaming,
//! 202 boring, 203 universal drilling, 205 universal pecking, 206 and 207 tapping, 209 tapping with chip breaking, 240 centering,
//! 241 single-fluted deep-hole drilling; 1, 2 and 17 of older controls. All lengths run along the tool axis:
//!
//! ```text
//!   2nd set-up clearance   Q203 + Q204
//!   set-up clearance       Q203 + Q200   the cycle starts and ends here
//!   surface                Q203
//!   depth                  Q203 + Q201   (Q201 negative: towards the workpiece)
//! ```

use std::collections::BTreeMap;

use super::cycle::Setting;
use super::interpreter::{Heidenhain, Interpreter};
use super::motion::Goal;
use crate::channel::milling::{Heights, SAME_HEIGHT_MM};
use crate::channel::{Holes, Stroke, direction_of, direction_of_thread, opposite};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{Feed, Motion, SpindleDirection};

/// Most infeeds of one hole.
const MAX_INFEEDS: u32 = 10_000;
/// Retraction of the boring bar from the wall in cycle 202, mm: fixed in the control.
const FREE_MM: f64 = 0.2;
/// Least infeed where the decrement would leave less, mm.
const LEAST_INFEED_MM: f64 = 1e-6;

type Values = BTreeMap<u32, Setting>;

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

impl Interpreter {
    /// Checks the parameters when the cycle is defined: refuses unsupported ones, a missing Q200
    /// and a depth of zero.
    pub(crate) fn check_cycle(&self, number: u32, values: &Values, span: Span) -> Result<(), Fault> {
        let zero = |key: u32, what: &str, remedy: &str| -> Result<(), Fault> {
            match values.get(&key) {
                Some(Setting::Number(v)) if *v != 0.0 => {
                    Err(super::lexer::refused(&format!("Q{key}={v} ({what})"), span, remedy))
                }
                _ => Ok(()),
            }
        };
        zero(
            395,
            "depth counted from the cylinder of the drill",
            "it needs the point angle of the tool: write the depth of the tip and Q395=0",
        )?;
        zero(
            343,
            "depth from the diameter",
            "it needs the point angle of the tool: write the depth in Q201 and Q343=0",
        )?;
        zero(435, "dwell at depth", "write Q435=0")?;
        zero(401, "feed factor", "write Q401=0")
            .or_else(|fault| if values.get(&401) == Some(&Setting::Number(100.0)) { Ok(()) } else { Err(fault) })?;
        self.cycle_number(values, 200, None, span)?;
        let depth = self.cycle_number(values, 201, None, span)?;
        if depth == 0.0 {
            return Err(Fault::new(codes::ARGUMENTS, span, format!("the depth Q201 of cycle {number} is zero"))
                .help("write a depth below zero"));
        }
        Ok(())
    }

    pub(super) fn mm(&self, values: &Values, key: u32, default: Option<f64>, span: Span) -> Result<f64, Fault> {
        self.cycle_number(values, key, default, span).map(|v| v * self.modal.unit())
    }

    pub(super) fn heights(&self, number: u32, values: &Values, lift: f64, span: Span) -> Result<Heights, Fault> {
        let clearance = self.mm(values, 200, None, span)?;
        let surface = if number < 100 {
            let axis = self.modal.normal;
            self.position.work.get(axis).map(|z| z - clearance).ok_or_else(|| {
                Fault::new(
                    codes::POSITION_UNKNOWN,
                    span,
                    "the cycle starts at the position of the tool axis, which is not known",
                )
                .help("program the tool axis before the cycle")
            })?
        } else {
            self.mm(values, 203, Some(0.0), span)? + lift
        };
        let depth = self.mm(values, 201, None, span)?;
        let second = surface + self.mm(values, 204, Some(0.0), span)?;
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
    pub(crate) fn hole(
        &mut self,
        number: u32,
        values: &Values,
        point: [f64; 2],
        lift: f64,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        let [u, v, n] = self.modal.plane_axes();
        let heights = self.heights(number, values, lift, span)?;
        let feed = if rapid { None } else { self.technology.feed };
        if self.position.work.get(n).is_some_and(|z| z < heights.clear) {
            self.course(&[Stroke::at(heights.clear, feed)], span)?;
        }
        let mut goal = Goal { end: self.position.work, programmed: 1 << u | 1 << v, tool_axis: None };
        goal.end.put(u, point[0]);
        goal.end.put(v, point[1]);
        self.straight(goal, rapid || feed.is_none(), span)?;
        self.drill(number, values, lift, span)
    }

    /// Runs a drilling or milling cycle at the tool position.
    pub(crate) fn drill(&mut self, number: u32, values: &Values, lift: f64, span: Span) -> Result<(), Fault> {
        if super::milling::CYCLES.contains(&number) {
            return self.mill(number, values, lift, span);
        }
        if matches!(number, 4 | 5) {
            return self.old_pocket_here(number, values, span);
        }
        let h = self.heights(number, values, lift, span)?;
        let before = self.technology.feed;
        let num = |this: &Self, key: u32| this.cycle_number(values, key, Some(0.0), span);
        // From below the clearance the tool first goes up; from above it comes down in rapid.
        self.course(&[Stroke::Rapid(h.clear)], span)?;
        match number {
            200 | 1 | 203 | 205 => self.peck(number, values, h, span)?,
            240 | 201 | 202 => {
                let down = self.cycle_feed(values, 206, span)?.or(before);
                self.course(&[Stroke::at(h.depth, down), Stroke::wait(Some(num(self, 211)?))], span)?;
                match number {
                    240 => self.course(&[Stroke::Rapid(h.clear)], span)?,
                    201 => {
                        let up = self.retraction_feed(values, down, span)?;
                        self.course(&[Stroke::at(h.clear, up)], span)?;
                    }
                    _ => self.bore_back(values, h, down, span)?,
                }
            }
            206 | 2 => {
                let feed = self.cycle_feed(values, 206, span)?.or(before);
                self.course(&[Stroke::at(h.depth, feed), Stroke::wait(Some(num(self, 211)?))], span)?;
                let direction = self.technology.direction;
                self.turn_spindle(opposite(direction));
                self.course(&[Stroke::at(h.clear, feed)], span)?;
                self.turn_spindle(direction);
            }
            207 | 17 => self.tap(values, h, None, span)?,
            209 => {
                let infeed = self.mm(values, 257, Some(0.0), span)?.abs();
                self.tap(values, h, (infeed > 0.0).then_some(infeed), span)?;
            }
            241 => self.deep(values, h, span)?,
            other => {
                return Err(super::lexer::refused(
                    &format!("CYCL DEF {other}"),
                    span,
                    "write its motions with L blocks",
                ));
            }
        }
        self.technology.feed = before;
        self.course(&[Stroke::Rapid(h.second)], span)
    }

    /// Q208: feed of retraction. 0 means as down; MAX and none mean rapid.
    fn retraction_feed(&self, values: &Values, down: Option<Feed>, span: Span) -> Result<Option<Feed>, Fault> {
        match values.get(&208) {
            None | Some(Setting::Max) => Ok(None),
            Some(Setting::Number(v)) if *v == 0.0 => Ok(down),
            // The control reads the input limit as rapid.
            Some(Setting::Number(v)) if *v >= 99999.0 => Ok(None),
            _ => self.cycle_feed(values, 208, span),
        }
    }

    /// Cycles 200, 203, 205 and 1: infeeds with full retraction or chip breaking.
    fn peck(&mut self, number: u32, values: &Values, h: Heights, span: Span) -> Result<(), Fault> {
        let num = |this: &Self, key: u32, default: f64| this.cycle_number(values, key, Some(default), span);
        let len = |this: &Self, key: u32, default: f64| {
            this.cycle_number(values, key, Some(default), span).map(|v| v * this.modal.unit())
        };
        let feed = self.cycle_feed(values, 206, span)?.or(self.technology.feed);
        let up = match number {
            203 => self.retraction_feed(values, feed, span)?,
            205 => self.retraction_feed(values, feed, span)?,
            _ => None,
        };
        let dwell_bottom = num(self, 211, 0.0)?;
        let dwell_top = if number == 205 { 0.0 } else { num(self, 210, 0.0)? };
        // Deepened starting point of 205: the hole begins at Q379 and is reached with Q253.
        let begin = if number == 205 { len(self, 379, 0.0)?.abs() } else { 0.0 };
        let total = (h.depth - h.surface).abs();
        let infeed = len(self, 202, 0.0)?.abs();
        let mut step = if infeed > 0.0 { infeed } else { total };
        let (decrement, least) = if matches!(number, 203 | 205) {
            (len(self, 212, 0.0)?.abs(), len(self, 205, 0.0)?.abs())
        } else {
            (0.0, 0.0)
        };
        let breaks = if number == 203 { num(self, 213, 0.0)?.max(0.0) as u32 } else { 0 };
        let break_after = if number == 205 { len(self, 257, 0.0)?.abs() } else { 0.0 };
        let break_back = len(self, 256, 0.2)?.abs();
        let clearance = (h.clear - h.surface).abs();
        let (ahead_first, ahead_last) = match number {
            205 => (len(self, 258, 0.2)?.abs(), len(self, 259, 0.2)?.abs()),
            // Chosen by the control: 0.6 mm up to 30 mm depth, then depth/50, at most 7 mm.
            1 => {
                let t = if total <= 30.0 { 0.6 } else { (total / 50.0).min(7.0) };
                (t, t)
            }
            _ => (clearance, clearance),
        };
        let at = |reached: f64| h.surface + h.down * reached;
        let mut reached = 0.0;
        if begin > 0.0 && begin < total {
            let approach = if values.contains_key(&253) { self.cycle_feed(values, 253, span)? } else { None };
            self.course(&[Stroke::at(at(begin) - h.down * clearance, approach)], span)?;
            reached = begin;
        }
        let mut count = 0u32;
        let mut broken = 0u32;
        loop {
            count += 1;
            if count > MAX_INFEEDS || step <= SAME_HEIGHT_MM {
                return Err(Fault::new(
                    codes::ARGUMENTS,
                    span,
                    format!("the cycle would need more than {MAX_INFEEDS} infeeds"),
                )
                .help("check the infeed Q202 and the decrement Q212"));
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

    /// 202: orients the spindle, moves the bar off the wall, retracts it and brings it back to the
    /// middle.
    fn bore_back(&mut self, values: &Values, h: Heights, down: Option<Feed>, span: Span) -> Result<(), Fault> {
        let direction = self.technology.direction;
        let way = self.cycle_number(values, 214, Some(0.0), span)?;
        let angle = self.cycle_number(values, 336, Some(0.0), span)?;
        self.turn_spindle(SpindleDirection::Off);
        self.note(format!("spindle oriented to {angle} degrees"));
        let [u, v, _] = self.modal.plane_axes();
        let (axis, sign) = match way {
            0.0 => (None, 0.0),
            1.0 => (Some(u), -1.0),
            2.0 => (Some(v), -1.0),
            3.0 => (Some(u), 1.0),
            4.0 => (Some(v), 1.0),
            _ => {
                return Err(
                    Fault::new(codes::ARGUMENTS, span, format!("Q214 takes 0 to 4 and has {way}")).help("write 0 to 4")
                );
            }
        };
        let up = self.retraction_feed(values, down, span)?;
        if let Some(axis) = axis {
            self.aside(axis, sign * FREE_MM, span)?;
        }
        self.course(&[Stroke::at(h.clear, up), Stroke::Rapid(h.second)], span)?;
        if let Some(axis) = axis {
            self.aside(axis, -sign * FREE_MM, span)?;
        }
        self.turn_spindle(direction);
        Ok(())
    }

    fn aside(&mut self, axis: usize, by: f64, span: Span) -> Result<(), Fault> {
        let Some(now) = self.position.work.get(axis) else {
            return Err(Fault::new(codes::POSITION_UNKNOWN, span, "cycle 202 needs the position in the working plane")
                .help("program X and Y before the cycle"));
        };
        let mut goal = Goal { end: self.position.work, programmed: 1 << axis, tool_axis: None };
        goal.end.put(axis, now + by);
        self.straight(goal, true, span)
    }

    /// Rigid tapping: down and up coupled to the spindle; with infeeds the chip is broken.
    fn tap(&mut self, values: &Values, h: Heights, infeed: Option<f64>, span: Span) -> Result<(), Fault> {
        let pitch = self.mm(values, 239, None, span)?;
        if pitch == 0.0 || !pitch.is_finite() {
            return Err(Fault::new(codes::ARGUMENTS, span, "the pitch Q239 is zero")
                .help("write the pitch, negative for a left-hand thread"));
        }
        let cut = direction_of_thread(pitch);
        let out = opposite(cut);
        let pitch = pitch.abs();
        let thread = |to: f64, turn: SpindleDirection| Stroke::Thread { to, pitch, turn };
        let back = self.cycle_number(values, 256, Some(0.0), span)?.abs() * pitch;
        let total = (h.depth - h.surface).abs();
        let mut reached = 0.0;
        if let Some(infeed) = infeed {
            let mut count = 0u32;
            while reached + infeed < total - SAME_HEIGHT_MM {
                count += 1;
                if count > MAX_INFEEDS {
                    return Err(Fault::new(
                        codes::ARGUMENTS,
                        span,
                        format!("the cycle would need more than {MAX_INFEEDS} infeeds"),
                    )
                    .help("check Q257"));
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
    fn deep(&mut self, values: &Values, h: Heights, span: Span) -> Result<(), Fault> {
        let (direction, speed) = (self.technology.direction, self.technology.speed);
        let num = |this: &Self, key: u32, default: f64| this.cycle_number(values, key, Some(default), span);
        let entry = direction_of(num(self, 426, 5.0)?);
        let (slow, fast) = (num(self, 427, 0.0)?, num(self, 428, 0.0)?);
        let feed = self.cycle_feed(values, 206, span)?.or(self.technology.feed);
        let begin = self.mm(values, 379, Some(0.0), span)?.abs();
        let approach = if values.contains_key(&253) { self.cycle_feed(values, 253, span)? } else { feed };
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
        for (key, on) in [(429, true), (430, false)] {
            if let Some(Setting::Number(code)) = values.get(&key)
                && on
            {
                self.cycle_coolant(*code);
            }
        }
        self.course(&[Stroke::at(h.depth, feed), Stroke::wait(Some(num(self, 211, 0.0)?))], span)?;
        if let Some(Setting::Number(code)) = values.get(&430) {
            self.cycle_coolant(*code);
        }
        self.technology.direction = entry;
        self.technology.speed = Some(slow);
        self.tell_spindle();
        let up = self.retraction_feed(values, feed, span)?;
        self.course(&[Stroke::at(h.clear, up)], span)?;
        self.technology.direction = direction;
        self.technology.speed = speed;
        self.tell_spindle();
        Ok(())
    }

    fn cycle_coolant(&mut self, code: f64) {
        match code {
            7.0 | 8.0 | 9.0 => self.coolant(code as u32),
            other => self.note(format!("M{other}")),
        }
    }
}
