//! CYCLE72: milling along a contour.
//!
//! ```text
//!      RTP   - - o . . . . . . . . . o    VARI: units 1 rough, 2 finish; tens 1: ways between in FF3, else
//!                :                   ^          rapid; hundreds: lift to RTP, to RFP + SDIS, by SDIS, not
//!      RFP+SDIS  v                   |          at all
//!                |  FFD              |    RL:   40, 41 left, 42 right of the contour
//!      depth     '-(LP1)-contour-(LP2)    AS1, AS2: 1 straight, 2 quarter, 3 half circle; tens 1: in space
//!                                         LP1, LP2: length, or radius of the path of the tool center
//! ```
//!
//! After Siemens, *SINUMERIK 840D Programming Guide Cycles* (11.02), "Path milling - CYCLE72", and *NC
//! programming* (12/2019), "Programming cycles externally" (places of the arguments up to LP2 and digits of
//! VARI). DMODE and AMODE from memory. The contour is given with cutter compensation on, as under G41 and
//! G42, so that its corners are those of the control.

use super::milling::{LEAST_SHARE_MM, share};
use super::run_state::Interpreter;
use crate::channel::milling::{self, Heights};
use crate::channel::shape::{Leg, Pass, Place, Point};
use crate::codes;
use crate::cycle::Values;
use crate::diagnostic::{Fault, Span};
use crate::{CompSide, CutterComp, Feed, Op};

/// Most infeeds.
const MAX_INFEEDS: usize = 10_000;

/// A path onto the contour or off it.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// 1 straight, 2 quarter, 3 half circle.
    kind: u32,
    /// The tool moves down or up along it.
    in_space: bool,
    length: f64,
}

/// What is done at every depth. Paths on and off are those of the tool center.
struct Course {
    on: Pass,
    path: Pass,
    off: Pass,
    on_in_space: bool,
    off_in_space: bool,
    side: CompSide,
    radius: Option<f64>,
    lift: u32,
    mill: Option<Feed>,
    down: Option<Feed>,
    between: Option<Feed>,
    heights: Heights,
}

impl Interpreter {
    /// Runs CYCLE72.
    pub(super) fn path_milling(&mut self, v: &Values) -> Result<(), Fault> {
        let span = v.span;
        let named = self.named_contour(v)?;
        v.no_more()?;
        v.check_plane(self.modal.normal)?;
        let h = v.heights_by_mode(["RTP", "RFP", "SDIS", "DP"])?;
        let (infeed, side_allowance, floor) = (v.value("MID")?, v.value("FAL")?, v.value("FALD")?);
        let (mill, down) = (self.milling_feed(v, "FFP1")?, self.milling_feed(v, "FFD")?);
        let vari = v.value("VARI")?;
        if vari.fract() != 0.0 || !(0.0..1000.0).contains(&vari) {
            let message = format!("VARI of `CYCLE72` is {vari}");
            let help = "1 or 2, tens 0 or 1, hundreds 0 to 3; a contour run backwards is not supported";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, help));
        }
        let vari = vari as u32;
        let finishing = v.finishes(vari % 10)?;
        let side = match v.value("RL")? {
            40.0 => CompSide::Off,
            41.0 => CompSide::Left,
            42.0 => CompSide::Right,
            other => {
                let message = format!("RL of `CYCLE72` is {other}");
                return Err(v.fault(codes::ARGUMENTS, message, "40 on the contour, 41 left, 42 right of it"));
            }
        };
        let radius = if side == CompSide::Off { None } else { self.tool_radius(v)? };
        let allowance = if finishing || side == CompSide::Off { 0.0 } else { side_allowance };
        let beside = radius.map_or(0.0, |r| r + allowance);
        let on = Way::read(v, ["AS1", "LP1"], None, side)?;
        let off = Way::read(v, ["AS2", "LP2"], Some(on), side)?;
        let path = self.contour(&named, span)?;
        let left = side != CompSide::Right;
        let between = if vari / 10 % 10 == 1 { self.milling_feed(v, "FF3")? } else { None };
        let course = Course {
            on: on.onto(&path, beside, left),
            off: off.onto(&path.reversed(), beside, !left).reversed(),
            path,
            on_in_space: on.in_space,
            off_in_space: off.in_space,
            side,
            radius: radius.map(|r| r + allowance),
            lift: vari / 100,
            mill,
            down,
            between,
            heights: h,
        };
        if course.lift > 3 {
            let message = format!("the hundreds of VARI of `CYCLE72` are {}", course.lift);
            return Err(v.fault(codes::ARGUMENTS, message, "0 to 3 say how the tool lifts at the end"));
        }
        let total = (h.depth - h.surface).abs() - if finishing { 0.0 } else { floor };
        let step = share(total, infeed);
        if !(total > 0.0 && total / step.max(LEAST_SHARE_MM) <= MAX_INFEEDS as f64) {
            let message = format!("`CYCLE72` would need no infeed or more than {MAX_INFEEDS}");
            return Err(v.fault(codes::ARGUMENTS, message, "check DP, FALD and MID"));
        }
        let unknown = radius.is_none() && side != CompSide::Off;
        self.assume(format!(
            "CYCLE72: equal infeeds, the tool comes down off the contour at its point of approach{}{}",
            if on.in_space || off.in_space { "; moves in space rise and fall evenly from RFP + SDIS" } else { "" },
            if unknown {
                "; the radius of the tool is not known here, so that LP1, LP2 and FAL count from the contour"
            } else {
                ""
            }
        ));
        let levels = milling::levels(total, step);
        let last = levels.len().saturating_sub(1);
        self.come_up(h.second, span)?;
        for (i, depth) in levels.into_iter().enumerate() {
            self.along_contour(&course, h.surface + h.down * depth, i == last, span)?;
        }
        self.mill_to(None, Some(h.second), None, span)
    }

    fn come_up(&mut self, height: f64, span: Span) -> Result<(), Fault> {
        let normal = self.modal.normal;
        if self.position.work.get(normal).is_none_or(|z| z < height) {
            self.mill_to(None, Some(height), None, span)?;
        }
        Ok(())
    }

    fn along_contour(&mut self, c: &Course, depth: f64, last: bool, span: Span) -> Result<(), Fault> {
        let place = Place::new([0.0; 2], 0.0);
        let radius = |side: CompSide| c.radius.filter(|_| side != CompSide::Off);
        let comp = |side: CompSide| Op::CutterComp(CutterComp { side, offset: None, radius: radius(side) });
        let (stays, clear) = (c.lift == 3, c.heights.clear);
        self.mill_to(Some(c.on.start), None, if stays { c.between.or(c.mill) } else { c.between }, span)?;
        if self.position.work.get(self.modal.normal).is_none_or(|z| (z - clear) * c.heights.down < 0.0) {
            self.mill_to(None, Some(clear), None, span)?;
        }
        if !c.on_in_space {
            self.mill_to(None, Some(depth), c.down, span)?;
        }
        for leg in &c.on.legs {
            let (height, feed) = if c.on_in_space { (Some(depth), c.down) } else { (None, c.mill) };
            self.mill_leg(&place, *leg, height, feed, span)?;
        }
        // The tool center is already at its offset from the contour: it moves neither here nor
        // after the end.
        if c.side != CompSide::Off {
            self.emit(comp(c.side));
        }
        self.mill_pass(&place, &c.path, c.mill, span)?;
        if c.side != CompSide::Off {
            self.emit(comp(CompSide::Off));
        }
        self.mill_to(Some(c.off.start), None, c.mill, span)?;
        for leg in &c.off.legs {
            self.mill_leg(&place, *leg, c.off_in_space.then_some(clear), c.mill, span)?;
        }
        let height = match c.lift {
            _ if last => Some(c.heights.second),
            0 => Some(c.heights.second),
            1 => Some(clear),
            2 => Some(depth - c.heights.down * (clear - c.heights.surface).abs()),
            _ => None,
        };
        height.map_or(Ok(()), |height| self.mill_to(None, Some(height), None, span))
    }
}

impl Way {
    fn read(v: &Values, [form, size]: [&str; 2], usual: Option<Self>, side: CompSide) -> Result<Self, Fault> {
        let kind = match (v.get(form)?.filter(|v| *v != 0.0), usual) {
            (None, Some(usual)) => return Ok(usual),
            (kind, _) => kind.unwrap_or(1.0),
        };
        let number = if kind.fract() == 0.0 && (1.0..20.0).contains(&kind) { kind as u32 } else { 0 };
        let (in_space, units) = (number / 10 == 1, number % 10);
        if !(1..=3).contains(&units) {
            let message = format!("the approach of `{}` (argument {}) is {kind}", v.name(), v.place(form));
            return Err(v.fault(
                codes::UNSUPPORTED_WORD,
                message,
                "1 straight, 2 quarter circle, 3 half circle; 11, 12 and 13 in space",
            ));
        }
        if side == CompSide::Off && units != 1 {
            let message = format!("`{}` comes onto a contour with RL 40 on a circle", v.name());
            return Err(v.fault(codes::ARGUMENTS, message, "write AS1 and AS2 as 1, or RL as 41 or 42"));
        }
        let length = match (v.value(size)?, usual) {
            (0.0, Some(usual)) if usual.kind == units => usual.length,
            (length, _) => length,
        };
        if length <= 0.0 && units != 1 {
            let message =
                format!("the radius of the approach of `{}` (argument {}) is not above zero", v.name(), v.place(size));
            return Err(v.fault(codes::ARGUMENTS, message, "write LP1 and LP2"));
        }
        Ok(Self { kind: units, in_space, length })
    }

    /// The path of the tool center to the start of a contour, offset to one side. `left`: the tool
    /// runs on its left. `beside`: distance from the contour to the tool center.
    fn onto(self, path: &Pass, beside: f64, left: bool) -> Pass {
        let plus = |q: Point, d: Point, by: f64| [q[0] + by * d[0], q[1] + by * d[1]];
        let Some(t) = path.heading() else { return Pass { start: path.start, legs: Vec::new() } };
        let side = if left { [-t[1], t[0]] } else { [t[1], -t[0]] };
        let to = plus(path.start, side, beside);
        if self.kind == 1 {
            let legs = if self.length > 0.0 { vec![Leg::Line(to)] } else { Vec::new() };
            return Pass { start: plus(to, t, -self.length), legs };
        }
        let center = plus(to, side, self.length);
        let start = if self.kind == 2 { plus(center, t, -self.length) } else { plus(center, side, self.length) };
        Pass { start, legs: vec![Leg::Arc { to, center, clockwise: !left }] }
    }
}
