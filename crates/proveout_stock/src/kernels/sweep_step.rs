//! One step of a motion against boxes of rays: which it cannot meet.

use crate::{
    kernels::lane_ball::BallPath,
    kernels::meridian::Meridian,
    kernels::motion::MotionPiece,
    kernels::vec3::{V, along, dot, norm, sub},
};

/// The arc of a turn is longer than its chord by less, mm.
const LONGER_MM: f64 = 1e-3;

/// The ball or the rest of a body on one piece of motion, in the coordinates (ray, u, v) of one set.
#[derive(Clone, Debug)]
pub(crate) struct SweepStep {
    pub piece: MotionPiece,
    /// Given for the ball.
    pub ball: Option<BallPath>,
    /// Box of what moves, mm.
    pub low: V,
    pub high: V,
    /// The item, in `Batch::ready`.
    pub item: u32,
    /// Tip and axis at mid-time, the heights between which the body lies, and how far from that piece of axis
    /// any of its points comes at any time, mm.
    middle: [V; 2],
    heights: [f64; 2],
    round: f64,
    /// What the turn takes at most, at any time, from a half space of mid-time: for each millimeter from
    /// where it was taken, for each from the tip, and everywhere, mm.
    sway: f64,
    bow: f64,
    drift: f64,
}

impl SweepStep {
    pub(crate) fn new(
        piece: MotionPiece,
        ball: Option<BallPath>,
        [low, high]: [V; 2],
        item: u32,
        body: &Meridian,
    ) -> Self {
        let middle = [piece.tip_at(0.5), piece.axis_at(0.5)];
        let half_way = 0.5 * (norm(piece.travel) + piece.angle2.sqrt() * body.reach) + LONGER_MM;
        // (1) of `ray_turn` half of the motion away from the sample, with room for the uneven pace of the
        // turn.
        let (angle, way) = (piece.angle2.sqrt(), norm(piece.travel));
        let sway = 0.505 * angle;
        let bow = angle * angle * (0.13 + 0.2 * angle);
        let drift = angle * way * (0.26 + 0.07 * angle);
        let round = body.radius + half_way;
        Self { piece, ball, low, high, item, middle, heights: body.z, round, sway, bow, drift }
    }

    /// Part `k` of `n` of the motion.
    pub(crate) fn part(&self, k: usize, n: usize) -> Self {
        Self { piece: self.piece.part(k, n), ..self.clone() }
    }

    /// Whether the body stays away from a box, judged by its piece of axis.
    #[inline]
    pub(crate) fn passes(&self, s: [f64; 2], u: [f64; 2], v: [f64; 2]) -> bool {
        let [tip, axis] = self.middle;
        let half = [0.5 * (s[1] - s[0]), 0.5 * (u[1] - u[0]), 0.5 * (v[1] - v[0])];
        let from_tip = sub([s[0] + half[0], u[0] + half[1], v[0] + half[2]], tip);
        let z = dot(from_tip, axis).clamp(self.heights[0], self.heights[1].max(self.heights[0]));
        let away = along(from_tip, axis, -z);
        let near = self.round + norm(half);
        dot(away, away) > near * near
    }

    /// Whether the body stays away from a box, by the half space that its function has at the middle of the
    /// box at mid-time.
    ///
    /// F is convex with a unit gradient: F at the middle less the extent of the box along the normal bounds F
    /// in the box at mid-time. At other times it is less by half of `F_tau` at most, and by what turning
    /// adds: see (1) of `ray_turn`, whose second and third derivatives grow with the distance of the point
    /// from the tip.
    #[inline]
    pub(crate) fn clears(&self, body: &Meridian, s: [f64; 2], u: [f64; 2], v: [f64; 2]) -> bool {
        let half = [0.5 * (s[1] - s[0]), 0.5 * (u[1] - u[0]), 0.5 * (v[1] - v[0])];
        let x = [s[0] + half[0], u[0] + half[1], v[0] + half[2]];
        let at = self.piece.sample(body, x, 0.5);
        let across = dot(at.normal.map(f64::abs), half);
        let (far, from_tip) = (norm(half), sub(x, self.middle[0]).map(f64::abs));
        let turned = self.sway * far + self.bow * (from_tip[0] + from_tip[1] + from_tip[2] + far) + self.drift;
        at.f - across - 0.5 * at.ft.abs() - turned > 0.0
    }
}
