//! All drives of a machine together with what loads them.
//!
//! *Newton-Euler.* Each drive is stepped by itself with its own mass; weight, coupling and the change of
//! inertia with the pose come in as a force that recursive Newton-Euler finds from the set points. No load
//! loop is closed through the servo states, so that the stability of each drive is that of its own loop.
//! Exact where the joints follow their set points; with lag, inertial coupling acts early by that lag.
//!
//! *Rapier.* The bodies move as one multibody under the forces of the drives, coupling of the actual motion
//! included. The control law is sampled at the plant's step, 0.1 ms or less.

use proveout_machine::{Drive, JointValues, MAX_JOINTS, Machine};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{
    legs::Legs,
    model::{DriveModel, FROM_NEWTON},
    step::{DriveState, SetPointRates},
};
use crate::{
    dynamics::{RapierPlant, RigidTree},
    error::ControlError,
    pieces::WHOLE,
};

/// By how much bodies may be heavier than what is stated as moved by rounding, part of it.
const ROUNDING: f64 = 1e-9;

/// What moves under the forces of the drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Plant {
    /// One mass a joint, loaded by recursive Newton-Euler.
    #[default]
    NewtonEuler,
    /// Coupled rigid bodies in Rapier; every body needs a mass.
    Rapier,
}

/// Drives and plant. A drive has the index of its joint; see [`Legs`] for platforms.
#[derive(Debug)]
pub(crate) struct Bank {
    pub(crate) legs: Legs,
    pub(crate) models: Vec<DriveModel>,
    pub(crate) states: Vec<DriveState>,
    pub(crate) tree: RigidTree,
    /// Mass (kg) or inertia (kg mm²) that the drives' models count for the bodies of the tree.
    own: JointValues,
    rapier: Option<Box<RapierRun>>,
}

#[derive(Debug)]
struct RapierRun {
    plant: RapierPlant,
    step: f64,
    steps: usize,
    /// Forces on each load other than spring, friction and motor, over M, as of the last step.
    rest: [f64; MAX_JOINTS],
}

fn fault(machine: &Machine, joint: usize, message: &str, help: &str) -> Box<ControlError> {
    let name = machine.joints.get(joint).map_or("?", |j| j.name.as_str());
    Box::new(ControlError {
        code: "control-servo",
        message: format!("machine {}, joint {name}: {message}", machine.name),
        location: None,
        help: Some(help.to_owned()),
    })
}

/// Drive of a place and the mass (kg) or inertia (kg mm²) that is stated for it: that of the joint, or of a
/// leg.
fn stated<'a>(machine: &'a Machine, legs: &'a Legs, place: usize) -> (Option<&'a Drive>, Option<f64>) {
    match legs.leg(place) {
        Some((platform, leg)) => (platform.legs[leg].drive.as_ref(), platform.legs[leg].moving_mass),
        None => machine.joints.get(place).map_or((None, None), |j| (j.drive.as_ref(), j.moving_inertia)),
    }
}

/// Names of joints and legs without a drive, in the order of the joints.
pub fn without_drive(machine: &Machine) -> Vec<String> {
    let legs = Legs::new(machine);
    let missing = |j: &usize| stated(machine, &legs, *j).0.is_none();
    let name = |j: usize| legs.names(j).unwrap_or_else(|| machine.joints[j].name.clone());
    (0..machine.joints.len()).filter(missing).map(name).collect()
}

impl Bank {
    /// Drives of all joints, at rest at home.
    pub(crate) fn new(machine: &Machine, cycle: f64, plant: Plant) -> Result<Self, Box<ControlError>> {
        let legs = Legs::new(machine);
        if let (Plant::Rapier, Some(platform)) = (plant, machine.platforms.first()) {
            let message = format!("platform {} moves it by legs, whose loops the plant does not close", platform.name);
            return Err(fault(machine, platform.heave, &message, "take plant = \"newton-euler\""));
        }
        let tree = RigidTree::new(machine);
        let home = machine.home();
        let matrix = tree.mass_matrix(&home);
        let (mut models, mut own, mut armature) = (Vec::new(), JointValues::ZERO, JointValues::ZERO);
        for (j, joint) in machine.joints.iter().enumerate().take(MAX_JOINTS) {
            let (drive, stated_inertia) = stated(machine, &legs, j);
            let Some(drive) = drive else {
                let (table, owner, message) = match legs.names(j) {
                    Some(name) => {
                        let message =
                            format!("the axis dynamics are asked for and the drive of {name} is not described");
                        ("[platform.leg.drive]", name, message)
                    }
                    None => {
                        let message = "the axis dynamics are asked for and the drive is not described".to_owned();
                        ("[joint.drive]", format!("joint {}", joint.name), message)
                    }
                };
                let help = format!(
                    "add {table} with position_gain_1_s and velocity_bandwidth_hz to {owner}, or run with dynamics \
                     \"planned\""
                );
                return Err(fault(machine, j, &message, &help));
            };
            own[j] = if tree.knows(j) { matrix[(j, j)] } else { 0.0 };
            let inertia = match stated_inertia {
                Some(stated) => stated,
                None if own[j] > 0.0 => own[j],
                None => {
                    let key = if joint.is_rotary() { "moving_inertia_kg_m2" } else { "moving_mass_kg" };
                    let reason = tree.report().unknown.iter().find(|(k, _)| *k == j).map(|(_, r)| r.as_str());
                    let message =
                        format!("the drive moves an unknown mass ({})", reason.unwrap_or("bodies of no mass"));
                    let help = format!("add {key} to the joint, or mass to every body that it carries and `up`");
                    return Err(fault(machine, j, &message, &help));
                }
            };
            let model = DriveModel::new(drive, inertia, cycle).map_err(|e| fault(machine, j, &e.message, e.help))?;
            let motor = if drive.elastic.is_some() { 0.0 } else { drive.motor_inertia.unwrap_or(0.0) };
            armature[j] = motor + inertia - own[j];
            if plant == Plant::Rapier && armature[j] < -ROUNDING * inertia {
                let message =
                    format!("{inertia} is stated as moved, and its bodies alone have {} (kg or kg mm2)", own[j]);
                let help = "correct moving_mass_kg or the masses of the bodies, or take plant = \"newton-euler\"";
                return Err(fault(machine, j, &message, help));
            }
            armature[j] = armature[j].max(0.0);
            models.push(model);
        }
        let zero = JointValues::ZERO;
        let mut bank = Self { legs, models, states: Vec::new(), tree, own, rapier: None };
        let loads = bank.loads(&home, &zero, &zero);
        bank.states = bank.models.iter().enumerate().map(|(j, m)| m.rest(loads[j])).collect();
        if plant == Plant::Rapier {
            let steps = (cycle / RapierPlant::LONGEST_STEP - WHOLE).ceil().max(1.0);
            let mut plant = RapierPlant::new(&bank.tree, cycle / steps, &armature).map_err(|message| {
                let help = if cfg!(feature = "rapier") {
                    "add mass to every body and `up`, or take plant = \"newton-euler\""
                } else {
                    "build with `--features rapier`, or take plant = \"newton-euler\""
                };
                fault(machine, 0, &format!("the plant cannot be made: {message}"), help)
            })?;
            let mut at = home;
            for (j, (model, s)) in bank.models.iter().zip(&bank.states).enumerate() {
                at[j] -= if model.spring.is_some() { s.load_error } else { s.motor_error };
            }
            plant.place(&at, &zero);
            let mut rest = [0.0; MAX_JOINTS];
            for (j, model) in bank.models.iter().enumerate() {
                rest[j] = model.per_mass(loads[j]);
            }
            bank.rapier = Some(Box::new(RapierRun { plant, step: cycle / steps, steps: steps as usize, rest }));
        }
        Ok(bank)
    }

    /// Forces (N, N mm) that the bodies put on each load for a motion, in addition to the inertia
    /// of the drive's own mass; zero where masses are not known.
    pub(crate) fn loads(&self, q: &JointValues, v: &JointValues, a: &JointValues) -> JointValues {
        let tau = self.tree.inverse_dynamics(q, v, a);
        let mut loads = JointValues::ZERO;
        for j in 0..self.models.len() {
            if self.tree.knows(j) {
                loads[j] = self.own[j] * a[j] / FROM_NEWTON - tau[j];
            }
        }
        loads
    }

    /// One control cycle: the set points run from `begin` along `references`; `loads` as of [`Bank::loads`].
    pub(crate) fn cycle(&mut self, begin: &JointValues, references: &[SetPointRates; MAX_JOINTS], loads: &JointValues) {
        match &mut self.rapier {
            None => {
                for (j, (model, state)) in self.models.iter().zip(&mut self.states).enumerate() {
                    model.cycle(state, references[j], loads[j]);
                }
            }
            Some(run) => run.cycle(&self.models, &mut self.states, begin, references),
        }
    }
}

impl RapierRun {
    fn cycle(
        &mut self,
        models: &[DriveModel],
        states: &mut [DriveState],
        begin: &JointValues,
        references: &[SetPointRates; MAX_JOINTS],
    ) {
        let h = self.step;
        for k in 0..self.steps {
            let before = h * k as f64;
            let mut tau = JointValues::ZERO;
            let mut given = [0.0; MAX_JOINTS];
            for (j, (model, s)) in models.iter().zip(states.iter_mut()).enumerate() {
                let r = references[j].after(before);
                given[j] = model.on_load(s, &r, self.rest[j], h);
                tau[j] = model.to_newton(given[j]);
            }
            self.plant.step(&tau);
            let (q, v) = (self.plant.position(), self.plant.velocity());
            for (j, (model, s)) in models.iter().zip(states.iter_mut()).enumerate() {
                let r = references[j].after(before);
                let set = begin[j] + references[j].way(before) + r.way(h);
                let old = if model.spring.is_some() { s.load_velocity } else { s.motor_velocity };
                let own = if model.spring.is_some() { model.share[1] } else { 1.0 };
                self.rest[j] = own * (v[j] - old) / h - given[j];
                model.moved(s, &r, set - q[j], v[j], h);
            }
        }
    }
}

impl DriveModel {
    /// Sampled control and motor of one step in front of an outer plant; gives the force on the load over M.
    fn on_load(&self, s: &mut DriveState, r: &SetPointRates, rest: f64, h: f64) -> f64 {
        let law = &self.law;
        let feedback = match self.encoder {
            proveout_machine::Encoder::Motor => s.motor_error,
            proveout_machine::Encoder::Load => s.load_error,
        };
        let asked = law.demand(feedback, s.motor_velocity, s.integral, r.velocity, r.acceleration);
        let force = asked.clamp(-law.limit, law.limit);
        if asked == force {
            let e = law.position_gain * feedback + law.velocity_forward * r.velocity - s.motor_velocity;
            s.integral += h * law.integral_rate * law.velocity_gain * e;
        } else {
            s.note_excess(asked);
            s.integral += h * law.integral_rate * (force - law.acceleration_forward * r.acceleration - s.integral);
        }
        let (push, own) = match self.spring {
            None => (force, 1.0),
            Some(k) => {
                let d = s.load_error - s.motor_error;
                let gap = d - d.clamp(-self.half_backlash, self.half_backlash);
                let touching = self.half_backlash == 0.0 || gap != 0.0;
                let pull =
                    k.stiffness * gap + if touching { k.damping * (s.motor_velocity - s.load_velocity) } else { 0.0 };
                s.motor_velocity += h * (force - pull) / self.share[0];
                (pull, self.share[1])
            }
        };
        let velocity = if self.spring.is_some() { s.load_velocity } else { s.motor_velocity };
        let smooth = push - self.viscous * velocity + self.counterbalance;
        let free = velocity + h * (smooth + rest) / own;
        let (friction, _) = self.friction.force(free, h / own, velocity);
        s.force = force;
        smooth + friction
    }

    /// Takes over where the outer plant has brought the load, `error` and velocity at the end of the step.
    fn moved(&self, s: &mut DriveState, r: &SetPointRates, error: f64, velocity: f64, h: f64) {
        let before = s.load_velocity;
        if self.spring.is_some() {
            s.motor_error += r.way(h) - h * s.motor_velocity;
            s.load_error = error;
            s.load_velocity = velocity;
        } else {
            let way = r.way(h) - (error - s.motor_error);
            s.motor_error = error;
            s.motor_velocity = velocity;
            if self.half_backlash == 0.0 {
                s.load_velocity = velocity;
            } else {
                s.play = (s.play + way).clamp(-self.half_backlash, self.half_backlash);
                s.load_velocity = if s.play.abs() >= self.half_backlash { velocity } else { 0.0 };
            }
            s.load_error = error + s.play;
        }
        s.note_acceleration((s.load_velocity - before) / h);
        let force = s.force;
        s.book(self, force, h);
    }
}
