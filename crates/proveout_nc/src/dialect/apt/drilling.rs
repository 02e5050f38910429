//! `CYCLE`: machines a hole along the tool axis at every point until `CYCLE/OFF`.
//!
//! ```text
//!   ----+----------------+----  travel: CLEAR, or where the tool came from
//!       |  rapid         ^
//!   ----+----            |      R: RAPTO, else CLEAR; feed begins
//!       |  feed          |
//!   ====+=== point ======|====
//!       v  feed          |      depth: FEDTO, DEPTH, or the first value, below the point
//! ```

use super::reader::{Apt, AptReader};
use super::statement::{AptStatement, Bad, Item, LineRange, Token};
use super::technology::FeedUnit;
use crate::channel::{Holes, Stroke, opposite};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame;
use crate::source::Source;
use crate::{Dwell, Feed, Motion, SpindleDirection};

/// Most infeeds of one hole.
const MAX_INFEEDS: f64 = 10_000.0;
/// Distance above the last depth at which a deep hole continues at feed, mm: a parameter on
/// controls.
const DEEP_AHEAD_MM: f64 = 1.0;
/// Lift that breaks a chip, mm: a parameter on controls.
const CHIP_LIFT_MM: f64 = 1.0;
/// Heights closer than this count as equal, mm.
const SAME_MM: f64 = 1e-9;
/// Least number of threads of an inch: a pitch stays finite.
const LEAST_TPI: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq)]
enum HoleCycle {
    Drill,
    /// Full retraction after each infeed.
    Deep,
    BreakChip,
    /// Retracts at feed.
    Bore,
    Tap,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Retract {
    /// To the height of travel.
    Travel,
    /// To the tool height at the start of the cycle.
    Start,
    /// Above the point, mm.
    Height(f64),
}

/// A cycle with its values, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle {
    kind: HoleCycle,
    depth: f64,
    travel: f64,
    start: f64,
    retract: Retract,
    /// First infeed and the others.
    step: Option<[f64; 2]>,
    dwell: Option<Dwell>,
    feed: Option<Feed>,
    pitch: Option<f64>,
}

/// Values of a CYCLE statement while it is read.
#[derive(Default)]
struct Values {
    depth: Option<f64>,
    clear: Option<f64>,
    rapid_to: Option<f64>,
    feed: Option<f64>,
    unit: Option<FeedUnit>,
    /// First infeed, and the others where they differ.
    step: Option<f64>,
    next_step: Option<f64>,
    pitch: Option<f64>,
    dwell: Option<f64>,
    dwell_revolutions: bool,
    retract: Option<Retract>,
}

impl AptReader {
    pub(crate) fn cycle_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let Some(first) = st.items.first() else {
            return Err(st.head.bad(
                codes::MISSING_VALUE,
                "CYCLE names no cycle",
                "write CYCLE/DRILL,... or CYCLE/OFF",
            ));
        };
        let word = Self::word(source, first);
        match word.as_str() {
            "OFF" | "NOMORE" => {
                self.own.cycle_on = false;
                self.note("CYCLE/OFF");
                self.tell_feed();
                return Ok(());
            }
            // CAMWorks announces the definition of the next statement.
            "INIT" if st.items.len() == 1 => {
                self.note("CYCLE/INIT");
                return Ok(());
            }
            "ON" => {
                if self.own.cycle.is_none() {
                    return Err(st.head.bad(
                        codes::CONFLICT,
                        "CYCLE/ON has no cycle to resume",
                        "define the cycle before it",
                    ));
                }
                self.begin_cycle();
                return Ok(());
            }
            _ => {}
        }
        let mut at = 1;
        let mut kind = match word.as_str() {
            "DRILL" | "FACE" => HoleCycle::Drill,
            // If it has no word, its first value may be the diameter of the cone.
            "CSINK" | "THRU" if st.items.get(1).is_some_and(|item| item.token == Token::Word) => HoleCycle::Drill,
            // CAMWorks gives the first infeed of DEEP2 and that of the others.
            "DEEP" | "DEEP2" => HoleCycle::Deep,
            "BRKCHP" => HoleCycle::BreakChip,
            "BORE" | "REAM" => HoleCycle::Bore,
            "TAP" | "RIGID" => HoleCycle::Tap,
            _ => return Err(refused(&word, first)),
        };
        while let Some(item) = st.items.get(at).filter(|i| i.token == Token::Word) {
            kind = match (Self::word(source, item).as_str(), kind) {
                ("DEEP", HoleCycle::Drill) => HoleCycle::Deep,
                ("BRKCHP", HoleCycle::Drill) => HoleCycle::BreakChip,
                ("RIGID", HoleCycle::Tap) => HoleCycle::Tap,
                ("DEEP" | "BRKCHP" | "BACK" | "NODRAG" | "DRAG" | "MANUAL" | "ORIENT", _) => {
                    return Err(refused(&format!("{word},{}", Self::word(source, item)), item));
                }
                _ => break,
            };
            at += 1;
        }
        let values = self.cycle_values(source, &st.items[at..])?;
        let cycle = self.cycle_of(kind, &values, st, first)?;
        self.note(format!("CYCLE/{word}"));
        self.own.cycle = Some(cycle);
        self.begin_cycle();
        Ok(())
    }

    fn begin_cycle(&mut self) {
        if !self.own.cycle_on {
            self.own.cycle_from = self.position.work.xyz();
        }
        self.own.cycle_on = true;
    }

    fn cycle_values(&self, source: &Source, items: &[Item]) -> Result<Values, Box<Bad>> {
        let mut v = Values::default();
        // Values without a word: the depth, the feed next to its unit, the clearance.
        let mut bare: Vec<(f64, &Item)> = Vec::new();
        let mut at = 0;
        let unit = self.own.unit;
        while let Some(item) = items.get(at) {
            at += 1;
            if item.token != Token::Word {
                bare.push((self.number(source, item)?, item));
                continue;
            }
            let word = Self::word(source, item);
            if let Some(found) = self.feed_unit(&word) {
                v.unit = Some(found);
                if bare.len() > 1 || v.depth.is_some() && !bare.is_empty() {
                    // `depth, feed, IPM, clearance`: the value before the unit is the feed.
                    v.feed = bare.pop().map(|(value, _)| value);
                } else if let Some(next) = items.get(at) {
                    v.feed = Some(self.number(source, next)?);
                    at += 1;
                } else {
                    let message = format!("`{word}` has no feed");
                    return Err(item.place.bad(codes::MISSING_VALUE, message, "write the feed after its unit"));
                }
                continue;
            }
            let next = items.get(at);
            let mut value = || -> Result<f64, Box<Bad>> {
                let item = next.ok_or_else(|| {
                    item.place.bad(codes::MISSING_VALUE, format!("`{word}` has no value"), "write it after the word")
                })?;
                at += 1;
                self.number(source, item)
            };
            match word.as_str() {
                "DEPTH" | "FEDTO" => v.depth = Some(value()?.abs() * unit),
                "CLEAR" => v.clear = Some(value()? * unit),
                "RAPTO" => v.rapid_to = Some(value()? * unit),
                "STEP" | "STEP1" | "INCR" | "1STPECK" | "PECK" => v.step = Some(value()?.abs() * unit),
                "SUBPECK" => v.next_step = Some(value()?.abs() * unit),
                "PITCH" => v.pitch = Some(value()?.abs() * unit),
                "TPI" => v.pitch = Some(25.4 / value()?.abs().max(LEAST_TPI)),
                "DWELL" => {
                    if next.is_some_and(|i| Self::word(source, i) == "REV") {
                        at += 1;
                        v.dwell_revolutions = true;
                        let item = items.get(at).ok_or_else(|| {
                            item.place.bad(codes::MISSING_VALUE, "`DWELL` has no value", "write it after the word")
                        })?;
                        at += 1;
                        v.dwell = Some(self.number(source, item)?);
                    } else {
                        v.dwell = Some(value()?);
                    }
                }
                "REV" if v.dwell.is_some() => v.dwell_revolutions = true,
                "RTRCTO" | "RETURN" => match next.map(|i| Self::word(source, i)).as_deref() {
                    Some("AUTO" | "ON") => {
                        at += 1;
                        v.retract = Some(Retract::Start);
                    }
                    Some("NONE" | "OFF") => {
                        at += 1;
                        v.retract = Some(Retract::Travel);
                    }
                    _ => v.retract = Some(Retract::Height(value()? * unit)),
                },
                // Some writers omit RTRCTO before its value.
                "AUTO" => v.retract = Some(Retract::Start),
                _ => return Err(refused(&word, item)),
            }
        }
        let mut bare = bare.into_iter();
        if v.depth.is_none() {
            v.depth = bare.next().map(|(value, _)| value.abs() * unit);
        }
        if v.clear.is_none() && v.rapid_to.is_none() {
            v.clear = bare.next().map(|(value, _)| value * unit);
        }
        if let Some((_, item)) = bare.next() {
            return Err(item.place.bad(
                codes::ARGUMENTS,
                "the position of this value of CYCLE does not show its meaning",
                "write the words: CYCLE/DRILL,FEDTO,-10,MMPM,250,RAPTO,3",
            ));
        }
        Ok(v)
    }

    fn cycle_of(&self, kind: HoleCycle, v: &Values, st: &AptStatement, first: &Item) -> Result<Cycle, Box<Bad>> {
        let Some(depth) = v.depth else {
            return Err(st.head.bad(codes::ARGUMENTS, "CYCLE has no depth", "write FEDTO or DEPTH with its value"));
        };
        let Some(start) = v.rapid_to.or(v.clear) else {
            return Err(st.head.bad(codes::ARGUMENTS, "CYCLE has no clearance", "write CLEAR or RAPTO with its value"));
        };
        let travel = v.clear.unwrap_or(start).max(start);
        if start < -depth || depth + start <= 0.0 {
            return Err(st.head.bad(
                codes::ARGUMENTS,
                format!("the feed of CYCLE would begin {start} mm above the point, below its depth of {depth} mm"),
                "give a depth below the height where the feed begins",
            ));
        }
        for step in [v.step, v.next_step].into_iter().flatten() {
            if step > 0.0 && (depth + start) / step <= MAX_INFEEDS {
                continue;
            }
            let message = format!("infeeds of {step} mm to {depth} mm: the limit is {MAX_INFEEDS} infeeds");
            return Err(st.head.bad(codes::ARGUMENTS, message, "give a larger infeed"));
        }
        if matches!(kind, HoleCycle::Deep | HoleCycle::BreakChip) && v.step.is_none() {
            return Err(st.head.bad(
                codes::ARGUMENTS,
                "the deep hole has no infeed",
                "write INCR or STEP with its value",
            ));
        }
        let idle = match kind {
            HoleCycle::Drill | HoleCycle::Bore => {
                v.step.or(v.next_step).map(|_| "INCR or STEP").or(v.pitch.map(|_| "PITCH or TPI"))
            }
            HoleCycle::Deep | HoleCycle::BreakChip => v.pitch.map(|_| "PITCH or TPI"),
            HoleCycle::Tap => v.step.or(v.next_step).map(|_| "INCR or STEP"),
        };
        if let Some(word) = idle {
            let message = format!("{word} in a cycle that does not use it");
            return Err(st.head.bad(codes::CONFLICT, message, "remove it, or write DEEP, BRKCHP or TAP"));
        }
        if v.dwell.is_some_and(|d| d < 0.0) {
            return Err(st.head.bad(codes::BAD_VALUE, "a dwell must not be negative", "write DWELL,1"));
        }
        let dwell = v
            .dwell
            .filter(|d| *d > 0.0)
            .map(|d| if v.dwell_revolutions { Dwell::Revolutions(d) } else { Dwell::Seconds(d) });
        let feed = v.feed.filter(|f| *f != 0.0).map(|f| self.feed_of(f, v.unit, first)).transpose()?;
        let retract = v.retract.unwrap_or(Retract::Travel);
        let step = v.step.map(|first| [first, v.next_step.unwrap_or(first)]);
        Ok(Cycle { kind, depth, travel, start, retract, step, dwell, feed, pitch: v.pitch })
    }

    /// One hole at a point.
    pub(crate) fn hole(&mut self, point: [f64; 3], place: LineRange) -> Result<(), Box<Bad>> {
        let Some(cycle) = self.own.cycle else {
            self.straight(point, false);
            return Ok(());
        };
        let axis = self.own.axis;
        let at = |height: f64| frame::add_scaled(point, axis, height);
        if let Some(here) = self.position.work.xyz() {
            // Above the travel height the tool first moves across; below, it first rises: it never
            // moves across below that height.
            let offset = frame::sub(here, point);
            let height = frame::dot(offset, axis);
            let across = frame::norm(frame::add_scaled(offset, axis, -height));
            if across > SAME_MM && (height - cycle.travel).abs() > SAME_MM {
                let way = if height > cycle.travel {
                    at(height)
                } else {
                    frame::add_scaled(here, axis, cycle.travel - height)
                };
                self.straight(way, true);
            }
        }
        self.own.hole = point;
        self.bore(&cycle, place.span).map_err(|fault| place.with(fault))
    }

    /// The course of a cycle; heights above the point.
    fn bore(&mut self, cycle: &Cycle, span: Span) -> Result<(), Fault> {
        self.course(&[Stroke::Rapid(cycle.travel), Stroke::Rapid(cycle.start)], span)?;
        let before = self.technology.feed;
        self.technology.feed = cycle.feed.or(self.technology.feed);
        self.need_feed();
        if cycle.kind != HoleCycle::Tap {
            self.tell_feed();
        }
        let (down, wait, up) = (Stroke::Feed(-cycle.depth), Stroke::Wait(cycle.dwell), Stroke::Feed(cycle.start));
        match cycle.kind {
            HoleCycle::Drill => self.course(&[down, wait], span)?,
            HoleCycle::Bore => self.course(&[down, wait, up], span)?,
            HoleCycle::Deep | HoleCycle::BreakChip => self.deep(cycle, span)?,
            HoleCycle::Tap => self.tap(cycle, span)?,
        }
        self.technology.feed = before;
        let retract = match (cycle.retract, self.own.cycle_from) {
            (Retract::Height(height), _) => height.max(cycle.start),
            (Retract::Start, Some(from)) => {
                frame::dot(frame::sub(from, self.own.hole), self.own.axis).max(cycle.travel)
            }
            (Retract::Travel | Retract::Start, _) => cycle.travel,
        };
        self.course(&[Stroke::Rapid(retract)], span)
    }

    fn deep(&mut self, cycle: &Cycle, span: Span) -> Result<(), Fault> {
        let [mut step, next_step] = cycle.step.unwrap_or([cycle.depth + cycle.start; 2]);
        // The first infeed is measured from the point, or from where the feed begins when that is lower.
        let mut reached = (-cycle.start).max(0.0);
        loop {
            reached = (reached + step).min(cycle.depth);
            step = next_step;
            self.course(&[Stroke::Feed(-reached), Stroke::Wait(cycle.dwell)], span)?;
            if reached >= cycle.depth - SAME_MM {
                return Ok(());
            }
            if cycle.kind == HoleCycle::BreakChip {
                self.course(&[Stroke::Feed(-reached + CHIP_LIFT_MM)], span)?;
            } else {
                let ahead = (-reached + DEEP_AHEAD_MM).min(cycle.start);
                self.course(&[Stroke::Rapid(cycle.start), Stroke::Rapid(ahead)], span)?;
            }
        }
    }

    fn tap(&mut self, cycle: &Cycle, span: Span) -> Result<(), Fault> {
        let speed = self.technology.speed.filter(|s| *s > 0.0 && self.technology.direction != SpindleDirection::Off);
        let pitch = match (cycle.pitch, self.technology.feed, speed) {
            (Some(pitch), ..) => Some(pitch),
            (None, Some(Feed::PerRevolution(feed)), _) => Some(feed),
            (None, Some(Feed::PerTime(feed)), Some(speed)) => Some(feed * 60.0 / speed),
            _ => None,
        };
        let pitch = pitch.filter(|p| *p > 0.0 && p.is_finite()).ok_or_else(|| {
            let code = if self.technology.feed.is_some() { codes::MISSING_VALUE } else { codes::NO_FEED };
            Fault::new(code, span, "the pitch of the thread is not known").help("give PITCH, or the feed and SPINDL")
        })?;
        let turn = self.own.last_direction;
        for (to, turn) in [(-cycle.depth, turn), (cycle.start, opposite(turn))] {
            let wait = Stroke::Wait(cycle.dwell.filter(|_| to < 0.0));
            self.course(&[Stroke::Thread { to, pitch, turn }, wait], span)?;
        }
        Ok(())
    }

    /// The point at a height over the hole.
    fn over_hole(&self, height: f64) -> [f64; 3] {
        frame::add_scaled(self.own.hole, self.own.axis, height)
    }
}

impl Holes for Apt {
    fn stands_at(channel: &AptReader, to: f64) -> bool {
        let point = channel.over_hole(to);
        channel.position.work.xyz().is_some_and(|here| frame::norm(frame::sub(here, point)) <= SAME_MM)
    }

    fn stroke(channel: &mut AptReader, to: f64, rapid: bool, _span: Span) -> Result<(), Fault> {
        if !rapid {
            channel.need_feed();
        }
        let motion = channel.motion(channel.over_hole(to));
        channel.go(motion, rapid);
        Ok(())
    }

    fn thread_stroke(channel: &mut AptReader, to: f64, _span: Span) -> Result<Motion, Fault> {
        Ok(channel.motion(channel.over_hole(to)))
    }
}

fn refused(word: &str, item: &Item) -> Box<Bad> {
    item.place.bad(
        codes::UNSUPPORTED_WORD,
        format!("`{word}` in CYCLE is not supported"),
        "use DRILL, FACE, CSINK, THRU, DEEP, BRKCHP, BORE, REAM or TAP, or write the motions with GOTO",
    )
}
