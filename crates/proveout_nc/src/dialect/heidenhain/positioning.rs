//! LN blocks and motions in machine coordinates.

use super::motion::ROTARY;
use super::run_state::Interpreter;
use super::words::{PathFunction, Value, Words};
use crate::codes;
use crate::diagnostic::{Fault, Span, give};
use crate::frame;
use crate::{AXIS_LETTERS, AxisValues};

impl Interpreter {
    /// LN: a line with the normal of the surface and, in TX TY TZ, the axis of the tool.
    pub(crate) fn normal_line(&mut self, w: &Words, rapid: bool, span: Span) -> Result<(), Fault> {
        let vector = |list: &[Option<Value>; 3]| -> Result<Option<[f64; 3]>, Fault> {
            if list.iter().all(Option::is_none) {
                return Ok(None);
            }
            let mut components = [0.0; 3];
            for (component, value) in components.iter_mut().zip(list) {
                if let Some(value) = value {
                    *component = self.variables.value(*value, span)?;
                }
            }
            frame::unit(components).map(Some).ok_or_else(|| {
                Fault::new(codes::ORIENTATION, span, "the vector has no length")
                    .help("give the components of a direction")
            })
        };
        let (normal, axis) = (vector(&w.normal)?, vector(&w.vector)?);
        if normal.is_some() && self.modal.delta != [0.0; 3] {
            return Err(super::lexer::refused(
                "LN with DL, DR or DR2",
                span,
                "3-D compensation by delta values is not computed: post the path for the real tool",
            ));
        }
        if axis.is_some() && !self.modal.tcpm {
            return Err(Fault::new(
                codes::ORIENTATION,
                span,
                "a tool vector is programmed and M128 or TCPM is not active",
            )
            .help("write M128 or FUNCTION TCPM before it"));
        }
        let mut goal = self.goal(w, span)?;
        // Without TX TY TZ the control holds the tool normal to the surface while it controls the tool center
        // point.
        let axis = axis.or(if self.modal.tcpm { normal } else { None });
        if axis.is_some() && w.programmed & ROTARY != 0 {
            return Err(Fault::new(codes::ORIENTATION, span, "rotary axes and a tool vector in the same block")
                .help("program one of the two"));
        }
        goal.tool_axis = axis.or(goal.tool_axis);
        self.straight(goal, rapid, span)
    }

    /// M91, M92: coordinates of the machine axes, only the programmed ones move.
    pub(crate) fn machine_motion(
        &mut self,
        path: PathFunction,
        w: &Words,
        rapid: bool,
        span: Span,
    ) -> Result<(), Fault> {
        if !matches!(path, PathFunction::Line) {
            return Err(Fault::new(codes::CONFLICT, span, "M91 and M92 belong to straight blocks").help("write L"));
        }
        if self.modal.corner.is_some() {
            return Err(super::corner::no_element(span));
        }
        if w.programmed == 0 {
            return Ok(());
        }
        if !rapid {
            self.need_feed(span)?;
        }
        let mut end = AxisValues::NONE;
        for (axis, c) in w.axes.iter().enumerate() {
            let Some(c) = c else { continue };
            if self.is_incremental(c.reference) {
                return Err(Fault::new(
                    codes::POSITION_UNKNOWN,
                    span,
                    "an increment in machine coordinates has no known start",
                )
                .help("write the coordinate without I"));
            }
            let value = self.coordinate(axis, self.variables.value(c.value, span)?);
            let shift = if w.has(92) { self.machine_datum(axis, span)? } else { 0.0 };
            end.put(axis, value + shift);
        }
        self.modal.inclined |= w.programmed & ROTARY != 0;
        let in_table = self.modal.told_tcp.is_some_and(|told| told.on);
        self.position.moved_in_machine(&end, w.programmed, in_table);
        if self.modal.tcpm {
            // HEIDENHAIN, *TNC 640 Klartext programming*, "M128": reset it before positioning with M91 or
            // M92.
            self.assume(
                "M91 or M92 under M128 or TCPM gives positions of the machine axes; the manual asks for M129 before them",
            );
        }
        self.modal.tangent = None;
        self.go_in_machine(end, w.programmed, rapid, false);
        Ok(())
    }

    /// Machine coordinate of the machine builder's datum (M92): the program cannot contain it.
    fn machine_datum(&self, axis: usize, span: Span) -> Result<f64, Fault> {
        let name = format!("M92_{}", AXIS_LETTERS[axis]);
        self.settings.variables.get(&name).map(|v| if (3..6).contains(&axis) { v.to_radians() } else { *v }).ok_or_else(
            || {
                super::lexer::refused(
                    "M92",
                    span,
                    &format!("its datum is set by the machine builder: {} (mm, degrees), or write M91", give(&name)),
                )
                .of_variable(name)
            },
        )
    }
}
