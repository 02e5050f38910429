//! A piece of a motion in the coordinates of one ray set.

use proveout_geom::{Aabb, Point, ToolPose};

use crate::{
    kernels::meridian::Meridian,
    kernels::vec3::{V, add, along, dot, norm, scale, sub},
    sweep_item::SweepMotion,
};

/// Bound of the part of the error that turning adds, mm.
pub(crate) const TURN_ERROR: f64 = 2.5e-4;
/// Bound of the part of the error that ends the search for a maximum, mm.
pub(crate) const SEARCH_ERROR: f64 = 1.5e-4;
/// Largest turn of a piece, radian: keeps the approximation of the great circle below 1e-5 mm on a 100 mm
/// tool.
const PIECE_TURN: f64 = 0.02;
/// Largest turn of a piece for a ball, radian: keeps the chord of the axis a direction.
const BALL_TURN: f64 = 0.5;
/// Pieces of one motion at most: memory of a senseless motion stays bounded.
const MOST_PIECES: f64 = 1e5;
/// Turns below this (radian) do not move any point of a 1 m tool by 1e-9 mm.
const NO_TURN: f64 = 1e-12;
/// Nearer to the axis of a body than this, no direction leads away from it, mm.
pub(crate) const ON_AXIS: f64 = 1e-12;
/// Part of an axis along a direction below which it lies across it.
const LEVEL: f64 = 1e-9;

/// Straight tip, axis on a short great circle; tau runs from 0 to 1. Components in the order (ray, u, v).
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionPiece {
    pub tip: V,
    /// Tip at the end less tip at the start, mm.
    pub travel: V,
    pub axis: V,
    /// Axis at the end less axis at the start.
    pub turn: V,
    /// Square of the angle of turn.
    pub angle2: f64,
}

/// Value and derivatives of the body's function at a point of a ray and a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodySample {
    pub f: f64,
    /// Derivative along the ray.
    pub fs: f64,
    /// Derivative with tau.
    pub ft: f64,
    /// Gradient: outward normal of the body.
    pub normal: V,
}

impl MotionPiece {
    pub(crate) fn turns(&self) -> bool {
        self.angle2 > 0.0
    }

    #[inline]
    pub(crate) fn tip_at(&self, tau: f64) -> V {
        along(self.tip, self.travel, tau)
    }

    /// Axis at tau. The chord of the great circle is lengthened to unit length:
    /// |a + tau (b - a)|^2 = 1 - tau (1 - tau) |b - a|^2. Its direction lags the uniform turn by at
    /// most angle^3 / 60 (see [`Self::lag`]).
    #[inline]
    pub(crate) fn axis_at(&self, tau: f64) -> V {
        if self.angle2 == 0.0 {
            return self.axis;
        }
        let x = tau * (1.0 - tau) * self.angle2;
        scale(along(self.axis, self.turn, tau), 1.0 + x * (0.5 + 0.375 * x))
    }

    /// Part `k` of `n` equal parts of the piece.
    pub(crate) fn part(&self, k: usize, n: usize) -> Self {
        let (first, last) = (k as f64 / n as f64, (k + 1) as f64 / n as f64);
        let axis = self.axis_at(first);
        let turn = sub(self.axis_at(last), axis);
        Self {
            tip: self.tip_at(first),
            travel: scale(self.travel, 1.0 / n as f64),
            axis,
            turn,
            angle2: if self.turns() { dot(turn, turn) } else { 0.0 },
        }
    }

    /// Point of the axis at height `z` above the tip.
    #[inline]
    pub(crate) fn on_axis(&self, z: f64, tau: f64) -> V {
        along(self.tip_at(tau), self.axis_at(tau), z)
    }

    /// Height along the ray of the point of the body's axis that is nearest to `x` at mid-time: where to look
    /// first.
    #[inline]
    pub(crate) fn facing(&self, body: &Meridian, x: V) -> f64 {
        let z = dot(sub(x, self.tip_at(0.5)), self.axis);
        self.on_axis(z.clamp(body.rest_z, body.z[1].max(body.rest_z)), 0.5)[0]
    }

    /// The body's function at the point `x` of space and its derivatives.
    ///
    /// With y = x - tip, z = y . w, p = y - z w, r = |p|: the gradient is `F_r p / r + F_z w`, and for a
    /// fixed point dz/dtau = -travel . w + p . w', dr/dtau = -(p/r) . travel - z (p/r) . w'.
    #[inline]
    pub(crate) fn sample(&self, body: &Meridian, x: V, tau: f64) -> BodySample {
        let w = self.axis_at(tau);
        let y = sub(x, self.tip_at(tau));
        let z = dot(y, w);
        let p = along(y, w, -z);
        let r = norm(p);
        let (f, fr, fz) = body.eval(r, z);
        let radial = if r > ON_AXIS { fr / r } else { 0.0 };
        let normal = add(scale(p, radial), scale(w, fz));
        let mut ft = -dot(normal, self.travel);
        if self.angle2 > 0.0 {
            ft += dot(p, self.turn) * (fz - radial * z);
        }
        BodySample { f, fs: normal[0], ft, normal }
    }

    /// Largest lag of a point at the distance `reach` from the tip relative to the uniform turn,
    /// mm. With the half angle h and x = 2 tau - 1 the chord points to atan(x tan h) instead of x
    /// h; the difference is h^3 (x - x^3) / 3 and less than 0.129 h^3 = angle^3 / 62.
    pub(crate) fn lag(&self, reach: f64) -> f64 {
        self.angle2 * self.angle2.sqrt() * reach / 60.0
    }

    /// Bound of the second derivative of the path of a body point at distance `reach` from the tip, in the
    /// frame of the body, mm: |omega|^2 reach + 2 |omega| |travel|.
    pub(crate) fn bend(&self, reach: f64) -> f64 {
        self.angle2 * reach + 2.0 * self.angle2.sqrt() * norm(self.travel)
    }
}

/// Splits a motion into pieces of small turn. A motion that only translates stays whole; one that turns also
/// stays short against the body, so that a piece meets few tiles.
pub(crate) fn pieces(motion: &SweepMotion, radius: f64) -> Vec<MotionPiece> {
    let angle = motion.from.angle_to(&motion.to);
    if angle <= NO_TURN {
        return split(motion, 1.0);
    }
    let travel = (motion.to.tip - motion.from.tip).norm();
    split(motion, (angle / PIECE_TURN).max(travel / radius.max(2.0)))
}

/// Splits a motion for a ball whose center lies at height `z` on the axis: only the path of the center
/// counts, which leaves its chord by angle^2 z / 8.
pub(crate) fn ball_pieces(motion: &SweepMotion, z: f64) -> Vec<MotionPiece> {
    let angle = motion.from.angle_to(&motion.to);
    split(motion, (angle * (z.abs() / (8.0 * TURN_ERROR)).sqrt()).max(angle / BALL_TURN))
}

fn split(motion: &SweepMotion, least: f64) -> Vec<MotionPiece> {
    let finite = |p: &ToolPose| p.tip.iter().chain(p.axis.iter()).all(|v| v.is_finite());
    if !(finite(&motion.from) && finite(&motion.to)) {
        return Vec::new();
    }
    let n = least.ceil().clamp(1.0, MOST_PIECES) as usize;
    let mut poses = (0..=n).map(|k| match k {
        0 => motion.from,
        k if k == n => motion.to,
        k => motion.from.interpolated(&motion.to, k as f64 / n as f64),
    });
    let Some(mut from) = poses.next() else { return Vec::new() };
    poses
        .map(|to| {
            let piece = piece(&from, &to);
            from = to;
            piece
        })
        .collect()
}

fn piece(from: &ToolPose, to: &ToolPose) -> MotionPiece {
    let angle = from.angle_to(to);
    // Opposite axes have no great circle between them; the axis then stays.
    let turns = angle > NO_TURN && angle < 1.0;
    MotionPiece {
        tip: from.tip.coords.into(),
        travel: (to.tip - from.tip).into(),
        axis: from.axis.into(),
        turn: if turns { (to.axis - from.axis).into() } else { [0.0; 3] },
        angle2: if turns { (to.axis - from.axis).norm_squared() } else { 0.0 },
    }
}

/// The piece in coordinates (ray, u, v) of set `a`.
pub(crate) fn permuted(p: &MotionPiece, a: usize) -> MotionPiece {
    let turn = |v: V| [v[a], v[(a + 1) % 3], v[(a + 2) % 3]];
    MotionPiece { tip: turn(p.tip), travel: turn(p.travel), axis: turn(p.axis), turn: turn(p.turn), angle2: p.angle2 }
}

/// Whether a body stays beyond one side of a box on all of its way: the first look at a motion, most of them
/// in air.
pub(crate) fn stays_outside(motion: &SweepMotion, body: &Meridian, bounds: &Aabb) -> bool {
    let ends = [motion.from, motion.to];
    let chord2 = (motion.to.axis - motion.from.axis).norm_squared();
    // A turn by the angle w lifts a point off the chord of its way by reach w^2 / 8 at most; w <= pi / 2
    // chord.
    let margin = body.radius + body.reach * chord2 * (std::f64::consts::FRAC_PI_2.powi(2) / 8.0);
    (0..3).any(|i| {
        let [a, b] = ends.map(|e| {
            let (low, high) = (body.z[0] * e.axis[i], body.z[1] * e.axis[i]);
            [e.tip[i] + low.min(high), e.tip[i] + low.max(high)]
        });
        a[0].min(b[0]) - margin > bounds.max[i] || a[1].max(b[1]) + margin < bounds.min[i]
    })
}

/// Box round the part of the body above `Meridian::rest_z` that may come into `bounds` on one piece of its
/// way, mm. Between the ends of a piece a point leaves its chord by at most the bend / 8.
///
/// ```text
///        \   \          a tilting tool: only its heights from a to b come into the stock
///     b - \   \
///     ____ \   \ ____
///         | \__/ |
///     a - |      |
/// ```
pub(crate) fn swept_box(p: &MotionPiece, body: &Meridian, bounds: &Aabb) -> Aabb {
    let ends = [0.0, 1.0].map(|tau| {
        let axis = p.axis_at(tau);
        // A disc of radius R about the axis w reaches R sqrt(1 - w_i^2) along axis i.
        (p.tip_at(tau), axis, axis.map(|w| body.radius * (1.0 - w * w).max(0.0).sqrt()))
    });
    let bend = p.bend(body.reach) / 8.0;
    let (mut low, mut high) = (body.rest_z, body.z[1]);
    for i in 0..3 {
        for (side, face) in [(1.0, bounds.max[i]), (-1.0, bounds.min[i])] {
            // Heights that stay beyond this face at both ends of the piece, and so on all of it, are none of
            // this box's business.
            let (mut from, mut to) = (low, high);
            for (tip, axis, half) in &ends {
                // Beyond: side (tip + z axis) - half > side face + bend.
                let (room, slope) = (side * (tip[i] - face) - half[i] - bend, side * axis[i]);
                if slope.abs() < LEVEL {
                    if room - high.abs().max(low.abs()) * LEVEL <= 0.0 {
                        to = f64::NEG_INFINITY;
                    }
                } else if slope > 0.0 {
                    from = from.max(-room / slope);
                } else {
                    to = to.min(-room / slope);
                }
            }
            if from > low && to >= high {
                high = high.min(from);
            } else if to < high && from <= low {
                low = low.max(to);
            } else if from <= low && to >= high {
                return Aabb::empty();
            }
        }
    }
    if low > high {
        return Aabb::empty();
    }
    let mut all = Aabb::empty();
    for (tip, axis, half) in &ends {
        for z in [low, high] {
            let c = along(*tip, *axis, z);
            all.grow(&Point::from(sub(c, *half)));
            all.grow(&Point::from(add(c, *half)));
        }
    }
    all.expanded(bend)
}

/// Box round the ball of a body on one piece of its way, mm.
pub(crate) fn ball_box(p: &MotionPiece, body: &Meridian) -> Aabb {
    let mut all = Aabb::empty();
    if let Some([z, radius]) = body.ball {
        for tau in [0.0, 1.0] {
            all.grow(&Point::from(p.on_axis(z, tau)));
        }
        all = all.expanded(radius);
    }
    all
}
