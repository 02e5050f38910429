//! Milling cycles: what is milled at every depth, and the motions that it takes.
//!
//! ```text
//!   come_over   - - - o              above the entry at rapid rate
//!   plunge            v              vertically, on a helix, to and fro
//!   rough       (((   )))            rings from the inside out, one overlap apart; then up, back over
//!                                    the entry, the next depth
//!   wall, floor (         )          with their allowances, on arcs onto the wall and off it
//! ```
//!
//! A language says with [`Mills`] how its motions are completed, and makes a [`Plan`] and a [`Job`] of the
//! words of its cycle.

use super::shape::{self, Leg, NO_WIDTH_MM, Pass, Place, Point, Shape};
use super::{Channel, Language};
use crate::arc::PlaneArc;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::{AxisValues, Feed, Motion};

/// Most passes of one cycle.
pub(crate) const MAX_PASSES: usize = 100_000;
/// Heights and sums of infeeds nearer than this are one, mm: rounding.
pub(crate) const SAME_HEIGHT_MM: f64 = 1e-9;
/// A count of passes that is above a whole number by no more than this is that number: rounding.
pub(crate) const WHOLE: f64 = 1e-9;
/// Most turns of a helix, and strokes of a ramp there and back.
const MOST_TURNS: f64 = 1e4;

/// How the tool comes to a depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Plunge {
    Vertical,
    /// About the entry point, falling by the slope.
    Helix {
        radius: f64,
        slope: f64,
    },
    /// To and fro along a piece of the path that begins at the entry point.
    Strokes {
        leg: Leg,
        slope: f64,
    },
}

/// What a cycle mills at every depth, in its own plane.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) place: Place,
    pub(crate) entry: Point,
    pub(crate) plunge: Plunge,
    pub(crate) rough: Vec<Pass>,
    pub(crate) wall: Pass,
    pub(crate) floor: Vec<Pass>,
    /// The tool comes back to where the cycle was called.
    pub(crate) returns: bool,
}

/// Heights of a cycle along the normal of the working plane, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heights {
    pub(crate) clear: f64,
    pub(crate) second: f64,
    pub(crate) surface: f64,
    pub(crate) depth: f64,
    /// -1 where the hole goes towards the workpiece.
    pub(crate) down: f64,
}

/// Heights, infeeds and feeds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Job {
    pub(crate) heights: Heights,
    pub(crate) clearance: f64,
    /// Below the surface.
    pub(crate) total: f64,
    pub(crate) infeed: f64,
    pub(crate) finish_infeed: f64,
    /// Depth of the wall that is finished, below the surface.
    pub(crate) wall_depth: f64,
    pub(crate) roughing: bool,
    pub(crate) finishing: bool,
    pub(crate) side: f64,
    pub(crate) floor: f64,
    pub(crate) mill: Option<Feed>,
    pub(crate) plunge: Option<Feed>,
    pub(crate) finish: Option<Feed>,
    /// Rings of a pocket run counter-clockwise, those of a stud clockwise.
    pub(crate) climb: bool,
    pub(crate) radius: f64,
}

/// Depths below the surface down to the total.
pub(crate) fn levels(total: f64, infeed: f64) -> Vec<f64> {
    let mut depths = Vec::new();
    let mut reached = 0.0;
    while total - reached > SAME_HEIGHT_MM && depths.len() < MAX_PASSES {
        reached = if infeed > 0.0 && reached + infeed < total - SAME_HEIGHT_MM { reached + infeed } else { total };
        depths.push(reached);
    }
    depths
}

/// Rings of the tool center in a pocket, from the inside out, the last one with an arc off the wall; none
/// where the tool does not fit. `overlap`: greatest way between two of them, mm. The innermost leaves no more
/// than the radius inside of it, or is the spine.
pub(crate) fn rings(shape: Shape, radius: f64, allowance: f64, overlap: f64, climb: bool) -> Option<Vec<Pass>> {
    let widest = shape.half_width() - radius - allowance;
    if widest < -NO_WIDTH_MM {
        return None;
    }
    let mut passes = Vec::new();
    let mut width = widest;
    loop {
        let ring = shape.ring(shape.half_width() - width.max(0.0));
        passes.push(if climb { ring } else { ring.reversed() });
        if width <= radius || passes.len() > MAX_PASSES {
            break;
        }
        width -= overlap;
    }
    passes.reverse();
    let lead = radius.min(widest);
    if let Some(last) = passes.pop() {
        passes.push(if widest > NO_WIDTH_MM { last.with_leads(lead, false, climb, false) } else { last });
    }
    Some(passes)
}

/// The wall of a pocket, once around, on arcs of the radius `lead` onto it and off it.
pub(crate) fn wall(shape: Shape, radius: f64, lead: f64, climb: bool) -> Pass {
    let ring = shape.ring(radius);
    let ring = if climb { ring } else { ring.reversed() };
    if lead > NO_WIDTH_MM { ring.with_leads(lead, false, climb, true) } else { ring }
}

/// The fault of a pocket into which the tool does not fit.
pub(crate) fn too_wide(shape: Shape, radius: f64, allowance: f64, cycle: &str, span: Span) -> Fault {
    let message = format!(
        "a tool of radius {radius} mm does not fit into {cycle}: half its width less the allowance is {:.3} mm",
        shape.half_width() - allowance
    );
    Fault::new(codes::COMPENSATION, span, message).help("use a smaller tool")
}

/// A language with milling cycles: its plane, its feed, and how it completes a motion.
pub(crate) trait Mills: Language {
    /// First and second axis of the working plane, and its normal.
    fn working_plane(channel: &Channel<Self>) -> [usize; 3];

    /// Before a motion in feed of these axes (bit mask): checks that a feed is in force, and emits
    /// it.
    fn mill_feed(channel: &mut Channel<Self>, programmed: u16, span: Span) -> Result<(), Fault>;

    /// The motion to work coordinates of which these axes are set.
    fn mill_motion(channel: &Channel<Self>, end: AxisValues, programmed: u16, span: Span) -> Result<Motion, Fault>;

    /// Straight, at rapid rate or in feed.
    fn mill_line(
        channel: &mut Channel<Self>,
        end: AxisValues,
        programmed: u16,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault>;
}

impl<L: Mills> Channel<L> {
    /// Work coordinates of the tool in the working plane.
    fn over(&self, span: Span) -> Result<Point, Fault> {
        let [u, v, _] = L::working_plane(self);
        Ok([self.known(u, span)?, self.known(v, span)?])
    }

    fn end_at(&self, point: Option<Point>, height: Option<f64>) -> (AxisValues, u16) {
        let [u, v, n] = L::working_plane(self);
        let (mut end, mut programmed) = (self.position.work, 0);
        if let Some(point) = point {
            end.put(u, point[0]);
            end.put(v, point[1]);
            programmed |= 1 << u | 1 << v;
        }
        if let Some(height) = height {
            end.put(n, height);
            programmed |= 1 << n;
        }
        (end, programmed)
    }

    /// Straight to a point of the working plane, a height, or both; without a feed at rapid rate.
    pub(crate) fn mill_to(
        &mut self,
        point: Option<Point>,
        height: Option<f64>,
        feed: Option<Feed>,
        span: Span,
    ) -> Result<(), Fault> {
        let (end, programmed) = self.end_at(point, height);
        if (0..3).all(|axis| programmed >> axis & 1 == 0 || end.get(axis) == self.position.work.get(axis)) {
            return Ok(());
        }
        if let Some(feed) = feed {
            self.technology.feed = Some(feed);
        }
        L::mill_line(self, end, programmed, feed.is_none(), span)
    }

    /// An arc in the working plane through an angle, with a way along the tool axis.
    pub(crate) fn mill_arc(
        &mut self,
        (to, center, clockwise): (Point, Point, bool),
        angle: f64,
        height: Option<f64>,
        feed: Option<Feed>,
        span: Span,
    ) -> Result<(), Fault> {
        let start = self.over(span)?;
        if let Some(feed) = feed {
            self.technology.feed = Some(feed);
        }
        let radius = (start[0] - center[0]).hypot(start[1] - center[1]);
        let (end, programmed) = self.end_at(Some(to), height);
        L::mill_feed(self, programmed, span)?;
        let [u, v, w] = L::working_plane(self);
        let (mut middle, mut normal) = ([0.0; 3], [0.0; 3]);
        middle[u] = center[0];
        middle[v] = center[1];
        middle[w] = self.position.work.get(w).unwrap_or(0.0);
        normal[w] = if clockwise { -1.0 } else { 1.0 };
        let motion = L::mill_motion(self, end, programmed, span)?;
        self.go_arc(motion, middle, normal, &PlaneArc { center, radius, sweep: angle }, span)
    }

    pub(crate) fn mill_leg(
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
                let angle = shape::sweep(self.over(span)?, to, center, clockwise);
                self.mill_arc((to, center, clockwise), angle, height, feed, span)
            }
        }
    }

    pub(crate) fn mill_pass(
        &mut self,
        place: &Place,
        pass: &Pass,
        feed: Option<Feed>,
        span: Span,
    ) -> Result<(), Fault> {
        self.mill_to(Some(place.at(pass.start)), None, feed, span)?;
        for leg in &pass.legs {
            self.mill_leg(place, *leg, None, feed, span)?;
        }
        Ok(())
    }

    /// Above a point of the plane at a height at least, at rapid rate: up, across, down.
    pub(crate) fn come_over(&mut self, point: Point, height: f64, span: Span) -> Result<(), Fault> {
        let normal = L::working_plane(self)[2];
        if self.position.work.get(normal).is_none_or(|z| z < height) {
            self.mill_to(None, Some(height), None, span)?;
        }
        self.mill_to(Some(point), None, None, span)?;
        self.mill_to(None, Some(height), None, span)
    }

    pub(crate) fn run_plan(&mut self, plan: &Plan, job: &Job, here: Point, span: Span) -> Result<(), Fault> {
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
            for depth in levels(job.wall_depth, job.finish_infeed) {
                self.mill_to(None, Some(at(depth)), job.plunge, span)?;
                self.mill_pass(&plan.place, &plan.wall, job.finish, span)?;
                self.mill_to(Some(entry), None, job.finish, span)?;
            }
            self.mill_to(None, Some(at(job.wall_depth - job.clearance)), None, span)?;
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
        let begin = from - job.heights.down * job.clearance;
        let drop = (to - begin).abs();
        let entry = plan.place.at(plan.entry);
        match plan.plunge {
            Plunge::Vertical => self.mill_to(None, Some(to), job.plunge, span),
            Plunge::Helix { radius, slope } => {
                let side = plan.place.at([plan.entry[0] + radius, plan.entry[1]]);
                let turns = (drop / (std::f64::consts::TAU * radius * slope)).ceil().clamp(1.0, MOST_TURNS);
                self.mill_to(Some(side), None, job.plunge, span)?;
                let circle = (side, entry, !job.climb);
                self.mill_arc(circle, turns * std::f64::consts::TAU, Some(to), job.plunge, span)?;
                self.mill_arc(circle, std::f64::consts::TAU, None, job.plunge, span)?;
                self.mill_to(Some(entry), None, job.plunge, span)
            }
            Plunge::Strokes { leg, slope } => {
                let there = Pass { start: plan.entry, legs: vec![leg] };
                let back = there.reversed();
                let length = match leg {
                    Leg::Line(p) => (p[0] - plan.entry[0]).hypot(p[1] - plan.entry[1]),
                    Leg::Arc { to, center, clockwise } => {
                        let radius = (to[0] - center[0]).hypot(to[1] - center[1]);
                        radius * shape::sweep(plan.entry, to, center, clockwise)
                    }
                };
                if length < NO_WIDTH_MM {
                    return self.mill_to(None, Some(to), job.plunge, span);
                }
                // There and back, so that the tool ends where it began; the last two are level.
                let pairs = (drop / (2.0 * length * slope)).ceil().clamp(1.0, MOST_TURNS) as u32;
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
