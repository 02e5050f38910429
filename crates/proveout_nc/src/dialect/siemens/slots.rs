//! Slots, elongated holes and spigots: SLOT1, SLOT2, LONGHOLE, CYCLE76, CYCLE77.
//!
//! ```text
//!   SLOT1(RTP, RFP, SDIS, DP, DPR, NUM, LENG, WID, CPA, CPO, RAD, STA1, INDA, FFD, FFP1, MID, CDIR, FAL, VARI, MIDF, FFP2, SSF,
//!         FALD, STA2)                                 NUM slots on a circle, each along a ray
//!   SLOT2(RTP, RFP, SDIS, DP, DPR, NUM, AFSL, WID, CPA, CPO, RAD, STA1, INDA, FFD, FFP1, MID, CDIR, FAL, VARI, MIDF, FFP2, SSF)
//!                                                     NUM slots along the circle
//!   LONGHOLE(RTP, RFP, SDIS, DP, DPR, NUM, LENG, CPA, CPO, RAD, STA1, INDA, FFD, FFP1, MID)      as wide as the tool
//!   CYCLE76(RTP, RFP, SDIS, DP, DPR, LENG, WID, CRAD, PA, PO, STA, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, AP1, AP2)
//!   CYCLE77(RTP, RFP, SDIS, DP, DPR, PRAD, PA, PO, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, AP1)
//!
//!           LENG               STA1: angle of the first one; INDA: step to the next one, 0 is 360 / NUM
//!         .------.
//!    c   (        ) WID        c: center CPA, CPO; RAD: from c to the inner end (SLOT2: to the middle line, which AFSL goes along)
//!    |RAD '------'
//! ```
//!
//! Courses after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), "Milling cycles". An
//! elongated hole: to the next depth at FFD at each end of its way, to and fro at FFP1, the nearer
//! end of the next hole first. A slot: infeeds at one place, rings with the allowance FAL, then the
//! wall at FFP2 with the speed SSF. A spigot: once around at each depth, onto it and off it on half
//! circles on the side of the positive first axis, and down where they meet. Parameters are those
//! of the guide, from memory.

use super::drilling::MAX_INFEEDS;
use super::eval::Val;
use super::interpreter::Interpreter;
use super::milling::{LEAD_MM, LEAST_SHARE_MM, USUAL_WIDTH, WIDEST_STEP, Words, no_radius, share};
use crate::channel::milling::{self, Heights, Job, Plan, Plunge};
use crate::channel::shape::{Leg, NO_WIDTH_MM, Pass, Place, Point, Shape};
use crate::codes;
use crate::diagnostic::Fault;
use crate::frame::sin_cos_degrees;
use crate::{CompSide, CutterComp, Feed, Op, SpindleDirection};

/// Most slots of one cycle.
const MOST: f64 = 10_000.0;

/// Positions of the slots: how many, about which center, at which distance, from which angle in
/// which steps.
struct Row {
    count: u32,
    center: Point,
    radius: f64,
    first: f64,
    step: f64,
}

impl Row {
    /// NUM, then from `at` on CPA, CPO, RAD, STA1, INDA.
    fn read(words: &Words<'_>, at: usize) -> Result<Self, Fault> {
        let count = words.number(5)?.unwrap_or(1.0);
        if count.fract() != 0.0 || !(1.0..=MOST).contains(&count) {
            let message = format!("`{}` has NUM {count} (argument 6)", words.name);
            return Err(words.fault(codes::ARGUMENTS, message, "write a whole number from 1"));
        }
        let step = match words.or_zero(at + 4)? {
            0.0 => 360.0 / count,
            step => step,
        };
        Ok(Self {
            count: count as u32,
            center: [words.need(at, "center")?, words.need(at + 1, "center")?],
            radius: words.size(at + 2)?,
            first: words.or_zero(at + 3)?,
            step,
        })
    }

    fn angle(&self, n: u32) -> f64 {
        self.first + f64::from(n) * self.step
    }

    /// A point at a distance from the center along the ray of a slot.
    fn at(&self, n: u32, distance: f64) -> Point {
        let (s, c) = sin_cos_degrees(self.angle(n));
        [self.center[0] + distance * c, self.center[1] + distance * s]
    }
}

/// Depths of a cycle: heights, and what is below the surface.
fn depths(total: f64, infeed: f64, words: &Words<'_>) -> Result<Vec<f64>, Fault> {
    let step = share(total, infeed);
    if total / step.max(LEAST_SHARE_MM) > MAX_INFEEDS as f64 {
        let message = format!("`{}` would need more than {MAX_INFEEDS} infeeds", words.name);
        return Err(words.fault(codes::LOOP_LIMIT, message, "check the infeed MID"));
    }
    Ok(milling::levels(total, step))
}

impl Interpreter {
    /// LONGHOLE: as wide as the tool, to and fro, down at the ends.
    pub(super) fn long_holes(&mut self, words: &Words<'_>) -> Result<(), Fault> {
        let span = words.span;
        words.no_more(15)?;
        let h = words.heights_by(Some(4))?;
        let row = Row::read(words, 7)?;
        let length = words.above_zero(6, "length")?;
        let (down, mill) = (self.milling_feed(words, 12)?, self.milling_feed(words, 13)?);
        let Some(radius) = self.tool_radius(words)? else {
            return Err(no_radius(words, "no tool table gives here"));
        };
        if length < 2.0 * radius {
            let message = format!("an elongated hole of {length} mm is shorter than the tool, {} mm", 2.0 * radius);
            return Err(words.fault(codes::COMPENSATION, message, "use a smaller tool"));
        }
        let levels = depths((h.depth - h.surface).abs(), words.size(14)?, words)?;
        self.assume("LONGHOLE: RAD and LENG count to the ends of the hole, not to the middle of the tool");
        let mut here = None;
        for n in 0..row.count {
            let mut ends = [row.at(n, row.radius + radius), row.at(n, row.radius + length - radius)];
            let way = |from: Point, to: Point| (from[0] - to[0]).hypot(from[1] - to[1]);
            if here.is_some_and(|here| way(here, ends[1]) < way(here, ends[0])) {
                ends.swap(0, 1);
            }
            self.come_over(ends[0], h.second, span)?;
            self.mill_to(None, Some(h.clear), None, span)?;
            let mut side = 0;
            for depth in &levels {
                self.mill_to(None, Some(h.surface + h.down * depth), down, span)?;
                side = 1 - side;
                self.mill_to(Some(ends[side]), None, mill, span)?;
            }
            self.mill_to(None, Some(h.second), None, span)?;
            here = Some(ends[side]);
        }
        Ok(())
    }

    /// SLOT1 and SLOT2.
    pub(super) fn slots(&mut self, words: &Words<'_>) -> Result<(), Fault> {
        let span = words.span;
        let along = words.name == "SLOT2";
        words.no_more(if along { 22 } else { 24 })?;
        let h = words.heights_by(Some(4))?;
        let row = Row::read(words, 8)?;
        let half = 0.5 * words.above_zero(7, "width")?;
        let (down, mill) = (self.milling_feed(words, 13)?, self.milling_feed(words, 14)?);
        let climb = self.ring_direction(words, 16, true)?;
        let side = words.size(17)?;
        let (tens, units) = words.variant_or(18, 0.0)?;
        let (roughing, finishing) = match units {
            0 => (true, true),
            1 => (true, false),
            2 => (false, true),
            other => {
                let message = format!("the units of VARI of `{}` are {other}", words.name);
                return Err(words.fault(codes::ARGUMENTS, message, "0 does both, 1 roughs, 2 finishes"));
            }
        };
        let finish = self.milling_feed_or(words, 20, mill)?;
        let speed = words.number(21)?.filter(|s| *s > 0.0);
        let (floor, angle) = if along { (0.0, None) } else { (words.size(22)?, words.number(23)?) };
        let shape = if along {
            let through = words.number(6)?.unwrap_or(0.0);
            if !(through > 0.0 && through < 360.0) || half >= row.radius {
                let message = format!("`SLOT2` goes through AFSL {through} degrees, {} mm wide", 2.0 * half);
                return Err(words.fault(
                    codes::ARGUMENTS,
                    message,
                    "write an angle above 0 and below 360, and a width below twice RAD",
                ));
            }
            Shape::Curved { pitch: row.radius, from: 0.0, through, half }
        } else {
            let a = 0.5 * words.above_zero(6, "length")?;
            if a < half {
                let message = format!("`SLOT1` is {} mm long and {} mm wide", 2.0 * a, 2.0 * half);
                return Err(words.fault(codes::ARGUMENTS, message, "exchange LENG and WID, or write POCKET3"));
            }
            Shape::Rounded { a, b: half, corner: half }
        };
        // The plunge is at the start of the slot, the other end of a stroke is the other end of its middle line.
        let (entry, stroke) = match shape {
            Shape::Rounded { a, b, .. } => ([b - a, 0.0], Leg::Line([a - b, 0.0])),
            Shape::Curved { pitch, through, .. } => {
                let (s, c) = sin_cos_degrees(through);
                let end = [pitch * c, pitch * s];
                ([pitch, 0.0], Leg::Arc { to: end, center: [0.0; 2], clockwise: false })
            }
        };
        let place = |n: u32| {
            let (point, angle) = match shape {
                Shape::Rounded { a, .. } => (row.at(n, row.radius + a), row.angle(n)),
                Shape::Curved { .. } => (row.center, row.angle(n)),
            };
            Place::new(point, angle)
        };
        let Some(radius) = self.tool_radius(words)? else {
            for n in 0..row.count {
                self.wall_alone(words, (place(n), shape, entry), h, (mill, down), climb)?;
            }
            return Ok(());
        };
        let room = half - radius;
        let step = |allowance: f64| {
            share((room - allowance).max(0.0), (2.0 * USUAL_WIDTH * radius).min(WIDEST_STEP * radius)).max(NO_WIDTH_MM)
        };
        let rings = |allowance: f64| {
            milling::rings(shape, radius, allowance, step(allowance), climb).ok_or_else(|| {
                let message = format!(
                    "a tool of radius {radius} mm does not fit into `{}`: half its width less the allowance is {:.3} mm",
                    words.name,
                    half - allowance
                );
                words.fault(codes::COMPENSATION, message, "use a smaller tool")
            })
        };
        let (plunge, feed) = match (tens, angle) {
            (0, _) => (Plunge::Vertical, None),
            (1, _) => (Plunge::Vertical, down),
            (3, Some(angle)) if angle > 0.0 && angle < 90.0 => {
                (Plunge::Strokes { leg: stroke, slope: angle.to_radians().tan() }, down)
            }
            (other, _) => {
                let message = format!("the tens of VARI of `{}` are {other}", words.name);
                let help = "0 and 1 plunge vertically, 3 (SLOT1) to and fro with the angle STA2";
                return Err(words.fault(codes::ARGUMENTS, message, help));
            }
        };
        let total = (h.depth - h.surface).abs();
        depths(total - floor, words.size(15)?, words)?;
        let ring = shape.ring(radius);
        let ring = if climb { ring } else { ring.reversed() };
        let lead = LEAD_MM.min(room);
        let wall = if lead > NO_WIDTH_MM { ring.with_leads(lead, false, climb, true) } else { ring };
        let (rough, bottom) = (rings(side)?, rings(0.0)?);
        self.assume(format!(
            "{}: {}; rings joined by straight lines, 80 percent of the diameter apart; after each depth the tool comes back over the \
             start of the slot, and plunges from SDIS above it; the wall is finished when the slot has its depth",
            words.name,
            if along {
                "RAD counts to the middle line of the slot and AFSL between the centers of its ends"
            } else {
                "RAD and LENG count to the ends of the slot"
            }
        ));
        for n in 0..row.count {
            let plan = Plan {
                place: place(n),
                entry,
                plunge,
                rough: rough.clone(),
                wall: wall.clone(),
                floor: bottom.clone(),
                returns: false,
            };
            let job = Job {
                heights: h,
                clearance: (h.clear - h.surface).abs(),
                total,
                infeed: share(total - floor, words.size(15)?),
                finish_infeed: share(total - floor, words.size(19)?),
                wall_depth: total - floor,
                roughing,
                finishing: false,
                side,
                floor,
                mill,
                plunge: feed,
                finish,
                climb,
                radius,
            };
            let middle = plan.place.at(entry);
            if roughing {
                self.run_plan(&plan, &job, middle, span)?;
            }
            if finishing && (side > 0.0 || floor > 0.0) {
                let before = self.technology.speed;
                if let Some(speed) = speed {
                    self.set_speed(speed, false);
                }
                self.run_plan(&plan, &Job { roughing: false, finishing: true, ..job }, middle, span)?;
                if let (Some(_), Some(before)) = (speed, before) {
                    self.set_speed(before, false);
                }
            }
        }
        Ok(())
    }

    /// CYCLE76, CYCLE77.
    pub(super) fn spigot(&mut self, words: &Words<'_>) -> Result<(), Fault> {
        let span = words.span;
        let circle = words.name == "CYCLE77";
        words.no_more(if circle { 16 } else { 20 })?;
        let h = words.heights_by(Some(4))?;
        // PRAD is the diameter of the spigot.
        let (a, b, corner, at) = if circle {
            let r = 0.5 * words.above_zero(5, "spigot diameter")?;
            (r, r, r, 6)
        } else {
            let (a, b) = (0.5 * words.above_zero(5, "spigot length")?, 0.5 * words.above_zero(6, "spigot width")?);
            (a, b, words.size(7)?.min(a).min(b), 8)
        };
        let center = [words.need(at, "center")?, words.need(at + 1, "center")?];
        let turn = if circle { 0.0 } else { words.or_zero(at + 2)? };
        let at = if circle { at + 2 } else { at + 3 };
        let (side, floor) = (words.size(at + 1)?, words.size(at + 2)?);
        let (mill, down) = (self.milling_feed(words, at + 3)?, self.milling_feed(words, at + 4)?);
        let clockwise = self.ring_direction(words, at + 5, false)?;
        let (tens, units) = words.variant_or(at + 6, 1.0)?;
        let finishing = words.finishes(units)?;
        if tens != 0 {
            let message = format!("the tens of VARI of `{}` are {tens}", words.name);
            return Err(words.fault(codes::ARGUMENTS, message, "1 roughs, 2 finishes"));
        }
        let blank = 0.5 * words.size(at + 7)?;
        let wide = if circle { blank } else { 0.5 * words.size(at + 8)? };
        if blank > 0.0 && (blank < a || wide < b && wide > 0.0) {
            let message = format!("the blank of `{}` is smaller than the spigot", words.name);
            return Err(words.fault(codes::ARGUMENTS, message, "write the sizes of the blank in AP1 and AP2"));
        }
        let place = Place::new(center, turn);
        let shape = Shape::Rounded { a, b, corner };
        let Some(radius) = self.tool_radius(words)? else {
            let start = [a.max(blank) + LEAD_MM, 0.0];
            return self.wall_alone(words, (place, shape, start), h, (mill, down), !clockwise);
        };
        let allowance = if finishing { 0.0 } else { side };
        let total = (h.depth - h.surface).abs();
        let levels = match finishing {
            true => vec![total],
            false => depths(total - floor, words.size(at)?, words)?,
        };
        // The half circle spans from SDIS outside the blank to the path around the spigot.
        let outside = a.max(blank) + radius + side + (h.clear - h.surface).abs();
        let lead = (0.5 * (outside - (a + radius + allowance))).max(LEAD_MM);
        let ring = shape.ring(-(radius + allowance));
        let ring = if clockwise { ring.reversed() } else { ring };
        let pass: Pass = ring.with_leads(lead, true, clockwise, true);
        self.assume(format!(
            "{}: the half circles reach SDIS outside the blank and are {LEAD_MM} mm at least; once around at every \
             depth, as far as the tool cuts",
            words.name
        ));
        self.come_over(place.at(pass.start), h.second, span)?;
        self.mill_to(None, Some(h.clear), None, span)?;
        for depth in levels {
            self.mill_to(None, Some(h.surface + h.down * depth), down, span)?;
            self.mill_pass(&place, &pass, mill, span)?;
        }
        self.mill_to(None, Some(h.second), None, span)
    }

    /// CDIR, as counter-clockwise rings in a pocket and as clockwise ones around a spigot: climb, up-cut, G2, G3.
    fn ring_direction(&self, words: &Words<'_>, at: usize, inside: bool) -> Result<bool, Fault> {
        let climbs = self.technology.direction != SpindleDirection::CounterClockwise;
        match words.or_zero(at)? {
            0.0 => Ok(climbs),
            1.0 => Ok(!climbs),
            2.0 => Ok(!inside),
            3.0 => Ok(inside),
            other => {
                let message = format!("the direction CDIR of `{}` is {other}", words.name);
                Err(words.fault(codes::ARGUMENTS, message, "0 climb, 1 up-cut, 2 as G2, 3 as G3"))
            }
        }
    }

    fn milling_feed_or(&self, words: &Words<'_>, at: usize, other: Option<Feed>) -> Result<Option<Feed>, Fault> {
        Ok(if words.number(at)?.is_some_and(|f| f > 0.0) { self.milling_feed(words, at)? } else { other })
    }

    /// The finished wall at its depth, with cutter compensation: all that a program without its
    /// tools says of the path. `start`: where the tool goes down, in the cycle. `left`: the tool
    /// runs on the left of the wall, counter-clockwise inside and clockwise outside.
    pub(super) fn wall_alone(
        &mut self,
        words: &Words<'_>,
        (place, shape, start): (Place, Shape, Point),
        h: Heights,
        (mill, down): (Option<Feed>, Option<Feed>),
        counter_clockwise: bool,
    ) -> Result<(), Fault> {
        let span = words.span;
        self.assume(format!(
            "{}: the radius of the tool is not known here, so that the finished wall is given once at its depth, with cutter \
             compensation, and no roughing",
            words.name
        ));
        let outside = matches!(words.name, "CYCLE76" | "CYCLE77");
        let ring = shape.ring(0.0);
        let ring = if counter_clockwise { ring } else { ring.reversed() };
        let start = place.at(start);
        self.come_over(start, h.clear, span)?;
        self.mill_to(None, Some(h.depth), down, span)?;
        let side = if counter_clockwise != outside { CompSide::Left } else { CompSide::Right };
        self.emit(Op::CutterComp(CutterComp { side, offset: None, radius: None }));
        self.mill_pass(&place, &ring, mill, span)?;
        self.emit(Op::CutterComp(CutterComp { side: CompSide::Off, offset: None, radius: None }));
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)?;
        self.mill_to(Some(start), None, None, span)
    }
}

/// The first argument that is set after the last one the cycle has.
pub(super) fn surplus(values: &[Option<Val>], from: usize) -> Option<usize> {
    let set = |value: &Option<Val>| value.as_ref().is_some_and(|value| *value != Val::Number(0.0));
    values.iter().skip(from).position(set).map(|at| from + at)
}
