//! Hands blocks of the contour out as motions of the tool center.

use super::contour::{Element, ElementShape, Point, ROUNDING_MM, SAME_POINT_MM, cross, norm, sub};
use super::corner::{self, BlockStart, ContourEntry, CornerPiece, FeedAt, Join};
use super::plane::CompPlane;
use super::stretch::{CenterPiece, PathRole};
use super::{CompState, CompensatedReader, Fault, PendingBlock, motion_mut, motion_of};
use crate::codes;
use crate::{ArcMotion, AxisValues, Command, Feed, Location, Motion, Op};

/// A factor of the feed this near to one is none.
const SAME_FEED: f64 = 1e-9;

impl CompensatedReader {
    /// Ends the pending block before the next one, or at the end of its own equidistant where there
    /// is none. Emits the commands held after it and the pieces of the corner. Returns where the
    /// next block begins.
    pub(super) fn settle(&mut self, next: Option<(&Element, &Command)>) -> Result<Option<OffsetStart>, Fault> {
        let Some(pending) = self.pending.take() else {
            // Switched off before a block in the plane came: nothing has moved.
            if next.is_none() && self.state == CompState::Entering {
                self.state = CompState::Off;
            }
            return Ok(None);
        };
        let Some(plane) = self.plane else { return Ok(None) };
        let offset = pending.offset;
        let join = match next {
            None if pending.entry => {
                return Err(self.unfit(
                    &pending.command.location,
                    "cutter compensation is switched off right after its entry move, with no contour between",
                ));
            }
            None => {
                let past = pending.rest < -ROUNDING_MM;
                let end = if past { pending.from } else { pending.element.offset_end(offset) };
                let follow = self.reader.comp_style().unwrap_or(self.default_style).follow_contour;
                self.exit = follow.then(|| (pending.element.end, pending.element.last_tangent(), offset));
                Join { taken: if past { pending.rest } else { 0.0 }, ..Join::end_at(end) }
            }
            Some((element, _)) if pending.entry && pending.style.entry == ContourEntry::Perpendicular => {
                if pending.style.follow_contour {
                    let from = pending.element.start;
                    let known = norm(sub(from, pending.element.end)) > SAME_POINT_MM;
                    if !known || is_behind(from, element.start, element.first_tangent(), offset) {
                        return Err(self.far_side(&pending.command.location, "entry"));
                    }
                }
                Join::end_at(element.offset_start(offset))
            }
            Some((element, command)) => {
                let rapid = matches!(command.op, Op::Rapid(_));
                let corner = self.reader.comp_style().unwrap_or(self.default_style).corner;
                let begun = BlockStart { element: pending.element, from: pending.from, rest: pending.rest };
                corner::join(&begun, element, offset, corner, rapid)
                    .ok_or_else(|| self.too_large(&pending, element, &command.location))?
            }
        };
        let corner_point = pending.element.end;
        self.record_block(&pending, &join);
        self.hand_out(pending, &join, &plane);
        for mut command in std::mem::take(&mut self.held) {
            if let Some(motion) = motion_mut(&mut command.op) {
                plane.shift(&mut motion.end_base, sub(join.end, corner_point));
                self.last = Some(motion.clone());
            }
            self.out.push_back(Ok(command));
        }
        self.residual = sub(join.end, corner_point);
        let Some((_, command)) = next else {
            self.check()?;
            let stretch = std::mem::take(&mut self.stretch);
            self.leaving = (!stretch.is_empty()).then_some((stretch, join.end));
            return Ok(None);
        };
        let rapid = matches!(command.op, Op::Rapid(_));
        let mut at = join.end;
        for piece in &join.pieces {
            let element = piece.element(at, corner_point, offset);
            at = element.end;
            if !rapid {
                let (wall, location) = (self.stretch.walls.len(), command.location.clone());
                let way = CenterPiece {
                    element,
                    role: PathRole::Corner,
                    wall,
                    radius: offset.abs(),
                    heights: self.heights,
                    location,
                };
                self.stretch.ways.push(way);
            }
            let op = self.piece(piece, corner_point, offset, &plane, rapid).ok_or_else(|| {
                let missing: String = crate::AXIS_LETTERS[..3].iter().filter(|l| self.is_missing(**l)).collect();
                self.unknown(&command.location, &missing)
            })?;
            if let Some(op) = op {
                // The piece belongs to the block that it leads to.
                self.out.push_back(Ok(Command { location: command.location.clone(), op }));
            }
        }
        Ok(Some(OffsetStart { point: join.start, offset, used: join.used }))
    }

    /// Notes the path along a block for the check of the stretch.
    fn record_block(&mut self, pending: &PendingBlock, join: &Join) {
        if matches!(pending.command.op, Op::Rapid(_)) {
            return;
        }
        let shape = match pending.element.shape {
            ElementShape::Line => ElementShape::Line,
            ElementShape::Arc { center, counter_clockwise, radius, .. } => ElementShape::Arc {
                center,
                counter_clockwise,
                radius: pending.element.offset_radius(pending.offset).unwrap_or(radius),
                sweep: (pending.rest - join.taken).max(0.0),
            },
        };
        let role = if pending.entry { PathRole::Entry } else { PathRole::Block };
        let way = CenterPiece {
            element: Element { start: pending.from, end: join.end, shape },
            role,
            wall: if pending.entry { 0 } else { self.stretch.walls.len().saturating_sub(1) },
            radius: pending.least_offset.abs(),
            heights: pending.heights,
            location: pending.command.location.clone(),
        };
        if pending.entry {
            self.check_exit(&way);
        }
        self.stretch.ways.push(way);
    }

    fn too_large(&self, pending: &PendingBlock, element: &Element, location: &Location) -> Fault {
        let fits = corner::fitting_radius(&pending.element, element, pending.offset);
        let message = format!(
            "the tool of radius {} mm does not fit between this block and the one of line {}",
            pending.offset.abs(),
            pending.command.location.line
        );
        let help = if fits > SAME_POINT_MM && fits < 0.999 * pending.offset.abs() {
            format!("a radius of at most {fits:.4} mm fits into this corner")
        } else {
            // The corner alone would fit: another corner has used up the rest of the block before.
            format!(
                "the block of line {} is too short between its two corners; use a smaller tool or a longer block",
                pending.command.location.line
            )
        };
        self.fault(codes::COMPENSATION, location, message, help)
    }

    /// The block with its end moved to the tool center.
    fn hand_out(&mut self, pending: PendingBlock, join: &Join, plane: &CompPlane) {
        let PendingBlock { mut command, element, offset, rest, feed, style, .. } = pending;
        let end = join.end;
        let mut scaled = None;
        if let (Op::Arc(arc), ElementShape::Arc { radius, .. }) = (&mut command.op, element.shape) {
            let own = element.offset_radius(offset).unwrap_or(radius);
            arc.sweep = rest - join.taken;
            arc.radius = own;
            let inside = own < radius;
            let at_contour = style.feed == FeedAt::Contour || style.feed == FeedAt::ContourInside && inside;
            scaled = feed.filter(|_| at_contour && radius > 0.0).and_then(|feed| scale_feed(feed, own / radius));
        }
        if let Some(motion) = motion_mut(&mut command.op) {
            plane.shift(&mut motion.end_base, sub(end, element.end));
        }
        self.last = motion_of(&command.op).cloned();
        if let Op::Arc(arc) = &command.op
            && arc.sweep * arc.radius <= SAME_POINT_MM
        {
            // Its corners have taken all of it; axes outside of the plane move all the same.
            command.op = Op::Linear(arc.motion.clone());
            scaled = None;
        }
        let location = command.location.clone();
        match (scaled, feed) {
            (Some(scaled), Some(feed)) => {
                self.out.push_back(Ok(Command { location: location.clone(), op: Op::Feed(scaled) }));
                self.out.push_back(Ok(command));
                self.out.push_back(Ok(Command { location, op: Op::Feed(feed) }));
            }
            _ => self.out.push_back(Ok(command)),
        }
    }

    fn is_missing(&self, letter: char) -> bool {
        let end = self.last.as_ref().map(|motion| motion.end_base);
        AxisValues::index(letter).is_some_and(|axis| end.is_none_or(|end| end.get(axis).is_none()))
    }

    /// A piece of a corner, if it has a length; `self.residual` is the tool center relative to the
    /// corner. None where a circle would need a height that the program has not set.
    fn piece(
        &mut self,
        piece: &CornerPiece,
        corner: Point,
        offset: f64,
        plane: &CompPlane,
        rapid: bool,
    ) -> Option<Option<Op>> {
        let mut motion = self.last.clone()?;
        let at = [corner[0] + self.residual[0], corner[1] + self.residual[1]];
        let to = match piece {
            CornerPiece::LineTo(to) => *to,
            CornerPiece::ArcTo { end, .. } => *end,
        };
        if norm(sub(to, at)) <= SAME_POINT_MM {
            return Some(None);
        }
        let center_base = {
            let mut center = motion.end_base;
            plane.shift(&mut center, self.residual.map(|v| -v));
            center.xyz()
        };
        plane.shift(&mut motion.end_base, sub(to, at));
        motion.programmed = plane.axes;
        motion.exact_stop = false;
        self.residual = sub(to, corner);
        self.last = Some(motion.clone());
        let CornerPiece::ArcTo { counter_clockwise, sweep, .. } = *piece else {
            return Some(Some(straight(motion, rapid)));
        };
        let (center, center_base) = (motion.end.xyz()?, center_base?);
        let sense = if counter_clockwise { 1.0 } else { -1.0 };
        Some(Some(Op::Arc(ArcMotion {
            motion,
            center,
            center_base,
            normal: plane.work_normal.map(|c| sense * c + 0.0),
            normal_base: plane.normal.map(|c| sense * c + 0.0),
            radius: offset.abs(),
            sweep,
        })))
    }
}

/// Where the tool center of a block begins.
pub(super) struct OffsetStart {
    pub(super) point: Point,
    /// Offset to the left there, mm.
    pub(super) offset: f64,
    /// What lies before it on the block, in the unit of [`Element::extent`].
    pub(super) used: f64,
}

/// True when a point lies on the other side of the contour than the tool, by the tangent at its start or end.
pub(super) fn is_behind(point: Point, corner: Point, tangent: Point, offset: f64) -> bool {
    offset * cross(tangent, sub(point, corner)) < -offset.abs() * SAME_POINT_MM
}

fn straight(motion: Motion, rapid: bool) -> Op {
    if rapid { Op::Rapid(motion) } else { Op::Linear(motion) }
}

fn scale_feed(feed: Feed, factor: f64) -> Option<Feed> {
    if (factor - 1.0).abs() < SAME_FEED {
        return None;
    }
    match feed {
        Feed::PerTime(v) => Some(Feed::PerTime(v * factor)),
        Feed::PerRevolution(v) => Some(Feed::PerRevolution(v * factor)),
        Feed::InverseTime(_) => None,
    }
}
