//! Milling cycles: POCKET3 rectangular pocket, POCKET4 circular pocket; the others are in [`super::slots`],
//! [`super::surfaces`] and [`super::contour_milling`].
//!
//! Courses after Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), "Milling cycles": the
//! pocket from its center outwards, infeeds of equal depth and width, none above MID and MIDA (MIDA
//! 0: 80 percent of the diameter), the wall once and then the base where they have an allowance;
//! the first line of a surface MIDA inside its edge, the last one at its width and FDP1 less the
//! radius, equal steps between them. The guide leaves some things open: the way back to the center
//! for the next depth, how rings are joined, what FDP counts from. These are chosen here and
//! reported as an assumption.
//!
//! The path needs the radius of the tool, from the scene or from the variable `$P_TOOLR`. Where
//! neither gives it and the path of the tool center is not requested, a pocket is its finished
//! wall, once, with cutter compensation.

use super::interpreter::{Interpreter, Siemens};
use crate::channel::milling::{self, Job, Mills, Plan, Plunge};
use crate::channel::shape::{Leg, NO_WIDTH_MM, Pass, Place, Shape};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::{Fault, Span};
use crate::settings::Compensation;
use crate::{AxisValues, Feed, Motion, SpindleDirection};

/// Share of the tool diameter that is the largest infeed width where MIDA gives none.
pub(super) const USUAL_WIDTH: f64 = 0.8;
/// Largest distance between two rings that leaves no posts in their corners, in radii of the tool.
pub(super) const WIDEST_STEP: f64 = 1.7;
/// Radius of the arc onto the wall, mm.
pub(super) const LEAD_MM: f64 = 2.0;
/// Least infeed, mm: their count stays finite.
pub(super) const LEAST_SHARE_MM: f64 = 1e-12;

impl Mills for Siemens {
    fn working_plane(channel: &Interpreter) -> [usize; 3] {
        channel.modal.plane_axes()
    }

    fn mill_feed(channel: &mut Interpreter, _programmed: u16, span: Span) -> Result<(), Fault> {
        channel.own.tangent = None;
        channel.need_feed(span)?;
        channel.tell_feed();
        Ok(())
    }

    fn mill_motion(channel: &Interpreter, end: AxisValues, programmed: u16, span: Span) -> Result<Motion, Fault> {
        channel.cycle_motion(end, programmed, span)
    }

    fn mill_line(
        channel: &mut Interpreter,
        end: AxisValues,
        programmed: u16,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        if !rapid {
            Self::mill_feed(channel, programmed, span)?;
        }
        channel.straight(end, programmed, rapid, span)
    }
}

/// The largest equal share of a distance that does not exceed the limit; the whole distance where
/// no limit is given.
pub(super) fn share(way: f64, greatest: f64) -> f64 {
    if greatest > 0.0 { way / (way / greatest - milling::WHOLE).ceil().max(1.0) } else { way }
}

/// What GMODE, DMODE and AMODE of a pocket say.
#[derive(Clone, Copy, Debug, Default)]
struct PocketModes {
    /// The whole pocket is milled, regardless of the sizes of an existing one.
    whole: bool,
    /// MIDA is a percentage of the tool diameter.
    percent: bool,
}

impl Interpreter {
    /// Runs a milling cycle.
    pub(super) fn mill_cycle(&mut self, v: &Values) -> Result<(), Fault> {
        let before = self.technology.feed;
        match v.name() {
            "CYCLE71" => self.face(v)?,
            "CYCLE61" => self.surface(v)?,
            "CYCLE72" => self.path_milling(v)?,
            "LONGHOLE" => self.long_holes(v)?,
            "SLOT1" | "SLOT2" => self.slots(v)?,
            "CYCLE76" | "CYCLE77" => self.spigot(v)?,
            _ => self.pocket(v)?,
        }
        if self.technology.feed != before && before.is_some() {
            self.set_feed(before);
        }
        Ok(())
    }

    /// Radius of the tool in the spindle, mm.
    pub(super) fn tool_radius(&self, v: &Values) -> Result<Option<f64>, Fault> {
        if let Some(radius) = self.settings.variables.get("$P_TOOLR") {
            return Ok(Some(radius * v.length).filter(|r| *r > 0.0));
        }
        let Compensation::ToolCenter(radii) = &self.settings.compensation else { return Ok(None) };
        match self.technology.in_spindle.as_ref().and_then(|tool| radii.by_tool.get(tool)) {
            Some(radius) if *radius > 0.0 => Ok(Some(*radius)),
            _ => Err(no_radius(v, "the tools do not give")),
        }
    }

    /// The same where the cycle has no path without it.
    pub(super) fn need_radius(&self, v: &Values) -> Result<f64, Fault> {
        self.tool_radius(v)?.ok_or_else(|| no_radius(v, "no tool table gives here"))
    }

    /// The feed of an argument, or else the one in force.
    pub(super) fn milling_feed(&self, v: &Values, name: &str) -> Result<Option<Feed>, Fault> {
        let factor = self.modal.units.feed();
        Ok(v.get(name)?.filter(|f| *f > 0.0).map_or(self.technology.feed, |value| {
            Some(match self.technology.feed {
                Some(Feed::PerRevolution(_)) => Feed::PerRevolution(value * factor),
                _ => Feed::PerTime(value * factor / 60.0),
            })
        }))
    }

    /// CDIR: whether rings in a pocket run counter-clockwise, and those around a spigot clockwise: climb,
    /// up-cut, G2, G3.
    pub(super) fn ring_direction(&self, v: &Values, inside: bool) -> Result<bool, Fault> {
        let climbs = self.technology.direction != SpindleDirection::CounterClockwise;
        match v.value("CDIR")? {
            0.0 => Ok(climbs),
            1.0 => Ok(!climbs),
            2.0 => Ok(!inside),
            3.0 => Ok(inside),
            other => {
                let message = format!("the direction CDIR of `{}` is {other}", v.name());
                Err(v.fault(codes::ARGUMENTS, message, "0 climb, 1 up-cut, 2 as G2, 3 as G3"))
            }
        }
    }

    fn pocket(&mut self, v: &Values) -> Result<(), Fault> {
        v.no_more()?;
        let circle = v.name() == "POCKET4";
        let modes = if circle { PocketModes::default() } else { self.pocket_modes(v)? };
        let h = v.heights_by_mode(["RTP", "RFP", "SDIS", "DP"])?;
        let (a, b, corner) = if circle {
            let r = v.above_zero("PRAD")?;
            (r, r, r)
        } else {
            let (a, b) = (0.5 * v.above_zero("LENG")?, 0.5 * v.above_zero("WID")?);
            (a, b, v.value("CRAD")?.min(a).min(b))
        };
        let center = [v.value("PA")?, v.value("PO")?];
        let place = Place::new(center, v.value("STA")?);
        for roughed in if modes.whole { [].as_slice() } else { &["AP1", "AP2", "AD"] } {
            v.refuse_set(roughed, "the size of a pre-machined pocket")?;
        }
        let (side, floor) = (v.value("FAL")?, v.value("FALD")?);
        let (mill, down) = (self.milling_feed(v, "FFP1")?, self.milling_feed(v, "FFD")?);
        let climb = self.ring_direction(v, true)?;
        let (insertion, units) = v.variant()?;
        let finishing = v.finishes(units)?;
        let Some(radius) = self.tool_radius(v)? else {
            let shape = Shape::Rounded { a, b, corner };
            return self.wall_alone(v, (place, shape, [0.0; 2]), h, (mill, down), climb);
        };
        // Corners smaller than the tool get the radius of the tool.
        let shape = Shape::Rounded { a, b, corner: corner.max(radius) };
        let room = shape.half_width() - radius;
        let greatest =
            if modes.percent { v.raw("MIDA")?.unwrap_or(0.0).abs() / 100.0 * 2.0 * radius } else { v.value("MIDA")? };
        let widest = if greatest > 0.0 { greatest } else { 2.0 * USUAL_WIDTH * radius };
        let rings = |allowance: f64| pocket_rings(v, shape, (radius, allowance), widest, climb);
        let (plunge, feed) = self.insertion(v, insertion, [a, b], (room - side, radius), down)?;
        let lead = LEAD_MM.max(side).min(if corner > radius { corner - radius } else { room }).min(room);
        let total = (h.depth - h.surface).abs();
        let plan = Plan {
            place,
            entry: [0.0; 2],
            plunge,
            rough: rings(side)?,
            wall: milling::wall(shape, radius, lead, climb),
            floor: rings(0.0)?,
            returns: false,
        };
        let job = Job {
            heights: h,
            clearance: (h.clear - h.surface).abs(),
            total,
            infeed: share(total - floor, v.value("MID")?),
            finish_infeed: 0.0,
            wall_depth: total - floor,
            roughing: !finishing,
            finishing,
            side,
            floor,
            mill,
            plunge: feed,
            finish: mill,
            climb,
            radius,
        };
        self.assume(format!(
            "{}: rings joined by straight lines, an infeed width above 1.7 radii counts as 1.7; after each depth the tool comes \
             back over the center, and plunges from SDIS above it",
            v.name()
        ));
        self.run_plan(&plan, &job, center, v.span)
    }

    /// GMODE, DMODE and AMODE, which the editor of the control adds.
    fn pocket_modes(&self, v: &Values) -> Result<PocketModes, Fault> {
        let (start_only, corner, rest) =
            (v.digit("GMODE", 100.0)?, v.digit("GMODE", 1000.0)?, v.digit("GMODE", 10_000.0)?);
        if start_only > 1.0 || corner > 1.0 || rest > 1.0 {
            let message = format!("`{}` with the mode GMODE {} is not supported", v.name(), v.value("GMODE")?);
            let help = "mill the whole pocket from its center, or let the CAM system write the motions";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, help));
        }
        v.check_plane(self.modal.normal)?;
        Ok(PocketModes { whole: rest == 1.0, percent: v.digit("AMODE", 10.0)? == 1.0 })
    }

    /// Tens of VARI: how the tool moves to a depth, and at which feed; none means rapid.
    fn insertion(
        &self,
        v: &Values,
        tens: u32,
        [a, b]: [f64; 2],
        (room, radius): (f64, f64),
        down: Option<Feed>,
    ) -> Result<(Plunge, Option<Feed>), Fault> {
        match tens {
            0 => Ok((Plunge::Vertical, None)),
            1 => Ok((Plunge::Vertical, down)),
            2 => {
                let (helix, fall) = (v.above_zero("RAD1")?, v.above_zero("DP1")?);
                if helix > room + NO_WIDTH_MM {
                    let message = format!(
                        "the helix RAD1 of `{}` has {helix} mm and the pocket has room for {:.3} mm",
                        v.name(),
                        room.max(0.0)
                    );
                    return Err(v.fault(codes::COMPENSATION, message, "write a smaller RAD1, or use a smaller tool"));
                }
                Ok((Plunge::Helix { radius: helix, slope: fall / (std::f64::consts::TAU * helix) }, down))
            }
            3 if v.name() != "POCKET4" => {
                let angle = v.raw("RAD1")?.unwrap_or(0.0);
                if !(angle > 0.0 && angle < 90.0) {
                    let message = format!("the greatest angle RAD1 of `{}` is {angle}", v.name());
                    return Err(v.fault(codes::ARGUMENTS, message, "write an angle above 0 and below 90 degrees"));
                }
                let along = |half: f64| (half - radius - (b.min(a) - radius - room)).clamp(0.0, 4.0 * radius);
                let leg = Leg::Line(if a >= b { [along(a), 0.0] } else { [0.0, along(b)] });
                Ok((Plunge::Strokes { leg, slope: angle.to_radians().tan() }, down))
            }
            other => {
                let message = format!("the tens of VARI of `{}` are {other}", v.name());
                Err(v.fault(codes::ARGUMENTS, message, "0 and 1 plunge vertically, 2 on a helix, 3 to and fro"))
            }
        }
    }
}

/// Rings in a pocket or a slot, from the inside out, in equal steps of `widest` at most.
pub(super) fn pocket_rings(
    v: &Values,
    shape: Shape,
    (radius, allowance): (f64, f64),
    widest: f64,
    climb: bool,
) -> Result<Vec<Pass>, Fault> {
    let room = shape.half_width() - radius;
    let step = share((room - allowance).max(0.0), widest.min(WIDEST_STEP * radius)).max(NO_WIDTH_MM);
    milling::rings(shape, radius, allowance, step, climb)
        .ok_or_else(|| milling::too_wide(shape, radius, allowance, &format!("`{}`", v.name()), v.span))
}

fn no_radius(v: &Values, why: &str) -> Fault {
    let message = format!("`{}` needs the radius of the tool, which {why}", v.name());
    v.fault(codes::COMPENSATION, message, "give the tool, or its radius with --variable $P_TOOLR=5")
        .of_variable("$P_TOOLR")
}
