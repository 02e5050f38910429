//! From fits to values of the machine file, in the units of its keys; why some are not written.

use proveout_machine::{Drive, Joint, VelocityGain};

use crate::{
    calibration::{Correlation, JointReport, Parameter, Table},
    fit::{
        friction::FrictionFit,
        law::LawKind::{JerkLimited, OneAverage, SmoothedTrapezoid, Trapezoid, TwoAverages},
        limits::LimitsFit,
        servo::{ServoFit, ServoParameter},
    },
};

/// A value whose standard error is above this part of it is not written: the machine file keeps its own.
const KNOWN: f64 = 0.1;
/// The same of the position gain: where it is known less well, the parameters of the loop go together.
const KNOWN_GAIN: f64 = 0.01;
/// The same of a share between zero and one.
const KNOWN_SHARE: f64 = 0.05;
/// Correlations below this are not listed.
const LISTED_CORRELATION: f64 = 0.5;
/// mm/min of a mm/s.
const MM_MIN: f64 = 60.0;
const N_MM_PER_N_M: f64 = 1e3;
const N_S_M_PER_N_S_MM: f64 = 1e3;

/// Collects parameters of one joint.
pub(crate) struct Sink<'a> {
    pub(crate) joint: &'a Joint,
    pub(crate) out: &'a mut Vec<Parameter>,
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

pub(crate) fn put_limits(
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

pub(crate) fn put_servo(
    sink: &mut Sink<'_>,
    joint: &Joint,
    servo: &Result<ServoFit, String>,
    report: &mut JointReport,
) {
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
            let of_gain = fit.list.iter().position(|w| *w == ServoParameter::PositionGain);
            let of_gain = of_gain.and_then(|k| fit.minimum.errors.get(k).copied().flatten()).unwrap_or(f64::INFINITY);
            if of_gain > KNOWN_GAIN {
                // Near a double root of the loop the cost is no parabola, and errors are no intervals.
                let reason = "gain, integral time and feed-forward of the loop go together in these moves";
                sink.put(Table::Drive, "position_gain_1_s", drive.map(|d| d.position_gain), None, false, reason);
                let before = drive.map(|d| d.velocity_feed_forward);
                sink.put(Table::Drive, "velocity_feed_forward", before, None, true, reason);
                return;
            }
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
                    // Over the moved mass alone; the force gives them better.
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

pub(crate) fn put_friction(
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
