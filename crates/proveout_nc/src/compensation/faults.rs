//! Radii, and what cannot be compensated.

use super::{CompensatedReader, Fault};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::source::{Mark, Source};
use crate::{CutterComp, Location, ToolName};

impl CompensatedReader {
    pub(super) fn radius(&self, comp: CutterComp, location: &Location) -> Result<f64, Fault> {
        let radii = self.radii.as_ref();
        let by_offset = |d: u32| radii.and_then(|r| r.by_offset.get(&d).copied()).or((d == 0).then_some(0.0));
        let by_tool = || radii.and_then(|r| r.by_tool.get(&self.tool).copied());
        let own = |d: u32| d == 0 || self.tool == ToolName::Number(d);
        if radii.is_some_and(|r| r.wear) {
            return self.wear(comp, by_offset, by_tool(), location);
        }
        let radius = comp.radius.or_else(|| match comp.offset {
            // The offset of another tool is not known, and not that of the tool in the spindle.
            Some(d) if radii.is_some_and(|r| r.offset_is_tool) && !own(d) => by_offset(d),
            Some(d) => by_offset(d).or_else(by_tool),
            None => by_tool(),
        });
        let tool = match &self.tool {
            ToolName::Empty => "no tool in the spindle".to_owned(),
            ToolName::Number(number) => format!("tool {number}"),
            ToolName::Name(name) => format!("tool \"{name}\""),
        };
        let offset = comp.offset.map_or(String::new(), |d| format!(", offset D{d}"));
        match radius {
            Some(radius) if radius.is_finite() => Ok(radius),
            Some(radius) => {
                let message = format!("the radius for cutter compensation is {radius} ({tool}{offset})");
                Err(self.fault(codes::COMPENSATION, location, message, "correct the radius in the tool table"))
            }
            None => {
                let message = format!("the radius for cutter compensation is not known ({tool}{offset})");
                let help = "give the radius of the tool in the tool library, or that of the offset D as parameters.radius_offset_mm of the control file or \
                            with G10 L12 P R in the program, or write the path of the tool center with G40";
                Err(self.fault(codes::COMPENSATION, location, message, help))
            }
        }
    }

    /// The offset where the programmed path is that of the tool center: the wear alone, which lies below the
    /// radius of the tool.
    fn wear(
        &self,
        comp: CutterComp,
        by_offset: impl Fn(u32) -> Option<f64>,
        tool_mm: Option<f64>,
        location: &Location,
    ) -> Result<f64, Fault> {
        let wear = comp.radius.or_else(|| comp.offset.and_then(by_offset)).unwrap_or(0.0);
        let offset = comp.offset.map_or(String::new(), |d| format!(" of D{d}"));
        if !wear.is_finite() || tool_mm.is_some_and(|radius| wear.abs() >= radius) {
            let radius = tool_mm.unwrap_or(0.0);
            let message = format!("the wear{offset} is {wear} mm, and the radius of the tool is {radius} mm");
            let help = "the offset holds the radius: write parameters.compensation = \"contour\" in the control file, or correct the offset";
            return Err(self.fault(codes::COMPENSATION, location, message, help));
        }
        Ok(wear)
    }

    pub(super) fn unfit(&self, location: &Location, what: &str) -> Fault {
        let message = format!("{what}: this cannot be compensated");
        self.fault(
            codes::COMPENSATION,
            location,
            message,
            "write G40 (R0) before this block and start compensation again after it",
        )
    }

    pub(super) fn far_side(&self, location: &Location, what: &str) -> Fault {
        let message = format!(
            "the {what} lies on the far side of the contour, or its position is not known: KONT cannot be computed"
        );
        let help = format!("use NORM, or put the {what} on the side of the contour where the tool runs");
        self.fault(codes::COMPENSATION, location, message, help)
    }

    pub(super) fn unknown(&self, location: &Location, missing: &str) -> Fault {
        let message = format!("cutter compensation needs the position of {missing}, which the program has not set");
        self.fault(codes::POSITION_UNKNOWN, location, message, "program all axes of the plane before G41 and G42")
    }

    pub(super) fn fault(
        &self,
        code: &'static str,
        location: &Location,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Fault {
        let source_line = self
            .reader
            .source_line(&location.file, location.line)
            .or_else(|| line_of_file(&location.file, location.line))
            .unwrap_or_default();
        Box::new(Diagnostic {
            about: None,
            code,
            message: message.into(),
            file: location.file.clone(),
            line: location.line,
            column: location.column,
            length: location.length,
            help: Some(help.into()),
            source_line: source_line.into(),
        })
    }
}

/// Reads a line of a program file again, for a message.
fn line_of_file(file: &str, line: u32) -> Option<String> {
    line_of(&Source::read(std::path::Path::new(file)).ok()?, line)
}

/// Text of a line of a program, from 1.
pub(crate) fn line_of(source: &Source, line: u32) -> Option<String> {
    let mut at = Mark::START;
    while let Some((text, next)) = source.line(at) {
        if at.line == line {
            return Some(text.to_owned());
        }
        at = next;
    }
    None
}
