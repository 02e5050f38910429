//! Rows of signed polar angles and azimuths, and what is changed in them near the pole.
//!
//! (b, c) and (-b, c + pi) are the same tool axis `(cos c sin b, sin c sin b, cos b)`. A row of blocks may
//! pass the pole by either: b changes its sign and c stays, or b stays and c turns by half a turn.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proveout_geom::Vector;
use schemars::JsonSchema;
use serde::Deserialize;

/// Blocks of a junction: two before, the junction, two after.
pub(super) const JUNCTION: usize = 5;
/// Sine of the angle from the pole below which an axis has no azimuth.
const AT_POLE: f64 = 1e-12;
/// Rounding of a turn, radian.
const ROUNDING: f64 = 1e-12;

/// A tool axis by its angles to and about the pole, radian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleAngles {
    /// Angle to the pole; below zero on the other side of it.
    pub polar: f64,
    /// Angle about the pole.
    pub azimuth: f64,
}

impl PoleAngles {
    /// The tool axis, the pole being z.
    pub fn axis(&self) -> Vector {
        let ((sb, cb), (sc, cc)) = (self.polar.sin_cos(), self.azimuth.sin_cos());
        Vector::new(cc * sb, sc * sb, cb)
    }

    /// The same axis with the other sign of the polar angle.
    #[must_use]
    pub fn other(&self) -> Self {
        Self { polar: -self.polar, azimuth: self.azimuth + PI }
    }

    /// The same axis with a polar angle of zero or above.
    #[must_use]
    pub fn positive(&self) -> Self {
        if self.polar < 0.0 { self.other() } else { *self }
    }
}

/// Angle in (-pi, pi].
fn wrapped(angle: f64) -> f64 {
    let a = angle - TAU * (angle / TAU).round();
    if a <= -PI { a + TAU } else { a }
}

/// The azimuth of an axis with turns added to be nearest to another.
fn near(angle: f64, to: f64) -> f64 {
    to + wrapped(angle - to)
}

/// A row of axes as a control without knowledge of poles runs it: of both signs the one with the least |db| +
/// |dc| (equation (2.4)), at the pole the azimuth before. Equations (2.2) and (2.3), corrected (errata SG-1,
/// SG-2): c = atan2(j, i) and atan2(-j, -i).
pub fn pole_angles(axes: &[Vector], start: PoleAngles) -> Vec<PoleAngles> {
    let mut last = start;
    let mut row = Vec::with_capacity(axes.len());
    for axis in axes {
        let across = axis.x.hypot(axis.y);
        let polar = across.atan2(axis.z);
        let mut now = if across > AT_POLE {
            let up = PoleAngles { polar, azimuth: near(axis.y.atan2(axis.x), last.azimuth) };
            let down = PoleAngles { polar: -polar, azimuth: near((-axis.y).atan2(-axis.x), last.azimuth) };
            let way = |p: &PoleAngles| (p.polar - last.polar).abs() + (p.azimuth - last.azimuth).abs();
            if way(&down) < way(&up) { down } else { up }
        } else {
            PoleAngles { polar, azimuth: last.azimuth }
        };
        if row.is_empty() && (now.polar < 0.0) != (start.polar < 0.0) && across > AT_POLE {
            now = now.other();
            now.azimuth = near(now.azimuth, start.azimuth);
        }
        row.push(now);
        last = now;
    }
    row
}

/// Between head and tail at a part t of the arc length: linear, or through the pole in the middle. Gives the
/// angles and whether the pole is crossed; the description is that of the head with a polar angle above zero.
///
/// Steps 5 to 9 of the paper, corrected (SG-8 to SG-12): the branch is decided once; b is `b_k (1 - 2 t)` and
/// then `-b_n (2 t - 1)`, and c turns by `delta - 180 sgn(delta)` in proportion to t.
pub fn between(head: PoleAngles, tail: PoleAngles, t: f64, switch: f64) -> (PoleAngles, bool) {
    let (head, tail) = (head.positive(), tail.positive());
    let turn = wrapped(tail.azimuth - head.azimuth);
    if turn.abs() <= switch + ROUNDING {
        let angles = PoleAngles { polar: head.polar + (tail.polar - head.polar) * t, azimuth: head.azimuth + turn * t };
        return (angles, false);
    }
    let rest = turn - PI * turn.signum();
    let polar = if t <= 0.5 { head.polar * (1.0 - 2.0 * t) } else { -tail.polar * (2.0 * t - 1.0) };
    (PoleAngles { polar, azimuth: head.azimuth + rest * t }, true)
}

/// How the ends of a stretch near the pole are smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Junction {
    /// Not at all.
    Off,
    /// By the least-squares quadratic through five blocks, as published: a small step stays at its ends.
    #[default]
    Free,
    /// By the one that keeps the first and the last of them.
    Pinned,
}

impl Junction {
    /// Every rule with its name.
    pub const NAMES: [(&'static str, Self); 3] = [("off", Self::Off), ("free", Self::Free), ("pinned", Self::Pinned)];
}

/// The quadratic Bezier curve fitted to five values at parts t of their length (equation (2.6) with three
/// control values, SG-13 to SG-15), at these parts.
pub fn fitted(values: [f64; JUNCTION], t: [f64; JUNCTION], pinned: bool) -> [f64; JUNCTION] {
    let basis = |t: f64| [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
    let control = if pinned {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (v, t) in values.iter().zip(t) {
            let [a, m, b] = basis(t);
            sum += m * (v - a * values[0] - b * values[4]);
            weight += m * m;
        }
        [values[0], sum / weight, values[4]]
    } else {
        let (mut a, mut r) = ([[0.0; 3]; 3], [0.0; 3]);
        for (v, t) in values.iter().zip(t) {
            let b = basis(t);
            for i in 0..3 {
                r[i] += b[i] * v;
                for k in 0..3 {
                    a[i][k] += b[i] * b[k];
                }
            }
        }
        solved(a, r)
    };
    t.map(|t| basis(t).iter().zip(control).map(|(b, x)| b * x).sum())
}

/// Three equations, positive definite: elimination without exchange.
fn solved(mut a: [[f64; 3]; 3], mut r: [f64; 3]) -> [f64; 3] {
    for i in 0..3 {
        for k in i + 1..3 {
            let f = a[k][i] / a[i][i];
            let above = a[i];
            for (entry, over) in a[k].iter_mut().zip(above).skip(i) {
                *entry -= f * over;
            }
            r[k] -= f * r[i];
        }
    }
    let mut x = [0.0; 3];
    for i in (0..3).rev() {
        let known: f64 = (i + 1..3).map(|k| a[i][k] * x[k]).sum();
        x[i] = (r[i] - known) / a[i][i];
    }
    x
}

/// What is done near the pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rules {
    pub(super) cone: f64,
    pub(super) rate: f64,
    pub(super) junction: Junction,
    /// The polar angle may change its sign.
    pub(super) crossing: bool,
}

/// A stretch that was treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoleStretch {
    /// The block before the first one inside of the cone; the first block of the row where it begins inside.
    pub head: usize,
    /// The block after the last one.
    pub tail: usize,
    /// The pole is crossed.
    pub crossed: bool,
    /// It would have been crossed, had the joint travel on the other side.
    pub kept_back: bool,
}

/// Paper steps 2 to 8 on a row with its arc lengths, mm.
pub(super) fn treated(row: &[PoleAngles], arc: &[f64], rules: &Rules) -> (Vec<PoleAngles>, Vec<PoleStretch>) {
    let mut out = row.to_vec();
    let mut stretches = Vec::new();
    for [first, last] in runs(row, rules.cone) {
        let (head, tail) = (first.saturating_sub(1), (last + 1).min(row.len() - 1));
        let rate = |i: usize| (row[i].azimuth - row[i - 1].azimuth).abs() / (arc[i] - arc[i - 1]);
        if tail <= head + 1 || !(head + 1..=tail).any(|i| rate(i) > rules.rate) {
            continue;
        }
        let (from, to) = (out[head], out[tail]);
        let switch = if rules.crossing { FRAC_PI_2 } else { PI };
        let length = arc[tail] - arc[head];
        // The description of the head is kept: its sign and its turns.
        let sign = if from.polar < 0.0 { -1.0 } else { 1.0 };
        let offset = from.azimuth - from.positive().azimuth;
        let at = |t: f64| {
            let (angles, crossed) = between(from, to, t, switch);
            (PoleAngles { polar: sign * angles.polar, azimuth: angles.azimuth + offset }, crossed)
        };
        for i in head + 1..tail {
            out[i] = at((arc[i] - arc[head]) / length).0;
        }
        let (end, crossed) = at(1.0);
        let flips = (end.polar < 0.0) != (to.polar < 0.0);
        let shift = end.azimuth - if flips { to.other().azimuth } else { to.azimuth };
        for angles in &mut out[tail..] {
            if flips {
                *angles = angles.other();
            }
            angles.azimuth += shift;
        }
        let turn = wrapped(to.positive().azimuth - from.positive().azimuth).abs();
        stretches.push(PoleStretch { head, tail, crossed, kept_back: !crossed && turn > FRAC_PI_2 + ROUNDING });
        // A run with less blocks than a junction has no room for two.
        if rules.junction != Junction::Off && tail - head >= JUNCTION {
            smooth(&mut out, arc, head, rules.junction);
            smooth(&mut out, arc, tail, rules.junction);
        }
    }
    (out, stretches)
}

/// Maximal runs of blocks inside of the cone; those with less blocks than a junction between them are one.
fn runs(row: &[PoleAngles], cone: f64) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for i in (0..row.len()).filter(|&i| row[i].polar.abs() < cone) {
        match runs.last_mut() {
            Some([_, last]) if i - *last <= JUNCTION => *last = i,
            _ => runs.push([i, i]),
        }
    }
    runs
}

/// Replaces the three inner blocks of a junction.
fn smooth(row: &mut [PoleAngles], arc: &[f64], middle: usize, junction: Junction) {
    let (Some(from), true) = (middle.checked_sub(JUNCTION / 2), middle + JUNCTION / 2 < row.len()) else { return };
    let length = arc[from + JUNCTION - 1] - arc[from];
    let t: [f64; JUNCTION] = std::array::from_fn(|k| (arc[from + k] - arc[from]) / length);
    let pinned = junction == Junction::Pinned;
    let polar = fitted(std::array::from_fn(|k| row[from + k].polar), t, pinned);
    let azimuth = fitted(std::array::from_fn(|k| row[from + k].azimuth), t, pinned);
    for k in 1..JUNCTION - 1 {
        row[from + k] = PoleAngles { polar: polar[k], azimuth: azimuth[k] };
    }
}
