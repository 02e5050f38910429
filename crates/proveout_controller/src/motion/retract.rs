//! Retraction along the tool axis.

use super::{BlockPath, Context, Position, ProgrammedMotion};
use crate::error::ControlError;

/// Ways of the tip below this (mm) are none.
const NO_WAY_MM: f64 = 1e-9;

impl Context<'_> {
    /// Path of a retraction from the workpiece along the tool axis, the rotary joints held: by a way in mm,
    /// or as far as the travels of the joints go.
    pub(crate) fn retract(&self, distance: Option<f64>, position: &Position) -> Result<BlockPath, Box<ControlError>> {
        let refuse = |message: String, help: &str| self.fail("control-retract", message, help);
        let Some(rig) = self.rig else {
            let message = format!(
                "a retraction along the tool axis on machine {}, which does not have exactly three free, independent \
                 linear joints",
                self.machine.name
            );
            return Err(refuse(message, "program the retracted position of each axis"));
        };
        let length = self.mapping.tcp_length.unwrap_or(self.mapping.tool_length);
        let axis = self.machine.forward(&position.q, length).axis;
        let from = rig.task(self.machine, &position.q, length);
        let lifted = |way: f64| {
            let mut task = from;
            for (k, &slot) in rig.slots.iter().enumerate() {
                task[slot] += axis[k] * way;
            }
            task
        };
        // With the rotary joints held, the linear joints run in proportion to the way.
        let per_mm = self.joints(rig, &lifted(1.0), length) - position.q;
        let way = match distance {
            Some(d) if d.is_finite() && d >= 0.0 => d,
            Some(d) => return Err(refuse(format!("a retraction by {d} mm"), "program a way above zero")),
            None => {
                let mut most = f64::INFINITY;
                for (i, joint) in self.machine.joints.iter().enumerate() {
                    let Some([low, high]) = joint.travel.filter(|_| per_mm[i].abs() > NO_WAY_MM) else { continue };
                    let end = if per_mm[i] > 0.0 { high } else { low };
                    most = most.min((end - position.q[i]) / per_mm[i]);
                }
                if most.is_infinite() {
                    let message = format!(
                        "a retraction to the end of travel, but machine {} states no travel in this direction",
                        self.machine.name
                    );
                    return Err(refuse(message, "state the travels of the linear joints in the machine description"));
                }
                most.max(0.0)
            }
        };
        let to = lifted(way);
        let end = self.joints(rig, &to, length);
        let tcp = self.mapping.tcp_length.is_some();
        let mut path = if tcp { self.line(from, to, end) } else { self.line(position.q, end, end) };
        path.programmed = Some(Box::new(ProgrammedMotion::joints(position.q, end, None)));
        Ok(path)
    }
}
