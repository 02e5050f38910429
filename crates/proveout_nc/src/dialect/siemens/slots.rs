//! Slots, elongated holes and spigots: SLOT1, SLOT2, LONGHOLE, CYCLE76, CYCLE77.
//!
//! ```text
//!           LENG               STA1: angle of the first one; INDA: step to the next one, 0 is 360 / NUM
//!         .------.
//!    c   (        ) WID        c: center CPA, CPO; RAD: from c to the inner end (SLOT2: to the middle
//!    |RAD '------'             line, which AFSL goes along)
//! ```
//!
//! Courses after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), "Milling cycles". An
//! elongated hole: to the next depth at FFD at each end of its way, to and fro at FFP1, the nearer
//! end of the next hole first. A slot: infeeds at one place, rings with the allowance FAL, then the
//! wall at FFP2 with the speed SSF. A spigot: once around at each depth, onto it and off it on half
//! circles on the side of the positive first axis, and down where they meet. Parameters are those
//! of the guide, from memory.

use super::drilling::MAX_INFEEDS;
use super::interpreter::Interpreter;
use super::milling::{LEAD_MM, LEAST_SHARE_MM, USUAL_WIDTH, pocket_rings, share};
use crate::channel::milling::{self, Heights, Job, Plan, Plunge};
use crate::channel::shape::{Leg, Pass, Place, Point, Shape};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::Fault;
use crate::frame::sin_cos_degrees;
use crate::{CompSide, CutterComp, Feed, Op};

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
    fn read(v: &Values) -> Result<Self, Fault> {
        let count = v.value("NUM")?;
        if count.fract() != 0.0 || !(1.0..=MOST).contains(&count) {
            let message = format!("`{}` has NUM {count} (argument 6)", v.name());
            return Err(v.fault(codes::ARGUMENTS, message, "write a whole number from 1"));
        }
        let step = match v.value("INDA")? {
            0.0 => 360.0 / count,
            step => step,
        };
        let center = [v.value("CPA")?, v.value("CPO")?];
        Ok(Self { count: count as u32, center, radius: v.value("RAD")?, first: v.value("STA1")?, step })
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

/// Depths below the surface, in equal infeeds of MID at most.
fn depths(total: f64, v: &Values) -> Result<Vec<f64>, Fault> {
    let step = share(total, v.value("MID")?);
    if total / step.max(LEAST_SHARE_MM) > MAX_INFEEDS as f64 {
        let message = format!("`{}` would need more than {MAX_INFEEDS} infeeds", v.name());
        return Err(v.fault(codes::LOOP_LIMIT, message, "check the infeed MID"));
    }
    Ok(milling::levels(total, step))
}

impl Interpreter {
    /// LONGHOLE: as wide as the tool, to and fro, down at the ends.
    pub(super) fn long_holes(&mut self, v: &Values) -> Result<(), Fault> {
        let span = v.span;
        v.no_more()?;
        let h = v.heights()?;
        let row = Row::read(v)?;
        let length = v.above_zero("LENG")?;
        let (down, mill) = (self.milling_feed(v, "FFD")?, self.milling_feed(v, "FFP1")?);
        let radius = self.need_radius(v)?;
        if length < 2.0 * radius {
            let message = format!("an elongated hole of {length} mm is shorter than the tool, {} mm", 2.0 * radius);
            return Err(v.fault(codes::COMPENSATION, message, "use a smaller tool"));
        }
        let levels = depths((h.depth - h.surface).abs(), v)?;
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

    /// The wall of a slot in its own place, its entry, and the other end of a stroke to and fro along its
    /// middle line.
    fn slot_shape(v: &Values, row: &Row, half: f64) -> Result<(Shape, Point, Leg), Fault> {
        if v.name() == "SLOT2" {
            let through = v.value("AFSL")?;
            if !(through > 0.0 && through < 360.0) || half >= row.radius {
                let message = format!("`SLOT2` goes through AFSL {through} degrees, {} mm wide", 2.0 * half);
                let help = "write an angle above 0 and below 360, and a width below twice RAD";
                return Err(v.fault(codes::ARGUMENTS, message, help));
            }
            let (pitch, (s, c)) = (row.radius, sin_cos_degrees(through));
            let stroke = Leg::Arc { to: [pitch * c, pitch * s], center: [0.0; 2], clockwise: false };
            return Ok((Shape::Curved { pitch, from: 0.0, through, half }, [pitch, 0.0], stroke));
        }
        let a = 0.5 * v.above_zero("LENG")?;
        if a < half {
            let message = format!("`SLOT1` is {} mm long and {} mm wide", 2.0 * a, 2.0 * half);
            return Err(v.fault(codes::ARGUMENTS, message, "exchange LENG and WID, or write POCKET3"));
        }
        let shape = Shape::Rounded { a, b: half, corner: half };
        Ok((shape, [half - a, 0.0], Leg::Line([a - half, 0.0])))
    }

    /// SLOT1 and SLOT2.
    pub(super) fn slots(&mut self, v: &Values) -> Result<(), Fault> {
        let span = v.span;
        v.no_more()?;
        let h = v.heights()?;
        let row = Row::read(v)?;
        let half = 0.5 * v.above_zero("WID")?;
        let (down, mill) = (self.milling_feed(v, "FFD")?, self.milling_feed(v, "FFP1")?);
        let climb = self.ring_direction(v, true)?;
        let side = v.value("FAL")?;
        let (tens, units) = v.variant()?;
        if units > 2 {
            let message = format!("the units of VARI of `{}` are {units}", v.name());
            return Err(v.fault(codes::ARGUMENTS, message, "0 does both, 1 roughs, 2 finishes"));
        }
        let finish = match v.get("FFP2")? {
            Some(feed) if feed > 0.0 => self.milling_feed(v, "FFP2")?,
            _ => mill,
        };
        let speed = v.get("SSF")?.filter(|s| *s > 0.0);
        let (floor, angle) = (v.value("FALD")?, v.get("STA2")?);
        let (shape, entry, stroke) = Self::slot_shape(v, &row, half)?;
        let place = |n: u32| match shape {
            Shape::Rounded { a, .. } => Place::new(row.at(n, row.radius + a), row.angle(n)),
            Shape::Curved { .. } => Place::new(row.center, row.angle(n)),
        };
        let Some(radius) = self.tool_radius(v)? else {
            for n in 0..row.count {
                self.wall_alone(v, (place(n), shape, entry), h, (mill, down), climb)?;
            }
            return Ok(());
        };
        let rings = |allowance: f64| pocket_rings(v, shape, (radius, allowance), 2.0 * USUAL_WIDTH * radius, climb);
        let (plunge, feed) = match (tens, angle) {
            (0, _) => (Plunge::Vertical, None),
            (1, _) => (Plunge::Vertical, down),
            (3, Some(angle)) if angle > 0.0 && angle < 90.0 => {
                (Plunge::Strokes { leg: stroke, slope: angle.to_radians().tan() }, down)
            }
            (other, _) => {
                let message = format!("the tens of VARI of `{}` are {other}", v.name());
                let help = "0 and 1 plunge vertically, 3 (SLOT1) to and fro with the angle STA2";
                return Err(v.fault(codes::ARGUMENTS, message, help));
            }
        };
        let total = (h.depth - h.surface).abs();
        depths(total - floor, v)?;
        let wall = milling::wall(shape, radius, LEAD_MM.min(half - radius), climb);
        let (rough, bottom) = (rings(side)?, rings(0.0)?);
        self.assume(format!(
            "{}: {}; rings joined by straight lines, 80 percent of the diameter apart; after each depth the tool comes back over the \
             start of the slot, and plunges from SDIS above it; the wall is finished when the slot has its depth",
            v.name(),
            match shape {
                Shape::Curved { .. } =>
                    "RAD counts to the middle line of the slot and AFSL between the centers of its ends",
                Shape::Rounded { .. } => "RAD and LENG count to the ends of the slot",
            }
        ));
        let job = Job {
            heights: h,
            clearance: (h.clear - h.surface).abs(),
            total,
            infeed: share(total - floor, v.value("MID")?),
            finish_infeed: share(total - floor, v.value("MIDF")?),
            wall_depth: total - floor,
            roughing: true,
            finishing: false,
            side,
            floor,
            mill,
            plunge: feed,
            finish,
            climb,
            radius,
        };
        let mut plan = Plan { place: place(0), entry, plunge, rough, wall, floor: bottom, returns: false };
        for n in 0..row.count {
            plan.place = place(n);
            let middle = plan.place.at(entry);
            if units != 2 {
                self.run_plan(&plan, &job, middle, span)?;
            }
            if units != 1 && (side > 0.0 || floor > 0.0) {
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
    pub(super) fn spigot(&mut self, v: &Values) -> Result<(), Fault> {
        let span = v.span;
        v.no_more()?;
        let h = v.heights()?;
        let circle = v.name() == "CYCLE77";
        // PRAD is the diameter of the spigot.
        let (a, b, corner) = if circle {
            let r = 0.5 * v.above_zero("PRAD")?;
            (r, r, r)
        } else {
            let (a, b) = (0.5 * v.above_zero("LENG")?, 0.5 * v.above_zero("WID")?);
            (a, b, v.value("CRAD")?.min(a).min(b))
        };
        let center = [v.value("PA")?, v.value("PO")?];
        let place = Place::new(center, v.value("STA")?);
        let (side, floor) = (v.value("FAL")?, v.value("FALD")?);
        let (mill, down) = (self.milling_feed(v, "FFP1")?, self.milling_feed(v, "FFD")?);
        let clockwise = self.ring_direction(v, false)?;
        let (tens, units) = v.variant()?;
        let finishing = v.finishes(units)?;
        if tens != 0 {
            let message = format!("the tens of VARI of `{}` are {tens}", v.name());
            return Err(v.fault(codes::ARGUMENTS, message, "1 roughs, 2 finishes"));
        }
        let blank = 0.5 * v.value("AP1")?;
        let wide = if circle { blank } else { 0.5 * v.value("AP2")? };
        if blank > 0.0 && (blank < a || wide < b && wide > 0.0) {
            let message = format!("the blank of `{}` is smaller than the spigot", v.name());
            return Err(v.fault(codes::ARGUMENTS, message, "write the sizes of the blank in AP1 and AP2"));
        }
        let shape = Shape::Rounded { a, b, corner };
        let Some(radius) = self.tool_radius(v)? else {
            let start = [a.max(blank) + LEAD_MM, 0.0];
            return self.wall_alone(v, (place, shape, start), h, (mill, down), !clockwise);
        };
        let allowance = if finishing { 0.0 } else { side };
        let total = (h.depth - h.surface).abs();
        let levels = if finishing { vec![total] } else { depths(total - floor, v)? };
        // The half circle spans from SDIS outside the blank to the path around the spigot.
        let outside = a.max(blank) + radius + side + (h.clear - h.surface).abs();
        let lead = (0.5 * (outside - (a + radius + allowance))).max(LEAD_MM);
        let ring = shape.ring(-(radius + allowance));
        let ring = if clockwise { ring.reversed() } else { ring };
        let pass: Pass = ring.with_leads(lead, true, clockwise, true);
        self.assume(format!(
            "{}: the half circles reach SDIS outside the blank and are {LEAD_MM} mm at least; once around at every \
             depth, as far as the tool cuts",
            v.name()
        ));
        self.come_over(place.at(pass.start), h.second, span)?;
        self.mill_to(None, Some(h.clear), None, span)?;
        for depth in levels {
            self.mill_to(None, Some(h.surface + h.down * depth), down, span)?;
            self.mill_pass(&place, &pass, mill, span)?;
        }
        self.mill_to(None, Some(h.second), None, span)
    }

    /// The finished wall at its depth, with cutter compensation: all that a program without its
    /// tools says of the path. `start`: where the tool goes down, in the cycle. `left`: the tool
    /// runs on the left of the wall, counter-clockwise inside and clockwise outside.
    pub(super) fn wall_alone(
        &mut self,
        v: &Values,
        (place, shape, start): (Place, Shape, Point),
        h: Heights,
        (mill, down): (Option<Feed>, Option<Feed>),
        counter_clockwise: bool,
    ) -> Result<(), Fault> {
        let span = v.span;
        self.assume(format!(
            "{}: the radius of the tool is not known here, so that the finished wall is given once at its depth, with cutter \
             compensation, and no roughing",
            v.name()
        ));
        let outside = matches!(v.name(), "CYCLE76" | "CYCLE77");
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
