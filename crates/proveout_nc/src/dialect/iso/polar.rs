//! `@` and `^` of a `LinuxCNC`: the end of a motion in the XY plane by radius and angle about the work origin
//! (*G-code overview*, "Polar coordinates"; `find_ends` of its interpreter).

use super::pending::Pending;
use super::run_state::Interpreter;
use crate::AxisValues;
use crate::codes;
use crate::diagnostic::{Fault, Span};
use crate::frame;

/// Bits of X and Y.
const PLANE: u16 = 0b011;

impl Interpreter {
    /// Takes `@` and `^` into the end of a motion; a value that is not written stays. Under G91 both are
    /// increments.
    pub(crate) fn polar_words(&mut self, p: &mut Pending, end: &mut AxisValues, span: Span) -> Result<u16, Fault> {
        let [radius, angle] = p.take_polar();
        if p.axes() & PLANE != 0 {
            return Err(Fault::new(codes::CONFLICT, span, "X or Y together with a polar radius or angle")
                .help("write the point with X and Y, or with @ and ^"));
        }
        let radius = radius.map(|radius| radius * self.modal.unit());
        let absolute = !self.modal.incremental;
        let (radius, angle_deg) = if let (true, Some(radius), Some(angle)) = (absolute, radius, angle) {
            (radius, angle)
        } else {
            let (Some(x), Some(y)) = (end.get(0), end.get(1)) else {
                return Err(Fault::new(codes::POSITION_UNKNOWN, span, "the polar coordinates before are not known")
                    .help("write both @ and ^ under G90 first"));
            };
            if x == 0.0 && y == 0.0 && (!absolute || angle.is_none()) {
                return Err(Fault::new(codes::BAD_VALUE, span, "the polar angle at the origin is not defined")
                    .help("write both @ and ^ under G90"));
            }
            let (now_radius, now_angle) = (x.hypot(y), y.atan2(x).to_degrees());
            if absolute {
                (radius.unwrap_or(now_radius), angle.unwrap_or(now_angle))
            } else {
                (now_radius + radius.unwrap_or(0.0), now_angle + angle.unwrap_or(0.0))
            }
        };
        let (s, c) = frame::sin_cos_degrees(angle_deg);
        end.put(0, radius * c);
        end.put(1, radius * s);
        Ok(PLANE)
    }
}
