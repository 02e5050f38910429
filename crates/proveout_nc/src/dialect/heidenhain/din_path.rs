//! Executes path blocks of the DIN/ISO form: path functions are modal.

use super::run_state::Interpreter;
use super::words::DinBlock;
use super::words::{Block, Coordinate, FeedWord, PathFunction, Reference, Value, Words};
use crate::codes;
use crate::diagnostic::{Fault, Span};

impl Interpreter {
    /// Executes a block of path functions.
    pub(crate) fn din(&mut self, din: &DinBlock, block: &mut Block) -> Result<(), Fault> {
        let span = block.span;
        if let Some(call) = &din.tool {
            self.settle_contour(span)?;
            self.tool_call(call, span)?;
        }
        if let Some(incremental) = din.incremental {
            self.modal.incremental = incremental;
        }
        if let Some(path) = din.path {
            self.modal.din_path = path;
        }
        if din.pole_here {
            self.pole_block(&Words::default(), span)?;
        }
        if din.pole.iter().any(Option::is_some) {
            let mut w = Words::default();
            for (axis, value) in din.pole.into_iter().enumerate() {
                let Some(value) = value else { continue };
                w.axes[axis] = Some(Coordinate { value, reference: Reference::Modal });
                w.programmed |= 1 << axis;
            }
            self.pole_block(&w, span)?;
        }
        let moves = block.words.programmed != 0 || din.radius.is_some() || din.angle.is_some();
        let arc = matches!(self.modal.din_path, 2 | 3 | 5);
        let full = arc && din.path.is_some() && din.pole.iter().any(Option::is_some);
        let path = if moves || full { self.din_path_of(din, block, span)? } else { PathFunction::Nothing };
        self.path(path, &block.words, span)
    }

    fn din_path_of(&mut self, din: &DinBlock, block: &mut Block, span: Span) -> Result<PathFunction, Fault> {
        let w = &mut block.words;
        let code = self.modal.din_path;
        match code {
            2 | 12 => self.modal.din_clockwise = Some(true),
            3 | 13 => self.modal.din_clockwise = Some(false),
            _ => {}
        }
        let polar = |value: Value| Coordinate { value, reference: Reference::Modal };
        if matches!(code, 2 | 3 | 5 | 12 | 13 | 15) {
            w.clockwise = self.modal.din_clockwise;
        }
        if matches!(code, 0 | 10) {
            // F in a rapid block holds for the motions after it.
            if let Some(word) = w.feed
                && let Some(feed) = self.feed_of(word, span)?
            {
                self.set_feed(Some(feed));
            }
            w.feed = Some(FeedWord::Max);
        }
        let has_polar = din.radius.is_some() || din.angle.is_some();
        Ok(match code {
            0 | 1 if !has_polar => PathFunction::Line,
            2 | 3 | 5 if din.angle.is_none() => match din.radius {
                Some(radius) => {
                    w.radius = Some(radius);
                    PathFunction::Radius
                }
                None => PathFunction::Arc,
            },
            6 if !has_polar => PathFunction::Tangent,
            10 | 11 | 16 => {
                w.polar_radius = din.radius.map(polar);
                w.polar_angle = din.angle.map(polar);
                if code == 16 { PathFunction::PolarTangent } else { PathFunction::PolarLine }
            }
            12 | 13 | 15 => {
                w.polar_angle = din.angle.map(polar);
                w.polar_radius = din.radius.map(polar);
                PathFunction::PolarArc
            }
            _ => {
                return Err(Fault::new(codes::CONFLICT, span, format!("R or H in a block with G{code:02}"))
                    .help("write G10, G11, G12, G13, G15 or G16 for polar coordinates"));
            }
        })
    }
}
