//! The twin as plant: a machine with known limits and drives runs its air program, and is read as a
//! recorder would read it.

use std::{fmt::Write as _, path::Path};

use proveout_calibrate::{AirProgram, Trace, trace_from_text};
use proveout_controller::{
    Controller, Sample, Settings,
    servo::{DriveModel, SetPointRates},
};
use proveout_machine::Machine;
use proveout_nc::{Dialect, Program};

/// Numbers that follow from a seed (xorshift64*, Vigna 2016).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub(crate) fn even(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.even()
    }

    /// Normal with deviation one (Box and Muller 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        let (u, v) = (self.even().max(1e-300), self.even());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

/// Limits and drive of a joint, in units of the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) gain: f64,
    pub(crate) bandwidth: f64,
    pub(crate) integral_ms: f64,
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    pub(crate) mass: f64,
    pub(crate) coulomb: f64,
    pub(crate) viscous: f64,
    pub(crate) elastic: Option<f64>,
}

impl Axis {
    pub(crate) fn random(r: &mut Random) -> Self {
        let mass = r.between(100.0, 1200.0);
        let acceleration = r.between(1500.0, 7000.0);
        let gain = r.between(20.0, 60.0);
        let velocity = r.between(200.0, 700.0) * 60.0;
        let share = |r: &mut Random| match r.even() {
            e if e < 0.4 => 1.0,
            e if e < 0.6 => 0.0,
            _ => r.between(0.1, 0.9),
        };
        Self {
            velocity: velocity.round(),
            acceleration: acceleration.round(),
            jerk: (acceleration / r.between(0.02, 0.09)).round(),
            gain,
            // A loop whose parts are spread as drives are set up: the rule of machines/README.md, +-30
            // percent.
            bandwidth: gain * r.between(0.7, 1.1),
            integral_ms: 600.0 / gain * r.between(0.9, 1.3),
            alpha: share(r),
            beta: share(r),
            mass,
            coulomb: mass * r.between(0.3, 1.0),
            viscous: mass * r.between(1.0, 4.0),
            elastic: (r.even() < 0.5).then(|| 1.5 * gain * r.between(0.95, 1.2)),
        }
    }

    /// As somebody has guessed it.
    pub(crate) fn guessed(&self, r: &mut Random) -> Self {
        let mut off = |v: f64| v * r.between(0.8, 1.25);
        Self {
            velocity: off(self.velocity),
            acceleration: off(self.acceleration),
            jerk: off(self.jerk),
            gain: off(self.gain),
            bandwidth: off(self.bandwidth),
            integral_ms: off(self.integral_ms),
            alpha: 0.5,
            beta: 0.5,
            mass: self.mass,
            coulomb: off(self.coulomb),
            viscous: off(self.viscous),
            elastic: self.elastic.map(|f| f * r.between(0.92, 1.08)),
        }
    }

    fn text(&self, name: &str, direction: &str, parent: &str) -> String {
        let Self { velocity, acceleration, jerk, gain, bandwidth, integral_ms, alpha, beta, mass, .. } = self;
        let elastic = self.elastic.map_or_else(String::new, |f| {
            // A third of the mass is that of the motor.
            format!("elastic_frequency_hz = {f}\nelastic_damping = 0.08\nmotor_mass_kg = {}\n", 0.5 * mass)
        });
        format!(
            "[[joint]]\nname = \"{name}\"\nkind = \"linear\"\ncarries = \"tool\"\nparent = \"{parent}\"\n\
             direction = {direction}\ntravel_mm = [0, 400]\nhome_mm = 0\nmax_velocity_mm_min = {velocity}\n\
             rapid_velocity_mm_min = {velocity} # a guess\nmax_acceleration_mm_s2 = {acceleration}\nmax_jerk_mm_s3 = {jerk}\n\
             moving_mass_kg = {mass}\n\n\
             [joint.chosen]\n\"*\" = \"a guess\"\nmax_jerk_mm_s3 = \"a usual setting\"\n\n\
             [joint.drive]\nposition_gain_1_s = {gain}\nvelocity_bandwidth_hz = {bandwidth}\nintegral_time_ms = {integral_ms}\n\
             velocity_feed_forward = {alpha}\nacceleration_feed_forward = {beta}\ncoulomb_friction_N = {}\n\
             static_friction_N = {}\nstribeck_velocity_mm_min = 100\nviscous_friction_N_s_m = {}\nencoder = \"load\"\n{elastic}\n",
            self.coulomb,
            1.4 * self.coulomb,
            self.viscous,
        )
    }
}

/// A machine file of three slides.
pub(crate) fn machine_text(axes: &[Axis; 3]) -> String {
    [
        "name = \"plant\"\ndescription = \"for tests\"\nup = [0, 0, 1]\n\n".to_owned(),
        axes[0].text("X", "[1, 0, 0]", "Y"),
        axes[1].text("Y", "[0, 1, 0]", "base"),
        axes[2].text("Z", "[0, 0, 1]", "X"),
        "[spindle]\non = \"Z\"\norigin_mm = [0, 0, 0]\ndirection = [0, 0, 1]\nmax_speed_rpm = 12_000\nstart_time_s = 1.5\n\n\
         [table]\non = \"base\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\n\
         [control]\ncycle_time_ms = 1\nblock_time_ms = 0\ntool_change_time_s = 4\nrapid_mode = \"straight\"\n\
         default_tolerance_mm = 0.01\n"
            .to_owned(),
    ]
    .concat()
}

pub(crate) fn machine(text: &str) -> Machine {
    Machine::from_text(Path::new("plant/machine.toml"), text).unwrap_or_else(|e| panic!("{e}"))
}

/// The air program of a machine, as text.
pub(crate) fn air_text(machine: &Machine) -> String {
    let plan = AirProgram::new(machine, &[("Z".to_owned(), [0.0, 400.0])]).unwrap_or_else(|e| panic!("{e:?}"));
    plan.text(machine, Dialect::Siemens840d).unwrap_or_else(|e| panic!("{e:?}")).0
}

/// Set points, positions and forces on a grid of 1 ms.
pub(crate) struct Recording {
    pub(crate) time: Vec<f64>,
    pub(crate) line: Vec<u32>,
    /// By joint: command, actual, force.
    pub(crate) joints: Vec<[Vec<f64>; 3]>,
}

/// Runs a program on the twin's control and the twin's drives.
pub(crate) fn record(machine: &Machine, program: &str) -> Recording {
    const CYCLE: f64 = 1e-3;
    let program = Program::from_text("air.mpf", program, &proveout_nc::Settings::default()).expect("a program");
    let settings = Settings { sample_time: Some(CYCLE), ..Settings::default() };
    let mut control = Controller::new(program, machine, &[], settings).unwrap_or_else(|e| panic!("{e}"));
    let (mut samples, mut lines): (Vec<Sample>, Vec<u32>) = (Vec::new(), Vec::new());
    while let Some(chunk) = control.next_chunk().unwrap_or_else(|e| panic!("{e}")) {
        for block in &chunk.blocks {
            let index = block.index as usize;
            lines.resize(lines.len().max(index + 1), 0);
            lines[index] = block.line;
        }
        samples.extend(chunk.samples);
    }
    // A standstill has its first and last sample only.
    let mut full: Vec<Sample> = Vec::new();
    for sample in samples {
        if let Some(last) = full.last().copied() {
            let rows = ((sample.time - last.time) / CYCLE).round() as usize;
            for k in 1..rows {
                let mut hold = last;
                hold.time = last.time + k as f64 * CYCLE;
                (hold.velocity, hold.block) = (hold.velocity * 0.0, sample.block);
                full.push(hold);
            }
        }
        full.push(sample);
    }
    let line = full.iter().map(|s| lines.get(s.block as usize).copied().unwrap_or(0)).collect();
    let mut joints = Vec::new();
    for (j, joint) in machine.joints.iter().enumerate() {
        let drive = joint.drive.as_ref().expect("a drive");
        let model =
            DriveModel::new(drive, joint.moving_inertia.expect("a mass"), CYCLE).unwrap_or_else(|e| panic!("{e}"));
        let mut state = model.rest(0.0);
        let (mut actual, mut force) = (Vec::new(), Vec::new());
        for (k, sample) in full.iter().enumerate() {
            actual.push(sample.commanded[j] - state.error());
            force.push(model.force(&state));
            let Some(next) = full.get(k + 1) else { break };
            let (way, v0, v1) = (next.commanded[j] - sample.commanded[j], sample.velocity[j], next.velocity[j]);
            let rates = SetPointRates {
                velocity: v0,
                acceleration: (6.0 * way / CYCLE - 4.0 * v0 - 2.0 * v1) / CYCLE,
                jerk: (6.0 * (v0 + v1) - 12.0 * way / CYCLE) / (CYCLE * CYCLE),
            };
            model.cycle(&mut state, rates, 0.0);
        }
        joints.push([full.iter().map(|s| s.commanded[j]).collect(), actual, force]);
    }
    Recording { time: full.iter().map(|s| s.time).collect(), line, joints }
}

/// How a recorder reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorder {
    /// Every so many rows of 1 ms.
    pub(crate) every: usize,
    /// Deviation of positions, mm.
    pub(crate) noise: f64,
    /// Rounding of positions, mm; zero for all digits.
    pub(crate) rounding: f64,
    /// Deviation of forces as a part of the largest.
    pub(crate) force_noise: f64,
}

/// A table as recorders write it.
pub(crate) fn table(recording: &Recording, recorder: Recorder, seed: u64) -> String {
    let mut r = Random::new(seed);
    let mut out = "time_s,block".to_owned();
    for name in ["X", "Y", "Z"] {
        let _ = write!(out, ",{name}_command_mm,{name}_actual_mm,{name}_force_N");
    }
    out.push('\n');
    let most: Vec<f64> = recording.joints.iter().map(|j| j[2].iter().fold(0.0_f64, |m, f| m.max(f.abs()))).collect();
    for row in (0..recording.time.len()).step_by(recorder.every) {
        let _ = write!(out, "{:.6},{}", recording.time[row], recording.line[row]);
        for (joint, most) in recording.joints.iter().zip(&most) {
            for (k, column) in joint.iter().enumerate() {
                let v = column[row];
                let v = if k == 2 {
                    v + recorder.force_noise * most * r.normal()
                } else {
                    let v = v + recorder.noise * r.normal();
                    if recorder.rounding > 0.0 { (v / recorder.rounding).round() * recorder.rounding } else { v }
                };
                let _ = write!(out, ",{v:.7}");
            }
        }
        out.push('\n');
    }
    out
}

pub(crate) fn trace(text: &str, machine: &Machine) -> Trace {
    trace_from_text(Path::new("air.csv"), text, None, machine).unwrap_or_else(|e| panic!("{e}"))
}
