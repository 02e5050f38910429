//! Blocks along a cubic Bezier curve.

use proveout_geom::Vector;
use proveout_machine::JointValues;
use proveout_nc::SplineMotion;

use super::{BlockPath, Context, Position, ProgrammedMotion, TipWay, linear_part};
use crate::{
    error::ControlError,
    shape::{Bezier, BlockShape},
};

impl Context<'_> {
    /// Path of a cubic Bezier curve: of the tip with tool center point control, else of the linear joints.
    pub(crate) fn spline(&self, spline: &SplineMotion, position: &Position) -> Result<BlockPath, Box<ControlError>> {
        let motion = &spline.motion;
        let inner = spline.control_base.map(Vector::from);
        if inner.iter().any(|p| !p.iter().all(|v| v.is_finite())) {
            let message = format!("the control points {inner:?} are not numbers");
            return Err(self.fail("control-not-a-number", message, "check the expressions of this block"));
        }
        let tcp = self.mapping.tcp_length.zip(self.rig);
        let (from, to, slots, shift, end, turned) = match tcp {
            Some((length, rig)) => {
                let (from, to, turned) = self.end_with_tcp(motion, position, rig, length)?;
                let end = self.joints(rig, &to, length);
                (from, to, rig.slots, rig.zero, end, turned)
            }
            None => {
                let (end, turned) = self.end_in_joints(motion, position)?;
                (position.q, end, self.letter_slots("a spline")?, self.length_offset(), end, turned)
            }
        };
        let at = |q: &JointValues| Vector::new(q[slots[0]], q[slots[1]], q[slots[2]]);
        let control = [at(&from), inner[0] + shift, inner[1] + shift, at(&to)];
        let polygon: f64 = control.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
        if polygon <= super::NO_TIP_MM {
            return self.straight(motion, position);
        }
        let curve = Bezier::new(slots, control, from, to).map_err(|t| {
            let place = control_point(&control, t);
            let message = format!(
                "the spline has a cusp near ({:.4}, {:.4}, {:.4}), where its direction is not defined",
                place.x, place.y, place.z
            );
            let help = "split the curve there, or keep the inner control points apart from the ends";
            self.fail("control-spline", message, help)
        })?;
        let length = curve.length();
        let shape = BlockShape::Bezier(Box::new(curve));
        let start = position.told.filter(|_| tcp.is_some()).map_or(control[0], |pose| pose.tip.coords);
        let way = TipWay::bezier([start, control[1], control[2], control[3]]);
        let mut path = BlockPath::whole(shape.clone(), length, true, end);
        (path.unreachable, path.other_position) = (turned.unreachable, turned.other_position);
        let Some((tool, rig)) = tcp else {
            path.programmed = Some(Box::new(ProgrammedMotion::joints(from, to, Some((slots, way)))));
            return Ok(path);
        };
        let tip = |t: f64| linear_part(rig, &shape.jet(t * length), length);
        path = self.oriented(path, motion, rig, (tool, [&from, &to]), &tip, Some(length));
        path.programmed = self.told(motion, position, tool, &to, (way, path.apart));
        Ok(path)
    }
}

fn control_point(c: &[Vector; 4], t: f64) -> Vector {
    let r = 1.0 - t;
    c[0] * (r * r * r) + c[1] * (3.0 * r * r * t) + c[2] * (3.0 * r * t * t) + c[3] * (t * t * t)
}
