//! G12 and G13 of a Haas: a circular pocket about the present position.
//!
//! ```text
//!         .-----.         I: radius of the first circle, or of the only one; K: of the last; Q: step
//!       /  .---.  \       between them
//!      |  ( c-o )-o |     c: the center, the present position; o: where circles begin
//!       \  '---'  /       G12 runs clockwise, with the tool on the right of the wall (G42), G13
//!         '-----'         counter-clockwise (G41)
//! ```
//!
//! Haas, *Mill operator's manual*, "G12 Circular pocket milling CW / G13 CCW": Z is the depth, D
//! the radius of the tool (D0: the circles are those of its center), L repeats the pocket with the
//! increments of Z under G91. The manual shows the path from the center onto the first circle and
//! from circle to circle in a drawing only. The reader assumes half circles and straight lines, and
//! says so. Where the radius is not known the finished circle is emitted, with cutter compensation.

use std::f64::consts::{PI, TAU};

use super::calls::whole;
use super::interpreter::{Interpreter, Iso};
use super::pending::Pending;
use crate::channel::milling::{MAX_PASSES, Mills, WHOLE};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::g_code::{G12, GCode};
use crate::settings::Compensation;
use crate::{AxisValues, CompSide, CutterComp, Motion, Op, ToolName};

/// Most repetitions of a block.
const MOST_REPEATS: f64 = 9999.0;
/// A circle of the tool center of no more than this radius is none, mm.
const NO_PATH_MM: f64 = 1e-6;

impl Mills for Iso {
    fn working_plane(channel: &Interpreter) -> [usize; 3] {
        channel.modal.plane_axes()
    }

    fn mill_feed(channel: &mut Interpreter, programmed: u16, span: Span) -> Result<(), Fault> {
        channel.need_feed(programmed, span)
    }

    fn mill_motion(channel: &Interpreter, end: AxisValues, programmed: u16, span: Span) -> Result<Motion, Fault> {
        channel.complete(end, programmed, false, span)
    }

    fn mill_line(
        channel: &mut Interpreter,
        end: AxisValues,
        programmed: u16,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        channel.cycle_motion(end, programmed, rapid, span)
    }
}

impl Interpreter {
    pub(super) fn circular_pocket(&mut self, code: GCode, p: &mut Pending, span: Span) -> Result<(), Fault> {
        let name = code.to_string();
        let wrong =
            |code: &'static str, message: String, help: &'static str| Err(Fault::new(code, span, message).help(help));
        if self.modal.normal != 2 {
            return wrong(codes::CONFLICT, format!("{name} in another plane than G17"), "write G17 before it");
        }
        if p.axes() & !0b100 != 0 {
            return wrong(
                codes::UNSUPPORTED_WORD,
                format!("{name} with axes other than Z is not supported"),
                "move to the center in a block before it",
            );
        }
        if self.modal.comp != CompSide::Off || self.modal.cycle.is_some() {
            return wrong(
                codes::CONFLICT,
                format!("{name} under cutter compensation or in a drilling cycle"),
                "write G40 and G80 before it",
            );
        }
        let z = self.length_of(p, b'Z');
        let first = self.length_of(p, b'I');
        let (last, step) = (self.length_of(p, b'K'), self.length_of(p, b'Q'));
        let times = whole(p.take(b'L').unwrap_or(1.0), "L", MOST_REPEATS, span)?;
        let radii = match (first, last, step) {
            (Some(i), None, None) if i > 0.0 && i.is_finite() => vec![i],
            (Some(i), Some(k), Some(q)) if i > 0.0 && k > i && q > 0.0 && (k - i) / q < MAX_PASSES as f64 => {
                let steps = ((k - i) / q - WHOLE).ceil() as u32;
                (0..=steps).map(|n| if n == steps { k } else { i + q * f64::from(n) }).collect()
            }
            _ => {
                return wrong(
                    codes::ARGUMENTS,
                    format!(
                        "{name} needs its radius I, or the first radius I, the last K and the step Q, all above zero"
                    ),
                    "write G13 I10. D1 Z-5. F200., or G13 I4. K10. Q3. D1 Z-5. F200.",
                );
            }
        };
        if times > 1 && !self.modal.incremental {
            return wrong(codes::CONFLICT, format!("{name} repeats with L under G90"), "write G91 and the step in Z");
        }
        let Some(offset) = self.own.d else {
            return wrong(
                codes::MISSING_VALUE,
                format!("{name} has no D"),
                "write D1, or D0 for the center of the tool",
            );
        };
        let center = [self.known(0, span)?, self.known(1, span)?];
        self.before_motion(0b111, p, span)?;
        self.need_feed(0b111, span)?;
        let feed = self.technology.feed;
        let clockwise = code == G12;
        let at = |radius: f64| [center[0] + radius, center[1]];
        let tool = self.pocket_tool(offset, &name, span)?;
        let paths: Vec<f64> = radii.iter().map(|radius| radius - tool.unwrap_or(0.0)).collect();
        if let Some(tool) = tool.filter(|_| paths.iter().any(|path| *path <= NO_PATH_MM)) {
            let message = format!("a tool of radius {tool} mm does not fit into the first circle of {name}");
            return wrong(codes::COMPENSATION, message, "use a smaller tool, or a larger I");
        }
        self.assume(format!(
            "{name}: {}",
            if tool.is_some() {
                "half circles lead from the center onto the first circle and back from the last, straight lines from circle to circle"
            } else {
                "the radius of the tool is not known here, so that the finished circle is given once, with cutter compensation"
            }
        ));
        for _ in 0..times {
            if let Some(z) = z {
                let depth = if self.modal.incremental { self.known(2, span)? + z } else { z };
                self.mill_to(None, Some(depth), feed, span)?;
            }
            if tool.is_none() {
                let wall = at(radii.last().copied().unwrap_or_default());
                let side = if clockwise { CompSide::Right } else { CompSide::Left };
                self.emit(Op::CutterComp(CutterComp { side, offset: Some(offset), radius: None }));
                self.mill_to(Some(wall), None, feed, span)?;
                self.mill_arc((wall, center, clockwise), TAU, None, feed, span)?;
                self.emit(Op::CutterComp(CutterComp { side: CompSide::Off, offset: None, radius: None }));
                self.mill_to(Some(center), None, feed, span)?;
                continue;
            }
            for (n, &path) in paths.iter().enumerate() {
                if n == 0 {
                    self.mill_arc((at(path), at(0.5 * path), clockwise), PI, None, feed, span)?;
                } else {
                    self.mill_to(Some(at(path)), None, feed, span)?;
                }
                self.mill_arc((at(path), center, clockwise), TAU, None, feed, span)?;
            }
            let path = paths.last().copied().unwrap_or_default();
            self.mill_arc((center, at(0.5 * path), clockwise), PI, None, feed, span)?;
        }
        Ok(())
    }

    /// Radius of the tool by its offset, mm; none where the path of the tool center is not wanted
    /// and the program does not give the radius.
    fn pocket_tool(&self, offset: u32, name: &str, span: Span) -> Result<Option<f64>, Fault> {
        if offset == 0 {
            return Ok(Some(0.0));
        }
        if let Some(&(Some(geometry), wear)) = self.own.radii.get(&offset) {
            return Ok(Some(geometry + wear));
        }
        let Compensation::ToolCenter(radii) = &self.settings.compensation else { return Ok(None) };
        let tool = self.technology.in_spindle.as_ref();
        let own = !radii.offset_is_tool || tool == Some(&ToolName::Number(offset));
        let found =
            radii.by_offset.get(&offset).or_else(|| tool.filter(|_| own).and_then(|tool| radii.by_tool.get(tool)));
        found.copied().map(Some).ok_or_else(|| {
            Fault::new(
                codes::COMPENSATION,
                span,
                format!("{name} needs the radius of D{offset}, which the tools do not give"),
            )
            .help("give the tool in the scene")
        })
    }
}
