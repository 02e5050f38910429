//! Milling cycles: POCKET3 rectangular pocket, POCKET4 circular pocket; the others are in [`super::slots`], [`super::surfaces`] and
//! [`super::contour_milling`].
//!
//! ```text
//!   POCKET3(RTP, RFP, SDIS, DP, LENG, WID, CRAD, PA, PO, STA, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, MIDA, AP1, AP2, AD, RAD1, DP1)
//!   POCKET4(RTP, RFP, SDIS, DP, PRAD, PA, PO, MID, FAL, FALD, FFP1, FFD, CDIR, VARI, MIDA, AP1, AD, RAD1, DP1)
//! ```
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

use super::eval::Val;
use super::frames::number;
use super::interpreter::{Interpreter, Siemens};
use super::parser::Call;
use super::slots::surplus;
use crate::channel::milling::{self, Heights, Job, Mills, Plan, Plunge};
use crate::channel::shape::{Leg, NO_WIDTH_MM, Place, Shape};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::settings::Compensation;
use crate::{AxisValues, Feed, Motion, SpindleDirection};

/// Milling cycles that are read.
pub(crate) const MILLING: [&str; 9] =
    ["POCKET3", "POCKET4", "CYCLE71", "CYCLE61", "SLOT1", "SLOT2", "LONGHOLE", "CYCLE76", "CYCLE77"];

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

/// The arguments of a cycle: numbers by their place, lengths in mm.
pub(super) struct Words<'a> {
    pub(super) name: &'a str,
    values: &'a [Option<Val>],
    length: f64,
    pub(super) span: Span,
    /// Number of arguments of the cycle before the first one here.
    before: usize,
}

impl<'a> Words<'a> {
    /// The arguments after the first one.
    pub(super) fn behind_first(name: &'a str, values: &'a [Option<Val>], length: f64, span: Span) -> Self {
        Self { name, values: values.get(1..).unwrap_or_default(), length, span, before: 1 }
    }

    /// Position of an argument in the call, counted from 1.
    pub(super) fn place(&self, at: usize) -> usize {
        at + self.before + 1
    }
}

impl Words<'_> {
    /// A digit of a number that codes several things: `unit` is 1, 10, 100.
    pub(super) fn digit(&self, at: usize, unit: f64) -> Result<f64, Fault> {
        Ok((self.or_zero(at)? / unit).floor().rem_euclid(10.0))
    }

    /// DMODE: the plane that it names must be the active one.
    pub(super) fn mode_planes(&self, at: usize, normal: usize) -> Result<(), Fault> {
        let plane = self.digit(at, 1.0)?;
        if plane == 0.0 || plane == (3 - normal) as f64 {
            return Ok(());
        }
        let message = format!(
            "`{}` in another plane than the active one (DMODE {}) is not supported",
            self.name,
            self.or_zero(at)?
        );
        Err(self.fault(codes::UNSUPPORTED_WORD, message, "choose the plane with G17, G18 or G19"))
    }

    /// Planes of a cycle whose AMODE says whether the depth is relative (1) or absolute (0, 2).
    pub(super) fn heights_by_mode(&self, mode: f64) -> Result<Heights, Fault> {
        if mode != 1.0 {
            return self.heights();
        }
        self.heights_by(Some(3))
    }

    pub(super) fn number(&self, at: usize) -> Result<Option<f64>, Fault> {
        number(self.values, at, self.name, self.span)
    }

    pub(super) fn or_zero(&self, at: usize) -> Result<f64, Fault> {
        Ok(self.number(at)?.unwrap_or(0.0))
    }

    fn missing(&self, at: usize, what: &str) -> Fault {
        Fault::new(codes::ARGUMENTS, self.span, format!("`{}` has no {what} (argument {})", self.name, self.place(at)))
            .help("write the argument")
    }

    pub(super) fn need(&self, at: usize, what: &str) -> Result<f64, Fault> {
        self.number(at)?.map(|v| v * self.length).ok_or_else(|| self.missing(at, what))
    }

    /// Without sign; zero where it is omitted.
    pub(super) fn size(&self, at: usize) -> Result<f64, Fault> {
        Ok(self.or_zero(at)?.abs() * self.length)
    }

    pub(super) fn above_zero(&self, at: usize, what: &str) -> Result<f64, Fault> {
        let value = self.need(at, what)?.abs();
        if value > 0.0 && value.is_finite() { Ok(value) } else { Err(self.missing(at, what)) }
    }

    pub(super) fn fault(&self, code: &'static str, message: String, help: &'static str) -> Fault {
        Fault::new(code, self.span, message).help(help)
    }

    pub(super) fn refuse_set(&self, at: usize, what: &str) -> Result<(), Fault> {
        if self.or_zero(at)? == 0.0 {
            return Ok(());
        }
        let message = format!("`{}` with {what} (argument {}) is not supported", self.name, self.place(at));
        Err(self.fault(codes::UNSUPPORTED_WORD, message, "let the CAM system write the motions"))
    }

    /// The cycle has no arguments from `from` on.
    pub(super) fn no_more(&self, from: usize) -> Result<(), Fault> {
        let Some(at) = surplus(self.values, from) else { return Ok(()) };
        let message = format!("argument {} of `{}` is not read", self.place(at), self.name);
        let help =
            "leave it out; those that the control's editor adds (GMODE, DMODE, AMODE and before) are not supported";
        Err(self.fault(codes::UNSUPPORTED_WORD, message, help))
    }

    /// Tens and units of VARI.
    pub(super) fn variant_or(&self, at: usize, usual: f64) -> Result<(u32, u32), Fault> {
        let vari = self.number(at)?.unwrap_or(usual);
        if vari.fract() == 0.0 && (0.0..100.0).contains(&vari) {
            return Ok((vari as u32 / 10, vari as u32 % 10));
        }
        Err(self.fault(codes::ARGUMENTS, format!("VARI of `{}` is {vari}", self.name), "write 1 or 2, and tens"))
    }

    pub(super) fn finishes(&self, units: u32) -> Result<bool, Fault> {
        match units {
            1 => Ok(false),
            2 => Ok(true),
            other => Err(self.fault(
                codes::ARGUMENTS,
                format!("the units of VARI of `{}` are {other}", self.name),
                "1 roughs, 2 finishes",
            )),
        }
    }

    /// Planes that all milling cycles share.
    pub(super) fn heights(&self) -> Result<Heights, Fault> {
        self.heights_by(None)
    }

    /// The same where the depth may be relative (DPR), without sign, away from the retraction
    /// plane.
    pub(super) fn heights_by(&self, relative: Option<usize>) -> Result<Heights, Fault> {
        let (retraction, reference) = (self.need(0, "retraction plane")?, self.need(1, "reference plane")?);
        let depth = match relative.map_or(Ok(0.0), |at| self.size(at))? {
            0.0 => self.need(3, "final depth")?,
            below => reference - below * if retraction >= reference { 1.0 } else { -1.0 },
        };
        let down = if depth < reference { -1.0 } else { 1.0 };
        if depth == reference || (retraction - reference) * down > 0.0 {
            let message = format!(
                "the planes of `{}` do not follow each other: retraction {retraction}, reference {reference}, depth {depth}",
                self.name
            );
            return Err(self.fault(
                codes::ARGUMENTS,
                message,
                "the reference plane lies between the retraction plane and the final depth",
            ));
        }
        let clear = reference - down * self.size(2)?;
        Ok(Heights { clear, second: retraction, surface: reference, depth, down })
    }
}

/// The largest equal share of a distance that does not exceed the limit; the whole distance where
/// no limit is given.
pub(super) fn share(way: f64, greatest: f64) -> f64 {
    if greatest > 0.0 { way / (way / greatest - milling::WHOLE).ceil().max(1.0) } else { way }
}

/// Positions of a pocket's arguments, after those of its shape.
struct Places {
    depth: usize,
    /// Sizes of an existing pocket: AP1, AP2, AD.
    roughed: &'static [usize],
    radius: usize,
}

/// What GMODE, DMODE and AMODE of a pocket say.
#[derive(Clone, Copy, Debug, Default)]
struct PocketModes {
    /// 1: the depth is relative.
    depth: f64,
    /// The whole pocket is milled, regardless of the sizes of an existing one.
    whole: bool,
    /// MIDA is a percentage of the tool diameter.
    percent: bool,
}

impl Interpreter {
    /// Runs a milling cycle.
    pub(super) fn mill_cycle(&mut self, call: &Call, span: Span) -> Result<(), Fault> {
        let values = self.arguments(call, span)?;
        let words = Words { name: &call.name, values: &values, length: self.modal.units.length(), span, before: 0 };
        let before = self.technology.feed;
        match call.name.as_str() {
            "CYCLE71" => self.face(&words)?,
            "CYCLE61" => self.surface(&words)?,
            "LONGHOLE" => self.long_holes(&words)?,
            "SLOT1" | "SLOT2" => self.slots(&words)?,
            "CYCLE76" | "CYCLE77" => self.spigot(&words)?,
            _ => self.pocket(&words)?,
        }
        if self.technology.feed != before && before.is_some() {
            self.set_feed(before);
        }
        Ok(())
    }

    /// Radius of the tool in the spindle, mm.
    pub(super) fn tool_radius(&self, words: &Words<'_>) -> Result<Option<f64>, Fault> {
        if let Some(radius) = self.settings.variables.get("$P_TOOLR") {
            return Ok(Some(radius * words.length).filter(|r| *r > 0.0));
        }
        let Compensation::ToolCenter(radii) = &self.settings.compensation else { return Ok(None) };
        match self.technology.in_spindle.as_ref().and_then(|tool| radii.by_tool.get(tool)) {
            Some(radius) if *radius > 0.0 => Ok(Some(*radius)),
            _ => Err(no_radius(words, "the tools do not give")),
        }
    }

    pub(super) fn milling_feed(&self, words: &Words<'_>, at: usize) -> Result<Option<Feed>, Fault> {
        let factor = self.modal.units.feed();
        Ok(words.number(at)?.filter(|f| *f > 0.0).map_or(self.technology.feed, |value| {
            Some(match self.technology.feed {
                Some(Feed::PerRevolution(_)) => Feed::PerRevolution(value * factor),
                _ => Feed::PerTime(value * factor / 60.0),
            })
        }))
    }

    fn pocket(&mut self, words: &Words<'_>) -> Result<(), Fault> {
        let span = words.span;
        let circle = words.name == "POCKET4";
        words.no_more(if circle { 19 } else { 29 })?;
        let modes = if circle { PocketModes::default() } else { self.pocket_modes(words)? };
        let h = words.heights_by_mode(modes.depth)?;
        let (shape, corner, center, turn, places) = if circle {
            let r = words.above_zero(4, "pocket radius")?;
            let center = [words.need(5, "center")?, words.need(6, "center")?];
            let places = Places { depth: 7, roughed: &[15, 16], radius: 17 };
            (Shape::Rounded { a: r, b: r, corner: r }, r, center, 0.0, places)
        } else {
            let (a, b) = (0.5 * words.above_zero(4, "pocket length")?, 0.5 * words.above_zero(5, "pocket width")?);
            let corner = words.size(6)?.min(a).min(b);
            let center = [words.need(7, "center")?, words.need(8, "center")?];
            let places = Places { depth: 10, roughed: &[18, 19, 20], radius: 21 };
            (Shape::Rounded { a, b, corner }, corner, center, words.or_zero(9)?, places)
        };
        let at = places.depth;
        let roughed: &[usize] = if modes.whole { &[] } else { places.roughed };
        for &roughed in roughed {
            words.refuse_set(roughed, "the size of a pre-machined pocket")?;
        }
        let (side, floor) = (words.size(at + 1)?, words.size(at + 2)?);
        let (mill, down) = (self.milling_feed(words, at + 3)?, self.milling_feed(words, at + 4)?);
        let climbs = self.technology.direction != SpindleDirection::CounterClockwise;
        let climb = match words.or_zero(at + 5)? {
            0.0 => climbs,
            1.0 => !climbs,
            2.0 => false,
            3.0 => true,
            other => {
                let message = format!("the direction CDIR of `{}` is {other}", words.name);
                return Err(words.fault(codes::ARGUMENTS, message, "0 climb, 1 up-cut, 2 as G2, 3 as G3"));
            }
        };
        let (insertion, units) = words.variant_or(at + 6, 1.0)?;
        let finishing = words.finishes(units)?;
        let place = Place::new(center, turn);
        let Some(radius) = self.tool_radius(words)? else {
            return self.wall_alone(words, (place, shape, [0.0; 2]), h, (mill, down), climb);
        };
        // Corners smaller than the tool get the radius of the tool.
        let Shape::Rounded { a, b, .. } = shape else { return Ok(()) };
        let shape = Shape::Rounded { a, b, corner: corner.max(radius) };
        let room = shape.half_width() - radius;
        let greatest =
            if modes.percent { words.or_zero(at + 7)?.abs() / 100.0 * 2.0 * radius } else { words.size(at + 7)? };
        let widest = if greatest > 0.0 { greatest } else { 2.0 * USUAL_WIDTH * radius };
        let rings = |allowance: f64| {
            let step = share((room - allowance).max(0.0), widest.min(WIDEST_STEP * radius)).max(NO_WIDTH_MM);
            milling::rings(shape, radius, allowance, step, climb).ok_or_else(|| {
                let message = format!(
                    "a tool of radius {radius} mm does not fit into `{}`: half its width less the allowance is {:.3} mm",
                    words.name,
                    shape.half_width() - allowance
                );
                words.fault(codes::COMPENSATION, message, "use a smaller tool")
            })
        };
        let (plunge, feed) = self.insertion(words, (insertion, places.radius), [a, b], (room - side, radius), down)?;
        let ring = shape.ring(radius);
        let ring = if climb { ring } else { ring.reversed() };
        let lead = LEAD_MM.max(side).min(if corner > radius { corner - radius } else { room }).min(room);
        let wall = if lead > NO_WIDTH_MM { ring.with_leads(lead, false, climb, true) } else { ring };
        let total = (h.depth - h.surface).abs();
        let plan =
            Plan { place, entry: [0.0; 2], plunge, rough: rings(side)?, wall, floor: rings(0.0)?, returns: false };
        let job = Job {
            heights: h,
            clearance: (h.clear - h.surface).abs(),
            total,
            infeed: share(total - floor, words.size(at)?),
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
            words.name
        ));
        self.run_plan(&plan, &job, center, span)
    }

    /// GMODE, DMODE and AMODE, which the editor of the control adds.
    fn pocket_modes(&self, words: &Words<'_>) -> Result<PocketModes, Fault> {
        let refuse = |what: &str, value: f64| {
            let message = format!("`{}` with {what} {value} is not supported", words.name);
            Err(words.fault(
                codes::UNSUPPORTED_WORD,
                message,
                "mill the whole pocket from its center, or let the CAM system write the motions",
            ))
        };
        let (start_only, corner, rest) =
            (words.digit(26, 100.0)?, words.digit(26, 1000.0)?, words.digit(26, 10_000.0)?);
        if start_only > 1.0 || corner > 1.0 || rest > 1.0 {
            return refuse("the mode GMODE", words.or_zero(26)?);
        }
        words.mode_planes(27, self.modal.normal)?;
        Ok(PocketModes { depth: words.digit(28, 1.0)?, whole: rest == 1.0, percent: words.digit(28, 10.0)? == 1.0 })
    }

    /// Tens of VARI: how the tool moves to a depth, and at which feed; none means rapid.
    fn insertion(
        &self,
        words: &Words<'_>,
        (tens, at): (u32, usize),
        [a, b]: [f64; 2],
        (room, radius): (f64, f64),
        down: Option<Feed>,
    ) -> Result<(Plunge, Option<Feed>), Fault> {
        let circle = words.name == "POCKET4";
        match tens {
            0 => Ok((Plunge::Vertical, None)),
            1 => Ok((Plunge::Vertical, down)),
            2 => {
                let helix = words.above_zero(at, "radius of the helix (RAD1)")?;
                let fall = words.above_zero(at + 1, "depth of a turn (DP1)")?;
                if helix > room + NO_WIDTH_MM {
                    let message = format!(
                        "the helix RAD1 of `{}` has {helix} mm and the pocket has room for {:.3} mm",
                        words.name,
                        room.max(0.0)
                    );
                    return Err(words.fault(
                        codes::COMPENSATION,
                        message,
                        "write a smaller RAD1, or use a smaller tool",
                    ));
                }
                Ok((Plunge::Helix { radius: helix, slope: fall / (std::f64::consts::TAU * helix) }, down))
            }
            3 if !circle => {
                let angle = words.number(at)?.unwrap_or(0.0);
                if !(angle > 0.0 && angle < 90.0) {
                    let message = format!("the greatest angle RAD1 of `{}` is {angle}", words.name);
                    return Err(words.fault(codes::ARGUMENTS, message, "write an angle above 0 and below 90 degrees"));
                }
                let along = |half: f64| (half - radius - (b.min(a) - radius - room)).clamp(0.0, 4.0 * radius);
                let leg = Leg::Line(if a >= b { [along(a), 0.0] } else { [0.0, along(b)] });
                Ok((Plunge::Strokes { leg, slope: angle.to_radians().tan() }, down))
            }
            other => {
                let message = format!("the tens of VARI of `{}` are {other}", words.name);
                Err(words.fault(codes::ARGUMENTS, message, "0 and 1 plunge vertically, 2 on a helix, 3 to and fro"))
            }
        }
    }
}

pub(super) fn no_radius(words: &Words<'_>, why: &str) -> Fault {
    words.fault(
        codes::COMPENSATION,
        format!("`{}` needs the radius of the tool, which {why}", words.name),
        "give the tool, or its radius with --variable $P_TOOLR=5",
    )
}
