//! Points, tool axis and coordinate systems.

use super::reader::{AptReader, arity};
use super::statement::{AptStatement, Bad, LineRange};
use crate::codes;
use crate::frame::{self, Frame};
use crate::source::Source;
use crate::{AxisValues, Motion, Op, OrientationInterpolation, Tcp};

/// How far the length of a programmed tool axis may be from one: CL data has six digits.
const AXIS_LENGTH: f64 = 1e-3;

impl AptReader {
    /// Point and tool axis of a statement, mm.
    pub(crate) fn pose(&mut self, source: &Source, st: &AptStatement) -> Result<[f64; 3], Box<Bad>> {
        let mut n = [0.0; 6];
        let count = self.numbers(source, st, &mut n)?;
        match count {
            3 => {}
            6 => {
                let axis = [n[3], n[4], n[5]];
                let length = frame::norm(axis);
                if (length - 1.0).abs() > AXIS_LENGTH {
                    let place = st.items.get(3).map_or(st.head, |item| item.place);
                    let message = format!("the tool axis {} {} {} has the length {length:.4}", n[3], n[4], n[5]);
                    return Err(place.bad(
                        codes::ORIENTATION,
                        message,
                        "write a unit vector from the tip to the holder, one point in a statement",
                    ));
                }
                self.set_axis(frame::unit(axis).unwrap_or([0.0, 0.0, 1.0]));
            }
            count => return Err(arity(st.head, &st.major, count, "x, y, z or x, y, z, i, j, k")),
        }
        Ok([n[0], n[1], n[2]].map(|v| v * self.own.unit))
    }

    /// Takes a tool axis; a vector switches tool center point control on.
    pub(crate) fn set_axis(&mut self, axis: [f64; 3]) {
        self.own.axis = axis;
        self.tcp_on();
    }

    pub(crate) fn tcp_on(&mut self) {
        if !self.own.tcp {
            self.own.tcp = true;
            self.emit(Op::Tcp(Tcp { on: true, interpolation: OrientationInterpolation::GreatCircle }));
        }
    }

    pub(crate) fn goto(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        self.take_path_tool();
        let point = self.pose(source, st)?;
        self.go_to(point, st.head)
    }

    pub(crate) fn godlta(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        self.take_path_tool();
        let mut n = [0.0; 3];
        let step = match self.numbers(source, st, &mut n)? {
            1 => self.own.axis.map(|v| v * n[0]),
            3 => n,
            count => return Err(arity(st.head, "GODLTA", count, "one value (along the tool axis) or three")),
        };
        let from = self.here(st.head)?;
        self.go_to(frame::add_scaled(from, step, self.own.unit), st.head)
    }

    /// The programmed position.
    pub(crate) fn here(&self, place: LineRange) -> Result<[f64; 3], Box<Bad>> {
        self.position.work.xyz().ok_or_else(|| {
            place.bad(codes::POSITION_UNKNOWN, "no point was programmed before", "begin with FROM or GOTO")
        })
    }

    /// Moves to a point as the statements before have asked: along a circle, through a cycle, or
    /// straight.
    pub(crate) fn go_to(&mut self, point: [f64; 3], place: LineRange) -> Result<(), Box<Bad>> {
        if let Some(circle) = self.own.circle.take() {
            return self.go_circle(&circle, point, place);
        }
        let rapid = std::mem::take(&mut self.own.rapid);
        if self.own.cycle_on {
            return self.hole(point, place);
        }
        self.straight(point, rapid);
        Ok(())
    }

    pub(crate) fn straight(&mut self, point: [f64; 3], rapid: bool) {
        if !rapid {
            self.need_feed();
        }
        let motion = self.motion(point);
        self.go(motion, rapid);
    }

    /// The motion to a point with the tool axis in effect.
    pub(crate) fn motion(&self, point: [f64; 3]) -> Motion {
        let (mut end, mut end_base) = (AxisValues::NONE, AxisValues::NONE);
        let base = self.position.point_in_base(point);
        for axis in 0..3 {
            end.put(axis, point[axis] + 0.0);
            end_base.put(axis, base[axis] + 0.0);
        }
        Motion {
            end,
            end_base,
            tool_axis: self.own.tcp.then_some(self.own.axis),
            tool_axis_base: if self.own.tcp {
                frame::unit(self.position.frame().apply_vector(self.own.axis))
            } else {
                None
            },
            programmed: 0b111,
            ..Motion::default()
        }
    }

    /// FROM and HOME: the tool is at a point (FROM), and GOHOME goes there.
    pub(crate) fn from(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let before = (self.own.axis, self.own.tcp);
        let point = self.pose(source, st)?;
        self.own.home = Some((point, self.own.axis));
        if st.major == "HOME" {
            self.own.axis = before.0;
        } else {
            let motion = self.motion(point);
            self.position.move_to(motion.end, motion.end_base);
        }
        self.note(format!("{}/{}, {}, {}", st.major, point[0], point[1], point[2]));
        Ok(())
    }

    /// To the point of FROM or HOME; without one to the reference point of the machine.
    pub(crate) fn go_home(&mut self, st: &AptStatement) -> Result<(), Box<Bad>> {
        let Some((point, axis)) = self.own.home else { return self.go_to_reference(st) };
        self.take_path_tool();
        self.own.rapid = false;
        self.own.axis = axis;
        self.straight(point, true);
        Ok(())
    }

    fn go_to_reference(&mut self, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut end = [0.0; 3];
        match self.settings.reference_points.clone() {
            Some(points) => {
                for (axis, value) in end.iter_mut().enumerate() {
                    *value = Self::stated_reference(&points, false, axis, "GOHOME", st.head.span)
                        .map_err(|fault| st.head.with(fault))?;
                }
            }
            None => self.note("GOHOME: no machine is known, and its reference point is taken as machine zero"),
        }
        self.assume("GOHOME without FROM and HOME goes to the reference point of the machine, Z first, then X and Y");
        self.take_path_tool();
        self.own.rapid = false;
        for axes in [&[2usize][..], &[0, 1]] {
            let mut to = AxisValues::NONE;
            for &axis in axes {
                to.put(axis, end[axis]);
            }
            let programmed = axes.iter().fold(0, |bits, axis| bits | 1 << axis);
            self.position.moved_in_machine(&to, programmed, self.own.tcp);
            self.go_in_machine(to, programmed, true, false);
        }
        Ok(())
    }

    pub(crate) fn multax(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        match st.items.first().map(|i| Self::word(source, i)).as_deref() {
            None | Some("ON") => self.tcp_on(),
            Some("OFF") => {
                // Tool center point control stays on, so that the tool turns back to the axis it now has.
                self.own.axis = [0.0, 0.0, 1.0];
                self.note("MULTAX/OFF: the tool axis is 0, 0, 1");
            }
            Some(other) => {
                let message = format!("`MULTAX/{other}` is not supported");
                return Err(st.head.bad(codes::UNSUPPORTED_WORD, message, "write MULTAX/ON or MULTAX/OFF"));
            }
        }
        Ok(())
    }

    /// TLAXIS/i,j,k: the tool axis of points without a vector.
    pub(crate) fn tool_axis_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 3];
        let count = self.numbers(source, st, &mut n)?;
        if count != 3 {
            return Err(arity(st.head, "TLAXIS", count, "i, j, k"));
        }
        let Some(axis) = frame::unit(n) else {
            return Err(st.head.bad(
                codes::ORIENTATION,
                "the tool axis has no length",
                "give the direction from the tip to the holder",
            ));
        };
        if axis != [0.0, 0.0, 1.0] || self.own.tcp {
            self.set_axis(axis);
        } else {
            self.note("TLAXIS/0, 0, 1");
        }
        Ok(())
    }

    /// MSYS/origin, x axis, y axis: the coordinate system of an NX operation. The first one is that
    /// of the program; later ones are relative to it.
    pub(crate) fn msys(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 9];
        let count = self.numbers(source, st, &mut n)?;
        if count != 9 {
            return Err(arity(st.head, "MSYS", count, "the origin, the x axis and the y axis, nine values"));
        }
        let (x, y) = ([n[3], n[4], n[5]], [n[6], n[7], n[8]]);
        let square = frame::dot(x, y).abs() < AXIS_LENGTH;
        let axes = frame::unit(x).zip(frame::unit(frame::cross(x, y))).filter(|_| square);
        let Some((x, z)) = axes else {
            return Err(st.head.bad(
                codes::BAD_VALUE,
                "the axes of MSYS are not square to each other",
                "give unit vectors of x and y",
            ));
        };
        let y = frame::cross(z, x);
        let frame = Frame {
            linear: std::array::from_fn(|row| [x[row], y[row], z[row]]),
            translation: [n[0], n[1], n[2]].map(|v| v * self.own.unit),
            rotary: [0.0; 3],
        };
        let first = *self.own.first_msys.get_or_insert(frame);
        let turned = first.linear;
        let back = Frame { linear: std::array::from_fn(|r| std::array::from_fn(|c| turned[c][r])), ..Frame::IDENTITY };
        let shift = back.apply(frame::sub(frame.translation, first.translation));
        let local = if frame == first {
            Frame::IDENTITY
        } else {
            Frame { translation: shift, ..back.then(&Frame { translation: [0.0; 3], ..frame }) }
        };
        if local == self.own.local {
            self.note("MSYS");
            return Ok(());
        }
        self.own.local = local;
        self.own.axis = [0.0, 0.0, 1.0];
        if local.is_rotated() {
            self.tcp_on();
        }
        self.take_frame("MSYS");
        Ok(())
    }

    /// ORIGIN, TRANS.
    pub(crate) fn shift_statement(&mut self, source: &Source, st: &AptStatement) -> Result<(), Box<Bad>> {
        let mut n = [0.0; 9];
        let count = self.numbers(source, st, &mut n)?;
        if st.major == "ORIGIN" {
            let plain = n[..3] == [0.0; 3] && (count == 3 || n[3..] == [1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
            if (count == 3 || count == 9) && plain {
                self.note("ORIGIN/0, 0, 0");
                return Ok(());
            }
            return Err(st.head.bad(
                codes::UNSUPPORTED_WORD,
                "`ORIGIN` away from 0, 0, 0 is not supported",
                "give the coordinates from the zero point of the work offset, or shift them with TRANS",
            ));
        }
        if count != 3 {
            return Err(arity(st.head, "TRANS", count, "x, y, z"));
        }
        self.own.shift = [n[0], n[1], n[2]].map(|v| v * self.own.unit);
        self.take_frame("TRANS");
        Ok(())
    }
}
