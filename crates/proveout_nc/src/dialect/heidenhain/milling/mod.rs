//! Milling cycles, expanded to the motions of the control.
//!
//! 251 rectangular pocket, 252 circular pocket, 253 slot, 254 circular slot ([`pocket`]), 256 rectangular stud, 257 circular stud
//! ([`stud`]), 208 bore milling, 262 thread milling ([`bore`]), 263 to 265 threads that are countersunk, drilled or milled downwards
//! ([`thread`]), 232 face milling ([`face`]).
//!
//! Courses after HEIDENHAIN, *TNC 640 Programming of machining cycles* (34059x), chapters "Pocket milling / stud milling / slot
//! milling", "Drilling" (208), "Threading" (262) and "Face milling" (232): which material is taken in which order, on which side,
//! with which infeeds and feeds. What they leave to the control - the plunging angle of the tool table, the radius of leads, how
//! passes are joined - is chosen here and told as an assumption when the cycle is defined.
//!
//! The path needs the radius of the tool. It comes from the tools of the scene or as `Q108`. Where neither gives it and the path
//! of the tool center is not asked for, the finished wall is given once, at its depth, with cutter compensation.

mod bore;
mod face;
mod pocket;
mod shape;
mod stud;
mod thread;

use std::collections::BTreeMap;

use super::cycle::Setting;
use super::drilling::Heights;
use super::interpreter::Interpreter;
use super::motion::Goal;
use super::words::{Kind, Param};
use crate::arc::PlaneArc;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::settings::Compensation;
use crate::{CompSide, CutterComp, Feed, Op, SpindleDirection};

use shape::{Leg, Pass, Place, Point};

type Values = BTreeMap<u32, Setting>;

/// Milling cycles that are read.
pub(crate) const CYCLES: [u32; 12] = [208, 232, 251, 252, 253, 254, 256, 257, 262, 263, 264, 265];

/// Largest overlap factor that leaves no posts in the corners between rings: a ring reaches the corner that the one around it
/// has left where (k - R) sqrt(2) is at most R.
const LARGEST_OVERLAP: f64 = 1.7;
/// Plunging angle where the tool table would give it, degrees: chosen, what makers allow for milling cutters that do not cut at
/// their center.
const PLUNGE_ANGLE_DEG: f64 = 3.0;
/// Most passes of one cycle.
const MAX_PASSES: usize = 100_000;

/// How the tool comes to a depth.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Plunge {
    Vertical,
    /// About the entry point.
    Helix(f64),
    /// To and fro along a piece of the path that begins at the entry point.
    Strokes(Leg),
}

/// What a cycle mills at every depth, in its own plane.
#[derive(Debug)]
struct Plan {
    place: Place,
    entry: Point,
    plunge: Plunge,
    rough: Vec<Pass>,
    wall: Pass,
    floor: Vec<Pass>,
    /// The tool comes back to where the cycle was called.
    returns: bool,
}

/// Heights, infeeds and feeds.
#[derive(Clone, Copy, Debug)]
struct Job {
    heights: Heights,
    clearance: f64,
    /// Below the surface.
    total: f64,
    infeed: f64,
    finish_infeed: f64,
    roughing: bool,
    finishing: bool,
    side: f64,
    floor: f64,
    mill: Option<Feed>,
    plunge: Option<Feed>,
    finish: Option<Feed>,
    /// Rings of a pocket run counter-clockwise, those of a stud clockwise.
    climb: bool,
    radius: f64,
}

/// Depths below the surface down to the total.
fn levels(total: f64, infeed: f64) -> Vec<f64> {
    let mut depths = Vec::new();
    let mut reached = 0.0;
    while total - reached > 1e-9 && depths.len() < MAX_PASSES {
        reached = if infeed > 0.0 && reached + infeed < total - 1e-9 { reached + infeed } else { total };
        depths.push(reached);
    }
    depths
}

impl Interpreter {
    /// What can be told to be wrong when the cycle is defined, and what is taken for granted.
    pub(crate) fn check_milling(&mut self, number: u32, values: &Values, span: Span) -> Result<(), Fault> {
        let (needed, assumed): (&[u32], &str) = match number {
            208 => bore::bore_words(),
            262 => bore::thread_words(),
            263..=265 => thread::words(number),
            232 => face::words(),
            256 | 257 => stud::words(number),
            _ => pocket::words(number),
        };
        for &key in needed {
            if !values.contains_key(&key) {
                return Err(Fault::new(codes::ARGUMENTS, span, format!("cycle {number} has no Q{key}"))
                    .help(format!("write Q{key}=, as the control does")));
            }
        }
        if number != 232 && self.cycle_number(values, 201, None, span)? == 0.0 {
            return Err(Fault::new(codes::ARGUMENTS, span, format!("the depth Q201 of cycle {number} is zero"))
                .help("write a depth below zero"));
        }
        for &(key, remedy) in thread::zeros(number) {
            let value = self.cycle_number(values, key, None, span)?;
            if value != 0.0 {
                let message = format!("cycle {number} with Q{key}={value} is not supported");
                return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help(remedy));
            }
        }
        if self.cycle_number(values, 439, Some(3.0), span)? == 1.0 {
            self.assume(format!(
                "cycle {number}: Q439=1 counts the feed at the cutting edge, and is taken at the tool center"
            ));
        }
        self.assume(format!("cycle {number}: {assumed}"));
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

    /// Runs a milling cycle where the tool stands.
    pub(crate) fn mill(&mut self, number: u32, values: &Values, lift: f64, span: Span) -> Result<(), Fault> {
        let before = self.technology.feed;
        let Some(radius) = self.tool_radius() else {
            self.mill_wall_alone(number, values, lift, span)?;
            self.technology.feed = before;
            return Ok(());
        };
        match number {
            208 => self.bore_mill(values, radius, lift, span)?,
            262 => self.thread_mill(values, radius, lift, span)?,
            263..=265 => self.thread_cycle(number, values, radius, lift, span)?,
            232 => self.face_mill(values, radius, span)?,
            _ => {
                let job = self.job(number, values, radius, lift, span)?;
                let here = self.flat(span)?;
                let plans = match number {
                    256 | 257 => vec![self.stud_plan(number, values, &job, here, span)?],
                    _ => self.pocket_plans(number, values, &job, here, span)?,
                };
                for plan in &plans {
                    self.run_plan(plan, &job, here, span)?;
                }
            }
        }
        self.technology.feed = before;
        Ok(())
    }

    fn job(&self, number: u32, values: &Values, radius: f64, lift: f64, span: Span) -> Result<Job, Fault> {
        let heights = self.heights(number, values, lift, span)?;
        let len = |key: u32, default: f64| self.mm(values, key, Some(default), span).map(f64::abs);
        let operation = self.cycle_number(values, 215, Some(0.0), span)?;
        if !matches!(operation, 0.0 | 1.0 | 2.0) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("Q215 takes 0, 1 or 2 and has {operation}"))
                .help("0 roughs and finishes, 1 roughs, 2 finishes"));
        }
        let (side, floor) = (len(368, 0.0)?, len(369, 0.0)?);
        let mill = self.cycle_feed(values, 207, span)?;
        let finish = if values.contains_key(&385) { self.cycle_feed(values, 385, span)? } else { mill };
        Ok(Job {
            heights,
            clearance: (heights.clear - heights.surface).abs(),
            total: (heights.depth - heights.surface).abs(),
            infeed: len(202, 0.0)?,
            finish_infeed: len(338, 0.0)?,
            roughing: operation != 2.0,
            finishing: operation != 1.0,
            side,
            floor,
            mill,
            plunge: self.cycle_feed(values, 206, span)?,
            finish,
            climb: self.climbs(values, span)?,
            radius,
        })
    }

    /// Q351: +1 climb, -1 up-cut. With M4 the tool runs the other way round.
    fn climbs(&self, values: &Values, span: Span) -> Result<bool, Fault> {
        let way = self.cycle_number(values, 351, Some(1.0), span)?;
        if way.abs() != 1.0 {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("Q351 takes +1 or -1 and has {way}"))
                .help("+1 mills in climb, -1 in up-cut"));
        }
        Ok((way > 0.0) == (self.technology.direction != SpindleDirection::CounterClockwise))
    }

    /// Way between two passes, mm.
    fn overlap(&self, values: &Values, radius: f64, span: Span) -> Result<f64, Fault> {
        let factor = self.cycle_number(values, 370, Some(1.0), span)?;
        if !(factor > 0.0 && factor < 2.0) {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("the overlap factor Q370 is {factor}"))
                .help("write a factor above 0 and below 2"));
        }
        Ok(factor.min(LARGEST_OVERLAP) * radius)
    }

    fn goal_at(&self, point: Option<Point>, height: Option<f64>) -> Goal {
        let [u, v, n] = self.modal.plane_axes();
        let mut goal = Goal { end: self.position.work, programmed: 0, tool_axis: None };
        if let Some(point) = point {
            goal.end.put(u, point[0]);
            goal.end.put(v, point[1]);
            goal.programmed |= 1 << u | 1 << v;
        }
        if let Some(height) = height {
            goal.end.put(n, height);
            goal.programmed |= 1 << n;
        }
        goal
    }

    /// Straight to a point of the working plane, a height, or both; without a feed at rapid rate.
    fn mill_to(
        &mut self,
        point: Option<Point>,
        height: Option<f64>,
        feed: Option<Feed>,
        span: Span,
    ) -> Result<(), Fault> {
        let goal = self.goal_at(point, height);
        if (0..3).all(|axis| goal.programmed >> axis & 1 == 0 || goal.end.get(axis) == self.position.work.get(axis)) {
            return Ok(());
        }
        if let Some(feed) = feed {
            self.technology.feed = Some(feed);
        }
        self.straight(goal, feed.is_none(), span)
    }

    /// An arc in the working plane through an angle, with a way along the tool axis.
    fn mill_arc(
        &mut self,
        (to, center, clockwise): (Point, Point, bool),
        angle: f64,
        height: Option<f64>,
        feed: Option<Feed>,
        span: Span,
    ) -> Result<(), Fault> {
        let start = self.flat(span)?;
        if let Some(feed) = feed {
            self.technology.feed = Some(feed);
        }
        let radius = (start[0] - center[0]).hypot(start[1] - center[1]);
        self.arc_to(self.goal_at(Some(to), height), PlaneArc { center, radius, sweep: angle }, clockwise, span)
    }

    fn mill_leg(
        &mut self,
        place: &Place,
        leg: Leg,
        height: Option<f64>,
        feed: Option<Feed>,
        span: Span,
    ) -> Result<(), Fault> {
        match leg {
            Leg::Line(to) => self.mill_to(Some(place.at(to)), height, feed, span),
            Leg::Arc { to, center, clockwise } => {
                let (to, center) = (place.at(to), place.at(center));
                let angle = shape::sweep(self.flat(span)?, to, center, clockwise);
                self.mill_arc((to, center, clockwise), angle, height, feed, span)
            }
        }
    }

    fn mill_pass(&mut self, place: &Place, pass: &Pass, feed: Option<Feed>, span: Span) -> Result<(), Fault> {
        self.mill_to(Some(place.at(pass.start)), None, feed, span)?;
        for leg in &pass.legs {
            self.mill_leg(place, *leg, None, feed, span)?;
        }
        Ok(())
    }

    /// Above a point of the plane at a height at least, at rapid rate: up, across, down.
    fn come_over(&mut self, point: Point, height: f64, span: Span) -> Result<(), Fault> {
        let normal = self.modal.normal;
        if self.position.work.get(normal).is_none_or(|z| z < height) {
            self.mill_to(None, Some(height), None, span)?;
        }
        self.mill_to(Some(point), None, None, span)?;
        self.mill_to(None, Some(height), None, span)
    }

    fn run_plan(&mut self, plan: &Plan, job: &Job, here: Point, span: Span) -> Result<(), Fault> {
        let h = job.heights;
        let entry = plan.place.at(plan.entry);
        let at = |depth: f64| h.surface + h.down * depth;
        self.come_over(entry, h.clear, span)?;
        let mut reached = 0.0;
        if job.roughing && job.total - job.floor > 0.0 {
            for depth in levels(job.total - job.floor, job.infeed) {
                self.plunge(plan, job, at(reached), at(depth), span)?;
                for pass in &plan.rough {
                    self.mill_pass(&plan.place, pass, job.mill, span)?;
                }
                self.mill_to(None, Some(at(depth - job.clearance)), None, span)?;
                self.mill_to(Some(entry), None, None, span)?;
                reached = depth;
            }
        }
        if job.finishing && job.side > 0.0 {
            for depth in levels(job.total, job.finish_infeed) {
                self.mill_to(None, Some(at(depth)), job.plunge, span)?;
                self.mill_pass(&plan.place, &plan.wall, job.finish, span)?;
                self.mill_to(Some(entry), None, job.finish, span)?;
            }
            self.mill_to(None, Some(at(job.total - job.clearance)), None, span)?;
        }
        if job.finishing && job.floor > 0.0 {
            self.mill_to(None, Some(h.depth), job.plunge, span)?;
            for pass in &plan.floor {
                self.mill_pass(&plan.place, pass, job.finish, span)?;
            }
        }
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)?;
        if plan.returns { self.mill_to(Some(here), None, None, span) } else { Ok(()) }
    }

    /// From above what was milled before to the next depth.
    fn plunge(&mut self, plan: &Plan, job: &Job, from: f64, to: f64, span: Span) -> Result<(), Fault> {
        let slope = PLUNGE_ANGLE_DEG.to_radians().tan();
        let begin = from - job.heights.down * job.clearance;
        let drop = (to - begin).abs();
        let entry = plan.place.at(plan.entry);
        match plan.plunge {
            Plunge::Vertical => self.mill_to(None, Some(to), job.plunge, span),
            Plunge::Helix(radius) => {
                let side = plan.place.at([plan.entry[0] + radius, plan.entry[1]]);
                let turns = (drop / (std::f64::consts::TAU * radius * slope)).ceil().clamp(1.0, 1e4);
                self.mill_to(Some(side), None, job.plunge, span)?;
                let circle = (side, entry, !job.climb);
                self.mill_arc(circle, turns * std::f64::consts::TAU, Some(to), job.plunge, span)?;
                self.mill_arc(circle, std::f64::consts::TAU, None, job.plunge, span)?;
                self.mill_to(Some(entry), None, job.plunge, span)
            }
            Plunge::Strokes(leg) => {
                let there = Pass { start: plan.entry, legs: vec![leg] };
                let back = there.reversed();
                let length = match leg {
                    Leg::Line(p) => (p[0] - plan.entry[0]).hypot(p[1] - plan.entry[1]),
                    Leg::Arc { to, center, clockwise } => {
                        let radius = (to[0] - center[0]).hypot(to[1] - center[1]);
                        radius * shape::sweep(plan.entry, to, center, clockwise)
                    }
                };
                if length < shape::NO_WIDTH_MM {
                    return self.mill_to(None, Some(to), job.plunge, span);
                }
                // There and back, so that the tool ends where it began; the last two are level.
                let pairs = (drop / (2.0 * length * slope)).ceil().clamp(1.0, 1e4) as u32;
                for stroke in 0..2 * pairs + 2 {
                    let part = (f64::from(stroke + 1) / f64::from(2 * pairs)).min(1.0);
                    let height = begin + (to - begin) * part;
                    let way = if stroke % 2 == 0 { &there } else { &back };
                    for leg in &way.legs {
                        self.mill_leg(&plan.place, *leg, Some(height), job.plunge, span)?;
                    }
                }
                Ok(())
            }
        }
    }

    /// The finished wall at its depth with cutter compensation: what a program without its tool table says of the path.
    fn mill_wall_alone(&mut self, number: u32, values: &Values, lift: f64, span: Span) -> Result<(), Fault> {
        let unknown = |message: &str| {
            Fault::new(
                codes::COMPENSATION,
                span,
                format!("cycle {number} needs the radius of the tool, which {message}"),
            )
            .help("give the tool, or its radius with --variable Q108=5")
        };
        if matches!(self.settings.compensation, Compensation::ToolCenter(_)) {
            return Err(unknown("the tools do not give"));
        }
        if number == 232 {
            return Err(unknown("no tool table gives here"));
        }
        let h = self.heights(number, values, lift, span)?;
        let here = self.flat(span)?;
        let (place, shape, inside) = match number {
            208 | 262..=265 => {
                let r = 0.5 * self.mm(values, 335, None, span)?;
                (Place::new(here, 0.0), shape::Shape::Rounded { a: r, b: r, corner: r }, true)
            }
            256 | 257 => {
                let (place, shape, ..) = self.stud_shape(number, values, here, span)?;
                (place, shape, false)
            }
            _ => {
                let (place, shape, ..) = self.pocket_shape(number, values, here, span)?;
                (place, shape, true)
            }
        };
        let climb = self.climbs(values, span)?;
        self.assume(format!(
            "cycle {number}: the radius of the tool is not known here, so that the finished wall is given once at its depth, with \
             cutter compensation, and no roughing"
        ));
        let ring = shape.ring(0.0);
        let ring = if climb == inside { ring } else { ring.reversed() };
        let key = if number == 208 { 206 } else { 207 };
        let feed = self.cycle_feed(values, key, span)?;
        let start = place.at(ring.start);
        self.come_over(if inside { here } else { start }, h.clear, span)?;
        self.mill_to(None, Some(h.depth), feed, span)?;
        // Climb has the tool on the left of its contour, whichever way round.
        let side = if climb { CompSide::Left } else { CompSide::Right };
        self.emit(Op::CutterComp(CutterComp { side, offset: None, radius: None }));
        self.mill_pass(&place, &ring, feed, span)?;
        self.emit(Op::CutterComp(CutterComp { side: CompSide::Off, offset: None, radius: None }));
        self.mill_to(None, Some(h.clear), None, span)?;
        self.mill_to(None, Some(h.second), None, span)?;
        self.mill_to(Some(here), None, None, span)
    }
}

#[cfg(test)]
mod tests {
    use super::levels;

    #[test]
    fn levels_end_at_the_depth() {
        assert_eq!(levels(10.0, 4.0), [4.0, 8.0, 10.0]);
        assert_eq!(levels(8.0, 4.0), [4.0, 8.0]);
        assert_eq!(levels(8.0, 0.0), [8.0]);
        assert!(levels(0.0, 4.0).is_empty());
    }
}
