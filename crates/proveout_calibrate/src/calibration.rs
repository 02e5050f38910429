//! All estimators over all joints, and what they found as one list.

use proveout_controller::dynamics::RigidTree;
use proveout_input::{InputError, InputFault};
use proveout_machine::{Drive, Joint, Machine};
use serde::Serialize;

use crate::{
    fit::{
        friction::{FrictionFit, fit_friction},
        limits::{LimitsFit, fit_limits},
        moves::{JointMoves, moves},
        servo::{KnownFriction, fit_servo},
    },
    parameters::{Sink, put_friction, put_limits, put_servo},
    times::{WordTime, WordTimes},
    trace::{JointTrace, Trace},
};

/// Quotients of a measured and a stated velocity that a wrong unit makes, with the word for it.
const UNIT_SLIPS: [(f64, &str); 8] = [
    (25.4, "the positions are in inch, or were converted twice"),
    (1.0 / 25.4, "the positions are in inch"),
    (1e3, "the positions are in micrometers, or the time in milliseconds"),
    (1e-3, "the positions are in meters, or the time in milliseconds"),
    (57.295_779_513, "the positions are in degrees, not radian"),
    (0.017_453_292_5, "the positions are in radian, not degrees"),
    (60.0, "the time is in minutes"),
    (1.0 / 60.0, "the time is in minutes"),
];
/// Part by which such a quotient may be missed.
const SLIP: f64 = 0.03;

/// Table of the machine file that a parameter belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Table {
    /// `[[joint]]`.
    Joint,
    /// `[joint.drive]`.
    Drive,
    /// `[control]`.
    Control,
}

/// One value of the machine file, in the unit of its key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Joint; none for the control.
    pub joint: Option<String>,
    /// Table.
    pub table: Table,
    /// Key.
    pub key: &'static str,
    /// Value of the machine file.
    pub before: Option<f64>,
    /// Estimate, where the data have one.
    pub estimate: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// The estimate replaces the value of the machine file.
    pub written: bool,
    /// Why it does not; empty where it does.
    pub reason: String,
}

/// A correlation of two estimates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Correlation {
    /// Keys of both.
    pub keys: [&'static str; 2],
    /// Minus one to one.
    pub correlation: f64,
}

/// What was found of one joint besides its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JointReport {
    /// Name.
    pub name: String,
    /// Moves of this joint alone, from rest to rest, that were used.
    pub moves: usize,
    /// Those that run at the velocity of rapids.
    pub moves_at_velocity: usize,
    /// Moves together with other joints, which no estimator uses.
    pub moves_together: usize,
    /// Moves at another override than 100 percent, left out.
    pub moves_overridden: usize,
    /// Moves that no law fits, left out: feed hold, single block.
    pub moves_unfit: usize,
    /// Rounding of the set points and of the measured positions, mm or degrees; zero where there is none.
    pub rounding: [Option<f64>; 2],
    /// Noise of both at rest, mm or degrees.
    pub noise: [Option<f64>; 2],
    /// The interpolator in words.
    pub interpolator: Option<&'static str>,
    /// Interpolators that fit as well.
    pub interpolators_alike: Vec<&'static str>,
    /// Moving averages of the interpolator and their standard errors, ms.
    pub averages_ms: Vec<[f64; 2]>,
    /// Root mean square of the residuals of the set points, in standard deviations of a row.
    pub misfit: Option<f64>,
    /// Variances of limits and of the drive were widened by these factors, for residuals that are larger than
    /// noise and rounding, or go together.
    pub widened: [Option<f64>; 2],
    /// Largest following error, and what the fitted drive leaves of it (root mean square), mm or degrees.
    pub following_error: Option<[f64; 2]>,
    /// Moved mass (kg) or inertia (kg m²) from the force, with its standard error.
    pub moved_mass: Option<[f64; 2]>,
    /// What the balance of momentum leaves of the force (standard deviation over a block of time), in N, N
    /// mm, or the unit of its column.
    pub force_left: Option<f64>,
    /// Friction in the unit of a column that is no force: dry, its standard error.
    pub friction_in_unit: Option<([f64; 2], &'static str)>,
    /// Pairs of estimates that go together.
    pub correlations: Vec<Correlation>,
}

/// Everything that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Calibration {
    /// Name of the machine.
    pub machine: String,
    /// Traces by name and SHA-256.
    pub traces: Vec<[String; 2]>,
    /// Values of the machine file.
    pub parameters: Vec<Parameter>,
    /// One entry for each joint that a trace has.
    pub joints: Vec<JointReport>,
    /// Times of standstills by their word, where the trace has lines of a program.
    pub word_times: Vec<WordTime>,
    /// Source note for the machine file.
    #[serde(skip)]
    pub source: String,
}

/// Estimates everything that the traces hold.
///
/// `words` are the standstills of the program, where the traces state its lines.
///
/// # Errors
/// [`InputError`] where a trace cannot belong to this machine or program, or no joint moves alone.
pub fn calibrate(machine: &Machine, traces: &[Trace], words: Option<&WordTimes>) -> Result<Calibration, InputError> {
    let fault = |message: String, remedy: &str| -> InputError {
        let file = traces.first().map_or_else(Default::default, |t| t.name.as_str().into());
        InputFault { code: "trace", file, message, remedy: remedy.into(), ..InputFault::default() }.into()
    };
    let mut by_joint: Vec<JointMoves> = machine.joints.iter().map(|_| JointMoves::default()).collect();
    for (k, trace) in traces.iter().enumerate() {
        for (all, found) in by_joint.iter_mut().zip(moves(k, trace)) {
            all.moves.extend(found.moves);
            all.together += found.together;
            all.overridden += found.overridden;
        }
    }
    let [mut alone, mut together, mut overridden] = [0; 3];
    for found in &by_joint {
        alone += found.moves.len();
        together += found.together;
        overridden += found.overridden;
    }
    if alone == 0 {
        let message = format!(
            "no joint moves alone from rest to rest: {together} motions of several joints, {overridden} at another override \
             than 100 percent"
        );
        return Err(fault(message, "record the program of `proveout calibrate plan` at 100 percent"));
    }
    let labels: Vec<String> = traces.iter().map(Trace::label).collect();
    let mut out = Calibration {
        machine: machine.name.clone(),
        traces: traces.iter().map(|t| [t.name.clone(), t.sha256.clone()]).collect(),
        parameters: Vec::new(),
        joints: Vec::new(),
        word_times: Vec::new(),
        source: format!("fitted to {}", labels.join(", ")),
    };
    // What a drive moves, where the file states no mass: the bodies, as the servo of the twin has it.
    let bodies = RigidTree::new(machine);
    let masses = bodies.mass_matrix(&machine.home());
    for (index, found) in by_joint.into_iter().enumerate() {
        let of_joint: Vec<&JointTrace> =
            traces.iter().filter_map(|t| t.joints.get(index).and_then(Option::as_ref)).collect();
        let Some(joint) = machine.joints.get(index).filter(|_| !of_joint.is_empty()) else { continue };
        let inertia = joint.moving_inertia.or_else(|| bodies.knows(index).then(|| masses[(index, index)]));
        let inertia = inertia.filter(|m| *m > 0.0);
        one_joint((index, joint, inertia), found, &of_joint, traces, &mut out)
            .map_err(|(message, remedy)| fault(message, remedy))?;
    }
    if let Some(words) = words {
        out.word_times = words.measured(traces).map_err(|(message, remedy)| fault(message, remedy))?;
        let before = machine.control.tool_change_time;
        if let Some(change) = out.word_times.iter().find(|t| t.word == "tool change") {
            out.parameters.push(Parameter {
                joint: None,
                table: Table::Control,
                key: "tool_change_time_s",
                before: Some(before),
                estimate: Some(change.mean_s),
                standard_error: Some(change.standard_error_s),
                written: true,
                reason: String::new(),
            });
        }
    }
    Ok(out)
}

fn one_joint(
    (index, joint, inertia): (usize, &Joint, Option<f64>),
    found: JointMoves,
    of_joint: &[&JointTrace],
    traces: &[Trace],
    out: &mut Calibration,
) -> Result<(), (String, &'static str)> {
    let rotary = joint.is_rotary();
    let unit = joint.kind.unit_factor();
    let coarsest = |of: fn(&JointTrace) -> Option<f64>| of_joint.iter().filter_map(|j| of(j)).reduce(f64::max);
    let mut report = JointReport {
        name: joint.name.clone(),
        moves_together: found.together,
        moves_overridden: found.overridden,
        rounding: [
            coarsest(|j| j.command.as_ref().map(|s| s.quantum)),
            coarsest(|j| j.actual.as_ref().map(|s| s.quantum)),
        ]
        .map(|v| v.map(|v| v * unit)),
        noise: [coarsest(|j| j.command.as_ref().map(|s| s.noise)), coarsest(|j| j.actual.as_ref().map(|s| s.noise))]
            .map(|v| v.map(|v| v * unit)),
        ..JointReport::default()
    };
    let all_moves = found.moves.clone();
    let mut sink = Sink { joint, out: &mut out.parameters };
    let commanded = of_joint.iter().all(|j| j.command.is_some());
    let limits = fit_limits(found.moves, traces, |t| {
        let j = t.joints.get(index)?.as_ref()?;
        if commanded { j.command.as_ref() } else { j.actual.as_ref() }
    });
    if let Some(limits) = &limits {
        unit_slip(joint, limits)?;
    }
    put_limits(&mut sink, joint, limits.as_ref(), commanded, &mut report);
    let Some(limits) = limits else {
        out.joints.push(report);
        return Ok(());
    };
    let friction = fit_friction(index, rotary, joint.drive.as_ref().and_then(stribeck), &all_moves, traces);
    let servo = if commanded && of_joint.iter().all(|j| j.actual.is_some()) {
        fit_servo(joint.drive.as_ref(), inertia, friction_over_mass(&friction), (index, rotary), &limits, traces)
    } else {
        Err("it takes command and measured position beside each other".to_owned())
    };
    put_servo(&mut sink, joint, &servo, &mut report);
    let known = of_joint.iter().all(|j| j.force_known);
    let unit_name = of_joint.iter().find_map(|j| j.force_unit).map_or("", |u| u.name());
    put_friction(&mut sink, joint, &friction, known, unit_name, &mut report);
    out.joints.push(report);
    Ok(())
}

/// Friction over the moved mass, in the unit in which the drive model counts; none where it is not known.
fn friction_over_mass(friction: &Result<FrictionFit, String>) -> Option<KnownFriction> {
    let fit = friction.as_ref().ok()?;
    let ([mass, of_mass], (coulomb, of_coulomb), (viscous, of_viscous)) = (fit.mass, fit.coulomb, fit.viscous);
    // The mass of the balance is F/a in N s2/mm, a thousandth of kg.
    const KG: f64 = 1e3;
    // Friction changes along the travel by more than a balance over all of it shows.
    const LEAST_PART: f64 = 0.01;
    let over = |value: f64, error: Option<f64>| {
        let part = (error? / value).hypot(of_mass / mass);
        (value > 0.0 && mass > 0.0 && part < 1.0).then_some([value / (mass * KG), part.max(LEAST_PART)])
    };
    Some(KnownFriction { coulomb: over(coulomb, of_coulomb)?, viscous: over(viscous, of_viscous)? })
}

fn stribeck(drive: &Drive) -> Option<f64> {
    Some(drive.stribeck_velocity).filter(|v| *v > 0.0)
}

/// A velocity that is off by a factor of units.
fn unit_slip(joint: &Joint, limits: &LimitsFit) -> Result<(), (String, &'static str)> {
    let Some(rapid) = joint.rapid_velocity.or(joint.max_velocity).filter(|_| limits.at_velocity > 0) else {
        return Ok(());
    };
    let quotient = limits.best.shape.velocity / rapid;
    let slip = UNIT_SLIPS.iter().find(|(of, _)| (quotient / of - 1.0).abs() < SLIP);
    let Some((_, words)) = slip else { return Ok(()) };
    let message = format!("{} moves at {:.4} times the velocity of the machine file: {words}", joint.name, quotient);
    Err((message, "state the unit of the column; where it is right, correct the velocity in the machine file first"))
}
