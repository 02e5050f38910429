//! All estimators over all joints, and what they found as one list.

use proveout_controller::dynamics::RigidTree;
use proveout_input::{InputError, InputFault};
use proveout_machine::{Drive, Joint, Machine, VelocityGain};
use serde::Serialize;

use crate::{
    fit::{
        friction::{FrictionFit, fit_friction},
        limits::{LimitsFit, fit_limits},
        moves::{JointMoves, moves},
        servo::{KnownFriction, ServoFit, ServoParameter, fit_servo},
    },
    times::{WordTime, WordTimes},
    trace::{JointTrace, Trace},
};

/// A value whose standard error is above this part of it is not written: the machine file keeps its own.
const KNOWN: f64 = 0.1;
/// The same of a share between zero and one.
const KNOWN_SHARE: f64 = 0.05;
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
/// Correlations below this are not listed.
const LISTED_CORRELATION: f64 = 0.5;
/// mm/min of a mm/s.
const MM_MIN: f64 = 60.0;
const N_MM_PER_N_M: f64 = 1e3;
const N_S_M_PER_N_S_MM: f64 = 1e3;

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
    /// What the balance of momentum leaves of the force (standard deviation over a block of time), in N, N mm, or
    /// the unit of its column.
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

/// Collects parameters of one joint.
struct Sink<'a> {
    joint: &'a Joint,
    out: &'a mut Vec<Parameter>,
}

impl Sink<'_> {
    /// Notes an estimate; `share` for one between zero and one.
    fn put(
        &mut self,
        table: Table,
        key: &'static str,
        before: Option<f64>,
        found: Option<(f64, Option<f64>)>,
        share: bool,
        reason: &str,
    ) {
        let (estimate, standard_error) = found.map_or((None, None), |(v, e)| (Some(v), e));
        let part = |v: f64, e: f64| if share { e / KNOWN_SHARE } else { e / (KNOWN * v.abs()) };
        let known = estimate.zip(standard_error).is_some_and(|(v, e)| part(v, e) <= 1.0);
        let reason = match (known, reason, estimate, standard_error) {
            (true, "", ..) => String::new(),
            (_, "", Some(v), Some(e)) if share => format!("known to {e:.2} only, about {v:.2}"),
            (_, "", Some(v), Some(e)) => {
                format!("known to {:.0} percent only", 100.0 * e / v.abs().max(f64::MIN_POSITIVE))
            }
            (_, "", ..) => "the moves do not determine it".to_owned(),
            (_, reason, ..) => reason.to_owned(),
        };
        let written = known && reason.is_empty();
        self.out.push(Parameter {
            joint: Some(self.joint.name.clone()),
            table,
            key,
            before,
            estimate,
            standard_error,
            written,
            reason,
        });
    }
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

fn put_limits(
    sink: &mut Sink<'_>,
    joint: &Joint,
    limits: Option<&LimitsFit>,
    commanded: bool,
    report: &mut JointReport,
) {
    let rotary = joint.is_rotary();
    let degrees = 1_f64.to_degrees();
    let (keys, factors) = if rotary {
        (["rapid_velocity_deg_s", "max_acceleration_deg_s2", "max_jerk_deg_s3"], [degrees; 3])
    } else {
        (["rapid_velocity_mm_min", "max_acceleration_mm_s2", "max_jerk_mm_s3"], [MM_MIN, 1.0, 1.0])
    };
    let before = [joint.rapid_velocity.or(joint.max_velocity), joint.max_acceleration, joint.max_jerk];
    let before: [Option<f64>; 3] = std::array::from_fn(|k| before[k].map(|v| v * factors[k]));
    let Some(fit) = limits else {
        for (key, before) in keys.into_iter().zip(before) {
            sink.put(Table::Joint, key, before, None, false, "this joint does not move alone in the trace");
        }
        return;
    };
    let best = &fit.best;
    report.moves = fit.moves.len();
    report.moves_at_velocity = fit.at_velocity;
    report.moves_unfit = fit.unfit;
    report.misfit = Some(best.misfit);
    report.widened[0] = Some(best.minimum.inflation);
    let [ev, e1, e2] = best.errors;
    let found = (best.shape.velocity, ev.map(|e| e * best.shape.velocity));
    let reason = if fit.at_velocity == 0 { "no move runs steadily at it: a longer one is needed" } else { "" };
    let scaled = |(v, e): (f64, Option<f64>), k: usize| (v * factors[k], e.map(|e: f64| e * factors[k]));
    sink.put(Table::Joint, keys[0], before[0], Some(scaled(found, 0)), false, reason);
    if !commanded {
        let reason = "it takes the commanded position: the measured one has the lag of the drive in it";
        sink.put(Table::Joint, keys[1], before[1], None, false, reason);
        sink.put(Table::Joint, keys[2], before[2], None, false, reason);
        return;
    }
    report.interpolator = Some(best.kind.words());
    report.interpolators_alike = fit.alike.iter().map(|k| k.words()).collect();
    let ms = |v: f64, e: Option<f64>| [1e3 * v, e.map_or(f64::INFINITY, |e| 1e3 * v * e)];
    use crate::fit::law::LawKind::{JerkLimited, OneAverage, SmoothedTrapezoid, Trapezoid, TwoAverages};
    let shape = best.shape.shape;
    match best.kind {
        OneAverage => report.averages_ms.push(ms(shape[0], e1)),
        TwoAverages => report.averages_ms.extend([ms(shape[0], e1), ms(shape[1], e2)]),
        SmoothedTrapezoid => report.averages_ms.push(ms(shape[1], e2)),
        JerkLimited | Trapezoid => {}
    }
    // Errors of products and quotients of the fitted numbers, by their logarithms.
    let c = &best.correlations;
    let combined = |weights: [f64; 3]| -> Option<f64> {
        let e = [ev, e1, e2];
        let mut sum = 0.0;
        for i in 0..3 {
            for k in 0..3 {
                if weights[i] != 0.0 && weights[k] != 0.0 {
                    sum += weights[i] * weights[k] * e[i]? * e[k]? * if i == k { 1.0 } else { c[i][k] };
                }
            }
        }
        Some(sum.max(0.0).sqrt())
    };
    let (of_a, of_j) = match best.kind {
        JerkLimited | Trapezoid => ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        SmoothedTrapezoid => ([0.0, 1.0, 0.0], [0.0, 1.0, -1.0]),
        OneAverage => ([1.0, -1.0, 0.0], [0.0; 3]),
        TwoAverages => ([1.0, -1.0, 0.0], [1.0, -1.0, -1.0]),
    };
    let a = best.shape.acceleration();
    sink.put(Table::Joint, keys[1], before[1], Some(scaled((a, combined(of_a).map(|e| e * a)), 1)), false, "");
    match best.shape.jerk() {
        Some(j) => {
            sink.put(Table::Joint, keys[2], before[2], Some(scaled((j, combined(of_j).map(|e| e * j)), 2)), false, "");
        }
        None => {
            let reason = "the set points have steps of acceleration";
            sink.put(Table::Joint, keys[2], before[2], None, false, reason);
        }
    }
    for (i, k) in [(0, 1), (0, 2), (1, 2)] {
        if c[i][k].abs() > LISTED_CORRELATION && best.kind == JerkLimited {
            report.correlations.push(Correlation { keys: [keys[i], keys[k]], correlation: c[i][k] });
        }
    }
}

fn put_servo(sink: &mut Sink<'_>, joint: &Joint, servo: &Result<ServoFit, String>, report: &mut JointReport) {
    let unit = joint.kind.unit_factor();
    let drive = joint.drive.as_ref();
    let rotary = joint.is_rotary();
    let gain_of = |d: &Drive| match d.velocity_gain {
        VelocityGain::Bandwidth(b) => ("velocity_bandwidth_hz", b / std::f64::consts::TAU),
        VelocityGain::Gain(g) if rotary => ("velocity_gain_Nm_s_rad", g / N_MM_PER_N_M),
        VelocityGain::Gain(g) => ("velocity_gain_N_s_m", g * N_S_M_PER_N_S_MM),
    };
    match servo {
        Err(reason) => {
            let before = drive.map(|d| d.position_gain);
            sink.put(Table::Drive, "position_gain_1_s", before, None, false, reason);
            let before = drive.map(|d| d.velocity_feed_forward);
            sink.put(Table::Drive, "velocity_feed_forward", before, None, true, reason);
        }
        Ok(fit) => {
            report.following_error = Some([fit.largest * unit, fit.left * unit]);
            report.widened[1] = Some(fit.minimum.inflation);
            let mut keys: Vec<&'static str> = Vec::new();
            for (k, what) in fit.list.iter().enumerate() {
                let error = fit.minimum.errors.get(k).copied().flatten();
                let times = |v: f64| Some((v, error.map(|e| e * v)));
                let (key, before, found, share) = match what {
                    ServoParameter::PositionGain => {
                        ("position_gain_1_s", drive.map(|d| d.position_gain), times(fit.drive.position_gain), false)
                    }
                    ServoParameter::VelocityFeedForward => (
                        "velocity_feed_forward",
                        drive.map(|d| d.velocity_feed_forward),
                        Some((fit.drive.velocity_feed_forward, error)),
                        true,
                    ),
                    ServoParameter::VelocityGain => {
                        let (key, value) = gain_of(&fit.drive);
                        (key, drive.map(|d| gain_of(d).1), times(value), false)
                    }
                    ServoParameter::IntegralTime => (
                        "integral_time_ms",
                        drive.and_then(|d| d.integral_time).map(|t| 1e3 * t),
                        times(1e3 * fit.drive.integral_time.unwrap_or(0.0)),
                        false,
                    ),
                    ServoParameter::AccelerationFeedForward => (
                        "acceleration_feed_forward",
                        drive.map(|d| d.acceleration_feed_forward),
                        Some((fit.drive.acceleration_feed_forward, error)),
                        true,
                    ),
                    ServoParameter::ElasticFrequency => (
                        "elastic_frequency_hz",
                        drive.and_then(|d| d.elastic).map(|e| e.frequency / std::f64::consts::TAU),
                        times(fit.drive.elastic.map_or(0.0, |e| e.frequency / std::f64::consts::TAU)),
                        false,
                    ),
                    // Over the moved mass alone; the force tells them better.
                    ServoParameter::CoulombFriction | ServoParameter::ViscousFriction => {
                        keys.push("");
                        continue;
                    }
                };
                keys.push(key);
                sink.put(Table::Drive, key, before, found, share, "");
            }
            for i in 0..keys.len() {
                for k in 0..i {
                    let r = fit.minimum.correlations[(i, k)];
                    if r.abs() > LISTED_CORRELATION && !keys[i].is_empty() && !keys[k].is_empty() {
                        report.correlations.push(Correlation { keys: [keys[k], keys[i]], correlation: r });
                    }
                }
            }
        }
    }
}

fn put_friction(
    sink: &mut Sink<'_>,
    joint: &Joint,
    friction: &Result<FrictionFit, String>,
    known: bool,
    unit_name: &'static str,
    report: &mut JointReport,
) {
    let rotary = joint.is_rotary();
    let (keys, factors) = if rotary {
        (["coulomb_friction_Nm", "viscous_friction_Nm_s_rad"], [1.0 / N_MM_PER_N_M; 2])
    } else {
        (["coulomb_friction_N", "viscous_friction_N_s_m"], [1.0, N_S_M_PER_N_S_MM])
    };
    let drive = joint.drive.as_ref();
    let before = [drive.map(|d| d.coulomb_friction * factors[0]), drive.map(|d| d.viscous_friction * factors[1])];
    let fit = match friction {
        Err(reason) => {
            sink.put(Table::Drive, keys[0], before[0], None, false, reason);
            sink.put(Table::Drive, keys[1], before[1], None, false, reason);
            return;
        }
        Ok(fit) => fit,
    };
    report.force_left = Some(fit.left);
    if !known {
        let (c, e) = fit.coulomb;
        report.friction_in_unit = Some(([c, e.unwrap_or(f64::INFINITY)], unit_name));
        let reason = format!("the column is in {unit_name}: state force_per_unit_N (torque_per_unit_Nm)");
        sink.put(Table::Drive, keys[0], before[0], None, false, &reason);
        sink.put(Table::Drive, keys[1], before[1], None, false, &reason);
        return;
    }
    // N s²/mm are 1,000 kg, N mm s² are a thousandth of a kg m².
    let to_mass = if rotary { 1e-3 } else { 1e3 };
    report.moved_mass = Some(fit.mass.map(|m| m * to_mass));
    let reason =
        if drive.is_none() { "the machine file states no drive: add [joint.drive] with a first guess" } else { "" };
    let of = |(v, e): (f64, Option<f64>), k: usize| Some((v * factors[k], e.map(|e| e * factors[k])));
    let below = |v: f64, e: Option<f64>| v < 0.0 || e.is_some_and(|e| v < 2.0 * e);
    let why =
        |v: (f64, Option<f64>)| if reason.is_empty() && below(v.0, v.1) { "not different from zero" } else { reason };
    sink.put(Table::Drive, keys[0], before[0], of(fit.coulomb, 0), false, why(fit.coulomb));
    sink.put(Table::Drive, keys[1], before[1], of(fit.viscous, 1), false, why(fit.viscous));
    if fit.correlation.abs() > LISTED_CORRELATION {
        report.correlations.push(Correlation { keys, correlation: fit.correlation });
    }
}
