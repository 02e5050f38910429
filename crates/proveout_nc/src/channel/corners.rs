//! Chamfers and roundings between two blocks: CHF=, CHR=, RND=, RNDM=, FRC=, FRCM= of an 840D, `,C` and `,R`
//! of ISO controls.
//!
//! ```text
//!          end of A              CHR: both legs in the direction of motion; CHF: the chamfer itself
//!    A ------+ - - + P           RND: the circle touches both blocks; its center is as far from both
//!            .  \  :                  as its radius, so it is where their equidistants meet
//!            . r  \+ start of B
//!            c     | B
//! ```
//!
//! The piece is inserted between straight and circular blocks of the working plane. Where no such
//! block follows, or one leaves the plane, an 840D inserts none, and a note says so (Siemens, *NC
//! programming, Fundamentals*, "Chamfer, rounding"). ISO controls raise an alarm (Fanuc,
//! *Operator's manual*, "Optional chamfering and corner rounding"). The command waits for the next
//! block. Commands between the two blocks stay after the first one. An 840D puts them before the
//! piece. Other controls put them after it, where the piece belongs to the block that programs it.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::{Channel, Language};
use crate::codes;
use crate::compensation::contour::{self, Element, ElementShape};
use crate::diagnostic::Diagnostic;
use crate::frame::{Frame, SAME_DIRECTION};
use crate::{ArcMotion, AxisValues, Command, Feed, Location, Motion, Note, Op};

/// Most commands between the two blocks of a corner.
const LOOK_AHEAD: usize = 1000;
/// Turns smaller than this are no corner, radian.
const STRAIGHT: f64 = 1e-6;
/// The same on ISO controls: within one degree the piece has no length (Fanuc, as above).
const ISO_STRAIGHT: f64 = std::f64::consts::PI / 180.0;

/// A language whose motions may wait for the next block.
pub(crate) trait CornerLanguage: Language<Mark = Option<Box<CornerMark>>> {
    fn corners(&mut self) -> &mut Corners;
}

/// The motion that waits, and what has passed.
#[derive(Debug, Default)]
pub(crate) struct Corners {
    /// Commands that have passed the corners.
    ready: VecDeque<Command>,
    /// The last motion asked for a chamfer or rounding at its end.
    pub(crate) waits: bool,
    /// A chamfer or rounding has failed: its blocks themselves were executed.
    failed: bool,
    /// A motion that waits for the next block.
    corner: Option<Box<HeldMotion>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CornerKind {
    /// CHF, mm.
    Chamfer(f64),
    /// CHR, mm.
    Leg(f64),
    /// RND, RNDM, mm.
    Rounding(f64),
}

/// What is asked for at the end of a motion, and what was in force there.
#[derive(Clone, Debug)]
pub(crate) struct CornerMark {
    pub(crate) kind: Option<CornerKind>,
    /// Start of the motion in work coordinates; the axis along the normal may be unknown.
    pub(crate) start: AxisValues,
    /// Axes of the working plane and its normal.
    pub(crate) axes: [usize; 3],
    pub(crate) frame: Frame,
    /// FRC, FRCM: feed on the piece, and the feed to come back to.
    pub(crate) feed: Option<(Feed, Option<Feed>)>,
    /// The piece belongs to the block that it is written in, and must be possible: an ISO control.
    pub(crate) strict: bool,
}

/// A motion that waits for the next block.
#[derive(Debug)]
pub(crate) struct HeldMotion {
    command: Command,
    mark: CornerMark,
    held: Vec<Command>,
}

fn motion_of(op: &Op) -> Option<&Motion> {
    match op {
        Op::Rapid(m) | Op::Linear(m) => Some(m),
        Op::Arc(a) => Some(&a.motion),
        Op::Spline(s) => Some(&s.motion),
        Op::Probe(p) => Some(&p.motion),
        Op::Thread(t) => Some(&t.motion),
        _ => None,
    }
}

impl Corners {
    /// After a fault nothing waits. True where the fault was that of a corner.
    pub(crate) fn resume(&mut self) -> bool {
        self.corner = None;
        self.waits = false;
        std::mem::take(&mut self.failed)
    }

    /// Takes the next command of the queue through the corners; commands that are ready go to `ready`.
    fn through(&mut self, command: Command, mark: Option<Box<CornerMark>>) -> Result<(), Box<CornerFailure>> {
        let Some(mut corner) = self.corner.take() else {
            match mark {
                Some(mark) if mark.kind.is_some() => {
                    self.corner = Some(Box::new(HeldMotion { command, mark: *mark, held: Vec::new() }));
                }
                _ => self.ready.push_back(command),
            }
            return Ok(());
        };
        if motion_of(&command.op).is_none() && !matches!(command.op, Op::End) {
            if matches!(command.op, Op::Frame(_) | Op::Plane(_)) || corner.held.len() >= LOOK_AHEAD {
                self.no_corner(corner)?;
                return self.through(command, mark);
            }
            corner.held.push(command);
            self.corner = Some(corner);
            return Ok(());
        }
        let Some(mut mark) = mark else {
            self.no_corner(corner)?;
            self.ready.push_back(command);
            return Ok(());
        };
        let mut next = command;
        match join(&mut corner, &mut next, &mut mark) {
            Ok(CornerOutcome::Piece(piece)) => self.put(*corner, *piece),
            Ok(CornerOutcome::Straight) => self.pass(*corner),
            Ok(CornerOutcome::Nothing) => self.no_corner(corner)?,
            Err((message, help)) => {
                return Err(Box::new(CornerFailure { location: corner.command.location, message, help }));
            }
        }
        self.through(next, Some(mark))
    }

    /// The first block and the commands between, without a piece.
    fn pass(&mut self, corner: HeldMotion) {
        self.ready.push_back(corner.command);
        self.ready.extend(corner.held);
    }

    /// The first block, the commands between, and the piece.
    fn put(&mut self, corner: HeldMotion, piece: Op) {
        let HeldMotion { command, mark, held } = corner;
        let location = command.location.clone();
        let told = held.iter().rev().find_map(|c| if let Op::Feed(f) = c.op { Some(f) } else { None });
        let at = |op| Command { location: location.clone(), op };
        self.ready.push_back(command);
        if mark.strict {
            self.ready.push_back(at(piece));
            self.ready.extend(held);
            return;
        }
        self.ready.extend(held);
        if let Some((feed, _)) = mark.feed {
            self.ready.push_back(at(Op::Feed(feed)));
        }
        self.ready.push_back(at(piece));
        if let Some(before) = mark.feed.and_then(|(_, before)| told.or(before)) {
            self.ready.push_back(at(Op::Feed(before)));
        }
    }

    /// No block follows that a piece could be put before.
    fn no_corner(&mut self, corner: Box<HeldMotion>) -> Result<(), Box<CornerFailure>> {
        let HeldMotion { command, mark, held } = *corner;
        if mark.strict {
            return Err(Box::new(CornerFailure {
                location: command.location,
                message: "the next motion makes no corner with this one in the working plane, which the chamfer or rounding needs"
                    .to_owned(),
                help: "write a G1, G2 or G3 in the plane after it, or remove ,C and ,R",
            }));
        }
        let note = Command {
            location: command.location.clone(),
            op: Op::Note(Note::new(
                "no chamfer or rounding: the next motion makes no corner with this one in the working plane",
            )),
        };
        self.ready.push_back(command);
        self.ready.push_back(note);
        self.ready.extend(held);
        Ok(())
    }
}

/// Why a piece cannot be made; reported at the block that asks for it.
#[derive(Debug)]
struct CornerFailure {
    location: Location,
    message: String,
    help: &'static str,
}

impl<L: CornerLanguage> Channel<L> {
    /// The next command that may leave: a motion with a chamfer or rounding waits for the next one.
    pub(crate) fn past_corners(&mut self) -> Option<Command> {
        loop {
            if let Some(command) = self.own.corners().ready.pop_front() {
                return Some(command);
            }
            if let Some((command, mark)) = self.queue.pop_front() {
                let corners = self.own.corners();
                if mark.is_none() && corners.corner.is_none() {
                    return Some(command);
                }
                if let Err(failure) = corners.through(command, mark) {
                    self.corner_failed(*failure);
                }
                continue;
            }
            let (done, failed) = (self.done, self.failure.is_some());
            let corners = self.own.corners();
            let corner = corners.corner.take_if(|_| done)?;
            if failed {
                // The corner of this motion is lost; the fault after it is reported anyway.
                corners.pass(*corner);
                continue;
            }
            if let Err(failure) = corners.no_corner(corner) {
                self.corner_failed(*failure);
                return None;
            }
        }
    }

    fn corner_failed(&mut self, failure: CornerFailure) {
        let CornerFailure { location, message, help } = failure;
        let source_line = self.line_of(&location.file, location.line).unwrap_or_default();
        self.queue.clear();
        self.done = true;
        self.own.corners().failed = true;
        self.failure = Some(Box::new(Diagnostic {
            code: codes::ARC_GEOMETRY,
            message,
            file: location.file.clone(),
            line: location.line,
            column: location.column,
            length: location.length,
            help: Some(help.to_owned()),
            source_line: source_line.into(),
            about: None,
        }));
    }

    /// Marks the last motion in the queue with what a corner at its end needs. `before`: commands
    /// in the queue before its block.
    pub(crate) fn mark_corner(&mut self, mark: CornerMark, before: usize) {
        if self.queue.len() > before
            && let Some((_, slot)) = self.queue.back_mut().filter(|(command, _)| motion_of(&command.op).is_some())
        {
            self.own.corners().waits = mark.kind.is_some();
            *slot = Some(Box::new(mark));
        }
    }
}

/// The element of a motion in the plane of work coordinates; none when it leaves the plane or is none.
fn element(op: &Op, mark: &CornerMark) -> Option<Element> {
    let [u, v, w] = mark.axes;
    let motion = match op {
        Op::Linear(m) => m,
        Op::Arc(a) => &a.motion,
        _ => return None,
    };
    let point = |at: &AxisValues| Some([at.get(u)?, at.get(v)?]);
    let (start, end) = (point(&mark.start)?, point(&motion.end)?);
    let leaves = match (mark.start.get(w), motion.end.get(w)) {
        (Some(from), Some(to)) => (to - from).abs() > contour::SAME_POINT_MM,
        (from, to) => from.is_some() != to.is_some(),
    };
    if leaves || motion.tool_axis.is_some() {
        return None;
    }
    let shape = match op {
        Op::Arc(arc) if arc.normal[w].abs() > SAME_DIRECTION => ElementShape::Arc {
            center: [arc.center[u], arc.center[v]],
            radius: (start[0] - arc.center[u]).hypot(start[1] - arc.center[v]),
            counter_clockwise: arc.normal[w] > 0.0,
            sweep: arc.sweep,
        },
        Op::Arc(_) => return None,
        _ => ElementShape::Line,
    };
    let element = Element { start, end, shape };
    (element.extent() > contour::SAME_POINT_MM).then_some(element)
}

/// Moves the end of a motion within the plane.
fn move_end(motion: &mut Motion, to: contour::Point, mark: &CornerMark) {
    let [u, v, _] = mark.axes;
    let mut by = [0.0; 3];
    by[u] = to[0] - motion.end.get(u).unwrap_or(to[0]);
    by[v] = to[1] - motion.end.get(v).unwrap_or(to[1]);
    motion.end.put(u, to[0]);
    motion.end.put(v, to[1]);
    for (axis, change) in mark.frame.apply_vector(by).into_iter().enumerate() {
        if let Some(base) = motion.end_base.get(axis) {
            motion.end_base.put(axis, base + change);
        }
    }
}

type Refusal = (String, &'static str);

/// What becomes of a corner.
enum CornerOutcome {
    Piece(Box<Op>),
    /// The second block continues the first one straight.
    Straight,
    /// The two make no corner in the plane.
    Nothing,
}

/// Cuts the two motions at their corner and makes the piece between them.
fn join(corner: &mut HeldMotion, next: &mut Command, mark: &mut CornerMark) -> Result<CornerOutcome, Refusal> {
    let own = corner.mark.clone();
    let (Some(first), Some(second), Some(kind)) =
        (element(&corner.command.op, &own), element(&next.op, mark), own.kind)
    else {
        return Ok(CornerOutcome::Nothing);
    };
    let (s, t) = (first.last_tangent(), second.first_tangent());
    let (sine, cosine) = (contour::cross(s, t), contour::dot(s, t));
    let turn = sine.abs().atan2(cosine);
    if turn < if own.strict { ISO_STRAIGHT } else { STRAIGHT } {
        return Ok(if own.strict { CornerOutcome::Straight } else { CornerOutcome::Nothing });
    }
    if turn > std::f64::consts::PI - STRAIGHT {
        return Ok(CornerOutcome::Nothing);
    }
    let (from, to, center) = match kind {
        CornerKind::Rounding(radius) => {
            let offset = radius.copysign(sine);
            let room = |e: &Element| e.offset_radius(offset).is_none_or(|r| r > contour::SAME_POINT_MM);
            let center = Some(first)
                .filter(|_| room(&first) && room(&second))
                .and_then(|first| contour::inside_corner(&first, &second, offset, first.extent()))
                .map(|meeting| meeting.point)
                .ok_or_else(|| {
                    (
                        format!("a rounding of {radius} mm does not fit between this block and the next"),
                        "write a smaller one",
                    )
                })?;
            (first.foot(center, offset), second.foot(center, offset), Some((center, radius)))
        }
        CornerKind::Chamfer(value) | CornerKind::Leg(value) => {
            if first.shape != ElementShape::Line || second.shape != ElementShape::Line {
                return Err(("a chamfer between circles is not supported".to_owned(), "write it as a G1 block"));
            }
            let leg = if matches!(kind, CornerKind::Leg(_)) { value } else { value / (2.0 * (0.5 * turn).cos()) };
            if leg > first.extent() || leg > second.extent() {
                let message =
                    format!("a chamfer with legs of {leg:.4} mm does not fit between this block and the next");
                return Err((message, "write a smaller one"));
            }
            (contour::along(first.end, s, -leg), contour::along(first.end, t, leg), None)
        }
    };
    let taken = first.back_from_end(from, 0.0);
    let used = second.on_from_start(to, 0.0);
    let cut = |op: &mut Op, by: f64| {
        if let Op::Arc(arc) = op {
            arc.sweep -= by;
        }
    };
    cut(&mut corner.command.op, taken);
    cut(&mut next.op, used);
    let (Op::Linear(motion) | Op::Arc(ArcMotion { motion, .. })) = &mut corner.command.op else {
        return Ok(CornerOutcome::Nothing);
    };
    move_end(motion, from, &own);
    let mut piece = motion.clone();
    let [u, v, w] = own.axes;
    move_end(&mut piece, to, &own);
    piece.programmed = 1 << u | 1 << v;
    piece.exact_stop = false;
    mark.start.put(u, to[0]);
    mark.start.put(v, to[1]);
    let Some((center, radius)) = center else { return Ok(CornerOutcome::Piece(Box::new(Op::Linear(piece)))) };
    // A coordinate that the program does not know is not in `programmed`: its value has no effect.
    let mut middle = [piece.end.get(w).unwrap_or(0.0); 3];
    middle[u] = center[0];
    middle[v] = center[1];
    let mut normal = [0.0; 3];
    normal[w] = 1f64.copysign(sine);
    let scale = own.frame.uniform_scale().unwrap_or(1.0);
    let sense = if own.frame.determinant() < 0.0 { -1.0 } else { 1.0 };
    Ok(CornerOutcome::Piece(Box::new(Op::Arc(ArcMotion {
        center_base: own.frame.apply(middle),
        normal_base: own.frame.apply_vector(normal).map(|c| sense * c / scale + 0.0),
        center: middle,
        normal,
        radius: radius * scale,
        sweep: sweep(from, to, center, sine > 0.0),
        motion: piece,
    }))))
}

fn sweep(from: contour::Point, to: contour::Point, center: contour::Point, counter_clockwise: bool) -> f64 {
    let (a, b) = (contour::sub(from, center), contour::sub(to, center));
    let angle = contour::cross(a, b).atan2(contour::dot(a, b));
    (if counter_clockwise { angle } else { -angle }).rem_euclid(TAU)
}
