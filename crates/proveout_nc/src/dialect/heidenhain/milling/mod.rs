//! Milling cycles, expanded to the motions of the control.
//!
//! 251 rectangular pocket, 252 circular pocket, 253 slot, 254 circular slot ([`pocket`]), 256
//! rectangular stud, 257 circular stud ([`stud`]), 208 bore milling, 262 thread milling ([`bore`]),
//! 263 to 265 threads that are countersunk, drilled or milled downwards ([`thread`]), 232 and 233
//! face milling ([`face`]), 230 and 231 lines over flat and ruled surfaces ([`ruled`]), the old
//! pockets 4 and 5 as 251 and 252, and those of 210 to 215 ([`old`]).
//!
//! Courses after HEIDENHAIN, *TNC 640 Programming of machining cycles* (34059x), chapters "Pocket
//! milling / stud milling / slot milling", "Drilling" (208), "Threading" (262) and "Face milling"
//! (232, 233): which material is cut in which order, on which side, with which infeeds and feeds.
//! The manual leaves some things to the control: the plunging angle of the tool table, the radius
//! of leads, how passes are joined. These are chosen here and reported as an assumption when the
//! cycle is defined.
//!
//! The path needs the radius of the tool, from the tools of the scene or from `Q108`. Where neither
//! gives it and the path of the tool center is not requested, the finished wall is emitted once, at
//! its depth, with cutter compensation.

mod bore;
mod face;
mod old;
mod pocket;
mod ruled;
mod stud;
mod thread;

use super::drilling::check_depth;
use super::interpreter::{Heidenhain, Interpreter};
use super::motion::Goal;
use super::words::{Kind, Param};
use crate::channel::milling::{Job, Mills};
use crate::channel::shape::{self, Place};
use crate::codes;
use crate::cycle::{Key, Values, heidenhain as table};
use crate::diagnostic::{Fault, Span};
use crate::settings::Compensation;
use crate::{AxisValues, CompSide, CutterComp, Motion, Op, SpindleDirection};

/// The cycle mills. Those have courses of their own, of which something is taken for granted.
pub(super) fn is_milling(cycle: &str) -> bool {
    table::ALL.iter().any(|spec| spec.name == cycle && spec.assumed.is_some())
}

/// Largest overlap factor that leaves no posts in the corners between rings: a ring reaches the
/// corner left by the ring around it if (k - R) sqrt(2) is at most R.
const LARGEST_OVERLAP: f64 = 1.7;
/// Plunging angle, degrees, in place of the one in the tool table. Chosen: the angle that
/// manufacturers allow for milling cutters that do not cut at their center.
const PLUNGE_ANGLE_DEG: f64 = 3.0;

/// Descent of a plunge per length of its path.
fn plunge_slope() -> f64 {
    PLUNGE_ANGLE_DEG.to_radians().tan()
}

impl Mills for Heidenhain {
    fn working_plane(channel: &Interpreter) -> [usize; 3] {
        channel.modal.plane_axes()
    }

    fn mill_feed(channel: &mut Interpreter, _programmed: u16, span: Span) -> Result<(), Fault> {
        channel.modal.tangent = None;
        channel.need_feed(span)
    }

    fn mill_motion(channel: &Interpreter, end: AxisValues, programmed: u16, span: Span) -> Result<Motion, Fault> {
        channel.complete(Goal { end, programmed, tool_axis: None }, span)
    }

    fn mill_line(
        channel: &mut Interpreter,
        end: AxisValues,
        programmed: u16,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        channel.straight(Goal { end, programmed, tool_axis: None }, rapid, span)
    }
}

impl Interpreter {
    /// Checks the parameters when the cycle is defined, and reports what is assumed.
    pub(crate) fn check_milling(&mut self, v: &Values) -> Result<(), Fault> {
        let number = v.name();
        for parameter in v.spec.parameters.iter().filter(|parameter| parameter.written) {
            if let Key::Q(key) = parameter.key
                && v.given(key).is_none()
            {
                return Err(Fault::new(codes::ARGUMENTS, v.span, format!("cycle {number} has no Q{key}"))
                    .help(format!("write Q{key}=, as the control does")));
            }
        }
        if !matches!(number, "230" | "231" | "232" | "233") {
            check_depth(v)?;
        }
        for &(key, remedy) in table::zeros(number) {
            let value = v.raw(key)?.unwrap_or(0.0);
            if value != 0.0 {
                let message = format!("cycle {number} with Q{key}={value} is not supported");
                return Err(v.fault(codes::UNSUPPORTED_WORD, message, remedy));
            }
        }
        if number == "233" && v.value(389)? == 4.0 {
            let message = "cycle 233 with Q389=4 (a spiral from the outside in) is not supported";
            return Err(v.fault(codes::UNSUPPORTED_WORD, message, "choose Q389=0 to 3"));
        }
        if v.value(439)? == 1.0 {
            self.assume(format!(
                "cycle {number}: Q439=1 counts the feed at the cutting edge, and is taken at the tool center"
            ));
        }
        if let Some(assumed) = v.spec.assumed {
            self.assume(format!("cycle {number}: {assumed}"));
        }
        Ok(())
    }

    /// Radius of the tool in the spindle with its delta value, mm.
    fn tool_radius(&self) -> Option<f64> {
        self.variables.get(Param { kind: Kind::Global, index: 108 }).map(|r| r * self.modal.unit()).filter(|r| *r > 0.0)
    }

    /// A tool has come: what the tool table says of its radius is Q108.
    pub(crate) fn take_tool_radius(&mut self, span: Span) -> Result<(), Fault> {
        let param = Param { kind: Kind::Global, index: 108 };
        self.variables.forget(param);
        let Compensation::ToolCenter(radii) = &self.settings.compensation else { return Ok(()) };
        let known = self.technology.in_spindle.as_ref().and_then(|tool| radii.by_tool.get(tool)).copied();
        let Some(radius) = known else { return Ok(()) };
        self.variables.set(param, (radius + self.modal.delta[1]) / self.modal.unit(), span)
    }

    /// Cycles 4 and 5: the surface lies the set-up clearance below the tool, and DR says the direction.
    pub(crate) fn old_pocket_here(&mut self, v: &Values) -> Result<(), Fault> {
        let clearance = v.value(200)?;
        let surface = self.known(self.modal.normal, v.span)? - clearance;
        let climbs = self.technology.direction != SpindleDirection::CounterClockwise;
        let turn = v.value(351)?;
        let mut values = v.clone();
        values.put(203, surface / v.length);
        values.put(204, clearance / v.length);
        values.put(351, if climbs { turn } else { -turn });
        for (key, value) in [(215, 1.0), (224, 0.0), (366, 0.0)] {
            values.put(key, value);
        }
        values.spec = if v.name() == "4" { &table::C251 } else { &table::C252 };
        self.mill(&values)
    }

    /// Runs a milling cycle at the tool position.
    pub(crate) fn mill(&mut self, v: &Values) -> Result<(), Fault> {
        if matches!(v.name(), "210" | "211" | "212" | "213" | "214" | "215") {
            return self.mill_old(v);
        }
        let before = self.technology.feed;
        let Some(radius) = self.tool_radius() else {
            self.mill_wall_alone(v)?;
            self.technology.feed = before;
            return Ok(());
        };
        match v.name() {
            "208" => self.bore_mill(v, radius)?,
            "262" => self.thread_mill(v, radius)?,
            "263" | "264" | "265" => self.thread_cycle(v, radius)?,
            "230" => self.multipass(v, radius)?,
            "231" => self.ruled_surface(v, radius)?,
            "232" => self.face_mill(v, radius)?,
            "233" => self.face_233(v, radius)?,
            number => {
                let job = self.job(v, radius)?;
                let here = self.flat(v.span)?;
                let plans = match number {
                    "256" | "257" => vec![self.stud_plan(v, &job, here)?],
                    _ => self.pocket_plans(v, &job, here)?,
                };
                for plan in &plans {
                    self.run_plan(plan, &job, here, v.span)?;
                }
            }
        }
        self.technology.feed = before;
        Ok(())
    }

    fn job(&self, v: &Values, radius: f64) -> Result<Job, Fault> {
        let heights = self.heights(v)?;
        let len = |key: u32| v.value(key).map(f64::abs);
        let operation = v.value(215)?;
        if !matches!(operation, 0.0 | 1.0 | 2.0) {
            let message = format!("Q215 takes 0, 1 or 2 and has {operation}");
            return Err(v.fault(codes::BAD_VALUE, message, "0 roughs and finishes, 1 roughs, 2 finishes"));
        }
        let (side, floor) = (len(368)?, len(369)?);
        let mill = self.cycle_feed(v, 207)?;
        let finish = if v.given(385).is_some() { self.cycle_feed(v, 385)? } else { mill };
        Ok(Job {
            heights,
            clearance: (heights.clear - heights.surface).abs(),
            total: (heights.depth - heights.surface).abs(),
            wall_depth: (heights.depth - heights.surface).abs(),
            infeed: len(202)?,
            finish_infeed: len(338)?,
            roughing: operation != 2.0,
            finishing: operation != 1.0,
            side,
            floor,
            mill,
            plunge: self.cycle_feed(v, 206)?,
            finish,
            climb: self.climbs(v)?,
            radius,
        })
    }

    /// Q351: +1 climb, -1 up-cut. With M4 the tool rotates the other way.
    fn climbs(&self, v: &Values) -> Result<bool, Fault> {
        let way = v.value(351)?;
        if way.abs() != 1.0 {
            let message = format!("Q351 takes +1 or -1 and has {way}");
            return Err(v.fault(codes::BAD_VALUE, message, "+1 mills in climb, -1 in up-cut"));
        }
        Ok((way > 0.0) == (self.technology.direction != SpindleDirection::CounterClockwise))
    }

    /// Distance between two passes, mm.
    fn overlap(&self, v: &Values, radius: f64) -> Result<f64, Fault> {
        let factor = v.value(370)?;
        if !(factor > 0.0 && factor < 2.0) {
            let message = format!("the overlap factor Q370 is {factor}");
            return Err(v.fault(codes::BAD_VALUE, message, "write a factor above 0 and below 2"));
        }
        Ok(factor.min(LARGEST_OVERLAP) * radius)
    }

    /// The finished wall at its depth with cutter compensation: all that a program without its tool
    /// table says of the path.
    fn mill_wall_alone(&mut self, v: &Values) -> Result<(), Fault> {
        let (number, span) = (v.name(), v.span);
        let unknown = |why: &str| {
            let message = format!("cycle {number} needs the radius of the tool, which {why}");
            let help = "give the tool, or its radius with --variable Q108=5";
            Err(v.fault(codes::COMPENSATION, message, help).of_variable("Q108"))
        };
        if matches!(self.settings.compensation, Compensation::ToolCenter(_)) {
            return unknown("the tools do not give");
        }
        if matches!(number, "230" | "231" | "232" | "233") {
            return unknown("no tool table gives here");
        }
        let h = self.heights(v)?;
        let here = self.flat(span)?;
        let (place, shape, inside) = match number {
            "208" | "262" | "263" | "264" | "265" => {
                let r = 0.5 * v.value(335)?;
                (Place::new(here, 0.0), shape::Shape::Rounded { a: r, b: r, corner: r }, true)
            }
            "256" | "257" => {
                let (place, shape, ..) = Self::stud_shape(v, here)?;
                (place, shape, false)
            }
            _ => {
                let (place, shape, ..) = Self::pocket_shape(v, here)?;
                (place, shape, true)
            }
        };
        let climb = self.climbs(v)?;
        self.assume(format!(
            "cycle {number}: the radius of the tool is not known here, so that the finished wall is given once at its depth, with \
             cutter compensation, and no roughing"
        ));
        let ring = shape.ring(0.0);
        let ring = if climb == inside { ring } else { ring.reversed() };
        let key = if number == "208" { 206 } else { 207 };
        let feed = self.cycle_feed(v, key)?;
        let start = place.at(ring.start);
        self.come_over(if inside { here } else { start }, h.clear, span)?;
        self.mill_to(None, Some(h.depth), feed, span)?;
        // In climb milling the tool is on the left of its contour, whichever way it runs.
        let side = if climb { CompSide::Left } else { CompSide::Right };
        self.emit(Op::CutterComp(CutterComp { side, offset: None, radius: None }));
        self.mill_pass(&place, &ring, feed, span)?;
        self.emit(Op::CutterComp(CutterComp { side: CompSide::Off, offset: None, radius: None }));
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)?;
        self.mill_to(Some(here), None, None, span)
    }
}
