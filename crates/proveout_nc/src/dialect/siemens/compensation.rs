//! Words of cutter radius compensation: G40 to G42 and what belongs to them.
//!
//! The reader emits [`CutterComp`] and keeps the style. The stage after all readers computes the
//! path of the tool center ([`crate::compensation`]). After Siemens, *NC programming,
//! Fundamentals*, "Tool radius compensation".

use super::modal::Compensation;
use super::pending::Pending;
use super::run_state::Interpreter;
use crate::codes;
use crate::compensation::FeedAt;
use crate::diagnostic::{Fault, Span};
use crate::frame::SQUARE;
use crate::{CompSide, CutterComp, Op};

impl Interpreter {
    /// G40, G41, G42.
    pub(crate) fn compensation_word(&mut self, p: &mut Pending, code: u32, span: Span) -> Result<(), Fault> {
        let side = [CompSide::Off, CompSide::Left, CompSide::Right][code as usize % 40 % 3];
        if side == CompSide::Off && self.modal.compensation.side == CompSide::Off && p.compensation.is_none() {
            self.note("G40");
            return Ok(());
        }
        if p.compensation.replace(side).is_some_and(|other| other != side) {
            return Err(Fault::new(codes::CONFLICT, span, format!("`G{code}` contradicts another word of its group"))
                .help("keep one of G40, G41 and G42"));
        }
        Ok(())
    }

    /// G450, G451.
    pub(crate) fn corner_word(&mut self, code: u32) {
        self.modal.compensation.style.corner = Compensation::corner(code);
        self.note(format!("G{code}"));
    }

    /// Words without a value that belong to compensation; false for any other name.
    pub(crate) fn compensation_name(&mut self, name: &str) -> bool {
        let state = &mut self.modal.compensation;
        match name {
            "NORM" | "KONT" => (state.style.follow_contour, state.smooth_approach) = (name == "KONT", None),
            "KONTC" => state.smooth_approach = Some("KONTC"),
            "KONTT" => state.smooth_approach = Some("KONTT"),
            "CUT2D" => state.plane_in_frame = false,
            "CUT2DF" => state.plane_in_frame = true,
            "CFC" => state.style.feed = FeedAt::Contour,
            "CFIN" => state.style.feed = FeedAt::ContourInside,
            "CFTCP" => state.style.feed = FeedAt::Center,
            "CDON" => state.style.look_ahead = Compensation::BOTTLENECK_BLOCKS,
            "CDOF" | "CDOF2" => state.style.look_ahead = Compensation::RESET.style.look_ahead,
            _ => return false,
        }
        self.note(name);
        true
    }

    /// Puts G40, G41, G42 of a block into effect, after its tool and edge.
    pub(crate) fn compensate(&mut self, side: CompSide, span: Span) -> Result<(), Fault> {
        let state = self.modal.compensation;
        if side != CompSide::Off {
            let refuse =
                |message: String, help: &str| Err(Fault::new(codes::UNSUPPORTED_WORD, span, message).help(help));
            if let Some(word) = state.smooth_approach {
                return refuse(format!("cutter compensation with `{word}` is not supported"), "use NORM or KONT");
            }
            if state.disc != 0.0 {
                return refuse("cutter compensation with `DISC=` above zero is not supported".to_owned(), "use DISC=0");
            }
            let (normal, linear) = (self.modal.normal, self.modal.frames.without_swivel().linear);
            let square =
                linear.iter().enumerate().all(|(row, factors)| row == normal || factors[normal].abs() < SQUARE);
            if !square && !state.plane_in_frame && !self.own.swiveled {
                return refuse(
                    "`CUT2D` in a frame that tilts the working plane is not supported".to_owned(),
                    "use CUT2DF, which compensates in the plane of the frame",
                );
            }
        }
        self.modal.compensation.side = side;
        self.tell_compensation();
        Ok(())
    }

    /// Another edge (D) was selected; its radius may differ.
    pub(crate) fn edge_changed_radius(&mut self) {
        if self.modal.compensation.side != CompSide::Off {
            self.tell_compensation();
        }
    }

    pub(crate) fn tell_compensation(&mut self) {
        let side = self.modal.compensation.side;
        // D0 switches off all data of the tool, including its radius. Other edges have the radius
        // of the tool.
        let radius = (side != CompSide::Off && self.own.edge == Some(0)).then_some(0.0);
        self.emit(Op::CutterComp(CutterComp { side, offset: None, radius }));
    }
}
