//! Chamfers and roundings between two blocks: CHF=, CHR=, RND=, RNDM=, FRC=, FRCM=.
//!
//! ```text
//!          end of A              CHR: both legs in the direction of motion; CHF: the chamfer itself
//!    A ------+ - - + P           RND: the circle touches both blocks; its center is as far from both
//!            .  \  :                  as its radius, so it is where their equidistants meet
//!            . r  \+ start of B
//!            c     | B
//! ```
//!
//! After Siemens, *NC programming, Fundamentals*, "Chamfer, rounding": the piece is put between straight and circular blocks
//! of the working plane. Where no such block follows, or one moves out of the plane, none is put in, and a note says so.
//! The command waits for the next block; commands between stay between.

use std::f64::consts::TAU;

use super::interpreter::Interpreter;
use super::pending::Pending;
use crate::codes;
use crate::compensation::contour::{self, Element, Shape};
use crate::diagnostic::{Diagnostic, Fault, Span};
use crate::frame::Frame;
use crate::{ArcMotion, Command, Feed, Motion, Op};

/// Most commands between the two blocks of a corner.
const LOOK_AHEAD: usize = 1000;
/// Turns smaller than this are no corner, radian.
const STRAIGHT: f64 = 1e-6;

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
    /// Start of the motion in work coordinates, X, Y, Z.
    pub(crate) start: Option<[f64; 3]>,
    /// Axes of the working plane and its normal.
    pub(crate) axes: [usize; 3],
    pub(crate) frame: Frame,
    /// FRC, FRCM: feed on the piece, and the feed to come back to.
    pub(crate) feed: Option<(Feed, Option<Feed>)>,
}

/// A motion that waits for the block behind it.
#[derive(Debug)]
pub(crate) struct Corner {
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

impl Interpreter {
    /// The corner that a block asks for at its end.
    pub(crate) fn corner_of(&self, p: &Pending, span: Span) -> Result<Option<CornerKind>, Fault> {
        let length = self.modal.units.length();
        let kinds = [
            p.chamfer.map(|v| CornerKind::Chamfer(v * length)),
            p.chamfer_leg.map(|v| CornerKind::Leg(v * length)),
            p.corner_radius.map(|v| CornerKind::Rounding(v * length)),
        ];
        let mut given = kinds.into_iter().flatten();
        let first = given.next();
        if given.next().is_some() {
            return Err(
                Fault::new(codes::CONFLICT, span, "the block has more than one of CHF=, CHR=, RND=").help("keep one")
            );
        }
        let kind = first.or(self.modal.modal_rounding.map(CornerKind::Rounding));
        match kind {
            Some(CornerKind::Chamfer(v) | CornerKind::Leg(v) | CornerKind::Rounding(v)) if v < 0.0 => {
                Err(Fault::new(codes::BAD_VALUE, span, "a chamfer or rounding must not be negative")
                    .help("write RND=2"))
            }
            Some(CornerKind::Chamfer(0.0) | CornerKind::Leg(0.0) | CornerKind::Rounding(0.0)) => Ok(None),
            kind => Ok(kind),
        }
    }

    /// The motion of a block, with what its end needs for a corner there or before it.
    pub(crate) fn motion_with_corner(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        let kind = self.corner_of(p, span)?;
        if kind.is_none() && !self.own.corner_waits {
            return self.motion(p, span);
        }
        let start = self.position.work.xyz();
        let moves_before = self.own.moves;
        self.motion(p, span)?;
        if self.own.moves == moves_before {
            return Ok(());
        }
        let feed = match p.corner_feed.or(self.modal.corner_feed) {
            Some(value) => Some((self.feed_of(value, span)?, self.technology.feed)),
            None => None,
        };
        self.own.corner_waits = kind.is_some();
        let (axes, frame) = (self.modal.plane_axes(), *self.position.frame());
        self.mark_corner(CornerMark { kind, start, axes, frame, feed });
        Ok(())
    }

    /// Takes the next command of the queue through the corners; commands that are ready go to `ready`.
    pub(crate) fn through_corners(
        &mut self,
        command: Command,
        mark: Option<Box<CornerMark>>,
    ) -> Result<(), Box<Diagnostic>> {
        let Some(mut corner) = self.own.corner.take() else {
            match mark {
                Some(mark) if mark.kind.is_some() => {
                    self.own.corner = Some(Box::new(Corner { command, mark: *mark, held: Vec::new() }));
                }
                _ => self.own.ready.push_back(command),
            }
            return Ok(());
        };
        if motion_of(&command.op).is_none() && !matches!(command.op, Op::End) {
            if matches!(command.op, Op::Frame(_) | Op::Plane(_)) || corner.held.len() >= LOOK_AHEAD {
                self.no_corner(corner);
                return self.through_corners(command, mark);
            }
            corner.held.push(command);
            self.own.corner = Some(corner);
            return Ok(());
        }
        let Some(mut mark) = mark else {
            self.no_corner(corner);
            self.own.ready.push_back(command);
            return Ok(());
        };
        let mut next = command;
        match join(&mut corner, &mut next, &mut mark) {
            Ok(Some(piece)) => {
                let location = corner.command.location.clone();
                let told = corner.held.iter().rev().find_map(|c| if let Op::Feed(f) = c.op { Some(f) } else { None });
                let Corner { command, mark: own, held } = *corner;
                self.own.ready.push_back(command);
                self.own.ready.extend(held);
                if let Some((feed, _)) = own.feed {
                    self.own.ready.push_back(Command { location: location.clone(), op: Op::Feed(feed) });
                }
                self.own.ready.push_back(Command { location: location.clone(), op: piece });
                if let Some(before) = own.feed.and_then(|(_, before)| told.or(before)) {
                    self.own.ready.push_back(Command { location, op: Op::Feed(before) });
                }
            }
            Ok(None) => self.no_corner(corner),
            Err((message, help)) => {
                let location = &corner.command.location;
                let source_line = self.line_of(&location.file, location.line).unwrap_or_default();
                return Err(Box::new(Diagnostic {
                    code: codes::ARC_GEOMETRY,
                    message,
                    file: location.file.clone(),
                    line: location.line,
                    column: location.column,
                    length: location.length,
                    help: Some(help.to_owned()),
                    source_line,
                }));
            }
        }
        self.through_corners(next, Some(mark))
    }

    /// No block follows that a piece could be put before.
    pub(crate) fn no_corner(&mut self, corner: Box<Corner>) {
        let note = Command {
            location: corner.command.location.clone(),
            op: Op::Note(
                "no chamfer or rounding: the next motion makes no corner with this one in the working plane".to_owned(),
            ),
        };
        let Corner { command, held, .. } = *corner;
        self.own.ready.push_back(command);
        self.own.ready.push_back(note);
        self.own.ready.extend(held);
    }
}

/// The element of a motion in the plane of work coordinates; none when it leaves the plane or is none.
fn element(op: &Op, mark: &CornerMark) -> Option<Element> {
    let [u, v, w] = mark.axes;
    let start = mark.start?;
    let motion = match op {
        Op::Linear(m) => m,
        Op::Arc(a) => &a.motion,
        _ => return None,
    };
    let end = motion.end.xyz()?;
    if (end[w] - start[w]).abs() > contour::SAME_POINT_MM || motion.tool_axis.is_some() {
        return None;
    }
    let shape = match op {
        Op::Arc(arc) if arc.normal[w].abs() > 1.0 - 1e-9 => Shape::Arc {
            center: [arc.center[u], arc.center[v]],
            radius: (start[u] - arc.center[u]).hypot(start[v] - arc.center[v]),
            counter_clockwise: arc.normal[w] > 0.0,
            sweep: arc.sweep,
        },
        Op::Arc(_) => return None,
        _ => Shape::Line,
    };
    let element = Element { start: [start[u], start[v]], end: [end[u], end[v]], shape };
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

/// Cuts the two motions at their corner and makes the piece between them; none where no corner can be.
fn join(corner: &mut Corner, next: &mut Command, mark: &mut CornerMark) -> Result<Option<Op>, Refusal> {
    let own = corner.mark.clone();
    let (Some(first), Some(second), Some(kind)) =
        (element(&corner.command.op, &own), element(&next.op, mark), own.kind)
    else {
        return Ok(None);
    };
    let (s, t) = (first.last_tangent(), second.first_tangent());
    let (sine, cosine) = (contour::cross(s, t), contour::dot(s, t));
    let turn = sine.abs().atan2(cosine);
    let tangential = turn < STRAIGHT;
    if tangential || turn > std::f64::consts::PI - STRAIGHT {
        return Ok(None);
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
            if first.shape != Shape::Line || second.shape != Shape::Line {
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
    let (Op::Linear(motion) | Op::Arc(ArcMotion { motion, .. })) = &mut corner.command.op else { return Ok(None) };
    move_end(motion, from, &own);
    let mut piece = motion.clone();
    let [u, v, w] = own.axes;
    move_end(&mut piece, to, &own);
    piece.programmed = 1 << u | 1 << v;
    piece.exact_stop = false;
    if let Some(start) = &mut mark.start {
        start[u] = to[0];
        start[v] = to[1];
    }
    let Some((center, radius)) = center else { return Ok(Some(Op::Linear(piece))) };
    let Some(mut middle) = piece.end.xyz() else { return Ok(None) };
    middle[u] = center[0];
    middle[v] = center[1];
    let mut normal = [0.0; 3];
    normal[w] = 1f64.copysign(sine);
    let scale = own.frame.uniform_scale().unwrap_or(1.0);
    let sense = if own.frame.determinant() < 0.0 { -1.0 } else { 1.0 };
    Ok(Some(Op::Arc(ArcMotion {
        center_base: own.frame.apply(middle),
        normal_base: own.frame.apply_vector(normal).map(|c| sense * c / scale + 0.0),
        center: middle,
        normal,
        radius: radius * scale,
        sweep: sweep(from, to, center, sine > 0.0),
        motion: piece,
    })))
}

fn sweep(from: contour::Point, to: contour::Point, center: contour::Point, counter_clockwise: bool) -> f64 {
    let (a, b) = (contour::sub(from, center), contour::sub(to, center));
    let angle = contour::cross(a, b).atan2(contour::dot(a, b));
    (if counter_clockwise { angle } else { -angle }).rem_euclid(TAU)
}
