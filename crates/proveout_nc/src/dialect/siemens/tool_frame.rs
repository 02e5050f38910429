//! TOROT and TOFRAME: the work coordinates turn so that Z points along the tool.
//!
//! ```text
//!        Z' = tool          X' lies in the old XZ plane, square to the tool: (tz, 0, -tx); Y' = Z' x X'
//!   Z |  /                  TOROT keeps the origin, TOFRAME moves it to the tip
//!     | /  . X'
//!     |/ .'                 TOROTOF and TOFRAMEOF take the frame away
//!     +------ X
//! ```
//!
//! After Siemens, *NC programming, Job planning*, "Frame generation according to tool orientation
//! (TOFRAME, TOROT, PAROT)": the tool frame (`$P_TOOLFRAME`) comes between the settable and the
//! programmable frame, and MD21110 (X axis in the old XZ plane) has its default value. A tool
//! vector (A3= B3= C3=) must give the direction of the tool: which way rotary axes turn it is data
//! of the machine.

use super::pending::{Pending, ToolFrame};
use super::run_state::Interpreter;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::{self, Frame};

/// Sine of the smallest angle between the tool and the old Y axis; below it X' is not determined.
const LEAST_SINE: f64 = 1e-6;

impl Interpreter {
    /// After a motion: the direction of the tool, base coordinates; none where rotary axes
    /// determine it.
    pub(super) fn keep_tool_axis(&mut self, p: &Pending, span: Span) -> Result<(), Fault> {
        if p.has_orientation() {
            let axis = self.tool_axis(p, span)?;
            self.own.tool_axis = frame::unit(self.position.frame().apply_vector(axis));
        } else if p.programmed & 0b111000 != 0 {
            self.own.tool_axis = None;
        }
        Ok(())
    }

    pub(super) fn tool_frame(&mut self, wanted: ToolFrame, p: &Pending, span: Span) -> Result<(), Fault> {
        let name = wanted.name();
        if wanted == ToolFrame::Off {
            if !std::mem::take(&mut self.own.tool_framed) {
                self.note(name);
                return Ok(());
            }
            self.modal.frames.swivel = Frame::IDENTITY;
            self.take_frames(name);
            return Ok(());
        }
        let refuse = |code: &'static str, message: String, help: &str| Err(Fault::new(code, span, message).help(help));
        if p.has_axis() || p.has_orientation() {
            return refuse(
                codes::CONFLICT,
                format!("`{name}` in a block with a motion"),
                "write it in a block of its own",
            );
        }
        if !self.own.transformed {
            return refuse(codes::ORIENTATION, format!("`{name}` without TRAORI"), "write TRAORI before it");
        }
        let Some(axis) = self.own.tool_axis else {
            return refuse(
                codes::ORIENTATION,
                format!("`{name}` needs the direction of the tool, which no tool vector says here"),
                "program it with A3= B3= C3=: which way rotary axes turn the tool is data of the machine",
            );
        };
        if self.own.swiveled || self.own.tool_framed || self.modal.frames.programmable != Frame::IDENTITY {
            return refuse(
                codes::CONFLICT,
                format!("`{name}` in a swivel plane, in a tool frame or in a programmed frame"),
                "write CYCLE800(), TOROTOF or TRANS before it, and further frames after it",
            );
        }
        let outer = self.modal.frames.base.then(&self.modal.frames.settable);
        let (Some(inverse), Some(_)) = (outer.inverse_linear(), outer.uniform_scale()) else {
            return refuse(codes::ORIENTATION, format!("`{name}` under unequal scales"), "use equal scale factors");
        };
        let inside = |v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| frame::dot(inverse[i], v)) };
        let turned = frame::unit(inside(axis)).and_then(|z| {
            let across = [z[2], 0.0, -z[0]];
            let x = frame::unit(across).filter(|_| frame::norm(across) > LEAST_SINE)?;
            let y = frame::cross(z, x);
            // Columns are the new axes.
            Some(std::array::from_fn(|row| [x[row], y[row], z[row]]))
        });
        let Some(linear) = turned else {
            return refuse(
                codes::ORIENTATION,
                format!("`{name}`: the tool points along Y, so that no X axis lies in the old XZ plane"),
                "turn the coordinates with ROT",
            );
        };
        let mut plane = Frame { linear, ..Frame::IDENTITY };
        if wanted == ToolFrame::AtTip {
            let Some(tip) = self.position.base.xyz() else {
                return refuse(
                    codes::POSITION_UNKNOWN,
                    format!("`{name}` moves the origin to the tip, whose position is not known here"),
                    "program X, Y and Z before it",
                );
            };
            plane.translation = inside(frame::sub(tip, outer.translation));
        }
        self.modal.frames.swivel = plane;
        self.own.tool_framed = true;
        self.assume(format!(
            "{name}: the frame of the tool comes before the programmable frame (bit 3 of MD28082), and its X axis \
             lies in the old XZ plane (MD21110)"
        ));
        self.take_frames(name);
        Ok(())
    }
}
