//! Cutter radius compensation: from the programmed contour to the path of the tool center.
//!
//! A stage behind the readers of all dialects. Without [`Op::CutterComp`] commands pass through one by one.

use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::dialect::Reader;
use crate::settings::{Compensation, Settings};
use crate::{Command, CompSide, Op};

/// A reader with its compensation.
#[derive(Debug)]
pub(crate) struct Compensated {
    reader: Box<dyn Reader>,
    settings: Compensation,
}

impl Compensated {
    pub(crate) fn new(reader: Box<dyn Reader>, settings: &Settings) -> Self {
        Self { reader, settings: settings.compensation.clone() }
    }

    pub(crate) fn next(&mut self) -> Option<Result<Command, Box<Diagnostic>>> {
        let command = self.reader.next_command()?;
        if let (Compensation::ToolCenter(_), Ok(Command { op: Op::CutterComp(comp), location })) =
            (&self.settings, &command)
            && comp.side != CompSide::Off
        {
            return Some(Err(Box::new(Diagnostic {
                code: codes::UNSUPPORTED_WORD,
                message: "cutter radius compensation is not computed yet".to_owned(),
                file: location.file.clone(),
                line: location.line,
                column: location.column,
                length: location.length,
                help: Some("program the path of the tool center".to_owned()),
                source_line: String::new(),
            })));
        }
        Some(command)
    }
}
