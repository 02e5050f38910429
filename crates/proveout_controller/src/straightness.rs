//! How far joints leave the straight motion between the ends of a piece.
//!
//! A piece says where the tool is; bodies of the machine hang on single joints, and a tip that runs straight under tool center point control
//! takes its joints along curves: with a table that turns by a degree under a tip 200 mm off its axis, slides leave their chord by 8
//! micrometers, and a slide may go out and come back within one piece. The check of bodies follows the joints straight, so it must know
//!
//! ```text
//!   e_j >= | q_j(s) - (a_j + l(s) (b_j - a_j)) |      for every s of the piece, one l in 0..1 for all joints
//! ```
//!
//! Then the bodies are, at every s, no nearer than at l less the sum of what each `e_j` moves them. Any l will do; the foot of the point on
//! the chord is taken, radians counted at a length. The ways of the joints are smooth between the places of a path, so that the
//! deviation is looked for at the quarters, as that of the tool is (`pieces.rs`), and at the places within.

use proveout_machine::{JointValues, MAX_JOINTS, Machine};

/// Length at which a radian counts as a way, mm: about the reach of a table or head.
const RADIAN_MM: f64 = 200.0;
/// Surcharge on a deviation measured at the quarters. A cubic error passes them by 3 percent; joints at a corner that is rounded within the
/// piece bend more at one end. Chosen, not derived.
const BETWEEN: f64 = 1.2;

/// The largest deviation so far, joint by joint.
pub(crate) struct Straightness {
    from: JointValues,
    way: JointValues,
    /// The way with each joint counted as a length, over the square of its length; zero where nothing moves.
    along: JointValues,
    worst: JointValues,
}

impl Straightness {
    pub(crate) fn new(machine: &Machine, from: &JointValues, to: &JointValues) -> Self {
        let way = *to - *from;
        let mut along = way;
        let mut square = 0.0;
        for (j, joint) in machine.joints.iter().enumerate().take(MAX_JOINTS) {
            let scale = if joint.is_rotary() { RADIAN_MM * RADIAN_MM } else { 1.0 };
            along[j] *= scale;
            square += along[j] * way[j];
        }
        let along = if square > 0.0 { along * (1.0 / square) } else { JointValues::ZERO };
        Self { from: *from, way, along, worst: JointValues::ZERO }
    }

    /// Takes a position on the way.
    pub(crate) fn look(&mut self, q: &JointValues) {
        let off = *q - self.from;
        let part = (0..MAX_JOINTS).map(|j| off[j] * self.along[j]).sum::<f64>().clamp(0.0, 1.0);
        for j in 0..MAX_JOINTS {
            self.worst[j] = self.worst[j].max((off[j] - self.way[j] * part).abs());
        }
    }

    /// What no joint exceeds.
    pub(crate) fn bound(&self) -> JointValues {
        self.worst * BETWEEN
    }
}
