//! How far joints leave the straight motion between the ends of a piece.
//!
//! A piece says where the tool is. Bodies of the machine are carried by single joints, and a tip
//! that runs straight under tool center point control takes its joints along curves: with a table
//! that turns by a degree under a tip 200 mm off its axis, slides leave their chord by 8 um, and a
//! slide may go out and come back within one piece. The check of bodies follows the joints
//! straight, so it must know
//! ```text
//!   e_j >= | q_j(s) - (a_j + l(s) (b_j - a_j)) |      for every s of the piece, one l in 0..1 for all joints
//! ```
//!
//! Then the bodies are, at every s, no nearer than at l less the sum of what each `e_j` moves them. Any l
//! will do; the foot of the point on the chord is taken, radians counted at a length. The ways of the joints
//! are smooth between the places of a path, so that the deviation is looked for at the quarters, as that of
//! the tool is (`pieces.rs`), and at the places within.

use proveout_machine::{JointValues, MAX_JOINTS, Machine};

use crate::output::FinerMotion;

/// Length at which a radian counts as a way, mm: about the reach of a table or head.
const RADIAN_MM: f64 = 200.0;
/// Surcharge on a deviation measured at the quarters. A cubic error passes them by 3 percent; joints at a
/// corner that is rounded within the piece bend more at one end. Chosen, not derived.
const BETWEEN: f64 = 1.2;
/// What a deviation is told larger for the rounding of places in single precision: a part of it, and mm or
/// radian.
const SINGLE: [f64; 2] = [1e-5, 1e-10];

/// Of what the joints leave a piece by, so much may be a bend at one end of it that the middles of its
/// quarters do not show.
const AT_ONE_END: f64 = 1.0 / 32.0;
/// A straighter motion than this needs no places within, mm; radians count at [`RADIAN_MM`].
const STRAIGHT_MM: f64 = 2e-4;

/// The places of a piece at its quarters, where its joints leave the straight way; `at` gives the joints at a
/// part of it.
pub(crate) fn finer(
    machine: &Machine,
    [from, to]: [&JointValues; 2],
    quarters: [&JointValues; 3],
    whole: &JointValues,
    at: impl Fn(f64) -> JointValues,
) -> Option<FinerMotion> {
    let length = |j: usize| if machine.joints[j].is_rotary() { RADIAN_MM } else { 1.0 };
    if (0..machine.joints.len().min(MAX_JOINTS)).all(|j| whole[j] * length(j) <= STRAIGHT_MM) {
        return None;
    }
    let places = [from, quarters[0], quarters[1], quarters[2], to];
    let mut worst = *whole * AT_ONE_END;
    for (k, ends) in places.windows(2).enumerate() {
        let mut part = Straightness::new(machine, ends[0], ends[1]);
        part.look(&at((k as f64 + 0.5) / 4.0));
        worst = worst.zip_map(part.bound() + *whole * AT_ONE_END, f64::max);
    }
    // Rounding of what is kept in single precision.
    let told = |x: f64| x as f32;
    let beside = [0, 1, 2].map(|k| {
        let straight = from.interpolated(*to, 0.25 * (k + 1) as f64);
        std::array::from_fn(|j| told(quarters[k][j] - straight[j]))
    });
    Some(FinerMotion {
        beside,
        joint_deviation: std::array::from_fn(|j| told(worst[j] * (1.0 + SINGLE[0]) + SINGLE[1])),
    })
}

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
