//! Where the tool is, as far as the program says, in work and in base coordinates.

use crate::AxisValues;
use crate::frame::Frame;

/// Bits of X, Y and Z.
const LINEAR: u16 = 0b111;

/// Programmed position under an active frame.
///
/// An axis has no value where the program has not set it: at the start, after motions in machine
/// coordinates, and where the meaning of coordinates changed (five-axis transformation, tool edge,
/// tool change).
#[derive(Clone, Debug)]
pub(crate) struct Position {
    frame: Frame,
    /// Inverse of the linear part of the frame.
    inverse: [[f64; 3]; 3],
    /// The linear part is the identity: the common case, and the cheap one.
    straight: bool,
    pub(crate) work: AxisValues,
    pub(crate) base: AxisValues,
}

/// The base coordinate that depends on a programmed axis and on one without a value: letters of the missing
/// axes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MissingAxes(pub(crate) String);

impl Position {
    pub(crate) fn new() -> Self {
        Self {
            frame: Frame::IDENTITY,
            inverse: Frame::IDENTITY.linear,
            straight: true,
            work: AxisValues::NONE,
            base: AxisValues::NONE,
        }
    }

    pub(crate) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Puts a frame into effect: the tool stays, its work coordinates are computed again. False
    /// when the frame is degenerate.
    pub(crate) fn set_frame(&mut self, frame: Frame) -> bool {
        let Some(inverse) = frame.inverse_linear() else {
            return false;
        };
        if frame == self.frame {
            return true;
        }
        self.frame = frame;
        self.inverse = inverse;
        self.straight = !frame.is_rotated();
        self.work_from_base();
        true
    }

    fn work_from_base(&mut self) {
        for row in 0..3 {
            let mut sum = 0.0;
            let mut known = true;
            for column in 0..3 {
                let factor = self.inverse[row][column];
                if factor != 0.0 {
                    match self.base.get(column) {
                        Some(base) => sum += factor * (base - self.frame.translation[column]),
                        None => known = false,
                    }
                }
            }
            if known { self.work.put(row, sum + 0.0) } else { self.work.clear(row) }
        }
        for axis in 3..6 {
            match self.base.get(axis) {
                Some(base) => self.work.put(axis, base - self.frame.rotary[axis - 3]),
                None => self.work.clear(axis),
            }
        }
    }

    /// Base coordinates of a point of which `programmed` axes are new; axes without a new value keep theirs.
    pub(crate) fn base_of(&self, work: &AxisValues, programmed: u16) -> Result<AxisValues, MissingAxes> {
        let mut base = self.base;
        if programmed & 0b111 != 0 {
            if self.straight {
                for axis in 0..3 {
                    if programmed >> axis & 1 == 1 {
                        base.put(axis, work.get(axis).unwrap_or(0.0) + self.frame.translation[axis]);
                    }
                }
            } else {
                self.turned_base(work, programmed, &mut base)?;
            }
        }
        if programmed >> 3 != 0 {
            for axis in 3..9 {
                if programmed >> axis & 1 == 1 {
                    let offset = if axis < 6 { self.frame.rotary[axis - 3] } else { 0.0 };
                    base.put(axis, work.get(axis).unwrap_or(0.0) + offset);
                }
            }
        }
        Ok(base)
    }

    fn turned_base(&self, work: &AxisValues, programmed: u16, base: &mut AxisValues) -> Result<(), MissingAxes> {
        for row in 0..3 {
            let mut sum = self.frame.translation[row];
            let mut touched = false;
            let mut missing = String::new();
            for column in 0..3 {
                let factor = self.frame.linear[row][column];
                if factor == 0.0 {
                    continue;
                }
                touched |= programmed >> column & 1 == 1;
                match work.get(column) {
                    Some(value) => sum += factor * value,
                    None => missing.push(crate::AXIS_LETTERS[column]),
                }
            }
            if touched {
                if !missing.is_empty() {
                    return Err(MissingAxes(missing));
                }
                base.put(row, sum + 0.0);
            }
        }
        Ok(())
    }

    /// Base coordinates of a motion in a turned frame that leaves a coordinate open, where the axes
    /// without a word stay. First what the motion gives: none of X, Y and Z. Second what is known
    /// after it: those of X, Y and Z that depend on no programmed axis.
    pub(crate) fn base_left_open(&self, work: &AxisValues, programmed: u16) -> (AxisValues, AxisValues) {
        let mut known = self.base_of(work, programmed & !LINEAR).unwrap_or(self.base);
        let mut told = known;
        for row in 0..3 {
            told.clear(row);
            let touched = |column: usize| programmed >> column & 1 == 1 && self.frame.linear[row][column] != 0.0;
            if (0..3).any(touched) {
                known.clear(row);
            }
        }
        (told, known)
    }

    /// Start of an arc in the plane of the first two axes. The third coordinate is not needed
    /// unless the frame mixes it with the others: where the program has not set it, the value is
    /// zero and has no meaning. None where a coordinate that is needed is not known.
    pub(crate) fn arc_start(&self, [u, v, w]: [usize; 3]) -> Option<[f64; 3]> {
        let linear = &self.frame.linear;
        let apart = [linear[u][w], linear[v][w], linear[w][u], linear[w][v]].iter().all(|factor| *factor == 0.0);
        if !apart {
            return self.work.xyz();
        }
        let mut start = [0.0; 3];
        (start[u], start[v], start[w]) = (self.work.get(u)?, self.work.get(v)?, self.work.get(w).unwrap_or(0.0));
        Some(start)
    }

    /// Base coordinates of a point whose X, Y and Z are known.
    pub(crate) fn point_in_base(&self, p: [f64; 3]) -> [f64; 3] {
        self.frame.apply(p)
    }

    /// Puts the tool at this point of the frame in force before the program begins.
    pub(crate) fn begin_at(&mut self, work: &AxisValues) {
        let programmed = (0..9).fold(0, |axes, axis| axes | u16::from(work.get(axis).is_some()) << axis);
        // A turned frame needs all of X, Y and Z; otherwise they stay unknown.
        if let Ok(base) = self.base_of(work, programmed) {
            self.move_to(*work, base);
        }
    }

    /// The tool is at this point now.
    pub(crate) fn move_to(&mut self, work: AxisValues, base: AxisValues) {
        self.work = work;
        self.base = base;
    }

    /// The tool has moved in machine coordinates: these linear axes have no programmed position any
    /// more, these rotary axes are where they were sent.
    ///
    /// `in_table`: base coordinates are those of the table (tool center point control, tilted plane). There
    /// each of the three depends on all axes of the machine, so that a motion of one of them leaves none
    /// known: with B at 90 degrees a retraction in Z moves the tip along X of the table, and the X that the
    /// program has set last is no longer where the tip is.
    pub(crate) fn moved_in_machine(&mut self, end: &AxisValues, programmed: u16, in_table: bool) {
        let lost = if in_table { programmed | LINEAR } else { programmed };
        for axis in (0..3).filter(|axis| lost >> axis & 1 == 1) {
            self.base.clear(axis);
        }
        for axis in 3..9 {
            if programmed >> axis & 1 == 1 {
                match end.get(axis) {
                    Some(value) => self.base.put(axis, value),
                    None => self.base.clear(axis),
                }
                if axis >= 6 {
                    self.work.put(axis, end.get(axis).unwrap_or(0.0));
                }
            }
        }
        self.work_from_base();
    }

    /// After a motion in machine coordinates without tool center point control: these axes, which
    /// carry no tool length, are where the motion has sent them.
    pub(crate) fn stands_in_machine(&mut self, end: &AxisValues, axes: u16) {
        for axis in (0..3).filter(|axis| axes >> axis & 1 == 1) {
            if let Some(value) = end.get(axis) {
                self.base.put(axis, value);
            }
        }
        self.work_from_base();
    }

    /// The positions of these axes (bit mask) are not known any more.
    pub(crate) fn forget(&mut self, axes: u16) {
        for axis in 0..9 {
            if axes >> axis & 1 == 1 {
                self.base.clear(axis);
                self.work.clear(axis);
            }
        }
        self.work_from_base();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(list: &[(usize, f64)]) -> AxisValues {
        let mut values = AxisValues::NONE;
        for &(axis, value) in list {
            values.put(axis, value);
        }
        values
    }

    #[test]
    fn a_turned_axis_needs_only_what_it_depends_on() {
        let mut position = Position::new();
        assert!(position.set_frame(Frame::rotation(1, 90.0)));
        // Base X is work Z, base Z is -work X: programming X alone is enough for base Z.
        let base = position.base_of(&values(&[(0, 31.0)]), 0b001).unwrap();
        assert_eq!(base, values(&[(2, -31.0)]));
        assert!(position.set_frame(Frame::rotation(1, 30.0)));
        assert_eq!(position.base_of(&values(&[(0, 31.0)]), 0b001), Err(MissingAxes("Z".to_owned())));
    }

    #[test]
    fn a_machine_motion_of_one_axis_leaves_no_table_coordinate_known() {
        let mut position = Position::new();
        let work = values(&[(0, 1.0), (1, 2.0), (2, 3.0), (4, 0.5)]);
        position.move_to(work, work);
        let mut tilted = position.clone();
        position.moved_in_machine(&values(&[(2, 650.0)]), 0b100, false);
        assert_eq!((position.base.get(0), position.base.get(2)), (Some(1.0), None));
        tilted.moved_in_machine(&values(&[(2, 650.0)]), 0b100, true);
        assert_eq!(tilted.base, values(&[(4, 0.5)]));
        assert_eq!(tilted.work, tilted.base);
        // A rotary axis alone turns the table under the tool.
        tilted.move_to(work, work);
        tilted.moved_in_machine(&values(&[(4, 0.0)]), 0b10000, true);
        assert_eq!(tilted.base, values(&[(4, 0.0)]));
    }

    #[test]
    fn the_tool_stays_when_the_frame_changes() {
        let mut position = Position::new();
        let work = values(&[(0, 1.0), (1, 2.0), (2, 3.0)]);
        let base = position.base_of(&work, 7).unwrap();
        position.move_to(work, base);
        position.set_frame(Frame::translation([10.0, 0.0, 0.0]).then(&Frame::rotation(2, 90.0)));
        assert_eq!(position.work.xyz(), Some([2.0, 9.0, 3.0]));
        assert_eq!(position.base.xyz(), Some([1.0, 2.0, 3.0]));
    }
}
