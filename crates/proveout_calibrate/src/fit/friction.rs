//! Dry and viscous friction from the motor's force, by the balance of momentum over short blocks of time.
//!
//! ```text
//!   over a block of length h:   F = M (v1 - v0) / h + Fc sign(v) + b (x1 - x0) / h + g
//! ```
//!
//! F is the mean of the measured force, v0 and v1 the velocities at the block's ends, M the moved mass, g
//! the load that does not depend on the motion (weight). The balance holds exactly for any motion within
//! the block, and is linear in M, Fc, b and g (Erkorkmaz and Altintas 2001, who filter instead of
//! integrating). Blocks in which the joint turns back, rests, or is slower than the Stribeck range are left
//! out. For rotary joints the sine and the cosine of the position are added to g: the weight of what leans
//! out.

use nalgebra::{DMatrix, DVector};

use super::{least_squares::covariance, moves::Move};
use crate::trace::{Signal, Trace};

/// Length of a block, s and rows at least.
const BLOCK_S: f64 = 0.02;
const BLOCK_ROWS: usize = 8;
/// Longest block, s: a move must have several of them.
const LONGEST_BLOCK_S: f64 = 0.2;
/// Slowest velocity as a part of the highest, where the machine file states no Stribeck velocity.
const SLOWEST_PART: f64 = 0.02;
/// Multiple of the Stribeck velocity from which static friction is gone: e^-9 of it is left.
const STRIBECK: f64 = 3.0;
/// Coarsest rounding of positions, mm and radian (0.1 degrees): over a block of 20 ms it is a velocity of 5
/// mm/s.
const COARSEST_MM: f64 = 0.1;
const COARSEST_RAD: f64 = 0.001_745_329_25;
/// Rows on either side from which the velocity at a border is taken.
const BORDER_ROWS: usize = 4;
/// Fewest blocks in each direction.
const FEWEST: usize = 8;

/// Friction of a joint, in the unit of the force.
#[derive(Clone, Debug)]
pub(crate) struct FrictionFit {
    /// Moved mass, kg over a thousand (N s²/mm), or inertia in N mm s²; in another unit of force by that.
    pub(crate) mass: [f64; 2],
    /// Dry friction with its standard error; none where it is not determined.
    pub(crate) coulomb: (f64, Option<f64>),
    /// Viscous friction.
    pub(crate) viscous: (f64, Option<f64>),
    /// Correlation of both.
    pub(crate) correlation: f64,
    /// Standard deviation of the residuals, in the unit of the force.
    pub(crate) left: f64,
}

/// Velocity at a row by the straight line through its neighbors.
fn velocity(signal: &Signal, time: &[f64], row: usize) -> Option<f64> {
    let from = row.checked_sub(BORDER_ROWS)?;
    let (x, t) = (signal.values.get(from..=row + BORDER_ROWS)?, time.get(from..=row + BORDER_ROWS)?);
    let n = x.len() as f64;
    let (mx, mt) = (x.iter().sum::<f64>() / n, t.iter().sum::<f64>() / n);
    let (mut sxt, mut stt) = (0.0, 0.0);
    for (x, t) in x.iter().zip(t) {
        sxt += (x - mx) * (t - mt);
        stt += (t - mt) * (t - mt);
    }
    (stt > 0.0).then_some(sxt / stt)
}

/// Fits the friction of a joint over its moves; the error says in words why it is not known.
pub(crate) fn fit_friction(
    joint: usize,
    rotary: bool,
    stribeck: Option<f64>,
    moves: &[Move],
    traces: &[Trace],
) -> Result<FrictionFit, String> {
    let mut rows: Vec<[f64; 6]> = Vec::new();
    let mut forces: Vec<f64> = Vec::new();
    let mut fastest = 0.0_f64;
    let mut pending: Vec<([f64; 6], f64, [f64; 2])> = Vec::new();
    for one in moves {
        let Some(trace) = traces.get(one.trace) else { continue };
        let Some(of) = trace.joints.get(joint).and_then(Option::as_ref) else { continue };
        let Some(force) = &of.force else { return Err("a trace has no column of force, current or load".to_owned()) };
        let Some(signal) = of.actual.as_ref().or(of.command.as_ref()) else { continue };
        let (coarsest, unit, factor) =
            if rotary { (COARSEST_RAD, "deg", 1_f64.to_degrees()) } else { (COARSEST_MM, "mm", 1.0) };
        if signal.quantum > coarsest * (1.0 + 1e-9) {
            return Err(format!(
                "positions are rounded to {:.4} {unit}: the velocity over a ramp is coarser than its friction",
                signal.quantum * factor
            ));
        }
        let length = ((BLOCK_S / trace.step).round() as usize).max(BLOCK_ROWS);
        if length as f64 * trace.step > LONGEST_BLOCK_S {
            return Err(format!("rows are {:.0} ms apart: a ramp is over before its force is read", 1e3 * trace.step));
        }
        let mut at = one.moving.start;
        while at.saturating_add(length) < one.moving.end {
            let end = at + length;
            let (Some(v0), Some(v1)) = (velocity(signal, &trace.time, at), velocity(signal, &trace.time, end)) else {
                break;
            };
            let (Some(x0), Some(x1)) = (signal.values.get(at), signal.values.get(end)) else { break };
            let (Some(t0), Some(t1)) = (trace.time.get(at), trace.time.get(end)) else { break };
            // Trapezoid rule: the readings are those of the rows.
            let part = force.get(at..=end).unwrap_or_default();
            let sum: f64 = part.windows(2).map(|w| 0.5 * (w[0] + w[1])).sum();
            let mean = sum / length as f64;
            let (h, middle) = (t1 - t0, 0.5 * (x0 + x1));
            let v = (x1 - x0) / h;
            let turn = if rotary { [middle.sin(), middle.cos()] } else { [0.0; 2] };
            fastest = fastest.max(v.abs());
            pending.push(([(v1 - v0) / h, v.signum(), v, 1.0, turn[0], turn[1]], mean, [v0, v1]));
            at = end;
        }
    }
    let slowest = stribeck.map_or(SLOWEST_PART * fastest, |v| (STRIBECK * v).min(0.5 * fastest));
    let mut blocks = [0, 0];
    for (row, mean, [v0, v1]) in pending {
        if v0 * v1 > 0.0 && v0.abs().min(v1.abs()) > slowest {
            blocks[usize::from(row[1] < 0.0)] += 1;
            rows.push(row);
            forces.push(mean);
        }
    }
    if blocks.iter().any(|n| *n < FEWEST) {
        return Err(format!(
            "{} and {} blocks of motion in the two directions: dry friction takes {FEWEST} in each",
            blocks[0], blocks[1]
        ));
    }
    let columns = if rotary { 6 } else { 4 };
    let a = DMatrix::from_fn(rows.len(), columns, |i, k| rows[i][k]);
    let f = DVector::from_vec(forces);
    let h = a.transpose() * &a;
    let x = a.clone().svd(true, true).solve(&f, 1e-10).map_err(str::to_owned)?;
    let left = &f - &a * &x;
    let free = rows.len().saturating_sub(columns).max(1) as f64;
    let variance = left.norm_squared() / free;
    let (errors, correlations) = covariance(&h, variance);
    let of = |k: usize| (x[k], errors.get(k).copied().flatten());
    Ok(FrictionFit {
        mass: [x[0], errors.first().copied().flatten().unwrap_or(f64::INFINITY)],
        coulomb: of(1),
        viscous: of(2),
        correlation: correlations[(1, 2)],
        left: variance.sqrt(),
    })
}
