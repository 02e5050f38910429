//! Datum, mirror, rotation, scale: the transforms from work to base coordinates.
//!
//! ```text
//! base = preset (247) * transforms before tilting * tilted plane * transforms in the plane
//!        [* PLANE RELATIVE * ...] * work
//! ```
//!
//! HEIDENHAIN, *TNC 620 User's Manual 2022*, "Reference systems": the workpiece system W-CS is
//! referenced to the preset. Datum shift and mirroring before tilting, and PLANE, lead from W-CS to
//! the working plane system WPL-CS; cycles 7, 8, 10, 11, 26 and PLANE RELATIVE lead from there to
//! the input system I-CS; "the result of transformations built up on each other depends on the
//! programming sequence". So each system keeps a list in the order of the program. A cycle that is
//! defined again replaces its value at its place in the list, a reset removes it, and a new one
//! acts within those before it.

use super::run_state::Interpreter;
use super::words::{Coordinate, Words};
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame::Frame;
use crate::{Offset, Op, Settings, WorkOffset};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Transform {
    Shift,
    Mirror,
    Rotation,
    Scale,
    AxisScale,
}

/// A transform with the numbers it was made of: an increment starts from them.
#[derive(Clone, Copy, Debug)]
struct DatumTransform {
    kind: Transform,
    values: [f64; 6],
    frame: Frame,
}

/// A tilt and the transforms within it.
#[derive(Clone, Debug)]
struct Zone {
    tilt: Frame,
    list: Vec<DatumTransform>,
}

/// All transforms of the control.
#[derive(Clone, Debug)]
pub(crate) struct DatumFrames {
    preset: Frame,
    /// Line of the first motion of a linear axis before a preset is called, if the active preset is
    /// not stated.
    before_preset: Option<u32>,
    /// The position of the preset that is active at the start is not known.
    untold: bool,
    /// The first zone has no tilt.
    zones: Vec<Zone>,
}

/// Most PLANE RELATIVE blocks on top of each other.
const MAX_ZONES: usize = 100;

impl DatumFrames {
    pub(crate) fn new(settings: &Settings) -> Self {
        // Row 0 of the preset table is set by the operator.
        let told = settings.work_offsets.get("PRESET0").copied();
        let (preset, untold) = (told.unwrap_or_default(), told.is_none());
        Self {
            preset: Frame::from(preset),
            before_preset: None,
            untold,
            zones: vec![Zone { tilt: Frame::IDENTITY, list: Vec::new() }],
        }
    }

    pub(crate) fn total(&self) -> Frame {
        self.zones.iter().fold(self.preset, |frame, zone| {
            zone.list.iter().fold(frame.then(&zone.tilt), |frame, entry| frame.then(&entry.frame))
        })
    }

    /// A tilted plane is in force.
    pub(crate) fn tilted(&self) -> bool {
        self.zones.len() > 1
    }

    /// Ends the tilted plane. Transforms programmed in it stay in force.
    pub(crate) fn untilt(&mut self) {
        let later: Vec<DatumTransform> = self.zones.drain(1..).flat_map(|zone| zone.list).collect();
        if let Some(first) = self.zones.first_mut() {
            for entry in later {
                put(&mut first.list, entry);
            }
        }
    }

    /// A new plane on the datum, or (`relative`) on top of the plane in force.
    pub(crate) fn tilt(&mut self, tilt: Frame, relative: bool) -> bool {
        if !relative {
            self.zones.truncate(1);
        }
        self.zones.push(Zone { tilt, list: Vec::new() });
        self.zones.len() <= MAX_ZONES
    }

    fn values(&self, kind: Transform) -> Option<[f64; 6]> {
        self.zones.last()?.list.iter().find(|entry| entry.kind == kind).map(|entry| entry.values)
    }

    fn set(&mut self, entry: DatumTransform) {
        if let Some(zone) = self.zones.last_mut() {
            put(&mut zone.list, entry);
        }
    }
}

fn put(list: &mut Vec<DatumTransform>, entry: DatumTransform) {
    let at = list.iter().position(|old| old.kind == entry.kind);
    match (at, entry.frame == Frame::IDENTITY) {
        (Some(at), true) => {
            list.remove(at);
        }
        (Some(at), false) => list[at] = entry,
        (None, true) => {}
        (None, false) => list.push(entry),
    }
}

impl Interpreter {
    /// Puts the transforms into effect and emits the resulting frame.
    pub(crate) fn take_frames(&mut self, word: &str, span: Span) -> Result<(), Fault> {
        let total = self.modal.frames.total();
        let finite = total.translation.iter().chain(total.linear.iter().flatten()).all(|v| v.is_finite());
        if !finite || !self.position.set_frame(total) {
            return Err(Fault::new(codes::BAD_VALUE, span, "the transformation is degenerate").help("check its values"));
        }
        self.modal.tangent = None;
        self.tell_frame(word);
        Ok(())
    }

    fn define(&mut self, kind: Transform, values: [f64; 6], frame: Frame, word: &str, span: Span) -> Result<(), Fault> {
        self.modal.frames.set(DatumTransform { kind, values, frame });
        self.take_frames(word, span)
    }

    /// A motion in coordinates of the program.
    pub(crate) fn moves_in_preset(&mut self, programmed: u16) {
        if self.modal.frames.untold && programmed & 0b111 != 0 {
            self.modal.frames.before_preset.get_or_insert(self.location.line);
        }
    }

    /// CYCL DEF 247: a row of the preset table; transforms of the program end.
    pub(crate) fn preset(&mut self, row: f64, span: Span) -> Result<(), Fault> {
        if !(0.0..=9999.0).contains(&row) || row.fract() != 0.0 {
            return Err(Fault::new(codes::BAD_VALUE, span, format!("the row of the preset table is {row}"))
                .help("write Q339=1"));
        }
        let word = format!("PRESET{row}");
        self.modal.frames.untold = false;
        // Without such a call the scene has its zero at that of the machine, and all of the program agrees
        // with it.
        if let Some(line) = self.modal.frames.before_preset.take() {
            self.assume(format!(
                "line {line} moves before a preset is called, from the one that is active when the program begins: it is read from the zero of \
                 the machine; PRESET0 of the work offsets states it"
            ));
        }
        let offset = self.settings.work_offsets.get(&word).copied().unwrap_or_default();
        self.modal.frames.preset = Frame::from(offset);
        self.emit(Op::Offset(Offset::Work { word: word.clone() }));
        // Activating a preset resets datum shift, mirror, rotation and scale.
        for zone in &mut self.modal.frames.zones {
            zone.list.clear();
        }
        self.take_frames(&word, span)
    }

    /// A row of the datum table: `CYCL DEF 7.1 #5`, G53 P01 5.
    pub(crate) fn datum_row(&mut self, row: f64, span: Span) -> Result<(), Fault> {
        let word = format!("DATUM{row}");
        let Some(offset) = self.settings.work_offsets.get(&word).copied() else {
            return Err(super::lexer::refused(
                &format!("datum {row} of the datum table"),
                span,
                &format!("give it with --offset {word}=X,Y,Z, or write the values into the cycle"),
            ));
        };
        let mut values = [0.0; 6];
        values[..3].copy_from_slice(&offset.translation);
        values[3..].copy_from_slice(&offset.rotary);
        self.emit(Op::Offset(Offset::Work { word: word.clone() }));
        self.define(Transform::Shift, values, Frame::from(offset), &word, span)
    }

    /// Datum shift by the axes of the words; axes that are not written keep their shift.
    pub(crate) fn shift(&mut self, w: &Words, word: &str, span: Span) -> Result<(), Fault> {
        if w.programmed >> 6 != 0 {
            return Err(super::lexer::refused("a shift of U, V, W", span, "shift X, Y, Z, A, B, C"));
        }
        let mut values = self.modal.frames.values(Transform::Shift).unwrap_or_default();
        for (axis, c) in w.axes.iter().enumerate().take(6) {
            let Some(c) = c else { continue };
            let value = self.coordinate(axis, self.variables.value(c.value, span)?);
            values[axis] = if self.is_incremental(c.reference) { values[axis] + value } else { value };
        }
        self.shift_to(values, word, span)
    }

    pub(crate) fn shift_to(&mut self, values: [f64; 6], word: &str, span: Span) -> Result<(), Fault> {
        let frame = Frame::from(WorkOffset {
            translation: [values[0], values[1], values[2]],
            rotary: [values[3], values[4], values[5]],
        });
        self.define(Transform::Shift, values, frame, word, span)
    }

    /// Mirrors the axes in the bit mask; an empty mask ends the mirror.
    pub(crate) fn mirror(&mut self, axes: u16, word: &str, span: Span) -> Result<(), Fault> {
        if axes >> 3 != 0 {
            return Err(super::lexer::refused("a mirror of rotary axes", span, "mirror X, Y, Z"));
        }
        let factors: [f64; 3] = std::array::from_fn(|i| if axes >> i & 1 == 1 { -1.0 } else { 1.0 });
        self.define(Transform::Mirror, [0.0; 6], Frame::scale(factors), word, span)
    }

    /// Rotation of the working plane, degrees.
    pub(crate) fn rotation(&mut self, angle: Coordinate, word: &str, span: Span) -> Result<(), Fault> {
        let mut degrees = self.variables.value(angle.value, span)?;
        if self.is_incremental(angle.reference) {
            degrees += self.modal.frames.values(Transform::Rotation).map_or(0.0, |v| v[0]);
        }
        let frame = if degrees == 0.0 { Frame::IDENTITY } else { Frame::rotation(self.modal.normal, degrees) };
        self.define(Transform::Rotation, [degrees, 0.0, 0.0, 0.0, 0.0, 0.0], frame, word, span)
    }

    /// Scale of all axes, or of each about a center.
    pub(crate) fn scale(
        &mut self,
        factors: [f64; 3],
        center: [f64; 3],
        per_axis: bool,
        word: &str,
        span: Span,
    ) -> Result<(), Fault> {
        if factors.iter().any(|&f| !(f > 0.0 && f.is_finite())) {
            return Err(
                Fault::new(codes::BAD_VALUE, span, "a scale factor must be above zero").help("mirror with cycle 8")
            );
        }
        let scale = Frame::scale(factors);
        let frame = Frame::translation(center).then(&scale).then(&Frame::translation(center.map(|c| -c)));
        let frame = if factors == [1.0; 3] { Frame::IDENTITY } else { frame };
        self.define(if per_axis { Transform::AxisScale } else { Transform::Scale }, [0.0; 6], frame, word, span)
    }
}
