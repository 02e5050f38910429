//! Gains of a drive from its following error: the twin's own drive model, run along the fitted set points.
//!
//! The measured error `command - actual` is compared with that of `DriveModel`
//! (`proveout_controller::servo`) along the first moves of a joint, rests between them included, so that
//! integrator and friction have their history. Position gain, feed-forward, velocity loop, integral time
//! and friction over mass are fitted together; all but the first two are there so that their errors widen
//! those of the gain. A steady stretch shows only `(1 - alpha) / Kv`; what separates gain and feed-forward
//! are the transients, so a trace that is too coarse for them is refused by name.
//!
//! *Two drives with one answer.* With the mass as one, the stiff loop from set point to position is
//!
//! ```text
//!     beta s^3 + k alpha s^2 + k (Kv + alpha/Tn) s + k Kv/Tn
//!     -----------------------------------------------------
//!            s^3 + k s^2 + k (Kv + 1/Tn) s + k Kv/Tn
//! ```
//!
//! With alpha = 1 it is the same when Kv and 1/Tn change places, and the minimum has a saddle where they are
//! equal. The position loop of a cascade is the slower one, so that Kv is the smaller of the two.

use std::ops::Range;

use proveout_controller::servo::{DriveModel, SetPointRates};
use proveout_machine::{Drive, VelocityGain};

use super::{
    law::Law,
    least_squares::{Minimum, Problem, minimize},
    limits::LimitsFit,
};
use crate::trace::Trace;

/// Coarsest rounding of positions, mm and degrees, at which transients of a loop are seen: a contouring
/// control holds its path within a few hundredths.
const COARSEST_MM: f64 = 0.1;
const COARSEST_DEG: f64 = 0.1;
/// The largest following error must be this many times its rounding.
const LEAST_STEPS: f64 = 5.0;
/// Longest rest before a move that is run, s: a resting integrator has ended long before.
const LONGEST_REST_S: f64 = 0.3;
/// Most moves that are run.
const MOST_MOVES: usize = 6;
/// Longest step of time over the time constant of the velocity loop at which a transient is seen.
const MOST_ROW_S: f64 = 0.025;
/// Longest cycle of the simulated drive, s.
const CYCLE_S: f64 = 1e-3;
/// Deviation of the logarithm of an elastic frequency in a machine file: it is right within a third.
const GUESSED_FREQUENCY: f64 = 0.3;
/// Mean square of the residuals, in squares of their deviations, of a fit that explains them: the errors of
/// another one would say nothing of how far the gains are off.
const GOOD: f64 = 1.2;
/// Drives of the net from which a search begins.
const TRIED: usize = 6;
/// Costs that differ by less than this part are the same.
const SAME: f64 = 1e-3;
/// Relative width of a difference.
const STEP: f64 = 1e-4;

/// Parameters in their order; multipliers of the start are logarithms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ServoParameter {
    PositionGain,
    VelocityFeedForward,
    VelocityGain,
    IntegralTime,
    AccelerationFeedForward,
    CoulombFriction,
    ViscousFriction,
    ElasticFrequency,
}

/// What the following error says.
#[derive(Clone, Debug)]
pub(crate) struct ServoFit {
    pub(crate) drive: Drive,
    pub(crate) list: Vec<ServoParameter>,
    /// Standard errors in the order of `list`: parts of the value for multipliers, absolute for shares.
    pub(crate) minimum: Minimum,
    /// Root mean square of what the model leaves, mm or radian.
    pub(crate) left: f64,
    /// Largest measured following error, mm or radian.
    pub(crate) largest: f64,
}

/// One stretch of the simulation: knots and the rows that are compared.
struct Stretch {
    /// Position and velocity of the set point at the knots, `cycle` apart.
    knots: Vec<[f64; 2]>,
    /// Measured error at every `every`-th knot after `skip` of them, and its standard deviation.
    measured: Vec<[f64; 2]>,
    skip: usize,
}

struct ServoProblem {
    /// Values that parameters multiply.
    start: Drive,
    inertia: f64,
    cycle: f64,
    every: usize,
    stretches: Vec<Stretch>,
    list: Vec<ServoParameter>,
    all: Vec<usize>,
    /// What is known besides: parameter, logarithm of its value, and the deviation of that.
    known: Vec<(ServoParameter, f64, f64)>,
}

/// Dry and viscous friction over the moved mass from the force, each with its standard error as a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KnownFriction {
    pub(crate) coulomb: [f64; 2],
    pub(crate) viscous: [f64; 2],
}

impl ServoProblem {
    fn drive(&self, p: &[f64]) -> Drive {
        let mut d = self.start.clone();
        for (what, v) in self.list.iter().zip(p) {
            match what {
                ServoParameter::PositionGain => d.position_gain *= v.exp(),
                ServoParameter::VelocityFeedForward => d.velocity_feed_forward = *v,
                ServoParameter::VelocityGain => {
                    d.velocity_gain = match d.velocity_gain {
                        VelocityGain::Gain(g) => VelocityGain::Gain(g * v.exp()),
                        VelocityGain::Bandwidth(b) => VelocityGain::Bandwidth(b * v.exp()),
                    }
                }
                ServoParameter::IntegralTime => d.integral_time = d.integral_time.map(|t| t * v.exp()),
                ServoParameter::AccelerationFeedForward => d.acceleration_feed_forward = *v,
                ServoParameter::CoulombFriction => {
                    d.coulomb_friction *= v.exp();
                    d.static_friction *= v.exp();
                }
                ServoParameter::ViscousFriction => d.viscous_friction *= v.exp(),
                ServoParameter::ElasticFrequency => {
                    if let Some(e) = &mut d.elastic {
                        e.frequency *= v.exp();
                    }
                }
            }
        }
        d
    }
}

impl ServoProblem {
    /// Fits these parameters from now on.
    fn take(&mut self, list: &[ServoParameter]) {
        self.list = list.to_vec();
        self.all = (0..list.len()).collect();
    }

    /// Parameters that give the drive of the start.
    fn begin(&self) -> Vec<f64> {
        let of = |what: &ServoParameter| match what {
            ServoParameter::VelocityFeedForward => self.start.velocity_feed_forward,
            ServoParameter::AccelerationFeedForward => self.start.acceleration_feed_forward,
            _ => 0.0,
        };
        self.list.iter().map(of).collect()
    }

    fn cost_at(&self, p: &[f64]) -> f64 {
        let square = |block: usize| Some(self.residuals(block, p)?.iter().map(|r| r * r).sum::<f64>());
        square(0).zip(square(1)).map_or(f64::INFINITY, |(a, b)| a + b)
    }

    fn cost(&self) -> f64 {
        self.cost_at(&self.begin())
    }

    /// Drives of a coarse net over speed and shape of the loops and both feed-forwards, the best first.
    fn net(&mut self) -> Vec<Drive> {
        let given = self.start.clone();
        let mut all = vec![(self.cost(), given.clone())];
        for alpha in [0.0, 0.5, 0.9, 1.0] {
            for beta in [0.0, 0.5, 1.0] {
                for factor in [0.6, 0.8, 1.0, 1.25, 1.6] {
                    for apart in [1.0, 0.7] {
                        let mut d = faster(&given, factor);
                        (d.velocity_feed_forward, d.acceleration_feed_forward) = (alpha, beta);
                        d.position_gain *= apart;
                        d.integral_time = d.integral_time.map(|t| t * apart);
                        self.start = d.clone();
                        all.push((self.cost(), d));
                    }
                }
            }
        }
        self.start = given;
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().map(|(_, d)| d).collect()
    }

    /// Of two drives with the same answer, the one whose position loop is the slower one.
    fn order(&mut self) {
        let Some(time) = self.start.integral_time.filter(|t| t * self.start.position_gain > 1.0) else { return };
        let before = (self.cost(), self.start.clone());
        self.start.integral_time = Some(1.0 / self.start.position_gain);
        self.start.position_gain = 1.0 / time;
        self.settle();
        if self.cost() > before.0 * (1.0 + SAME) {
            self.start = before.1;
        }
    }

    /// Moves the start to the minimum near it.
    fn settle(&mut self) {
        if let Some(found) = minimize(self, &self.begin()) {
            self.start = self.drive(&found.parameters);
        }
    }

    /// The best minimum of all parameters from the best drives of the net: first the loops alone, then with
    /// friction and elasticity. Where Kv is 1/Tn the minimum is a saddle (see above), and a search may end
    /// there.
    fn minimum_from_the_net(&mut self, loops: &[ServoParameter], list: &[ServoParameter]) -> Option<Minimum> {
        let mut best: Option<(Minimum, Drive)> = None;
        for drive in self.net().into_iter().take(TRIED) {
            self.start = drive;
            self.take(loops);
            self.settle();
            self.order();
            self.take(list);
            let Some(found) = minimize(self, &self.begin()).filter(|m| m.converged) else { continue };
            let good = found.cost < GOOD * found.rows as f64 && found.errors.iter().all(Option::is_some);
            if best.as_ref().is_none_or(|(b, _)| found.cost < b.cost * (1.0 - SAME)) {
                best = Some((found, self.start.clone()));
            }
            if good {
                break;
            }
        }
        let (minimum, start) = best?;
        self.start = start;
        self.take(list);
        let drive = self.drive(&minimum.parameters);
        if drive.integral_time.is_some_and(|t| t * drive.position_gain > 1.0) {
            // The same answer with both changed: the position loop is the slower one.
            let start = std::mem::replace(&mut self.start, drive);
            self.order();
            let swapped = minimize(self, &self.begin()).filter(|m| m.converged && m.cost < minimum.cost * (1.0 + SAME));
            if swapped.is_some() {
                return swapped;
            }
            self.start = start;
        }
        Some(minimum)
    }
}

/// A drive whose loops are all faster by a factor.
fn faster(drive: &Drive, factor: f64) -> Drive {
    let mut d = drive.clone();
    d.position_gain *= factor;
    d.integral_time = d.integral_time.map(|t| t / factor);
    d.velocity_gain = match d.velocity_gain {
        VelocityGain::Gain(g) => VelocityGain::Gain(g * factor),
        VelocityGain::Bandwidth(b) => VelocityGain::Bandwidth(b * factor),
    };
    d
}

/// The cubic between two knots, as the fine interpolator of the twin's drives takes it.
fn rates([x0, v0]: [f64; 2], [x1, v1]: [f64; 2], h: f64) -> SetPointRates {
    let way = x1 - x0;
    SetPointRates {
        velocity: v0,
        acceleration: (6.0 * way / h - 4.0 * v0 - 2.0 * v1) / h,
        jerk: (6.0 * (v0 + v1) - 12.0 * way / h) / (h * h),
    }
}

impl Problem for ServoProblem {
    fn blocks(&self) -> usize {
        2
    }

    fn depends(&self, _: usize) -> &[usize] {
        &self.all
    }

    fn residuals(&self, block: usize, p: &[f64]) -> Option<Vec<f64>> {
        if block > 0 {
            let drive = self.drive(p);
            let of = |(what, ln, deviation): &(ServoParameter, f64, f64)| {
                let value = match what {
                    ServoParameter::CoulombFriction => drive.coulomb_friction,
                    ServoParameter::ViscousFriction => drive.viscous_friction,
                    _ => drive.elastic.map_or(1.0, |e| e.frequency),
                };
                (value.ln() - ln) / deviation
            };
            return Some(self.known.iter().map(of).collect());
        }
        let model = DriveModel::new(&self.drive(p), self.inertia, self.cycle).ok()?;
        let mut state = model.rest(0.0);
        let mut out = Vec::new();
        for stretch in &self.stretches {
            let mut row = 0;
            for (k, knot) in stretch.knots.iter().enumerate() {
                if k >= stretch.skip && (k - stretch.skip) % self.every == 0 {
                    let [measured, deviation] = *stretch.measured.get(row)?;
                    out.push((state.error() - measured) / deviation);
                    row += 1;
                }
                if let Some(next) = stretch.knots.get(k + 1) {
                    model.cycle(&mut state, rates(*knot, *next, self.cycle), 0.0);
                }
            }
        }
        out.iter().all(|r| r.is_finite()).then_some(out)
    }

    fn step(&self, _: usize) -> f64 {
        STEP
    }

    fn one_sided(&self) -> bool {
        true
    }

    fn bounds(&self, parameter: usize) -> [f64; 2] {
        match self.list.get(parameter) {
            Some(ServoParameter::VelocityFeedForward | ServoParameter::AccelerationFeedForward) => [0.0, 1.0],
            // A factor of twenty either way: beyond it the start is that of another machine.
            _ => [-3.0, 3.0],
        }
    }
}

/// Fits the drive of a joint; the error says in words why it cannot be known.
pub(crate) fn fit_servo(
    start: Option<&Drive>,
    inertia: Option<f64>,
    friction: Option<KnownFriction>,
    (joint, rotary): (usize, bool),
    limits: &LimitsFit,
    traces: &[Trace],
) -> Result<ServoFit, String> {
    let start = start.ok_or("the machine file states no drive: add [joint.drive] with a first guess")?;
    let inertia = inertia.ok_or(
        "neither moving_mass_kg (moving_inertia_kg_m2) nor masses of bodies are stated: gains count over them",
    )?;
    let mut start = start.clone();
    let mut known = Vec::new();
    if let Some(KnownFriction { coulomb, viscous }) = friction {
        // The force has them over the mass that it moves; the model counts with that of the file.
        let held = start.static_friction / start.coulomb_friction.max(f64::MIN_POSITIVE);
        let stiction = if start.coulomb_friction > 0.0 { held.max(1.0) } else { 1.0 };
        start.coulomb_friction = coulomb[0] * inertia;
        start.static_friction = stiction * start.coulomb_friction;
        start.viscous_friction = viscous[0] * inertia;
        known.push((ServoParameter::CoulombFriction, start.coulomb_friction.ln(), coulomb[1]));
        known.push((ServoParameter::ViscousFriction, start.viscous_friction.ln(), viscous[1]));
    } else if start.viscous_friction > 0.0 {
        // Damping by friction and by the velocity loop look alike; the file is right within a factor of e.
        known.push((ServoParameter::ViscousFriction, start.viscous_friction.ln(), 1.0));
    }
    if let Some(e) = start.elastic {
        known.push((ServoParameter::ElasticFrequency, e.frequency.ln(), GUESSED_FREQUENCY));
    }
    // A multiplier needs something to multiply.
    for friction in [&mut start.coulomb_friction, &mut start.viscous_friction] {
        *friction = friction.max(1e-6 * inertia);
    }
    start.static_friction = start.static_friction.max(start.coulomb_friction);
    let mut stretches = Vec::new();
    let (mut largest, mut coarsest, mut cycle, mut every) = (0.0_f64, 0.0_f64, 0.0, 1);
    for (one, (begin, velocity)) in limits.moves.iter().zip(&limits.best.starts).take(MOST_MOVES) {
        let Some(trace) = traces.get(one.trace) else { continue };
        let Some(of) = trace.joints.get(joint).and_then(Option::as_ref) else { continue };
        let (Some(command), Some(actual)) = (&of.command, &of.actual) else {
            return Err("a trace has no command beside the measured position".to_owned());
        };
        if !trace.even {
            return Err("rows are not evenly spaced in time: lags of a loop and of the clock look the same".to_owned());
        }
        if trace.step > MOST_ROW_S {
            return Err(format!(
                "rows are {:.0} ms apart: the settling of a loop takes less than two of them",
                1e3 * trace.step
            ));
        }
        let parts = (trace.step / CYCLE_S - 1e-6).ceil().max(1.0);
        if cycle == 0.0 {
            (cycle, every) = (trace.step / parts, parts as usize);
        } else if (cycle - trace.step / parts).abs() > 1e-3 * cycle {
            return Err("traces have different steps of time: give them one at a time".to_owned());
        }
        coarsest = coarsest.max(command.quantum).max(actual.quantum);
        let mut shape = limits.best.shape;
        shape.velocity = *velocity;
        let (from, law) = (one.from, shape.law(one.to - one.from));
        let rest = (LONGEST_REST_S / trace.step) as usize;
        let rows: Range<usize> = one.rows.start.max(one.moving.start.saturating_sub(rest))..one.rows.end;
        stretches.push(stretch(trace, (command, actual), rows, (from, *begin, &law), (cycle, every), &mut largest));
    }
    let coarse = if rotary { COARSEST_DEG.to_radians() } else { COARSEST_MM };
    let (unit, factor) = if rotary { ("deg", 1_f64.to_degrees()) } else { ("mm", 1.0) };
    if coarsest > coarse * (1.0 + 1e-9) {
        return Err(format!(
            "positions are rounded to {:.4} {unit}: settling and lag of a loop are finer than {:.1} {unit}",
            coarsest * factor,
            coarse * factor
        ));
    }
    if stretches.is_empty() {
        return Err("no move of this joint alone".to_owned());
    }
    if largest < LEAST_STEPS * coarsest || largest == 0.0 {
        return Err(format!(
            "the following error stays below {:.5} {unit}, {LEAST_STEPS} steps of the rounding",
            LEAST_STEPS * coarsest * factor
        ));
    }
    let mut list =
        vec![ServoParameter::PositionGain, ServoParameter::VelocityFeedForward, ServoParameter::VelocityGain];
    list.extend(start.integral_time.map(|_| ServoParameter::IntegralTime));
    list.push(ServoParameter::AccelerationFeedForward);
    let loops = list.clone();
    list.extend([ServoParameter::CoulombFriction, ServoParameter::ViscousFriction]);
    list.extend(start.elastic.map(|_| ServoParameter::ElasticFrequency));
    let mut problem =
        ServoProblem { start, inertia, cycle, every, stretches, list: Vec::new(), all: Vec::new(), known };
    let minimum = problem
        .minimum_from_the_net(&loops, &list)
        .ok_or("no stable loop near the machine file's gains follows these set points")?;
    let residuals = problem.residuals(0, &minimum.parameters).unwrap_or_default();
    let deviations: Vec<f64> = problem.stretches.iter().flat_map(|s| s.measured.iter().map(|m| m[1])).collect();
    let squares: f64 = residuals.iter().zip(&deviations).map(|(r, s)| (r * s).powi(2)).sum();
    let left = (squares / residuals.len().max(1) as f64).sqrt();
    if minimum.cost > GOOD * minimum.rows as f64 {
        return Err(format!(
            "the drive model leaves {:.5} {unit} of a following error of {:.5} {unit}: this drive has another structure, or \
             its start in the machine file is too far off",
            left * factor,
            largest * factor
        ));
    }
    let drive = problem.drive(&minimum.parameters);
    Ok(ServoFit { drive, list: problem.list.clone(), minimum, left, largest })
}

fn stretch(
    trace: &Trace,
    (command, actual): (&crate::trace::Signal, &crate::trace::Signal),
    rows: Range<usize>,
    (from, begin, law): (f64, f64, &Law),
    (cycle, every): (f64, usize),
    largest: &mut f64,
) -> Stretch {
    let time = trace.time.get(rows.clone()).unwrap_or_default();
    let first = time.first().copied().unwrap_or(0.0);
    let count = time.len().saturating_sub(1) * every + 1;
    let knots = (0..count)
        .map(|k| {
            let t = first + k as f64 * cycle - begin;
            [from + law.position(t), law.derivative(1, t)]
        })
        .collect();
    let mut measured = Vec::with_capacity(time.len());
    for row in rows {
        let (Some(c), Some(a)) = (command.values.get(row), actual.values.get(row)) else { continue };
        let speed = law.derivative(1, trace.time.get(row).copied().unwrap_or(0.0) - begin);
        let variance = command.variance(speed, trace.step) + actual.variance(speed, trace.step);
        let floor = 1e-12 * (c.abs() + a.abs()).max(1.0);
        *largest = largest.max((c - a).abs());
        measured.push([c - a, variance.sqrt().max(floor)]);
    }
    Stretch { knots, measured, skip: 0 }
}
