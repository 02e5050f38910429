//! Where the coordinates of a program begin on the table.
//!
//! Without tool center point control a program moves axes: base coordinates (those of `G54` and the like)
//! are positions of X, Y and Z, less the tool length. With it, base coordinates are those of a point that
//! is fixed to the table. A work offset is stored once in the control and used in both cases, so both must
//! mean the same point where they can be compared: with all rotary joints at zero. There
//!
//! ```text
//!    tip_in_table = z + X e_x + Y e_y + Z e_z     z: the tip of a tool of zero length, all joints at zero
//! ```
//!
//! and base coordinates with tool center point control are `tip_in_table - z`, fixed to the table from there
//! on. On a machine whose axes read the place of the gauge line (zero at the table) z is the origin of the
//! table frame and nothing is subtracted. On a machine whose axes are zero at home, z is the gauge line at
//! home.
//!
//! It needs that X, Y and Z move the tool along x, y and z of the table frame. Where one of them does not (a
//! table axis whose value counts the motion of the table, a slanted slide), axes and table coordinates are
//! two things, no offset can mean the same in both, and there is no such point.

use proveout_geom::{Point, Vector};

use crate::{JointValues, Machine};

/// The largest difference between the motion of X, Y or Z by one millimeter and the unit vector, mm: rounding
/// of directions that a file gives with nine digits.
const ALONG_AXIS: f64 = 1e-9;

impl Machine {
    /// The point of the table frame K at which base coordinates of a program are zero, mm, in machine
    /// coordinates and with tool center point control alike: the gauge line's center with all joints at
    /// zero, held ones at home. `None` if X, Y and Z are not joints that move the tool along x, y and z of
    /// K.
    pub fn program_zero(&self) -> Option<Point> {
        let mut q = JointValues::ZERO;
        for (value, joint) in q.0.iter_mut().zip(&self.joints) {
            if joint.held {
                *value = joint.home;
            }
        }
        let zero = self.forward(&q, 0.0).tip;
        for (letter, along) in [('X', Vector::x()), ('Y', Vector::y()), ('Z', Vector::z())] {
            let joint = self.joint_for_letter(letter)?;
            if self.joints[joint].held {
                return None;
            }
            let mut moved = q;
            moved[joint] = 1.0;
            if (self.forward(&moved, 0.0).tip - zero - along).norm() > ALONG_AXIS {
                return None;
            }
        }
        Some(zero)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn read(name: &str) -> Machine {
        Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name))
            .expect("library machine")
    }

    #[test]
    fn axes_that_read_the_gauge_line_begin_at_the_table_frame() {
        for name in
            ["spinner-u5-620", "ac-trunnion-620", "bc-trunnion", "fork-head-gantry", "starrag-lx-451", "jdgr200t"]
        {
            // Exactly, so that nothing is added to the coordinates of their programs.
            assert_eq!(read(name).program_zero(), Some(Point::origin()), "{name}");
        }
        assert_eq!(read("pocket-nc-v2").program_zero(), Some(Point::new(0.0, 0.0, 130.0)));
    }

    #[test]
    fn slides_that_count_the_motion_of_the_table_have_no_common_zero() {
        for name in ["lu-serial-i", "lu-hybrid-ii"] {
            assert_eq!(read(name).program_zero(), None, "{name}");
        }
    }
}
