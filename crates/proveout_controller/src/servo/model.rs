//! The constant part of a drive: cascade control and mechanics as exact discrete maps.
//!
//! # Equations
//!
//! Forces are divided by the whole moved mass M = m1 + m2 (motor, load), so that everything is in mm (radian)
//! and seconds; r is the set point, e = r - x, mu = m / M:
//!
//! ```text
//!   r ──►( )──[Kv]──►( )──►( )──[k (1 + 1/(Tn s))]──►( )──►[limit]── phi ──► motor x1 ─┤g├─/\/\/─ load x2
//!        -▲    alpha r.▲   -▲        beta r.. ▲                                  │      k2, d2      │
//!         │                 └─────────────────┼──────────────────────────── x1. ─┤                  │
//!         └───────────────────────────────────┴──── encoder "motor": x1 ─────────┘  "load": x2 ─────┘
//!
//!   phi    = k (Kv e + alpha r. - x1.) + i + beta r..           i. = k/Tn (Kv e + alpha r. - x1.)
//!   mu1 x1.. = phi - s                                          s  = k2 (x1 - x2 - o) + d2 (x1. - x2.)
//!   mu2 x2.. = s - b x2. + f + w                                o  = +g/2 or -g/2: the flank that touches
//!                                                               s  = 0 between the flanks
//! ```
//!
//! A stiff drive has x1 = x2 and one equation for M; its lost motion is a play operator after the
//! mass. f is dry friction (see `friction.rs`), w what the bodies put on the load. Where phi would pass
//! the force limit S, the motor gives S and the integrator follows by back-calculation with the
//! time Tn (Åström and Hägglund 2006, section 3.5), which makes it `i. = (S - beta r.. - i) / Tn`:
//! linear again. So each mode (loop closed or saturated, flanks touching or apart) is a linear
//! system in the errors e1, e2, the velocities and i, and gets its exact map over the inner step,
//! `linear.rs`.
//!
//! # Stability at any control cycle
//!
//! The maps are exponentials of the continuous loop: they are stable at every step exactly when the loop is,
//! and a loop that is not is refused. The inner step matters for what is not linear alone; it is a whole part
//! of the control cycle, at most 0.125 ms, and short enough for friction to act on a mass that has not yet
//! come back: the velocity that a constant force gives within the step is at least half of that of the free
//! mass. A drive that keeps its mode over a whole control cycle takes it in two exact steps instead
//! (`step.rs`).
//!
//! # Limits
//!
//! The current loop is taken as instantaneous (its bandwidth is some ten times that of the velocity loop).
//! Friction acts on the load. A stiff drive holds its load by friction while it crosses the lost motion; a
//! load heavier than its friction falls to the flank. The mass in the loop is constant: what it changes with
//! the pose comes in through w.

use proveout_machine::{Drive, Encoder, VelocityGain};
use thiserror::Error;

use super::{
    friction::Friction,
    linear::{ACCELERATION, FRICTION, INPUTS, LOAD, MOTOR, Map, OFFSET, RATE},
};
use crate::pieces::WHOLE;

/// Longest inner step, s: the usual cycle of a drive's velocity loop.
const LONGEST_INNER_STEP: f64 = 1.25e-4;
/// Most inner steps of a control cycle; a drive that wants more has data from another world.
const MOST_STEPS: usize = 1 << 14;
/// N to kg mm/s², N mm to kg mm²/s².
pub(crate) const FROM_NEWTON: f64 = 1e3;
/// Milliseconds in a second.
pub(super) const MS_PER_S: f64 = 1e3;

/// Why a drive cannot be simulated.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
pub struct DriveFault {
    /// What is wrong, with values.
    pub message: String,
    /// What to do about it.
    pub help: &'static str,
}

/// Closed loop and saturated motor.
#[derive(Clone, Debug)]
pub(crate) struct LoopMaps<const N: usize> {
    pub(crate) closed: Map<N>,
    pub(crate) saturated: Map<N>,
    /// Closed loop over half a control cycle, for a drive that keeps its mode all the way; none where modes
    /// must be watched.
    pub(crate) half: Option<Map<N>>,
}

/// States: motor error, velocity, integral (stiff); motor error, motor velocity, load error, load velocity,
/// integral.
#[derive(Clone, Debug)]
pub(crate) enum Mechanics {
    Stiff(Box<LoopMaps<3>>),
    Elastic { touching: Box<LoopMaps<5>>, apart: Box<LoopMaps<5>> },
}

/// The control law over M.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    pub(crate) position_gain: f64,
    pub(crate) velocity_gain: f64,
    pub(crate) velocity_forward: f64,
    pub(crate) acceleration_forward: f64,
    /// 1/Tn; zero without an integral part.
    pub(crate) integral_rate: f64,
    /// Highest force; infinite where none is stated.
    pub(crate) limit: f64,
}

impl Law {
    /// Force that the control asks for.
    #[inline]
    pub(crate) fn demand(&self, error: f64, velocity: f64, integral: f64, rate: f64, acceleration: f64) -> f64 {
        self.velocity_gain * (self.position_gain * error + self.velocity_forward * rate - velocity)
            + integral
            + self.acceleration_forward * acceleration
    }
}

/// Elasticity over M: stiffness, damping.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

/// One drive with its load, ready to be stepped; constant.
#[derive(Clone, Debug)]
pub struct DriveModel {
    pub(crate) law: Law,
    pub(crate) friction: Friction,
    pub(crate) mechanics: Mechanics,
    pub(crate) spring: Option<Spring>,
    pub(crate) viscous: f64,
    /// Shares of motor and load in M.
    pub(crate) share: [f64; 2],
    pub(crate) half_backlash: f64,
    pub(crate) encoder: Encoder,
    /// Force of a weight compensation over M.
    pub(crate) counterbalance: f64,
    inertia: f64,
    pub(crate) step: f64,
    pub(crate) steps: usize,
}

impl DriveModel {
    /// Drive with a load of `load_inertia` (kg or kg mm², the motor apart), for a control cycle in s.
    ///
    /// # Errors
    /// [`DriveFault`]: data that are no numbers, a loop that is not stable with these gains.
    pub fn new(drive: &Drive, load_inertia: f64, cycle: f64) -> Result<Self, DriveFault> {
        let fault = |message: String, help| Err(DriveFault { message, help });
        if !(load_inertia > 0.0 && load_inertia.is_finite()) {
            let help = "state moving_mass_kg (moving_inertia_kg_m2) of the joint or the masses of its bodies";
            return fault(format!("the drive moves a mass of {load_inertia}"), help);
        }
        if !(cycle > 0.0 && cycle.is_finite()) {
            return fault(format!("a control cycle of {cycle} s"), "give a cycle above zero");
        }
        let motor = drive.motor_inertia.unwrap_or(0.0);
        let inertia = load_inertia + motor;
        let scale = FROM_NEWTON / inertia;
        let share = [motor / inertia, load_inertia / inertia];
        let law = Law {
            position_gain: drive.position_gain,
            velocity_gain: match drive.velocity_gain {
                VelocityGain::Gain(g) => g * scale,
                VelocityGain::Bandwidth(b) => b,
            },
            velocity_forward: drive.velocity_feed_forward,
            acceleration_forward: drive.acceleration_feed_forward,
            integral_rate: drive.integral_time.map_or(0.0, |t| 1.0 / t),
            limit: drive.max_force.map_or(f64::INFINITY, |f| f * scale),
        };
        let friction = Friction {
            coulomb: drive.coulomb_friction * scale,
            stiction: drive.static_friction.max(drive.coulomb_friction) * scale,
            stribeck: drive.stribeck_velocity,
        };
        let viscous = drive.viscous_friction * scale;
        let spring = drive.elastic.map(|e| Spring {
            stiffness: share[1] * e.frequency * e.frequency,
            damping: 2.0 * e.damping * share[1] * e.frequency,
        });
        let numbers = [law.position_gain, law.velocity_gain, law.integral_rate, friction.stiction, viscous];
        if numbers.iter().any(|v| !(v.is_finite() && *v >= 0.0)) || law.limit.is_nan() {
            return fault("the drive's data are not all numbers of zero or more".to_owned(), "check the joint's drive");
        }
        if spring.is_some() && share[0] <= 0.0 {
            return fault("an elastic drive whose motor has no mass".to_owned(), "state the mass of the motor");
        }
        let on_load = drive.encoder == Encoder::Load;
        let mut steps = (cycle / LONGEST_INNER_STEP - WHOLE).ceil().max(1.0);
        loop {
            let step = cycle / steps;
            let half = (drive.backlash == 0.0 && steps >= 4.0).then_some(0.5 * cycle);
            let (mechanics, gain, own) = match spring {
                None => {
                    let pair = stiff(&law, viscous, step, half);
                    let gain = pair.closed.b[1][FRICTION].min(pair.saturated.b[1][FRICTION]);
                    (Mechanics::Stiff(Box::new(pair)), gain, 1.0)
                }
                Some(s) => {
                    let touching = elastic(
                        &law,
                        viscous,
                        share,
                        s,
                        on_load,
                        [step, half.filter(|h| h * s.stiffness.sqrt() < 0.75).unwrap_or(0.0)],
                    );
                    let none = Spring { stiffness: 0.0, damping: 0.0 };
                    let apart = elastic(&law, viscous, share, none, on_load, [step, 0.0]);
                    let all = [&touching.closed, &touching.saturated, &apart.closed, &apart.saturated];
                    let gain = all.iter().map(|m| m.b[3][FRICTION]).fold(f64::INFINITY, f64::min);
                    (Mechanics::Elastic { touching: Box::new(touching), apart: Box::new(apart) }, gain, share[1])
                }
            };
            if gain >= 0.5 * step / own {
                let stable = match &mechanics {
                    Mechanics::Stiff(pair) => pair.closed.dies_out(),
                    Mechanics::Elastic { touching, .. } => touching.closed.dies_out(),
                };
                if !stable {
                    let message = format!(
                        "the loop is not stable: Kv {:.4} 1/s, velocity loop {:.2} Hz, integral time {} ms, moved mass \
                         {inertia:.6} (kg or kg mm2)",
                        law.position_gain,
                        law.velocity_gain / std::f64::consts::TAU,
                        drive.integral_time.map_or_else(|| "none".to_owned(), |t| format!("{:.3}", t * MS_PER_S)),
                    );
                    let help = "lower position_gain_1_s, raise the gain of the velocity loop or its integral time, or \
                                correct the masses";
                    return fault(message, help);
                }
                return Ok(Self {
                    law,
                    friction,
                    mechanics,
                    spring,
                    viscous,
                    share,
                    half_backlash: 0.5 * drive.backlash,
                    encoder: drive.encoder,
                    counterbalance: drive.counterbalance * scale,
                    inertia,
                    step,
                    steps: steps as usize,
                });
            }
            steps *= 2.0;
            if steps > MOST_STEPS as f64 {
                let message = format!("the drive needs inner steps below {step:.1e} s");
                return fault(message, "check gains, masses and the elastic frequency of the joint's drive");
            }
        }
    }

    /// Mass (kg) or inertia (kg mm²) of motor and load.
    pub fn inertia(&self) -> f64 {
        self.inertia
    }

    /// Inner steps of a control cycle.
    pub fn inner_steps(&self) -> usize {
        self.steps
    }

    /// Highest force (N) or torque (N mm) of the motor, where it is stated.
    pub fn max_force(&self) -> Option<f64> {
        self.law.limit.is_finite().then(|| self.to_newton(self.law.limit))
    }

    /// Force over M to N or N mm.
    pub(crate) fn to_newton(&self, acceleration: f64) -> f64 {
        acceleration * self.inertia / FROM_NEWTON
    }

    /// N or N mm to force over M.
    pub(crate) fn per_mass(&self, force: f64) -> f64 {
        force * FROM_NEWTON / self.inertia
    }
}

/// Rows of the control: force phi and its integral part, as coefficients of the N states and of the inputs.
fn control<const N: usize>(law: &Law, error: usize, offset: bool) -> ([f64; N], [f64; INPUTS]) {
    let (mut z, mut u) = ([0.0; N], [0.0; INPUTS]);
    z[error] = law.velocity_gain * law.position_gain;
    z[1] = -law.velocity_gain;
    u[RATE] = law.velocity_gain * law.velocity_forward;
    if offset {
        u[OFFSET] = law.velocity_gain * law.position_gain;
    }
    (z, u)
}

/// The integrator's row; without an integral part it decays, so that the map has no idle eigenvalue of one.
fn integrator<const N: usize>(law: &Law, closed: bool, z: &[f64; N], u: &[f64; INPUTS]) -> ([f64; N], [f64; INPUTS]) {
    let rate = law.integral_rate;
    let (mut row, mut inputs) = ([0.0; N], [0.0; INPUTS]);
    if rate == 0.0 {
        row[N - 1] = -1.0;
    } else if closed {
        row = z.map(|v| v * rate);
        inputs = u.map(|v| v * rate);
    } else {
        row[N - 1] = -rate;
        inputs[MOTOR] = rate;
        inputs[ACCELERATION] = -rate * law.acceleration_forward;
    }
    (row, inputs)
}

fn stiff(law: &Law, viscous: f64, step: f64, half: Option<f64>) -> LoopMaps<3> {
    let map = |closed: bool, step: f64| {
        let (z, u) = control::<3>(law, 0, true);
        let (i_row, i_inputs) = integrator(law, closed, &z, &u);
        let mut f = [[0.0, -1.0, 0.0], [0.0, -viscous, 0.0], i_row];
        let mut g = [[0.0; INPUTS], [0.0; INPUTS], i_inputs];
        g[0][RATE] = 1.0;
        (g[1][FRICTION], g[1][LOAD]) = (1.0, 1.0);
        if closed {
            for k in 0..3 {
                f[1][k] += z[k];
            }
            f[1][2] += 1.0;
            for k in 0..INPUTS {
                g[1][k] += u[k];
            }
            g[1][ACCELERATION] += law.acceleration_forward;
        } else {
            g[1][MOTOR] = 1.0;
        }
        Map::new(&f, &g, step)
    };
    LoopMaps { closed: map(true, step), saturated: map(false, step), half: half.map(|h| map(true, h)) }
}

fn elastic(
    law: &Law,
    viscous: f64,
    share: [f64; 2],
    spring: Spring,
    on_load: bool,
    [step, half]: [f64; 2],
) -> LoopMaps<5> {
    let Spring { stiffness: k, damping: d } = spring;
    let [m1, m2] = share;
    let map = |closed: bool, step: f64| {
        let (z, u) = control::<5>(law, if on_load { 2 } else { 0 }, false);
        let (i_row, i_inputs) = integrator(law, closed, &z, &u);
        // x1 - x2 = e2 - e1: the spring pulls the motor by -s and the load by +s.
        let s = [-k, d, k, -d, 0.0];
        let mut f = [[0.0; 5]; 5];
        f[0][1] = -1.0;
        f[1] = s.map(|v| -v / m1);
        f[2][3] = -1.0;
        f[3] = s.map(|v| v / m2);
        f[3][3] -= viscous / m2;
        f[4] = i_row;
        let mut g = [[0.0; INPUTS]; 5];
        (g[0][RATE], g[2][RATE]) = (1.0, 1.0);
        (g[1][OFFSET], g[3][OFFSET]) = (k / m1, -k / m2);
        (g[3][FRICTION], g[3][LOAD]) = (1.0 / m2, 1.0 / m2);
        g[4] = i_inputs;
        if closed {
            for n in 0..5 {
                f[1][n] += z[n] / m1;
            }
            f[1][4] += 1.0 / m1;
            for n in 0..INPUTS {
                g[1][n] += u[n] / m1;
            }
            g[1][ACCELERATION] += law.acceleration_forward / m1;
        } else {
            g[1][MOTOR] = 1.0 / m1;
        }
        Map::new(&f, &g, step)
    };
    LoopMaps { closed: map(true, step), saturated: map(false, step), half: (half > 0.0).then(|| map(true, half)) }
}
