//! The changing part of a drive and its inner step.
//!
//! *Saturation.* A step begins saturated when the control asks for more than the limit; a step that would end
//! beyond it is taken again with the limit, so that the force never passes it.
//!
//! *Gliding.* Where a drive without lost motion begins a cycle in motion, well above the Stribeck
//! velocity and below the force limit, friction is a constant and the loop linear: two maps over
//! half a cycle each give the same state as all the inner steps. They are taken when velocity and
//! force have kept their sides at begin, middle and end, with a distance larger than they change in
//! between; otherwise the cycle is made in inner steps. In a stiff drive that sticks while its set
//! point is constant only the integrator winds up, along a line.

use proveout_machine::Encoder;

use super::{
    linear::{FRICTION, INPUTS, LOAD, MOTOR, Map, OFFSET},
    model::{DriveModel, LoopMaps, Mechanics},
};

/// kg mm²/s³ make W.
const TO_WATT: f64 = 1e-6;

/// The set point's derivatives; the jerk is constant over the time for which they are used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPointRates {
    /// mm/s or rad/s.
    pub velocity: f64,
    /// mm/s² or rad/s².
    pub acceleration: f64,
    /// mm/s³ or rad/s³.
    pub jerk: f64,
}

impl SetPointRates {
    /// Way within a time.
    pub(crate) fn way(&self, h: f64) -> f64 {
        h * (self.velocity + h * (0.5 * self.acceleration + h * self.jerk / 6.0))
    }

    pub(crate) fn after(&self, h: f64) -> Self {
        Self {
            velocity: self.velocity + h * (self.acceleration + 0.5 * h * self.jerk),
            acceleration: self.acceleration + h * self.jerk,
            jerk: self.jerk,
        }
    }
}

/// All that changes in a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveState {
    /// Set point minus motor position, mm or radian.
    pub(crate) motor_error: f64,
    pub(crate) motor_velocity: f64,
    /// Set point minus load position.
    pub(crate) load_error: f64,
    pub(crate) load_velocity: f64,
    /// Integral part over M.
    pub(crate) integral: f64,
    /// Motor minus load of a stiff drive with lost motion.
    pub(crate) play: f64,
    /// Force over M.
    pub(crate) force: f64,
    /// Mechanical power of the motor, W.
    power: f64,
    /// Work drawn by the motor, J; what it gives back when it brakes is not taken off.
    energy: f64,
    /// Largest force over M that the control has asked for beyond the limit since
    /// [`DriveState::take_excess`].
    excess: f64,
    /// Extremes of the load's acceleration since [`DriveState::take_accelerations`].
    extremes: Option<[f64; 2]>,
}

impl DriveState {
    /// Set point minus load position, mm or radian.
    pub fn error(&self) -> f64 {
        self.load_error
    }

    /// Velocity of the load.
    pub fn velocity(&self) -> f64 {
        self.load_velocity
    }

    /// Velocity of the motor, at the joint.
    pub fn motor_velocity(&self) -> f64 {
        self.motor_velocity
    }

    /// Mechanical power of the motor, W.
    pub fn power(&self) -> f64 {
        self.power
    }

    /// Work drawn so far, J, without what braking gives back.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// The set point jumps.
    pub fn jump(&mut self, way: f64) {
        self.motor_error += way;
        self.load_error += way;
    }

    /// True when every number is finite.
    pub fn is_finite(&self) -> bool {
        let all = [self.motor_error, self.motor_velocity, self.load_error, self.load_velocity, self.integral];
        all.iter().chain(&[self.play, self.force, self.power, self.energy]).all(|v| v.is_finite())
    }

    pub(crate) fn take_excess(&mut self) -> f64 {
        std::mem::take(&mut self.excess)
    }

    pub(crate) fn take_accelerations(&mut self) -> [f64; 2] {
        self.extremes.take().unwrap_or([0.0; 2])
    }

    pub(crate) fn note_excess(&mut self, demand: f64) {
        if demand.abs() > self.excess.abs() {
            self.excess = demand;
        }
    }

    pub(crate) fn note_acceleration(&mut self, a: f64) {
        let [low, high] = self.extremes.unwrap_or([a, a]);
        self.extremes = Some([low.min(a), high.max(a)]);
    }

    /// Books force and motor velocity at the end of a step of length `h`.
    pub(crate) fn book(&mut self, model: &DriveModel, force: f64, h: f64) {
        self.force = force;
        let power = force * self.motor_velocity * model.inertia() * TO_WATT;
        self.energy += (0.5 * (power + self.power)).max(0.0) * h;
        self.power = power;
    }
}

impl DriveModel {
    /// A drive at rest on its set point that holds the load's force (N or N mm, positive in the direction of
    /// growing values): the integral part carries it; without one the drive sags.
    pub fn rest(&self, load: f64) -> DriveState {
        let w = self.per_mass(load) + self.counterbalance;
        let mut s = DriveState { force: -w, ..DriveState::default() };
        let sag = if self.law.integral_rate > 0.0 {
            s.integral = -w;
            0.0
        } else {
            -w / (self.law.velocity_gain * self.law.position_gain)
        };
        // The load leans on the flank to which its force pushes it.
        let lean = match self.spring {
            None => 0.0,
            Some(k) => -w / k.stiffness,
        } - if w == 0.0 { 0.0 } else { self.half_backlash * w.signum() };
        if self.spring.is_none() {
            s.play = lean;
        }
        (s.motor_error, s.load_error) = match self.encoder {
            Encoder::Motor => (sag, sag + lean),
            Encoder::Load => (sag - lean, sag),
        };
        s
    }

    /// Motor force in N or N mm.
    pub fn force(&self, state: &DriveState) -> f64 {
        self.to_newton(state.force)
    }

    /// One control cycle: the reference runs on from `reference` with constant jerk; `load` is the force on
    /// the load, N or N mm.
    pub fn cycle(&self, state: &mut DriveState, reference: SetPointRates, load: f64) {
        let w = self.per_mass(load) + self.counterbalance;
        if self.glides(state, &reference, w) || self.stands(state, &reference, w) {
            return;
        }
        let mut r = reference;
        for _ in 0..self.steps {
            self.advance(state, &r, w);
            r = r.after(self.step);
        }
    }

    /// A whole cycle in two maps, if the drive keeps its mode; false, and nothing is changed, where it may
    /// not.
    fn glides(&self, s: &mut DriveState, r: &SetPointRates, w: f64) -> bool {
        match &self.mechanics {
            Mechanics::Stiff(pair) => {
                let Some(half) = &pair.half else { return false };
                let z = [s.motor_error, s.motor_velocity, s.integral];
                let Some([(middle, f1), (end, f2)]) = self.glide(half, s, z, [0, 1], r, w) else { return false };
                for (z, force) in [(middle, f1), (end, f2)] {
                    [s.motor_error, s.motor_velocity, s.integral] = z;
                    (s.load_error, s.load_velocity) = (s.motor_error, s.motor_velocity);
                    s.book(self, force, 0.5 * self.step * self.steps as f64);
                }
            }
            Mechanics::Elastic { touching, .. } => {
                let Some(half) = &touching.half else { return false };
                let z = [s.motor_error, s.motor_velocity, s.load_error, s.load_velocity, s.integral];
                let error = if self.encoder == Encoder::Load { 2 } else { 0 };
                let Some([(middle, f1), (end, f2)]) = self.glide(half, s, z, [error, 3], r, w) else { return false };
                for (z, force) in [(middle, f1), (end, f2)] {
                    [s.motor_error, s.motor_velocity, s.load_error, s.load_velocity, s.integral] = z;
                    s.book(self, force, 0.5 * self.step * self.steps as f64);
                }
            }
        }
        true
    }

    /// States and forces in the middle and at the end of a cycle in which the drive keeps its mode.
    fn glide<const N: usize>(
        &self,
        half: &Map<N>,
        s: &mut DriveState,
        z: [f64; N],
        [error, moving]: [usize; 2],
        r: &SetPointRates,
        w: f64,
    ) -> Option<[([f64; N], f64); 2]> {
        let (law, h) = (&self.law, 0.5 * self.step * self.steps as f64);
        let direction = z[moving].signum();
        let friction = -self.friction.coulomb * direction;
        // Three times the Stribeck velocity leave e^-9, 1.2e-4, of the difference between static and dry
        // friction.
        let slowest = 3.0 * self.friction.stribeck;
        let dry = self.friction.stiction > 0.0;
        if dry && z[moving].abs() <= slowest {
            return None;
        }
        let demand = |z: &[f64; N], r: &SetPointRates| law.demand(z[error], z[1], z[N - 1], r.velocity, r.acceleration);
        let pulled = |z: &[f64; N], force: f64| match self.spring {
            None => force - self.viscous * z[1] + friction + w,
            Some(k) => {
                let pull = k.stiffness * (z[2] - z[0]) + k.damping * (z[1] - z[3]);
                (pull - self.viscous * z[3] + friction + w) / self.share[1]
            }
        };
        let mut from = (z, demand(&z, r));
        let mut accelerations = [pulled(&z, from.1); 5];
        let mut at = *r;
        let mut out = [from; 2];
        for (k, place) in out.iter_mut().enumerate() {
            let u = [at.velocity, at.acceleration, at.jerk, friction, w, 0.0, 0.0];
            let end = half.apply(&from.0, &u);
            at = at.after(h);
            let force = demand(&end, &at);
            let change = (end[moving] - from.0[moving]).abs();
            let kept = end[moving] * direction > slowest + change && from.0[moving].abs() > change;
            if dry && !kept || from.1.abs().max(force.abs()) + (force - from.1).abs() > law.limit {
                return None;
            }
            accelerations[2 * k + 1] = (end[moving] - from.0[moving]) / h;
            accelerations[2 * k + 2] = pulled(&end, force);
            from = (end, force);
            *place = from;
        }
        for a in accelerations {
            s.note_acceleration(a);
        }
        Some(out)
    }

    /// A whole cycle of a stiff drive that sticks under a standing set point; false, and nothing is changed,
    /// where it may move.
    fn stands(&self, s: &mut DriveState, r: &SetPointRates, w: f64) -> bool {
        let Mechanics::Stiff(_) = self.mechanics else { return false };
        let still = s.motor_velocity == 0.0 && *r == SetPointRates::default() && self.half_backlash == 0.0;
        if !still || self.friction.stiction == 0.0 {
            return false;
        }
        let (law, time) = (&self.law, self.step * self.steps as f64);
        let pull = law.velocity_gain * law.position_gain * s.motor_error;
        let wound = s.integral + law.integral_rate * pull * time;
        let (begin, end) = (pull + s.integral, pull + wound);
        let held = |force: f64| (force + w).abs() <= self.friction.stiction && force.abs() <= law.limit;
        if !held(begin) || !held(end) || law.integral_rate == 0.0 && s.integral != 0.0 {
            return false;
        }
        s.integral = wound;
        s.load_velocity = 0.0;
        s.note_acceleration(0.0);
        s.book(self, end, time);
        true
    }

    /// One inner step; `w` over M.
    #[inline]
    fn advance(&self, s: &mut DriveState, r: &SetPointRates, w: f64) {
        let before = s.load_velocity;
        let next = r.after(self.step);
        let force = match &self.mechanics {
            Mechanics::Stiff(pair) => self.stiff(pair, s, r, &next, w),
            Mechanics::Elastic { touching, apart } => {
                let d = s.load_error - s.motor_error;
                let (pair, offset) = if self.half_backlash == 0.0 {
                    (touching, 0.0)
                } else if d.abs() >= self.half_backlash {
                    (touching, self.half_backlash.copysign(d))
                } else {
                    (apart, 0.0)
                };
                self.elastic(pair, s, r, &next, w, offset)
            }
        };
        s.book(self, force, self.step);
        s.note_acceleration((s.load_velocity - before) / self.step);
    }

    /// Steps the map of a mode: `error` and `moving` are the states of the encoder and of the mass with
    /// friction, `at` is added to the encoder's error.
    #[expect(clippy::too_many_arguments, reason = "one step of a mode needs what the mode is")]
    #[inline]
    fn through<const N: usize>(
        &self,
        pair: &LoopMaps<N>,
        s: &mut DriveState,
        z: [f64; N],
        u: &mut [f64; INPUTS],
        [error, moving]: [usize; 2],
        at: f64,
        next: &SetPointRates,
    ) -> ([f64; N], f64) {
        let law = &self.law;
        let begin = law.demand(z[error] + at, z[1], z[N - 1], u[0], u[1]);
        let mut saturated = begin.abs() > law.limit;
        let mut motor = begin;
        loop {
            let map = if saturated {
                s.note_excess(motor);
                motor = law.limit.copysign(motor);
                u[MOTOR] = motor;
                &pair.saturated
            } else {
                &pair.closed
            };
            let mut end = map.apply(&z, u);
            let gain = map.b[moving][FRICTION];
            let (f, sticks) = self.friction.force(end[moving], gain, z[moving]);
            if f != 0.0 {
                for k in 0..N {
                    end[k] += map.b[k][FRICTION] * f;
                }
            }
            if sticks {
                end[moving] = 0.0;
            }
            if saturated {
                return (end, motor);
            }
            motor = law.demand(end[error] + at, end[1], end[N - 1], next.velocity, next.acceleration);
            if motor.abs() <= law.limit {
                return (end, motor);
            }
            saturated = true;
        }
    }

    fn stiff(&self, pair: &LoopMaps<3>, s: &mut DriveState, r: &SetPointRates, next: &SetPointRates, w: f64) -> f64 {
        let at = if self.encoder == Encoder::Load { s.play } else { 0.0 };
        let mut u = [r.velocity, r.acceleration, r.jerk, 0.0, w, 0.0, at];
        let z = [s.motor_error, s.motor_velocity, s.integral];
        let (end, force) = self.through(pair, s, z, &mut u, [0, 1], at, next);
        let way = r.way(self.step) - (end[0] - s.motor_error);
        [s.motor_error, s.motor_velocity, s.integral] = end;
        self.push_load(s, way, w);
        s.load_error = s.motor_error + s.play;
        force
    }

    fn elastic(
        &self,
        pair: &LoopMaps<5>,
        s: &mut DriveState,
        r: &SetPointRates,
        next: &SetPointRates,
        w: f64,
        offset: f64,
    ) -> f64 {
        let mut u = [r.velocity, r.acceleration, r.jerk, 0.0, 0.0, 0.0, 0.0];
        (u[LOAD], u[OFFSET]) = (w, offset);
        let z = [s.motor_error, s.motor_velocity, s.load_error, s.load_velocity, s.integral];
        let error = if self.encoder == Encoder::Load { 2 } else { 0 };
        let (end, force) = self.through(pair, s, z, &mut u, [error, 3], 0.0, next);
        [s.motor_error, s.motor_velocity, s.load_error, s.load_velocity, s.integral] = end;
        force
    }
}
