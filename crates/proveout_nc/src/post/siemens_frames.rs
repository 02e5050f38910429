//! Frames of the 840D post: TRANS and AROT, swivel planes as CYCLE800.

use std::io::Write;

use super::format::LEAST_COSINE;
use super::siemens::SiemensPost;
use super::{Unpostable, decimal};
use crate::frame::{self, Frame};
use crate::{FrameChange, RotarySolution};

/// Numbers of frames nearer than this are written the same.
const SAME: f64 = 1e-9;

impl<W: Write> SiemensPost<W> {
    /// TRANS, AROT, AMIRROR, ASCALE that make the transform above the work offset; none for a sheared one.
    pub(crate) fn frame_lines(&mut self, change: &FrameChange) -> Result<Vec<String>, Unpostable> {
        let total = Frame { linear: change.rotation, translation: change.translation, rotary: change.rotary };
        let mut lines = Vec::new();
        // A work offset only shifts and a swivel plane only turns and shifts, so what lies above them follows
        // by subtracting and turning back.
        let turn = &self.swivel.linear;
        let back = Frame { linear: std::array::from_fn(|r| std::array::from_fn(|c| turn[c][r])), ..Frame::IDENTITY };
        let shift = frame::sub(frame::sub(total.translation, self.settable.translation), self.swivel.translation);
        let above = Frame {
            linear: back.then(&Frame { translation: [0.0; 3], ..total }).linear,
            translation: back.apply(shift),
            rotary: frame::sub(total.rotary, self.settable.rotary),
        };
        if same(&above, &self.programmable) {
            return Ok(lines);
        }
        let Some((angles, mirrored, factors)) = decompose(&above) else {
            return Err(Unpostable::new("a frame with shear", "use rotations, mirrors and scales"));
        };
        self.programmable = above;
        let a = self.out.settings.angle_decimals;
        let mut trans = format!(
            "TRANS X{} Y{} Z{}",
            self.out.length(above.translation[0]),
            self.out.length(above.translation[1]),
            self.out.length(above.translation[2])
        );
        for (letter, offset) in ['A', 'B', 'C'].into_iter().zip(above.rotary) {
            if offset != 0.0 {
                trans.push_str(&format!(" {letter}{}", decimal(offset.to_degrees(), a)));
            }
        }
        lines.push(trans);
        if angles != [0.0; 3] {
            // A frame turns points far from its origin: it is written finer than an axis.
            let text = angles.map(|v| decimal(v, a + 6));
            lines.push(format!("AROT X{} Y{} Z{}", text[0], text[1], text[2]));
        }
        if mirrored {
            lines.push("AMIRROR X0".to_owned());
        }
        if factors.iter().any(|f| (f - 1.0).abs() > frame::UNIT_SCALE) {
            let text = factors.map(|v| decimal(v, 9));
            lines.push(format!("ASCALE X{} Y{} Z{}", text[0], text[1], text[2]));
        }
        Ok(lines)
    }

    /// Writes the frame that waits.
    pub(crate) fn write_frame(&mut self) -> Result<(), Unpostable> {
        let Some(change) = self.waiting.take() else { return Ok(()) };
        if std::mem::take(&mut self.plane_ends) {
            self.end_swivel()?;
        }
        let lines = self.frame_lines(&change)?;
        lines.iter().try_for_each(|line| self.line(line))
    }

    /// A swivel plane axis by axis about X, Y, Z, with the tool turned upright on it.
    pub(crate) fn cycle800(&mut self, change: &FrameChange, solution: RotarySolution) -> Result<(), Unpostable> {
        let total = Frame { linear: change.rotation, translation: change.translation, rotary: change.rotary };
        let shift = frame::sub(total.translation, self.settable.translation);
        let m = &total.linear;
        let square =
            total.determinant() > 0.0 && total.uniform_scale().is_some_and(|s| (s - 1.0).abs() < frame::UNIT_SCALE);
        if !square {
            return Err(Unpostable::new(
                "a swivel plane with a mirror or a scale",
                "mirror or scale the path in the CAM system",
            ));
        }
        // Rx Ry Rz: the image of e_z is (sy, -sx cy, cx cy).
        let flat = m[1][2].hypot(m[2][2]);
        let y = m[0][2].atan2(flat);
        let (x, z) = if flat > LEAST_COSINE {
            ((-m[1][2]).atan2(m[2][2]), (-m[0][1]).atan2(m[0][0]))
        } else {
            (m[2][1].atan2(m[1][1]), 0.0)
        };
        // A frame turns points far from its origin: it is written finer than an axis.
        let angles = [x, y, z].map(|v| decimal(v.to_degrees(), self.out.settings.angle_decimals + 6));
        let shift = shift.map(|v| self.out.length(v));
        self.swivel =
            Frame { translation: frame::sub(total.translation, self.settable.translation), rotary: [0.0; 3], ..total };
        self.programmable = Frame::IDENTITY;
        self.swiveled = true;
        // The cycle knows no least turn: it goes to the lower or the higher angle.
        let direction = if matches!(solution, RotarySolution::Angle { higher: false, .. }) { -1 } else { 1 };
        self.line(&format!(
            "CYCLE800(0,\"TC1\",0,57,{},{},{},{},{},{},0,0,0,{direction})",
            shift[0], shift[1], shift[2], angles[0], angles[1], angles[2]
        ))
    }

    /// The swivel plane ends, and tool center point control with it.
    pub(crate) fn end_swivel(&mut self) -> Result<(), Unpostable> {
        self.swiveled = false;
        self.swivel = Frame::IDENTITY;
        self.programmable = Frame::IDENTITY;
        self.line("CYCLE800()")
    }
}

/// Frames that do not differ within what is written of them.
fn same(a: &Frame, b: &Frame) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() < SAME;
    a.linear.iter().flatten().zip(b.linear.iter().flatten()).all(|(x, y)| near(*x, *y))
        && a.translation.iter().zip(b.translation).all(|(x, y)| near(*x, y))
        && a.rotary.iter().zip(b.rotary).all(|(x, y)| near(*x, y))
}

/// Linear part as Rz Ry Rx, a mirror of X, and scales: angles in degrees.
fn decompose(frame: &Frame) -> Option<([f64; 3], bool, [f64; 3])> {
    let m = &frame.linear;
    let column = |at: usize| [m[0][at], m[1][at], m[2][at]];
    let factors = [frame::norm(column(0)), frame::norm(column(1)), frame::norm(column(2))];
    let mirrored = frame.determinant() < 0.0;
    let mut unit = [frame::unit(column(0))?, frame::unit(column(1))?, frame::unit(column(2))?];
    if mirrored {
        unit[0] = unit[0].map(|v| -v);
    }
    let square = |a: usize, b: usize| frame::dot(unit[a], unit[b]).abs() < frame::SQUARE;
    if !(square(0, 1) && square(0, 2) && square(1, 2)) {
        return None;
    }
    // R[i][j] is unit[j][i]; the image of e_x of Rz Ry Rx is (cz cy, sz cy, -sy).
    let r = |row: usize, at: usize| unit[at][row];
    let cy = r(0, 0).hypot(r(1, 0));
    let y = (-r(2, 0)).atan2(cy);
    let (x, z) = if cy > LEAST_COSINE {
        (r(2, 1).atan2(r(2, 2)), r(1, 0).atan2(r(0, 0)))
    } else {
        // Y is plus or minus 90 degrees: X and Z turn about the same axis, all goes to Z.
        (0.0, (-r(0, 1)).atan2(r(1, 1)))
    };
    Some(([x, y, z].map(|v| v.to_degrees() + 0.0), mirrored, factors))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decomposition_gives_the_frame_back() {
        for angles in
            [[10.0, 20.0, 30.0], [0.0, 90.0, 40.0], [-170.0, -90.0, 12.0], [180.0, 0.0, -90.0], [0.0, -45.0, 0.0]]
        {
            for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [2.0, 3.0, -4.0]] {
                let frame = Frame::rpy(angles).then(&Frame::scale(scale));
                let (angles, mirrored, factors) = decompose(&frame).unwrap();
                let mirror = Frame::scale([if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0]);
                let again = Frame::rpy(angles).then(&mirror).then(&Frame::scale(factors));
                for (a, b) in again.linear.iter().flatten().zip(frame.linear.iter().flatten()) {
                    assert!((a - b).abs() < 1e-9, "{angles:?} {scale:?}");
                }
            }
        }
    }
}
