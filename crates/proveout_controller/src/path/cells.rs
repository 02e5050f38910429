//! Cuts spans into cells and bounds the derivatives of the joints in each.

use proveout_machine::{JointKind, JointValues, MAX_JOINTS};

use super::{PathBlock, PathContext, Septic, WayMeasure};
use crate::{
    jet::JointJet,
    limits::{CellLimits, Stride, cell_limits},
    shape::{BlockShape, DerivativeBounds, Quintic},
};

/// Largest turn of a rotary joint in one cell, radian: 3 degrees change the direction of the linear axes by 5
/// percent.
const CELL_TURN: f64 = 0.052;
/// Largest angle of an arc in one cell, radian.
const CELL_ARC: f64 = 0.2;
/// Surcharge on derivatives that are known only at points of a cell.
const POINT_SURCHARGE: f64 = 1.02;
/// Points of a cell at which curved paths are looked at.
const POINTS: usize = 5;
/// A piece of a spline shorter than this part of the block is rounding of its ends.
const NO_PIECE: f64 = 1e-12;

/// End, limits, and the joints as polynomials of a cell, where these were checked and approximate
/// the kinematics.
pub(super) type NewCell = (f64, CellLimits, Option<Box<Septic>>);

/// Cells of the exact path of a block over s0..s1.
pub(super) fn exact_cells(frame: &PathContext<'_>, block: &PathBlock, s0: f64, s1: f64) -> Vec<NewCell> {
    let rapid = block.is_rapid();
    let tcp = frame.kinematics.is_tcp();
    let machine = frame.kinematics.machine;
    let (u0, u1) = (s0 - block.s0, s1 - block.s0);
    let turn = |slope: &JointValues| {
        let rotary = machine.joints.iter().enumerate().filter(|(_, j)| j.kind == JointKind::Rotary);
        rotary.fold(0.0_f64, |m, (i, _)| m.max(slope[i].abs())) * (u1 - u0)
    };
    let limits = |a: f64, b: f64, bounds: &DerivativeBounds| {
        (block.s0 + b, cell_limits(frame.limits, &Stride::exact(rapid, block.feed, b - a), bounds), None)
    };
    let looked_at = |jet: &dyn Fn(f64) -> JointJet, [a, b]: [f64; 2], points: usize| {
        let places = places(frame, |s| jet(s - block.s0), [block.s0 + a, block.s0 + b], points);
        cell(frame, &Stride::exact(rapid, block.feed, b - a), &places)
    };
    let course = |u: f64| block.course().jet(u);
    let cut = |n: usize| {
        (0..n).map(move |i| {
            let at = |k: usize| if k == n { u1 } else { u0 + (u1 - u0) * k as f64 / n as f64 };
            (at(i), at(i + 1))
        })
    };
    match block.course() {
        BlockShape::Line { slope, .. } => {
            let turn = turn(slope);
            if !tcp || turn == 0.0 {
                let q = frame.kinematics.joints(&block.course().jet(u0)).first().map(f64::abs);
                let zero = JointValues::ZERO;
                return vec![limits(u0, u1, &DerivativeBounds { first: q, first_low: q, second: zero, third: zero })];
            }
            let n = (turn / CELL_TURN).ceil().max(1.0) as usize;
            cut(n).map(|(a, b)| looked_at(&course, [a, b], 3)).collect()
        }
        // Independent joints: their own laws keep the limits, the parameter is time.
        BlockShape::Timed(_) => Vec::new(),
        BlockShape::Arc(arc) => {
            let n = (arc.omega.abs() * (u1 - u0) / CELL_ARC).max(turn(&arc.slope) / CELL_TURN).ceil().max(1.0) as usize;
            cut(n)
                .map(|(a, b)| if tcp { looked_at(&course, [a, b], POINTS) } else { limits(a, b, &arc.bounds(a, b)) })
                .collect()
        }
        BlockShape::Bezier(curve) => {
            let mut cells = Vec::new();
            for w in curve.places(u0, u1).windows(2) {
                let n = (turn(curve.slope()) / (u1 - u0) * (w[1] - w[0]) / CELL_TURN).ceil().max(1.0) as usize;
                for i in 0..n {
                    let at = |k: usize| if k == n { w[1] } else { w[0] + (w[1] - w[0]) * k as f64 / n as f64 };
                    let (a, b) = (at(i), at(i + 1));
                    cells.push(looked_at(&course, [a, b], POINTS));
                }
            }
            cells
        }
        BlockShape::Spline(pieces) => {
            let mut cells = Vec::with_capacity(pieces.len());
            for piece in pieces {
                let (a, b) = (piece.u0.max(u0), piece.u1.min(u1));
                if b - a > NO_PIECE * block.length {
                    cells.push(looked_at(&|u| piece.jet(u), [a, b], POINTS));
                }
            }
            if let Some(last) = cells.last_mut() {
                last.0 = s1;
            }
            cells
        }
    }
}

/// Joints at equally spaced points from a to b.
fn places(
    frame: &PathContext<'_>,
    task: impl Fn(f64) -> JointJet,
    [a, b]: [f64; 2],
    points: usize,
) -> Vec<(f64, JointJet)> {
    let at = |i: usize| if i + 1 == points { b } else { a + (b - a) * i as f64 / (points - 1) as f64 };
    (0..points).map(|i| (at(i), frame.kinematics.joints(&task(at(i))))).collect()
}

/// A cell that was looked at in these places, both of its ends among them.
fn cell(frame: &PathContext<'_>, stride: &Stride, places: &[(f64, JointJet)]) -> NewCell {
    let bounds = point_bounds(frame, places);
    let limits = cell_limits(frame.limits, stride, &bounds);
    let [(a, begin), within @ .., (b, end)] = places else { return (0.0, limits, None) };
    if !frame.kinematics.is_tcp() {
        return (*b, limits, None);
    }
    let septic = Septic::hermite([*a, *b], begin, end);
    let rotary = |i: usize| frame.kinematics.machine.joints[i].kind == JointKind::Rotary;
    let highest = [&bounds.second, &bounds.third];
    let stands = septic.stands_for(frame.limits, rotary, within, highest, limits.highest);
    (*b, limits, stands.then(|| Box::new(septic)))
}

/// Bounds of the joints' derivatives from points of a cell, with a surcharge for what lies between them.
fn point_bounds(frame: &PathContext<'_>, places: &[(f64, JointJet)]) -> DerivativeBounds {
    let mut bounds = DerivativeBounds {
        first: JointValues::ZERO,
        first_low: JointValues([f64::INFINITY; MAX_JOINTS]),
        second: JointValues::ZERO,
        third: JointValues::ZERO,
    };
    let mut sign = JointValues::ZERO;
    for (_, q) in places {
        let high = |m: f64, v: f64| m.max(v.abs());
        bounds.first = bounds.first.zip_map(q.first(), high);
        bounds.second = bounds.second.zip_map(q.second(), high);
        bounds.third = bounds.third.zip_map(q.third(), high);
        for k in 0..frame.limits.count {
            let v = q.first()[k];
            bounds.first_low[k] = if v * sign[k] < 0.0 { 0.0 } else { bounds.first_low[k].min(v.abs()) };
            sign[k] = v;
        }
    }
    bounds.second = bounds.second * POINT_SURCHARGE;
    bounds.third = bounds.third * POINT_SURCHARGE;
    // A function passes its values at points of distance h by at most h^2/8 times its second derivative.
    let h = places.get(1).zip(places.first()).map_or(0.0, |(b, a)| b.0 - a.0);
    let between = bounds.third * (h * h / 8.0);
    bounds.first = bounds.first + between;
    bounds.first_low = bounds.first_low.zip_map(between, |low, e| (low - e).max(0.0));
    bounds
}

/// Cells of a blend or fitted stretch that begins at s0.
pub(super) fn blend_cells(
    frame: &PathContext<'_>,
    (rapid, feed, way): (bool, f64, WayMeasure),
    s0: f64,
    quintic: &Quintic,
) -> Vec<NewCell> {
    let s1 = quintic.u1;
    let machine = frame.kinematics.machine;
    let stride = |part: &Quintic| Stride {
        rapid,
        feed,
        length: part.u1 - part.u0,
        way,
        rate: way.range(machine, part),
        whole: if feed.is_finite() { way.length(machine, part, [part.u0, part.u1]) } else { 0.0 },
    };
    if frame.kinematics.is_tcp() {
        let joints = frame.kinematics.machine.joints.iter().enumerate();
        let fastest = quintic.bounds().first;
        let turn = joints.filter(|(_, j)| j.kind == JointKind::Rotary).fold(0.0_f64, |m, (i, _)| m.max(fastest[i]));
        let n = (turn * (s1 - s0) / CELL_TURN).ceil().max(1.0) as usize;
        let at = |k: usize| if k == n { s1 } else { s0 + (s1 - s0) * k as f64 / n as f64 };
        let own = |k: usize| {
            let (a, b) = (at(k), at(k + 1));
            let part = if n == 1 { quintic.clone() } else { quintic.between(a, b) };
            cell(frame, &Stride { length: b - a, ..stride(&part) }, &places(frame, |s| quintic.jet(s), [a, b], POINTS))
        };
        return (0..n).map(own).collect();
    }
    let halves = quintic.halves();
    halves.iter().map(|h| (h.u1, cell_limits(frame.limits, &stride(h), &h.bounds()), None)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proveout_machine::Machine;

    use super::*;
    use crate::{
        limits::JointLimits,
        mapping::{ActiveKinematics, Mapping},
        rtcp::Rig,
    };

    /// Corners between lines whose slopes differ by some percent, from 0.01 to 3 degrees and more
    /// per block, on machines with both rotary axes in the table, both in the head, and one in
    /// each. Where polynomials approximate the joints, they are as near to the kinematics between
    /// the checked places as at them, and their derivatives are those of their own values. Corners
    /// that turn far use the kinematics itself.
    #[test]
    fn polynomials_are_near_the_kinematics_everywhere() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut taken, mut all) = (0, 0);
        for name in ["bc-trunnion", "starrag-lx-451", "spinner-u5-620"] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines").join(name);
            let machine = Machine::read(&folder).expect("library machine");
            let rig = Rig::new(&machine).expect("three linear joints");
            let mapping = Mapping { tcp_length: Some(120.0), tool_length: 120.0, edge_length: 20.0 };
            let kinematics = ActiveKinematics { machine: &machine, rig: Some(&rig), mapping };
            let limits = JointLimits::new(&machine);
            let frame = PathContext { kinematics, limits: &limits };
            for round in 0..60 {
                let turn = 2e-4 * 400.0_f64.powf(f64::from(round) / 59.0);
                let length = 0.1 + 0.5 * (random() + 0.5);
                let mut jets = [JointJet::constant(JointValues::ZERO); 2];
                for i in 0..limits.count {
                    let rotary = machine.joints[i].kind == JointKind::Rotary;
                    let slope = 2.0 * random() * if rotary { turn / length } else { 1.0 };
                    jets[0].0[0][i] = random() * if rotary { 1.0 } else { 200.0 };
                    jets[0].0[1][i] = slope;
                    jets[1].0[1][i] = slope * (1.0 + 0.2 * random());
                    jets[1].0[0][i] = jets[0].0[0][i] + 0.5 * length * (slope + jets[1].0[1][i]);
                }
                let quintic = Quintic::hermite(0.0, length, &jets[0], &jets[1]);
                let mut from = 0.0;
                for (to, _, joints) in blend_cells(&frame, (false, 80.0, WayMeasure::Tip), 0.0, &quintic) {
                    all += 1;
                    if let Some(septic) = joints {
                        taken += 1;
                        for k in 0..=40 {
                            let s = from + (to - from) * f64::from(k) / 40.0;
                            let off = septic.at(s) - kinematics.joints(&quintic.jet(s)).0[0];
                            // The remainder is highest in the middle, which was looked at, where its eighth
                            // derivative is even; twice that where it is not.
                            assert!(off.max_abs() < 2e-7, "{name} {round} {s}: {off:?}");
                            // Central differences of steps h: rounding of 200 mm over h, and h^2/6 times the
                            // third derivative.
                            let h = 1e-3 * (to - from);
                            let s = s.clamp(from + h, to - h);
                            let slope = (septic.at(s + h) - septic.at(s - h)) * (0.5 / h);
                            let own = septic.jet(s).first();
                            assert!((slope - own).max_abs() < 1e-5 * own.max_abs().max(1.0), "{name} {round} {s}");
                        }
                    }
                    from = to;
                }
            }
        }
        assert!(taken * 4 > all && taken < all, "{taken} of {all}");
    }
}
