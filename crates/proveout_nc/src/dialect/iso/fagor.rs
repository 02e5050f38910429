//! Words of a Fagor: polar coordinates, absolute centers, and the milling cycles G69, G87 and G88.
//!
//! ```text
//!   G93 I20 J30      pole                         G69 deep hole     X Y Z I B C D H J K L R
//!   G1 R40 Q90       radius and angle about it    G87 rectangular   X Y Z I J K B C D H L V
//!   G3 Q180          an arc about it              G88 circular      X Y Z I J   B C D H L V
//!   G6 G2 X Y I J    absolute center
//!
//!    Z  - - - - -   reference plane     J, K: from the center to the edge, along the first and second axis
//!       |  D                            B: infeed (above zero: equal ones, not above it)
//!       '--------   surface             C: way between two rings
//!    I  _________   depth               L: allowance of the wall, finished in the feed H
//!                                       V: feed of the plunge, half of F without it
//! ```
//!
//! After Fagor, *CNC 8055 M programming manual* (V02.2x), "Polar coordinates", "G93", "G06" and
//! "Canned cycles" (for D, H, L and V). From memory, and reported as assumptions: which sign of J
//! mills in climb, and what B below zero does.

use super::pending::Pending;
use super::run_state::{FagorCycle, Interpreter};
use crate::arc::{self, PlaneArc};
use crate::channel::milling::{self, MAX_PASSES};
use crate::channel::shape::{Pass, Place, Point, Shape};
use crate::channel::{Stroke, arc_fault};
use crate::codes;
use crate::cycle::{Key, Unit};
use crate::diagnostic::{Fault, Span};
use crate::frame::sin_cos_degrees;
use crate::g_code::{G69, G87, G88, GCode};
use crate::settings::Compensation;
use crate::{AxisValues, CompSide, CutterComp, Feed, Op, SpindleDirection};

/// Most infeeds of one cycle.
const MOST_INFEEDS: usize = 10_000;
/// Any feed says that a motion is one in feed: which one it is comes from F.
const IN_FEED: Option<Feed> = Some(Feed::PerTime(1.0));
/// Least infeed, mm: pecks come to an end.
const LEAST_PECK_MM: f64 = 1e-6;
/// Least distance of two rings, mm: where there is no room for a second one.
const LEAST_STEP_MM: f64 = 1e-6;
/// An arc onto the wall of no more than this radius is none, mm.
const NO_LEAD_MM: f64 = 1e-6;

impl FagorCycle {
    fn get(&self, letter: u8) -> Option<f64> {
        self.values.get(usize::from(letter.saturating_sub(b'A'))).copied().flatten()
    }
}

impl Interpreter {
    /// G93: the pole of polar coordinates, absolute, or the present position.
    pub(super) fn fagor_pole(&mut self, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let words = [b'I', b'J', b'K'].map(|letter| self.length_of(p, letter));
        self.own.pole = match (words[u], words[v]) {
            (None, None) => [self.known(u, span)?, self.known(v, span)?],
            (Some(a), Some(b)) if a.is_finite() && b.is_finite() => [a, b],
            _ => {
                return Err(Fault::new(codes::MISSING_VALUE, span, "G93 needs both coordinates of the pole, or none")
                    .help("write G93 I20 J30"));
            }
        };
        Ok(())
    }

    /// The block has a polar radius or angle: Q, or R of a straight motion.
    pub(super) fn is_fagor_polar(&self, p: &Pending, arc: bool) -> bool {
        self.settings.control.depth_in_i && self.modal.cycle.is_none() && (p.any_free(b"Q") || !arc && p.any_free(b"R"))
    }

    /// Takes R and Q into the end of a motion; the axes that they set.
    pub(super) fn fagor_polar(&mut self, p: &mut Pending, end: &mut AxisValues, span: Span) -> Result<u16, Fault> {
        let [u, v, _] = self.modal.plane_axes();
        let plane = 1 << u | 1 << v;
        if p.axes() & plane != 0 {
            return Err(Fault::new(
                codes::CONFLICT,
                span,
                "a polar radius or angle together with an axis of the plane",
            )
            .help("write the point with R and Q, or with its coordinates"));
        }
        let pole = self.own.pole;
        let (radius, angle) = (self.length_of(p, b'R'), p.take(b'Q'));
        let incremental = self.modal.incremental;
        let before = (radius.is_none() || angle.is_none() || incremental)
            .then(|| Ok::<_, Fault>([self.known(u, span)? - pole[0], self.known(v, span)? - pole[1]]))
            .transpose()?;
        let (now_radius, now_angle) = before.map_or((0.0, 0.0), |d| (d[0].hypot(d[1]), d[1].atan2(d[0]).to_degrees()));
        let base = |value: f64| if incremental { value } else { 0.0 };
        let radius = radius.map_or(now_radius, |r| r + base(now_radius));
        let angle = angle.map_or(now_angle, |a| a + base(now_angle));
        let (s, c) = sin_cos_degrees(angle);
        end.put(u, crate::channel::finite(u, pole[0] + radius * c, span)?);
        end.put(v, crate::channel::finite(v, pole[1] + radius * s, span)?);
        Ok(plane)
    }

    /// G2 and G3 to an angle: about the pole, or about I and J, which is the pole from here on.
    pub(super) fn fagor_polar_arc(&mut self, p: &mut Pending, clockwise: bool, span: Span) -> Result<(), Fault> {
        let [u, v, w] = self.modal.plane_axes();
        let start = self.arc_start("the arc", [u, v, w], span)?;
        let words = [b'I', b'J', b'K'].map(|letter| self.length_of(p, letter));
        if words[u].is_some() || words[v].is_some() {
            self.own.pole = [start[u] + words[u].unwrap_or(0.0), start[v] + words[v].unwrap_or(0.0)];
        }
        let pole = self.own.pole;
        let mut end = self.position.work;
        let mut programmed = self.fagor_polar(p, &mut end, span)?;
        if let Some(height) = self.length_of(p, super::pending::AXES[w]) {
            let height = if self.modal.incremental { self.known(w, span)? + height } else { height };
            end.put(w, crate::channel::finite(w, height, span)?);
            programmed |= 1 << w;
        }
        let to = [end.get(u).unwrap_or(start[u]), end.get(v).unwrap_or(start[v])];
        let tolerance = self.settings.arc_limit();
        let arc: PlaneArc = arc::from_center([start[u], start[v]], to, pole, clockwise, tolerance)
            .map_err(|fault| arc_fault(fault, tolerance, "write a full circle with I and J", span))?;
        self.need_feed(programmed, span)?;
        let motion = self.complete(end, programmed, false, span)?;
        let (mut center, mut normal) = (start, [0.0; 3]);
        (center[u], center[v]) = (pole[0], pole[1]);
        normal[w] = if clockwise { -1.0 } else { 1.0 };
        self.go_arc(motion, center, normal, &arc, span)
    }

    /// Takes the words of G69, G87 and G88 before D is a tool, H a length, and B, C, V are axes.
    pub(super) fn fagor_cycle_words(&mut self, p: &mut Pending) {
        let Some(code @ (G69 | G87 | G88)) = self.modal.cycle.filter(|_| self.settings.control.depth_in_i) else {
            return;
        };
        if p.g(super::words::Group::Cycle).is_some() {
            self.own.fagor = FagorCycle::default();
        }
        for word in self.cycles().words(code) {
            let Key::Letter(letter) = word.key else { continue };
            let value = match word.unit {
                Unit::Number | Unit::Feed => p.take(letter),
                _ if p.any_free(&[letter]) => self.length_of(p, letter),
                _ => continue,
            };
            if let Some(slot) = self.own.fagor.values.get_mut(usize::from(letter - b'A')) {
                *slot = value.or(*slot);
            }
        }
    }

    /// A block of G69, G87 or G88, or a further position of one.
    pub(super) fn fagor_cycle_block(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let name = code.to_string();
        let [u, v, w] = self.modal.plane_axes();
        if self.modal.normal != 2 || self.modal.incremental {
            let message = format!("`{name}` with G91 or in another plane than G17 is not supported");
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("write it with G90 and G17"));
        }
        let defines = p.g(super::words::Group::Cycle).is_some();
        if defines {
            self.own.cycle.initial = self.position.work.get(w);
        }
        // B, C and V are words of the cycle here.
        let plane = 1 << u | 1 << v;
        if p.axes() & !(plane | 1 << w) != 0 {
            let message = format!("`{name}` with a rotary axis is not supported");
            return Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help("turn it in a block of its own"));
        }
        let axes = p.axes() & plane;
        if axes == 0 && !defines {
            return Ok(());
        }
        self.before_motion(axes, p, span)?;
        let (end, programmed) = self.targets(p, span)?;
        if programmed & plane != 0 {
            self.cycle_motion(end, programmed & plane, true, span)?;
        }
        let c = self.own.fagor.clone();
        let need = |letter: u8| {
            c.get(letter).ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, span, format!("{name} has no `{}`", char::from(letter)))
                    .help("write the reference plane Z, the depth I and the infeed B of the cycle")
            })
        };
        let (reference, depth, infeed) = (need(b'Z')?, need(b'I')?, need(b'B')?);
        let surface = reference - c.get(b'D').unwrap_or(0.0);
        let total = surface - depth;
        if !(total > 0.0 && infeed != 0.0 && total / infeed.abs() <= MOST_INFEEDS as f64) {
            let message = format!(
                "the depth {depth} of {name} does not lie below the surface {surface}, or its infeed is {infeed}"
            );
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("check Z, I, D and B"));
        }
        let back = match (self.modal.return_to_r.unwrap_or(false), self.own.cycle.initial) {
            (true, _) => reference,
            (false, Some(initial)) => initial.max(reference),
            (false, None) => {
                let message = "G98 comes back to the starting plane, which the program has not set";
                return Err(
                    Fault::new(codes::POSITION_UNKNOWN, span, message).help("program Z before the cycle, or use G99")
                );
            }
        };
        self.need_feed(0b111, span)?;
        let feed = self.own.feed;
        if code == G69 {
            self.course(&[Stroke::Rapid(reference)], span)?;
            self.fagor_pecks(&c, reference, surface, depth, span)?;
        } else {
            self.fagor_pocket(code, &c, [reference, surface, depth], span)?;
        }
        self.own.feed = feed;
        self.course(&[Stroke::Rapid(back)], span)
    }

    /// G69: pecks B, each R times the one before, at least L; H out after each and every J-th to the
    /// reference plane.
    fn fagor_pecks(
        &mut self,
        c: &FagorCycle,
        reference: f64,
        surface: f64,
        depth: f64,
        span: Span,
    ) -> Result<(), Fault> {
        let clear = c.get(b'C').map_or(1.0, f64::abs);
        let (factor, least) = (c.get(b'R').filter(|r| *r > 0.0).unwrap_or(1.0), c.get(b'L').map_or(0.0, f64::abs));
        let every = c.get(b'J').filter(|j| *j >= 1.0);
        let lift = c.get(b'H').map(f64::abs).filter(|h| *h > 0.0);
        let dwell =
            c.get(b'K').zip(self.settings.control.dwell_unit(b'K')).map(|(value, unit)| unit.seconds(value, true));
        let (mut peck, mut reached, mut count) = (c.get(b'B').map_or(0.0, f64::abs), surface, 0.0);
        for _ in 0..MOST_INFEEDS {
            let next = (reached - peck.max(LEAST_PECK_MM)).max(depth);
            self.course(&[Stroke::Feed(next), Stroke::wait(dwell)], span)?;
            if next <= depth {
                return Ok(());
            }
            count += 1.0;
            let out = every.is_some_and(|j| count % j == 0.0) || lift.is_none();
            let up = if out { reference } else { (next + lift.unwrap_or(0.0)).min(reference) };
            self.course(&[Stroke::Rapid(up)], span)?;
            if up > next + clear {
                self.course(&[Stroke::Rapid(next + clear)], span)?;
            }
            reached = next;
            peck = (peck * factor).max(least);
        }
        Err(Fault::new(codes::LOOP_LIMIT, span, format!("G69 needs more than {MOST_INFEEDS} pecks"))
            .help("check B, R and L"))
    }

    fn fagor_pocket(
        &mut self,
        code: GCode,
        c: &FagorCycle,
        [reference, surface, depth]: [f64; 3],
        span: Span,
    ) -> Result<(), Fault> {
        let name = code.to_string();
        let [u, v, _] = self.modal.plane_axes();
        let center: Point = [self.known(u, span)?, self.known(v, span)?];
        let size = |letter: u8| {
            c.get(letter).map(f64::abs).filter(|s| *s > 0.0 && s.is_finite()).ok_or_else(|| {
                Fault::new(codes::MISSING_VALUE, span, format!("{name} has no `{}`", char::from(letter)))
                    .help("it is the way from the center to the edge")
            })
        };
        let a = size(b'J')?;
        let b = if code == G87 { size(b'K')? } else { a };
        let climb =
            (c.get(b'J').unwrap_or(1.0) > 0.0) == (self.technology.direction != SpindleDirection::CounterClockwise);
        let radius = self.fagor_tool(&name, span)?;
        let side = c.get(b'L').map_or(0.0, f64::abs);
        let mill = self.own.feed;
        let plunge = c.get(b'V').filter(|v| *v > 0.0).or(mill.map(|f| 0.5 * f));
        let finish = c.get(b'H').filter(|h| *h > 0.0).or(mill);
        let corner = if code == G87 { radius.unwrap_or(0.0) } else { a };
        let shape = Shape::Rounded { a, b, corner };
        let place = Place::new(center, 0.0);
        self.assume(format!(
            "{name}: {}; J above zero mills in climb",
            if radius.is_some() {
                "rings from the center outwards, joined by straight lines; after each depth the tool comes back over the center"
            } else {
                "the radius of the tool is not known here, so that the finished wall is given once at its depth, with cutter compensation"
            }
        ));
        self.mill_to(None, Some(reference), None, span)?;
        let Some(radius) = radius else {
            let ring = shape.ring(0.0);
            let ring = if climb { ring } else { ring.reversed() };
            self.own.feed = plunge;
            self.mill_to(None, Some(depth), IN_FEED, span)?;
            self.own.feed = mill;
            let on = if climb { CompSide::Left } else { CompSide::Right };
            self.emit(Op::CutterComp(CutterComp { side: on, offset: self.own.d, radius: None }));
            self.mill_pass(&place, &ring, IN_FEED, span)?;
            self.emit(Op::CutterComp(CutterComp { side: CompSide::Off, offset: None, radius: None }));
            self.mill_to(Some(center), None, IN_FEED, span)?;
            return Ok(());
        };
        let width = c.get(b'C').map(f64::abs).filter(|w| *w > 0.0).unwrap_or(1.5 * radius);
        if width > 2.0 * radius {
            let message = format!("the milling pass C{width} of {name} is wider than the tool, {} mm", 2.0 * radius);
            return Err(Fault::new(codes::ARGUMENTS, span, message).help("write a smaller C"));
        }
        let room = (shape.half_width() - radius - side).max(0.0);
        let step = (room / (room / width.min(1.7 * radius) - milling::WHOLE).ceil().clamp(1.0, MAX_PASSES as f64))
            .max(LEAST_STEP_MM);
        let rough = milling::rings(shape, radius, side, step, climb).ok_or_else(|| {
            let message = format!("a tool of radius {radius} mm does not fit into {name}");
            Fault::new(codes::COMPENSATION, span, message).help("use a smaller tool")
        })?;
        let ring = shape.ring(radius);
        let ring: Pass = if climb { ring } else { ring.reversed() };
        let lead = radius.min(shape.half_width() - radius);
        let wall = if lead > NO_LEAD_MM { ring.with_leads(lead, false, climb, true) } else { ring };
        let total = surface - depth;
        let infeed = c.get(b'B').unwrap_or(total);
        let equal = total / (total / infeed.abs() - milling::WHOLE).ceil().max(1.0);
        let levels = milling::levels(total, if infeed > 0.0 { equal } else { -infeed });
        for level in &levels {
            self.own.feed = plunge;
            self.mill_to(None, Some(surface - level), IN_FEED, span)?;
            self.own.feed = mill;
            for pass in &rough {
                self.mill_pass(&place, pass, IN_FEED, span)?;
            }
            if side > 0.0 {
                self.own.feed = finish;
                self.mill_pass(&place, &wall, IN_FEED, span)?;
                self.own.feed = mill;
            }
            self.mill_to(None, Some(surface - level + 1.0), None, span)?;
            self.mill_to(Some(center), None, None, span)?;
        }
        Ok(())
    }

    /// Radius of the tool; none where the path of the tool center is not asked for.
    fn fagor_tool(&self, name: &str, span: Span) -> Result<Option<f64>, Fault> {
        let Compensation::ToolCenter(radii) = &self.settings.compensation else { return Ok(None) };
        let by_tool = || self.technology.in_spindle.as_ref().and_then(|tool| radii.by_tool.get(tool));
        let found = self.own.d.and_then(|d| radii.by_offset.get(&d)).or_else(by_tool);
        found.copied().filter(|r| *r > 0.0).map(Some).ok_or_else(|| {
            Fault::new(
                codes::COMPENSATION,
                span,
                format!("{name} needs the radius of the tool, which the tools do not give"),
            )
            .help("give the tool in the scene")
        })
    }
}
