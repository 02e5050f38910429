//! From joint limits to limits along the path parameter.
//!
//! With q(s) along the path and s(t) in time, the chain rule gives for every joint
//!
//! ```text
//!   q.   = q' s.
//!   q..  = q' s.. + q'' s.^2
//!   q... = q' s... + 3 q'' s. s.. + q''' s.^3
//! ```
//!
//! Over a cell, upper bounds of |q'|, |q''|, |q'''| turn these into constants V, A, J: V keeps the velocity
//! limit and the feed along the path that is run, and leaves a part of acceleration and jerk to motion along
//! the path; A and J take what curvature leaves at V.

use proveout_machine::{MAX_JOINTS, Machine};

use crate::{jerk_ramp::Rates, look_ahead::SpeedCell, path::WayMeasure, shape::DerivativeBounds};

/// Speed along the path where nothing limits it, mm/s or degrees a second: a thousand times that of real
/// machines, and finite, so that the plan stays finite on a machine without limits.
pub(crate) const UNLIMITED_SPEED: f64 = 1e6;
/// Part of the acceleration limit that the curvature of the path may use at V.
const CURVATURE_ACCELERATION: f64 = 0.8;
/// Part of the jerk limit that the change of curvature may use at V.
const CURVATURE_JERK: f64 = 0.75;

/// Limits of every joint; infinite where none is given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLimits {
    pub(crate) count: usize,
    pub(crate) velocity: [f64; MAX_JOINTS],
    pub(crate) rapid: [f64; MAX_JOINTS],
    pub(crate) acceleration: [f64; MAX_JOINTS],
    pub(crate) jerk: [f64; MAX_JOINTS],
}

impl JointLimits {
    pub(crate) fn new(machine: &Machine) -> Self {
        let none = [f64::INFINITY; MAX_JOINTS];
        let count = machine.joints.len().min(MAX_JOINTS);
        let mut l = Self { count, velocity: none, rapid: none, acceleration: none, jerk: none };
        for (i, joint) in machine.joints.iter().take(MAX_JOINTS).enumerate() {
            l.velocity[i] = joint.max_velocity.unwrap_or(f64::INFINITY);
            l.rapid[i] = joint.rapid_velocity.unwrap_or(f64::INFINITY).min(l.velocity[i]);
            l.acceleration[i] = joint.max_acceleration.unwrap_or(f64::INFINITY);
            l.jerk[i] = joint.max_jerk.unwrap_or(f64::INFINITY);
        }
        l
    }
}

/// What a cell allows, for the plan and for the lower bound of the time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellLimits {
    /// V, A, J for the plan.
    pub(crate) cell: SpeedCell,
    /// V and A that no motion under the joint limits can pass (jerk infinite).
    pub(crate) bound: SpeedCell,
    /// Derivatives of the joints from which the limits follow.
    pub(crate) bounds: DerivativeBounds,
    /// Feed along the path that is run without curvature: programmed feed and joint velocities alone, and the
    /// joint that limits it below the feed.
    pub(crate) steady: f64,
    pub(crate) steady_joint: Option<usize>,
    /// Speed along the parameter that feed and joint velocities allow somewhere in the cell.
    pub(crate) highest: f64,
    /// No motion at the feed passes the cell in less than this time, s.
    pub(crate) least_time: f64,
    /// Programmed speed along the path that is run, infinite for rapid motion, and whether the limits of
    /// rapid motion hold.
    pub(crate) feed: f64,
    pub(crate) rapid: bool,
    /// What the feed is about.
    pub(crate) way: WayMeasure,
}

/// A stretch of the path whose limits are asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stride {
    pub(crate) rapid: bool,
    /// Programmed speed along the path that is run, infinite for rapid motion.
    pub(crate) feed: f64,
    /// Length along the parameter.
    pub(crate) length: f64,
    /// What the feed is about, lowest and highest way by the parameter, and the whole way.
    pub(crate) way: WayMeasure,
    pub(crate) rate: [f64; 2],
    pub(crate) whole: f64,
}

impl Stride {
    /// Of an exact path, whose parameter is its length.
    pub(crate) fn exact(rapid: bool, feed: f64, length: f64) -> Self {
        Self { rapid, feed, length, way: WayMeasure::Parameter, rate: [1.0, 1.0], whole: length }
    }
}

/// Step of the highest way by the parameter in the first law; half of it may be missing, which is within what
/// the feed may be passed by.
const RATE_STEP: f64 = 1e-3;
/// Part by which the sum of a way may be too long.
const SUMMED: f64 = 1e-6;

/// Limits over a cell whose joints have derivatives within `b`.
pub(crate) fn cell_limits(l: &JointLimits, stride: &Stride, b: &DerivativeBounds) -> CellLimits {
    let Stride { rapid, feed, length, way, rate: [slow, fast], whole } = *stride;
    let velocity = if rapid { &l.rapid } else { &l.velocity };
    // Rounded, and no faster than where the parameter is the way: a chain of many speeds that hardly differ
    // would shake the joints.
    let fast = ((fast / RATE_STEP - 0.5).ceil() * RATE_STEP).max(1.0);
    let mut speed = (feed / fast).min(UNLIMITED_SPEED);
    let mut highest = (feed / slow.max(f64::MIN_POSITIVE)).min(UNLIMITED_SPEED);
    let mut bound_speed = highest;
    let mut steady_joint = None;
    for i in 0..l.count {
        if b.first[i] > 0.0 {
            highest = highest.min(velocity[i] / b.first[i]);
            if velocity[i] < speed * b.first[i] {
                speed = velocity[i] / b.first[i];
                steady_joint = Some(i);
            }
        }
        if b.first_low[i] > 0.0 {
            bound_speed = bound_speed.min(velocity[i] / b.first_low[i]);
        }
    }
    let steady = (speed * fast).min(feed);
    let least_time = if feed.is_finite() && way != WayMeasure::Parameter { whole * (1.0 - SUMMED) / feed } else { 0.0 };
    for i in 0..l.count {
        if b.second[i] > 0.0 {
            speed = speed.min((CURVATURE_ACCELERATION * l.acceleration[i] / b.second[i]).sqrt());
        }
        if b.third[i] > 0.0 {
            speed = speed.min((CURVATURE_JERK * l.jerk[i] / b.third[i]).cbrt());
        }
    }
    let mut bound_acceleration = f64::INFINITY;
    for i in 0..l.count {
        if b.first_low[i] > 0.0 {
            let most = (l.acceleration[i] + b.second[i] * bound_speed * bound_speed) / b.first_low[i];
            bound_acceleration = bound_acceleration.min(most);
        }
    }
    let rates = rates_at(l, b, speed);
    CellLimits {
        cell: SpeedCell { length, speed, rates },
        bound: SpeedCell {
            length,
            speed: bound_speed,
            rates: Rates { acceleration: bound_acceleration, jerk: f64::INFINITY },
        },
        bounds: *b,
        steady,
        steady_joint,
        highest: highest.max(speed),
        least_time,
        feed: feed.min(UNLIMITED_SPEED),
        rapid,
        way,
    }
}

/// A and J of a cell whose speed stays below `speed`.
fn rates_at(l: &JointLimits, b: &DerivativeBounds, speed: f64) -> Rates {
    let mut rates = Rates::FREE;
    for i in 0..l.count {
        let (a, j) = (l.acceleration[i], l.jerk[i]);
        if b.first[i] > 0.0 {
            rates.acceleration = rates.acceleration.min((a - b.second[i] * speed * speed) / b.first[i]);
        }
        if b.second[i] > 0.0 && speed > 0.0 {
            let left = j - b.third[i] * speed * speed * speed;
            rates.acceleration = rates.acceleration.min(left / (6.0 * b.second[i] * speed));
        }
    }
    for i in 0..l.count {
        if b.first[i] > 0.0 && l.jerk[i].is_finite() {
            let curved = b.third[i] * speed * speed * speed + cross(b.second[i], speed, rates.acceleration);
            rates.jerk = rates.jerk.min((l.jerk[i] - curved) / b.first[i]);
        }
    }
    rates
}

/// 3 q'' s. s.. without the product of zero and infinity.
fn cross(second: f64, speed: f64, acceleration: f64) -> f64 {
    if second > 0.0 { 3.0 * second * speed * acceleration } else { 0.0 }
}

/// Shortest time over cells with V and A alone, from rest to rest (or from and to any speed where `open`):
/// forward and backward reachability of s.^2, exact for limits that are constant in each cell.
///
/// A lower bound of the time of every motion over the same path: V and A of the `bound` cells are no smaller
/// than what the joints' limits allow anywhere in the cell. Each cell takes its least time at the feed in any
/// case.
pub(crate) fn bound_time(limits: &[CellLimits], open: [bool; 2]) -> f64 {
    let cells: Vec<SpeedCell> = limits.iter().map(|c| c.bound).collect();
    let n = cells.len();
    let mut b = vec![f64::INFINITY; n + 1];
    if !open[0] {
        b[0] = 0.0;
    }
    if !open[1] {
        b[n] = 0.0;
    }
    let gain = |c: &SpeedCell| 2.0 * c.rates.acceleration * c.length;
    for (k, c) in cells.iter().enumerate() {
        b[k] = b[k].min(c.speed * c.speed);
        b[k + 1] = b[k + 1].min(b[k] + gain(c));
    }
    for (k, c) in cells.iter().enumerate().rev() {
        b[k + 1] = b[k + 1].min(c.speed * c.speed);
        b[k] = b[k].min(b[k + 1] + gain(c));
    }
    let mut time = 0.0;
    for (k, c) in cells.iter().enumerate() {
        let (v0, v1) = (b[k].sqrt(), b[k + 1].sqrt());
        let a = c.rates.acceleration;
        let least = limits[k].least_time;
        if a.is_infinite() {
            time += (c.length / c.speed).max(least);
            continue;
        }
        let peak = (0.5 * (b[k] + b[k + 1]) + a * c.length).sqrt().min(c.speed);
        let ramps = (2.0 * peak * peak - b[k] - b[k + 1]) / (2.0 * a);
        time += ((2.0 * peak - v0 - v1) / a + (c.length - ramps).max(0.0) / peak).max(least);
    }
    time
}

/// Lowers the limits of a cell after a sample was found at `velocity`, `acceleration` and `jerk` times the
/// limits.
pub(crate) fn slow_down(limits: &mut CellLimits, ratios: [f64; 3]) {
    let [v, a, j] = ratios.map(|r| r.max(1.0));
    let margin = 1.002;
    let time = v.max(a.sqrt()).max(j.cbrt()) * margin; // the factor by which time is stretched
    let cell = &mut limits.cell;
    cell.speed /= time;
    cell.rates.acceleration /= time * time;
    cell.rates.jerk /= time * time * time;
}
