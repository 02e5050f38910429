//! Path blocks: what they have in common, and straight motions.

use super::run_state::Interpreter;
use super::words::{Coordinate, FeedWord, Kind, Param, PathFunction, RadiusSide, Reference, Value, Words};
use crate::channel::finite;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};
use crate::{AxisValues, CompSide, CutterComp, Feed, Motion, Op, RotarySolution};

/// Bits of X, Y and Z.
pub(crate) const LINEAR: u16 = 0b111;
/// Bits of A, B and C.
pub(crate) const ROTARY: u16 = 0b111_000;
/// Rounding of a feed, part of it.
const ROUNDING: f64 = 1e-12;
/// A feed that is this near to a number of rapid traverse is that number.
const SAME_NUMBER: f64 = 1e-6;

/// Highest numbers of F that controls without FMAX took for rapid traverse.
const RAPID_NUMBERS: [f64; 6] = [9998.0, 9999.0, 15998.0, 15999.0, 29998.0, 29999.0];

/// End of a motion before base coordinates are known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    pub(crate) end: AxisValues,
    pub(crate) programmed: u16,
    pub(crate) tool_axis: Option<[f64; 3]>,
}

impl Interpreter {
    /// Executes a path block.
    pub(crate) fn path(&mut self, path: PathFunction, w: &Words, span: Span) -> Result<(), Fault> {
        if path == PathFunction::FreePole {
            return self.free_pole(w, span);
        }
        if !matches!(path, PathFunction::Free(_))
            && let Some(fault) = self.free_is_open(span)
        {
            return Err(fault);
        }
        if matches!(path, PathFunction::Round | PathFunction::Chamfer) {
            return self.begin_corner(path, w, span);
        }
        if path == PathFunction::Pole {
            return self.pole_block(w, span);
        }
        let contour = matches!(
            path,
            PathFunction::Line
                | PathFunction::Arc
                | PathFunction::Radius
                | PathFunction::Tangent
                | PathFunction::PolarLine
                | PathFunction::PolarArc
                | PathFunction::PolarTangent
                | PathFunction::Free(_)
        );
        if self.modal.corner.is_some() && !contour {
            return Err(super::corner::no_element(span));
        }
        if self.modal.approach.is_some() && !contour && path != PathFunction::Nothing {
            return Err(super::approach::no_contour(span));
        }
        self.modal.held = false;
        if let PathFunction::Depart(_) = path {
            self.modal.departing = self.modal.side;
        } else if let Some(side) = w.side {
            self.compensation(side);
        }
        self.modal.feed_before = self.technology.feed;
        self.functions_before(w, span)?;
        let rapid = self.feed_word(w, span)?;
        if w.programmed == 0 {
            self.tell_idle(path, w);
        }
        if path != PathFunction::Nothing && !w.has(91) && !w.has(92) {
            self.moves_in_preset(w.programmed);
        }
        match path {
            PathFunction::Nothing => {}
            _ if w.has(91) || w.has(92) => self.machine_motion(path, w, rapid, span)?,
            PathFunction::Line => self.line(w, rapid, span)?,
            PathFunction::Normal => self.normal_line(w, rapid, span)?,
            PathFunction::Arc => self.arc_block(w, span)?,
            PathFunction::Radius => self.radius_arc(w, span)?,
            PathFunction::Tangent => self.tangent_arc(w, span)?,
            PathFunction::PolarLine => self.polar_line(w, rapid, span)?,
            PathFunction::PolarArc => self.polar_arc(w, span)?,
            PathFunction::PolarTangent => self.polar_tangent(w, span)?,
            PathFunction::Approach(lead) => self.approach(lead, w, rapid, span)?,
            PathFunction::Depart(lead) => self.depart(lead, w, rapid, span)?,
            PathFunction::Free(kind) => self.free(kind, w, rapid, span)?,
            PathFunction::Round | PathFunction::Chamfer | PathFunction::Pole | PathFunction::FreePole => {}
        }
        if path != PathFunction::Nothing {
            self.modal.rapid_before = rapid;
        }
        if !w.functions.is_empty() || self.modal.modal_cycle {
            self.functions_after(w, span)?;
            self.cycle_after(path, w, span)?;
            self.functions_last(w);
        }
        self.modal.held = contour
            && match self.queue.back().map(|(c, ())| &c.op) {
                Some(Op::Linear(m)) => !m.machine_coordinates,
                Some(Op::Arc(arc)) => arc.normal[self.modal.normal] != 0.0,
                _ => false,
            };
        if contour {
            self.modal.element_feed = self.technology.feed;
        }
        Ok(())
    }

    /// Notes the words of a motion that have no effect in a block that moves no axis.
    fn tell_idle(&mut self, path: PathFunction, w: &Words) {
        if path == PathFunction::Nothing && w.feed == Some(FeedWord::Max) {
            self.note("FMAX has no effect: the block moves no axis");
        }
        for code in [91, 92] {
            if w.has(code) && matches!(path, PathFunction::Nothing | PathFunction::Line) {
                self.note(format!("M{code} has no effect: the block moves no axis"));
            }
        }
    }

    /// R0, RL, RR.
    pub(crate) fn compensation(&mut self, side: RadiusSide) {
        if self.modal.side.unwrap_or(RadiusSide::Off) != side {
            let told = match side {
                RadiusSide::Off => CompSide::Off,
                RadiusSide::Left => CompSide::Left,
                RadiusSide::Right => CompSide::Right,
            };
            self.emit(Op::CutterComp(CutterComp { side: told, offset: None, radius: None }));
        }
        // M120 ends with R0. The contour before is still in progress then, so it is forgotten at
        // the next RL or RR.
        if side == RadiusSide::Off {
            self.modal.look_ahead_ended = true;
        } else if std::mem::take(&mut self.modal.look_ahead_ended) {
            self.modal.look_ahead = 1;
        }
        self.modal.side = Some(side);
    }

    /// Takes the feed of the block; true for FMAX, which holds for this block only.
    pub(crate) fn feed_word(&mut self, w: &Words, span: Span) -> Result<bool, Fault> {
        match w.feed {
            None => Ok(self.modal.rapid_number),
            Some(FeedWord::Max) => Ok(true),
            Some(word) => {
                let feed = self.feed_of(word, span)?;
                self.set_feed(feed);
                self.rapid_by_number(feed);
                Ok(self.modal.rapid_number)
            }
        }
    }

    /// Whether an F is rapid traverse by its number. Controls before FMAX used their highest feed
    /// number for it.
    pub(crate) fn rapid_by_number(&mut self, feed: Option<Feed>) {
        let Some(Feed::PerTime(feed)) = feed else {
            self.modal.rapid_number = false;
            return;
        };
        let mm_min = feed * 60.0;
        self.modal.rapid_number =
            self.settings.control.rapid_from_mm_min.is_some_and(|from| mm_min >= from * (1.0 - ROUNDING));
        let written = mm_min / if self.modal.inch { 2.54 } else { 1.0 };
        let Some(number) = RAPID_NUMBERS.into_iter().find(|number| (number - written).abs() < SAME_NUMBER) else {
            return;
        };
        let stated = self.settings.control.rapid_from_mm_min.is_some();
        if !stated && !std::mem::replace(&mut self.modal.rapid_number_told, true) {
            self.assume(format!(
                "F{number} is read as a feed of this number; older controls read it as rapid traverse: write FMAX, \
                 or state it as feed.rapid_from_mm_min of the control file"
            ));
        }
    }

    /// Feed value of a word; FAUTO is the feed of TOOL CALL.
    pub(crate) fn feed_of(&self, word: FeedWord, span: Span) -> Result<Option<Feed>, Fault> {
        let positive = |value: f64| {
            if value > 0.0 && value.is_finite() {
                return Ok(value);
            }
            Err(Fault::new(codes::BAD_VALUE, span, format!("the feed must be above zero and is {value}"))
                .help("write F500"))
        };
        Ok(Some(match word {
            FeedWord::Max => return Ok(None),
            FeedWord::Auto => {
                return self.modal.tool_feed.map(Some).ok_or_else(|| {
                    Fault::new(codes::NO_FEED, span, "FAUTO uses the feed of TOOL CALL, which has none")
                        .help("write F in the TOOL CALL block")
                });
            }
            FeedWord::PerRevolution(value) => {
                Feed::PerRevolution(positive(self.variables.value(value, span)?)? * self.modal.unit())
            }
            FeedWord::Value(value) => {
                let value = positive(self.variables.value(value, span)?)?;
                if self.modal.per_revolution {
                    Feed::PerRevolution(value)
                } else {
                    // Inch programs write tenths of an inch a minute.
                    Feed::PerTime(value * if self.modal.inch { 2.54 } else { 1.0 } / 60.0)
                }
            }
        }))
    }

    pub(crate) fn need_feed(&mut self, span: Span) -> Result<(), Fault> {
        if self.technology.feed.is_some() {
            self.tell_feed();
            return Ok(());
        }
        if !self.modal.per_revolution && self.default_feed().is_some() {
            self.tell_feed();
            return Ok(());
        }
        Err(Fault::new(codes::NO_FEED, span, "the motion has no feed").help("write F before or in this block"))
    }

    /// mm, or radian for A B C, of a coordinate as written.
    pub(crate) fn coordinate(&self, axis: usize, value: f64) -> f64 {
        if (3..6).contains(&axis) { value.to_radians() } else { value * self.modal.unit() }
    }

    pub(crate) fn is_incremental(&self, reference: Reference) -> bool {
        match reference {
            Reference::Absolute => false,
            Reference::Incremental => true,
            Reference::Modal => self.modal.incremental,
        }
    }

    fn target(&mut self, axis: usize, c: Coordinate, span: Span) -> Result<f64, Fault> {
        let value = self.coordinate(axis, self.variables.value(c.value, span)?);
        let rotary = (3..6).contains(&axis);
        let target = if self.is_incremental(c.reference) {
            self.known(axis, span)? + value
        } else if rotary && self.modal.shortest {
            // M126; unknown, it goes to the value as written.
            self.short_way(axis, value)
        } else if rotary {
            self.rolled(axis, value)
        } else {
            value
        };
        finite(axis, target, span)
    }

    /// `A+Q120 B+Q121 C+Q122`: the rotary axes go where the tilted plane needs them.
    fn plane_word(&self, axis: usize, c: Coordinate) -> bool {
        let index = 117 + axis as u32;
        let param = Param { kind: Kind::Global, index };
        self.modal.plane_angles
            && (3..6).contains(&axis)
            && c.value == (Value::Param { negative: false, param })
            && self.variables.get(param).is_none()
    }

    /// End of the block in the work frame.
    pub(crate) fn goal(&mut self, w: &Words, span: Span) -> Result<Goal, Fault> {
        let mut goal = Goal { end: self.position.work, programmed: w.programmed, tool_axis: None };
        if w.programmed == 0 {
            return Ok(goal);
        }
        let mut by_plane = 0u16;
        let rotary = w.programmed & ROTARY;
        if rotary != 0 && self.modal.spatial {
            return self.spatial_goal(w, goal, span);
        }
        for (axis, c) in w.axes.iter().enumerate() {
            let Some(c) = c else { continue };
            if rotary != 0 && self.plane_word(axis, *c) {
                by_plane |= 1 << axis;
                continue;
            }
            goal.end.put(axis, self.target(axis, *c, span)?);
        }
        if by_plane != 0 {
            if by_plane != rotary {
                return Err(Fault::new(
                    codes::ORIENTATION,
                    span,
                    "rotary positions of the tilted plane (Q120 to Q122) mixed with other rotary words",
                )
                .help("write all rotary axes with Q120, Q121, Q122, or all as numbers"));
            }
            goal.programmed &= !ROTARY;
            goal.tool_axis = Some([0.0, 0.0, 1.0]);
        }
        Ok(goal)
    }

    /// FUNCTION TCPM AXIS SPAT: A, B, C turn the tool axis about the fixed X, then Y, then Z.
    fn spatial_goal(&mut self, w: &Words, mut goal: Goal, span: Span) -> Result<Goal, Fault> {
        let mut angles = [0.0; 3];
        for (axis, c) in w.axes.iter().enumerate() {
            let Some(c) = c else { continue };
            if (3..6).contains(&axis) {
                if self.is_incremental(c.reference) {
                    return Err(Fault::new(codes::ORIENTATION, span, "spatial angles cannot be incremental")
                        .help("write A, B and C as absolute angles"));
                }
                angles[axis - 3] = self.variables.value(c.value, span)?;
            } else {
                goal.end.put(axis, self.target(axis, *c, span)?);
            }
        }
        if w.programmed & ROTARY != ROTARY {
            return Err(Fault::new(
                codes::ORIENTATION,
                span,
                "with AXIS SPAT all three spatial angles must be programmed",
            )
            .help("write A, B and C in every block that turns the tool"));
        }
        goal.programmed &= !ROTARY;
        goal.tool_axis = Some(Frame::rpy(angles).apply_vector([0.0, 0.0, 1.0]));
        Ok(goal)
    }

    /// Base coordinates of a goal.
    pub(crate) fn complete(&self, goal: Goal, span: Span) -> Result<Motion, Fault> {
        let mut end = goal.end;
        let mut mask = goal.programmed;
        if mask & LINEAR != 0 && self.position.base.xyz().is_none() && end.xyz().is_some() {
            // All three are known by now, although no block before could determine base
            // coordinates.
            mask |= LINEAR;
        }
        let mut end_base = match self.position.base_of(&end, mask) {
            Ok(base) => base,
            Err(_) => {
                // First blocks in a turned frame: the base coordinates need an axis that the program has not
                // set.
                let mut base = self.position.base_of(&end, mask & !LINEAR).unwrap_or(self.position.base);
                for axis in 0..3 {
                    base.clear(axis);
                }
                base
            }
        };
        let tool_axis_base = match goal.tool_axis {
            None => None,
            Some(axis) => {
                let frame = self.position.frame();
                if frame.uniform_scale().is_none() {
                    return Err(Fault::new(
                        codes::ORIENTATION,
                        span,
                        "a tool axis cannot be turned by a frame with unequal scales",
                    )
                    .help("switch the axis-specific scaling off"));
                }
                // The rotary axes follow the vector; the reader does not know their positions.
                for axis in 3..6 {
                    end.clear(axis);
                    end_base.clear(axis);
                }
                frame::unit(frame.apply_vector(axis))
            }
        };
        // Q120 to Q122: the position that the plane has chosen.
        let by_plane = self.modal.plane_angles && goal.tool_axis == Some([0.0, 0.0, 1.0]);
        Ok(Motion {
            end,
            end_base,
            tool_axis: goal.tool_axis,
            tool_axis_base,
            programmed: goal.programmed,
            solution: if by_plane { self.modal.plane_solution } else { RotarySolution::Nearest },
            ..Motion::default()
        })
    }

    /// Straight motion to a goal, contour element or positioning.
    pub(crate) fn straight(&mut self, goal: Goal, rapid: bool, span: Span) -> Result<(), Fault> {
        if !rapid {
            self.need_feed(span)?;
        }
        let start = self.position.work;
        if self.modal.approach.is_some() {
            let from = self.flat(span)?;
            let [u, v, _] = self.modal.plane_axes();
            let to = [goal.end.get(u).unwrap_or(from[0]), goal.end.get(v).unwrap_or(from[1])];
            self.finish_approach([to[0] - from[0], to[1] - from[1]], span)?;
        }
        let motion = self.complete(goal, span)?;
        if self.modal.corner.is_some() {
            self.corner_to_line(start, &motion, span)?;
        }
        self.modal.line_start = start;
        let [u, v, _] = self.modal.plane_axes();
        self.modal.tangent = match (start.get(u), start.get(v), motion.end.get(u), motion.end.get(v)) {
            (Some(a), Some(b), Some(c), Some(d)) if (c - a).hypot(d - b) > crate::arc::SAME_POINT_MM => {
                Some([c - a, d - b])
            }
            (Some(_), Some(_), Some(_), Some(_)) => self.modal.tangent,
            _ => None,
        };
        self.drive(motion, rapid);
        Ok(())
    }

    /// Emits a straight motion; one with rotary words leaves the tool inclined.
    #[inline]
    pub(crate) fn drive(&mut self, motion: Motion, rapid: bool) {
        self.modal.inclined |= motion.programmed & ROTARY != 0 || motion.tool_axis.is_some();
        self.go(motion, rapid);
    }

    fn line(&mut self, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        if w.polar_radius.is_some() || w.polar_angle.is_some() || w.clockwise.is_some() {
            return Err(Fault::new(codes::CONFLICT, span, "words of a polar or circular path in a straight block")
                .help("write LP, CP or C"));
        }
        if w.programmed == 0 {
            return Ok(());
        }
        let goal = self.goal(w, span)?;
        self.turn_or_go(goal, w, rapid, span)
    }

    /// In a tilted plane without tool center point control, rotary axes move by themselves with the linear
    /// axes at rest.
    fn turn_or_go(&mut self, mut goal: Goal, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        let alone = w.programmed & ROTARY != 0 && w.programmed & !ROTARY == 0;
        if alone && self.modal.frames.tilted() && !self.modal.tcpm {
            self.tell_tcp_as(false);
            for axis in 0..3 {
                if self.position.work.get(axis).is_none() {
                    goal.end.clear(axis);
                }
            }
            self.straight(goal, rapid, span)?;
            self.tell_tcp_as(true);
            self.position.forget(LINEAR);
            return Ok(());
        }
        self.straight(goal, rapid, span)
    }
}
