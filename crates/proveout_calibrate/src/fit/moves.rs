//! Moves of one joint from rest to rest, as they are found in a trace.

use std::ops::Range;

use crate::trace::{JointTrace, Trace};

/// Shortest rest between two moves, s, and in rows.
const REST_S: f64 = 0.02;
const REST_ROWS: usize = 3;
/// Longest part of the rests at both ends that belongs to a move, s.
const MARGIN_S: f64 = 0.25;
/// Window over which a change of position counts as motion, s.
const WINDOW_S: f64 = 0.01;
/// Noise and rounding within a window, in standard deviations and steps.
const DEVIATIONS: f64 = 7.0;
const STEPS: f64 = 1.01;
/// Least change that is motion, mm or radian: a nanometer, below any encoder.
const LEAST_WAY: f64 = 1e-6;
/// Motion at another override than this (percent) is left out.
const FULL_OVERRIDE: f64 = 100.0;

/// One move.
#[derive(Clone, Debug)]
pub(crate) struct Move {
    /// Index of the trace.
    pub(crate) trace: usize,
    /// Rows, rests at both ends included.
    pub(crate) rows: Range<usize>,
    /// Rows in which it may move.
    pub(crate) moving: Range<usize>,
    /// Place before and after, mm or radian.
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// Moves of one joint, and how many were left out.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointMoves {
    pub(crate) moves: Vec<Move>,
    /// Motion together with other joints.
    pub(crate) together: usize,
    /// Motion at another override.
    pub(crate) overridden: usize,
}

/// Rows in which a joint moves.
fn moving(joint: &JointTrace, step: f64) -> Vec<bool> {
    let Some(signal) = joint.position() else { return Vec::new() };
    let values = &signal.values;
    let window = ((WINDOW_S / step).round() as usize).clamp(1, 64);
    let threshold = (DEVIATIONS * std::f64::consts::SQRT_2 * signal.noise).max(STEPS * signal.quantum).max(LEAST_WAY);
    let mut out = vec![false; values.len()];
    for k in 0..values.len().saturating_sub(window) {
        if (values[k + window] - values[k]).abs() > threshold {
            out[k..=k + window].fill(true);
        }
    }
    // The window reaches into the rests: a run of motion begins and ends where the joint leaves its places.
    let mut row = 0;
    while row < out.len() {
        let end = row + out.iter().skip(row).take_while(|m| **m).count();
        if end > row {
            let (first, last) = (values[row], values[end - 1]);
            let lead = values[row..end].iter().take_while(|v| (*v - first).abs() <= threshold).count();
            let tail = values[row..end].iter().rev().take_while(|v| (*v - last).abs() <= threshold).count();
            // The row before the first change and the one after the last belong to the motion.
            out[row..row + lead.saturating_sub(1)].fill(false);
            out[end - tail.saturating_sub(1)..end].fill(false);
        }
        row = end + 1;
    }
    out
}

/// Rows in which no joint moves.
pub(crate) fn at_rest(trace: &Trace) -> Vec<bool> {
    let all: Vec<Vec<bool>> = trace.joints.iter().flatten().map(|j| moving(j, trace.step)).collect();
    (0..trace.time.len()).map(|row| !all.iter().any(|m| m.get(row).copied().unwrap_or(false))).collect()
}

/// The moves of every joint of a trace.
pub(crate) fn moves(index: usize, trace: &Trace) -> Vec<JointMoves> {
    let rows = trace.time.len();
    let by_joint: Vec<Option<Vec<bool>>> =
        trace.joints.iter().map(|j| j.as_ref().map(|j| moving(j, trace.step))).collect();
    let mut out: Vec<JointMoves> = trace.joints.iter().map(|_| JointMoves::default()).collect();
    let any = |row: usize| by_joint.iter().flatten().any(|m| m.get(row).copied().unwrap_or(false));
    let rest = ((REST_S / trace.step).ceil() as usize).max(REST_ROWS);
    // Runs of motion of any joint, with rests between them that are long enough.
    let mut runs: Vec<Range<usize>> = Vec::new();
    for row in 0..rows {
        if !any(row) {
            continue;
        }
        match runs.last_mut() {
            Some(run) if row - run.end < rest => run.end = row + 1,
            _ => runs.push(row..row + 1),
        }
    }
    let margin = ((MARGIN_S / trace.step).round() as usize).max(REST_ROWS);
    for (k, run) in runs.iter().enumerate() {
        let before = k.checked_sub(1).and_then(|b| runs.get(b)).map_or(0, |r| r.end);
        let after = runs.get(k + 1).map_or(rows, |r| r.start);
        if run.start < before + REST_ROWS || run.end + REST_ROWS > after {
            // It begins or ends outside of the trace.
            continue;
        }
        // Half of a rest belongs to either neighbor.
        let first = if before == 0 { 0 } else { before + (run.start - before) / 2 };
        let last = if after == rows { rows } else { run.end + (after - run.end) / 2 };
        let whole = first.max(run.start.saturating_sub(margin))..last.min(run.end.saturating_add(margin));
        let movers: Vec<usize> = by_joint
            .iter()
            .enumerate()
            .filter(|(_, m)| m.as_ref().is_some_and(|m| run.clone().any(|row| m.get(row).copied().unwrap_or(false))))
            .map(|(j, _)| j)
            .collect();
        let overridden = trace.override_percent.as_ref().is_some_and(|o| {
            o.get(run.clone()).is_some_and(|part| part.iter().any(|v| (v - FULL_OVERRIDE).abs() > 1e-6))
        });
        for &j in &movers {
            let Some(found) = out.get_mut(j) else { continue };
            if movers.len() > 1 {
                found.together += 1;
                continue;
            }
            if overridden {
                found.overridden += 1;
                continue;
            }
            let Some(values) = trace.joints.get(j).and_then(Option::as_ref).and_then(JointTrace::position) else {
                continue;
            };
            let mean = |rows: Range<usize>| {
                let part = values.values.get(rows).unwrap_or_default();
                part.iter().sum::<f64>() / part.len().max(1) as f64
            };
            let (from, to) = (mean(whole.start..run.start), mean(run.end..whole.end));
            found.moves.push(Move { trace: index, rows: whole.clone(), moving: run.clone(), from, to });
        }
    }
    out
}
