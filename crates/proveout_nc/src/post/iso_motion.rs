//! Motions of the ISO post.

use std::f64::consts::TAU;
use std::io::Write;

use super::Unpostable;
use super::format::{along_axis, radius_word};
use super::iso::{CoordinateFrame, IsoPost};
use crate::settings::Dialect;
use crate::{AXIS_LETTERS, ArcMotion, Feed, Motion, ProbeMotion, SplineMotion, ThreadMotion};

/// Tool axes nearer than this are the same.
const SAME_AXIS: f64 = 1e-9;
/// Heights nearer than this are one, mm: the curve is in its plane.
const LEVEL_MM: f64 = 1e-6;

impl<W: Write> IsoPost<W> {
    /// The coordinate of an axis as it is written.
    fn value(&self, motion: &Motion, axis: usize) -> Option<f64> {
        if motion.machine_coordinates || self.way == CoordinateFrame::AsProgrammed {
            return motion.end.get(axis);
        }
        let base = motion.end_base.get(axis)?;
        let settable = &self.frames.settable;
        let shift = match axis {
            0..3 => settable.translation[axis],
            3..6 => settable.rotary[axis - 3],
            _ => 0.0,
        };
        Some(base - shift)
    }

    fn vector_of(&self, motion: &Motion) -> Option<[f64; 3]> {
        if self.way == CoordinateFrame::Flat { motion.tool_axis_base } else { motion.tool_axis }
    }

    /// Axes that a motion must name.
    fn wanted(&self, motion: &Motion) -> u16 {
        // In a turned frame every base axis may move when one is programmed.
        let turned = if self.way == CoordinateFrame::Flat && motion.programmed & 0b111 != 0 { 0b111 } else { 0 };
        let all = if motion.programmed == 0 && motion.tool_axis.is_none() { 0x1ff } else { 0 };
        motion.programmed | turned | all
    }

    /// Coordinates of a motion, `forced` axes also where they have not changed.
    fn coordinates(&mut self, motion: &Motion, forced: u16, words: &mut Vec<String>) -> Result<(), Unpostable> {
        super::must_be_known(motion, |axis| self.value(motion, axis))?;
        let wanted = self.wanted(motion) | forced;
        let first = words.len();
        let mut kept = None;
        for (axis, letter) in AXIS_LETTERS.iter().enumerate() {
            let Some(value) = self.value(motion, axis).filter(|_| wanted >> axis & 1 == 1) else { continue };
            let text = self.out.axis(axis, value);
            let same = self.out.settings.modal
                && !motion.machine_coordinates
                && forced >> axis & 1 == 0
                && self.written[axis].as_deref() == Some(&text);
            if same {
                kept.get_or_insert_with(|| format!("{letter}{text}"));
            } else {
                words.push(format!("{letter}{text}"));
            }
            if motion.machine_coordinates {
                (self.written[axis], self.at[axis]) = (None, None);
            } else {
                // What the control takes is the rounded value.
                let unit = if (3..6).contains(&axis) {
                    1f64.to_radians()
                } else if self.out.settings.inches {
                    25.4
                } else {
                    1.0
                };
                self.at[axis] = text.parse::<f64>().ok().map(|v| v * unit);
                self.written[axis] = Some(text);
            }
        }
        // A motion to where the tool is must still be one.
        if words.len() == first
            && let Some(word) = kept
        {
            words.push(word);
        }
        Ok(())
    }

    fn inverse_time(&self, words: &mut Vec<String>) {
        if let Some(Feed::InverseTime(seconds)) = self.feed {
            words.push(format!("F{}", self.out.above_zero(60.0 / seconds, 6)));
        }
    }

    pub(crate) fn straight(&mut self, word: &'static str, motion: &Motion) -> Result<(), Unpostable> {
        let vector = self.vector_of(motion);
        let turned = vector.filter(|v| self.axis.is_none_or(|a| (0..3).any(|i| (a[i] - v[i]).abs() > SAME_AXIS)));
        if !motion.machine_coordinates {
            self.tell_tool_center(vector.is_some())?;
        }
        if vector.is_some() && !self.tcp {
            return Err(Unpostable::new("a tool vector without tool center point control", "switch it on before"));
        }
        let mut words = Vec::new();
        if motion.machine_coordinates {
            if word != "G0" && self.dialect != Dialect::LinuxCnc {
                return Err(Unpostable::new("a feed motion in machine coordinates", "write it as a rapid motion"));
            }
            words.push("G53".to_owned());
        }
        if motion.exact_stop {
            if self.dialect == Dialect::LinuxCnc {
                return Err(Unpostable::new("an exact stop of one block", "write G61 and G64 round it"));
            }
            words.push("G9".to_owned());
        }
        if self.word != Some(word) || !self.out.settings.modal || motion.machine_coordinates {
            self.word = Some(word);
            words.push(word.to_owned());
        }
        let vector_words = turned.is_some() || vector.is_some() && !self.out.settings.modal;
        self.coordinates(motion, 0, &mut words)?;
        if let Some(v) = vector.filter(|_| vector_words) {
            for (letter, component) in ['I', 'J', 'K'].into_iter().zip(v) {
                words.push(format!("{letter}{}", self.out.vector(component)));
            }
            self.axis = Some(v);
        }
        if word != "G0" {
            self.inverse_time(&mut words);
        }
        self.out.block(&words.join(" "))
    }

    /// Center, normal and radius in the coordinates that are written.
    fn circle(&self, arc: &ArcMotion) -> ([f64; 3], [f64; 3]) {
        if self.way == CoordinateFrame::AsProgrammed {
            return (arc.center, arc.normal);
        }
        (std::array::from_fn(|i| arc.center_base[i] - self.frames.settable.translation[i]), arc.normal_base)
    }

    pub(crate) fn arc(&mut self, arc: &ArcMotion, turns: u32) -> Result<(), Unpostable> {
        let (center, normal) = self.circle(arc);
        let Some((axis, sense)) = along_axis(normal) else {
            return Err(Unpostable::new(
                "a circle outside of the planes G17, G18, G19",
                "post it for siemens-840d or apt, or write it as short straight blocks",
            ));
        };
        let vector = self.vector_of(&arc.motion);
        if let (Some(v), Some(a)) = (vector, self.axis)
            && (0..3).any(|i| (a[i] - v[i]).abs() > SAME_AXIS)
        {
            return Err(Unpostable::new(
                "an arc on which the tool axis turns",
                "post it for siemens-840d, or write it as short straight blocks",
            ));
        }
        self.tell_tool_center(vector.is_some())?;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let plane_axes = 1u16 << u | 1 << v;
        let (Some(start_u), Some(start_v)) = (self.at[u], self.at[v]) else {
            return Err(Unpostable::new(
                "an arc whose start has not been written",
                "program X, Y and Z before the arc",
            ));
        };
        let mut end = arc.motion.clone();
        for i in 0..3 {
            if let Some(value) = self.value(&arc.motion, i) {
                end.end.put(i, value);
            }
        }
        let falls_together = [u, v].iter().all(|&i| {
            let text = end.end.get(i).map(|value| self.out.axis(i, value));
            text.is_some() && text == self.written[i]
        });
        let within = arc.sweep - f64::from(turns) * TAU;
        if falls_together && within < TAU / 2.0 && turns == 0 {
            // Shorter than the last decimal: as an arc it would come back as a full circle.
            return self.straight("G1", &arc.motion);
        }
        let mut center = center;
        if turns == 0 && self.dialect != Dialect::LinuxCnc {
            let unit = if self.out.settings.inches { 25.4 } else { 1.0 };
            let as_read = |text: String| text.parse::<f64>().unwrap_or_default() * unit;
            let ends = [u, v].map(|i| end.end.get(i).map_or(0.0, |value| as_read(self.out.axis(i, value))));
            let from = [start_u, start_v];
            let about = [0, 1].map(|i| from[i] + as_read(self.out.center(center[[u, v][i]] - from[i])));
            if super::format::radii_apart(from, ends, about) {
                if super::format::is_flat(from, ends, arc) {
                    return self.straight("G1", &arc.motion);
                }
                let fitted = super::format::between(from, ends, about);
                (center[u], center[v]) = (fitted[0], fitted[1]);
            }
        }
        let word = if sense > 0.0 { "G3" } else { "G2" };
        let mut head = Vec::new();
        if self.plane != axis {
            self.plane = axis;
            head.push(format!("G{}", 19 - axis));
        }
        let split = turns > 0 && self.dialect != Dialect::LinuxCnc;
        let way = self.way;
        if split {
            // Controls without a word for turns get one block a turn, each with its part of the height.
            let (Some(from), Some(to)) = (self.at[axis], end.end.get(axis)) else {
                return Err(Unpostable::new(
                    "a helix whose start has not been written",
                    "program X, Y and Z before it",
                ));
            };
            let (cu, cv) = (start_u, start_v);
            for turn in 1..=turns {
                let mut part = end.clone();
                part.programmed |= 0b111;
                part.end.put(u, cu);
                part.end.put(v, cv);
                part.end.put(axis, from + (to - from) * f64::from(turn) * TAU / arc.sweep);
                self.way = CoordinateFrame::AsProgrammed;
                let result = self.arc_block(&part, word, &mut head, center, axis, plane_axes, None);
                self.way = way;
                result?;
            }
        }
        let turn_word = (turns > 0 && !split).then(|| format!("P{}", turns + 1));
        let radius = radius_word(arc, &self.out.settings).filter(|_| !falls_together);
        if let Some(radius) = radius {
            return self.radius_block(&arc.motion, word, &mut head, radius, plane_axes);
        }
        self.way = CoordinateFrame::AsProgrammed;
        let mut last = end;
        last.programmed = self.wanted(&arc.motion);
        if way == CoordinateFrame::Flat && arc.motion.programmed & 0b111 != 0 {
            last.programmed |= 0b111;
        }
        let result = self.arc_block(&last, word, &mut head, center, axis, plane_axes, turn_word);
        self.way = way;
        result
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one arc")]
    fn arc_block(
        &mut self,
        motion: &Motion,
        word: &'static str,
        head: &mut Vec<String>,
        center: [f64; 3],
        axis: usize,
        plane_axes: u16,
        turns: Option<String>,
    ) -> Result<(), Unpostable> {
        // The center counts from the start as the control has it, with its rounding.
        let start = [0, 1, 2].map(|i| self.at[i].unwrap_or(0.0));
        let mut words = std::mem::take(head);
        if self.word != Some(word) || !self.out.settings.modal {
            self.word = Some(word);
            words.push(word.to_owned());
        }
        self.coordinates(motion, plane_axes, &mut words)?;
        for (i, letter) in ['I', 'J', 'K'].into_iter().enumerate().filter(|(i, _)| *i != axis) {
            words.push(format!("{letter}{}", self.out.center(center[i] - start[i])));
        }
        words.extend(turns);
        self.inverse_time(&mut words);
        self.out.block(&words.join(" "))
    }

    fn radius_block(
        &mut self,
        motion: &Motion,
        word: &'static str,
        head: &mut Vec<String>,
        radius: f64,
        plane_axes: u16,
    ) -> Result<(), Unpostable> {
        let mut words = std::mem::take(head);
        if self.word != Some(word) || !self.out.settings.modal {
            self.word = Some(word);
            words.push(word.to_owned());
        }
        self.coordinates(motion, plane_axes, &mut words)?;
        words.push(format!("R{}", self.out.center(radius)));
        self.inverse_time(&mut words);
        self.out.block(&words.join(" "))
    }

    /// G5 of `LinuxCNC`: a cubic in the XY plane.
    pub(crate) fn spline(&mut self, spline: &SplineMotion) -> Result<(), Unpostable> {
        let flat = |z: f64| self.at[2].is_some_and(|at| (z - at).abs() < LEVEL_MM);
        let end = spline.motion.end.xyz();
        let (Some(x), Some(y), Some(end), true) = (self.at[0], self.at[1], end, self.dialect == Dialect::LinuxCnc)
        else {
            return Err(Unpostable::new(
                "a Bezier curve",
                "post it for linuxcnc, or write it as short straight blocks",
            ));
        };
        let level = flat(end[2]) && spline.control.iter().all(|p| flat(p[2]));
        if self.way != CoordinateFrame::AsProgrammed || self.plane != 2 || !level {
            return Err(Unpostable::new("a Bezier curve outside of the XY plane", "write it as short straight blocks"));
        }
        let [a, b] = spline.control;
        let (i, j) = (self.out.center(a[0] - x), self.out.center(a[1] - y));
        self.word = Some("G5");
        let mut words = vec!["G5".to_owned()];
        self.coordinates(&spline.motion, 0b11, &mut words)?;
        let (p, q) = (self.out.center(b[0] - end[0]), self.out.center(b[1] - end[1]));
        words.push(format!("I{i} J{j} P{p} Q{q}"));
        self.inverse_time(&mut words);
        self.out.block(&words.join(" "))
    }

    pub(crate) fn probe(&mut self, probe: &ProbeMotion) -> Result<(), Unpostable> {
        let word = match (self.dialect, probe.away, probe.must_switch) {
            (Dialect::LinuxCnc, false, true) => "G38.2",
            (Dialect::LinuxCnc, false, false) => "G38.3",
            (Dialect::LinuxCnc, true, true) => "G38.4",
            (Dialect::LinuxCnc, true, false) => "G38.5",
            (_, false, _) => "G31",
            _ => return Err(Unpostable::new("probing away from the surface", "post it for linuxcnc")),
        };
        self.word = None;
        let mut words = vec![word.to_owned()];
        self.coordinates(&probe.motion, probe.motion.programmed, &mut words)?;
        let result = self.out.block(&words.join(" "));
        // The probe stops where it meets the part.
        self.forget();
        result
    }

    /// G33. A tapping cycle turns the spindle round at the bottom, which G33 does not say.
    pub(crate) fn thread(&mut self, thread: &ThreadMotion) -> Result<(), Unpostable> {
        if thread.direction.is_some() {
            return Err(Unpostable::new(
                "rigid tapping motion by motion",
                "post it for siemens-840d, or write the tapping cycle (G84) by hand",
            ));
        }
        if self.dialect == Dialect::Haas {
            return Err(Unpostable::new(
                "a motion coupled to the spindle: a Haas mill has no G33",
                "post it for fanuc or linuxcnc, or write the tapping cycle (G84) by hand",
            ));
        }
        self.word = None;
        let mut words = vec!["G33".to_owned()];
        self.coordinates(&thread.motion, thread.motion.programmed, &mut words)?;
        let letter = if self.dialect == Dialect::LinuxCnc { 'K' } else { 'F' };
        words.push(format!("{letter}{}", self.out.center(thread.pitch)));
        self.out.block(&words.join(" "))
    }
}
