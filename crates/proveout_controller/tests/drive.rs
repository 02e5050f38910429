//! The drive against closed forms and against an integrator of its own that shares no code with it.
//!
//! Masses in kg, forces in N (1 N = 1000 kg mm/s²), mm, s.

use std::f64::consts::TAU;

use crate::common::Random;
use proveout_controller::servo::{DriveModel, DriveState, SetPointRates};
use proveout_machine::{Drive, ElasticMode, Encoder, VelocityGain};

const MASS: f64 = 400.0;

fn drive() -> Drive {
    Drive {
        position_gain: 50.0,
        velocity_gain: VelocityGain::Bandwidth(TAU * 40.0),
        integral_time: Some(0.012),
        velocity_feed_forward: 0.0,
        acceleration_feed_forward: 0.0,
        max_force: None,
        viscous_friction: 0.0,
        coulomb_friction: 0.0,
        static_friction: 0.0,
        stribeck_velocity: 0.0,
        backlash: 0.0,
        encoder: Encoder::Motor,
        elastic: None,
        motor_inertia: None,
        counterbalance: 0.0,
    }
}

fn model(drive: &Drive, cycle: f64) -> DriveModel {
    DriveModel::new(drive, MASS, cycle).unwrap_or_else(|e| panic!("{e}"))
}

/// The cubic over a cycle between two places with velocities.
fn cubic(h: f64, x: [f64; 2], v: [f64; 2]) -> SetPointRates {
    let way = x[1] - x[0];
    SetPointRates {
        velocity: v[0],
        acceleration: 6.0 * way / (h * h) - (4.0 * v[0] + 2.0 * v[1]) / h,
        jerk: 6.0 * (v[0] + v[1]) / (h * h) - 12.0 * way / (h * h * h),
    }
}

/// Runs a motion given by position and velocity over time; calls `see` with time, set point and state after
/// each cycle.
fn run(
    m: &DriveModel,
    cycle: f64,
    until: f64,
    r: impl Fn(f64) -> [f64; 2],
    mut see: impl FnMut(f64, f64, &DriveState),
) {
    let mut s = m.rest(0.0);
    let cycles = (until / cycle).round() as usize;
    for k in 0..cycles {
        let (t0, t1) = (k as f64 * cycle, (k + 1) as f64 * cycle);
        let ([x0, v0], [x1, v1]) = (r(t0), r(t1));
        m.cycle(&mut s, cubic(cycle, [x0, x1], [v0, v1]), 0.0);
        see(t1, x1, &s);
    }
}

#[test]
fn a_step_is_answered_as_a_second_order_system() {
    // A proportional velocity loop closes to s^2 + k s + k Kv.
    let (k, kv): (f64, f64) = (TAU * 40.0, 90.0);
    let d = Drive { integral_time: None, position_gain: kv, ..drive() };
    let w = (k * kv).sqrt();
    let zeta = k / (2.0 * w);
    assert!(zeta < 1.0);
    let wd = w * (1.0 - zeta * zeta).sqrt();
    for cycle in [1e-4, 1e-3, 2e-3, 8e-3] {
        let m = model(&d, cycle);
        let mut s = m.rest(0.0);
        s.jump(1.0);
        let mut highest = 0.0_f64;
        for n in 1..=(0.2 / cycle) as usize {
            m.cycle(&mut s, SetPointRates::default(), 0.0);
            let t = n as f64 * cycle;
            let left = (-zeta * w * t).exp() * ((wd * t).cos() + zeta / (1.0 - zeta * zeta).sqrt() * (wd * t).sin());
            // The maps are exact: what is left is the rounding of some thousand products.
            assert!((s.error() - left).abs() < 1e-11, "{cycle} {t}: {} {left}", s.error());
            highest = highest.max(-s.error());
        }
        let overshoot = (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        // Seen at the samples alone, the top of the overshoot may be missed by half a cycle.
        let missed = 0.5 * overshoot * (w * cycle / 2.0).powi(2);
        assert!(highest <= overshoot + 1e-11 && highest >= overshoot - missed - 1e-11);
    }
}

#[test]
fn a_ramp_lags_by_velocity_over_gain_and_not_at_all_with_feed_forward() {
    for (forward, encoder) in
        [(0.0, Encoder::Motor), (0.6, Encoder::Motor), (1.0, Encoder::Motor), (0.0, Encoder::Load)]
    {
        let d = Drive {
            velocity_feed_forward: forward,
            viscous_friction: 3.0,
            coulomb_friction: 200.0,
            encoder,
            ..drive()
        };
        let m = model(&d, 2e-3);
        let (v, mut last) = (120.0, f64::NAN);
        run(&m, 2e-3, 2.0, |t| [v * t, v], |_, _, s| last = s.error());
        // The integral part carries friction; its error dies with the slowest pole, far below rounding after
        // 2 s.
        let expected = (1.0 - forward) * v / d.position_gain;
        assert!((last - expected).abs() < 1e-9, "{forward}: {last} {expected}");
    }
}

/// Complex numbers, for the frequency response.
#[derive(Clone, Copy)]
struct C(f64, f64);

impl C {
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
    fn times(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn by(self, f: f64) -> Self {
        Self(self.0 * f, self.1 * f)
    }
    fn over(self, o: Self) -> Self {
        let n = o.0 * o.0 + o.1 * o.1;
        Self((self.0 * o.0 + self.1 * o.1) / n, (self.1 * o.0 - self.0 * o.1) / n)
    }
}

/// Load over set point at the angular frequency `w`, from the equations of motion in the frequency domain.
fn response(d: &Drive, w: f64) -> C {
    let s = C(0.0, w);
    let VelocityGain::Bandwidth(k) = d.velocity_gain else { panic!("a bandwidth") };
    let m1 = d.motor_inertia.unwrap_or(0.0);
    let m2 = MASS;
    let m = m1 + m2;
    let kp = k * m;
    let pi = C(kp, 0.0).add(C(d.integral_time.map_or(0.0, |t| kp / t), 0.0).over(s));
    let b = d.viscous_friction * 1e3;
    // Force = pi (Kv (r - p) + a s r - s x1) + beta m s^2 r.
    let forward = pi.times(C(d.position_gain, 0.0).add(s.by(d.velocity_feed_forward)));
    let forward = forward.add(s.times(s).by(d.acceleration_feed_forward * m));
    let (on_p, on_x1) = (pi.by(d.position_gain), pi.times(s));
    match d.elastic {
        None => {
            let plant = s.times(s).by(m).add(s.by(b));
            forward.over(plant.add(on_p).add(on_x1))
        }
        Some(e) => {
            let stiffness = C(m2 * e.frequency * e.frequency, 0.0).add(s.by(2.0 * e.damping * m2 * e.frequency));
            // (m1 s^2 + c) x1 - c x2 = F,  (m2 s^2 + b s + c) x2 = c x1.
            let x2_over_x1 = stiffness.over(s.times(s).by(m2).add(s.by(b)).add(stiffness));
            let own = s.times(s).by(m1).add(stiffness).add(stiffness.times(x2_over_x1).by(-1.0));
            let p = if d.encoder == Encoder::Load { x2_over_x1 } else { C(1.0, 0.0) };
            let x1 = forward.over(own.add(on_p.times(p)).add(on_x1));
            x1.times(x2_over_x1)
        }
    }
}

#[test]
fn sines_come_out_with_the_amplitude_and_phase_of_the_transfer_function() {
    let elastic = Some(ElasticMode { frequency: TAU * 60.0, damping: 0.05 });
    let stiff = Drive { viscous_friction: 4.0, ..drive() };
    let fed = Drive { velocity_feed_forward: 1.0, acceleration_feed_forward: 0.9, ..stiff.clone() };
    let motor = Drive { elastic, motor_inertia: Some(150.0), ..stiff.clone() };
    let load = Drive { encoder: Encoder::Load, ..motor.clone() };
    for (name, d) in [("stiff", &stiff), ("feed-forward", &fed), ("motor", &motor), ("load", &load)] {
        for hertz in [1.0, 7.0, 25.0] {
            let (w, cycle) = (TAU * hertz, 1e-3);
            let m = model(d, cycle);
            let (mut cosine, mut sine, mut count) = (0.0, 0.0, 0);
            // 3 s for the transient to die, then whole periods: sums with sine and cosine give both parts.
            run(
                &m,
                cycle,
                4.0,
                |t| [(w * t).sin(), w * (w * t).cos()],
                |t, set, s| {
                    if t > 3.0 {
                        let x = set - s.error();
                        cosine += x * (w * t).cos();
                        sine += x * (w * t).sin();
                        count += 1;
                    }
                },
            );
            assert_eq!(count, 1000);
            let (real, imaginary) = (2.0 * sine / 1000.0, 2.0 * cosine / 1000.0);
            let C(re, im) = response(d, w);
            // The cubic between samples misses a sine by (w T)^4/384, and its acceleration, which is fed
            // forward, by (w T)^2/12 at most; 25 Hz: 1.6e-6 and 2e-3, the latter attenuated above the
            // bandwidth.
            let bound = 1e-6 + if d.acceleration_feed_forward > 0.0 { 1e-5 } else { 0.0 } * hertz;
            assert!(
                (real - re).abs() < bound && (imaginary - im).abs() < bound,
                "{name} {hertz}: {real} {imaginary} {re} {im}"
            );
        }
    }
}

/// Stick and slip by explicit events on a grid of a microsecond (Runge-Kutta of fourth order between them):
/// the oracle for friction.
struct Oracle {
    x: f64,
    v: f64,
    i: f64,
    sticks: bool,
}

impl Oracle {
    fn step(&mut self, d: &Drive, t: f64, h: f64, r: &dyn Fn(f64) -> [f64; 2]) {
        let VelocityGain::Bandwidth(k) = d.velocity_gain else { panic!("a bandwidth") };
        let scale = 1e3 / MASS;
        let (fc, fs) = (d.coulomb_friction * scale, d.static_friction * scale);
        let b = d.viscous_friction * scale;
        let rate = d.integral_time.map_or(0.0, |t| 1.0 / t);
        let demand = |t: f64, x: f64, v: f64, i: f64| {
            let [set, speed] = r(t);
            k * (d.position_gain * (set - x) + d.velocity_feed_forward * speed - v) + i
        };
        let wind = |t: f64, x: f64, v: f64| {
            let [set, speed] = r(t);
            k * rate * (d.position_gain * (set - x) + d.velocity_feed_forward * speed - v)
        };
        if self.sticks {
            self.i += h * wind(t + 0.5 * h, self.x, 0.0);
            let asked = demand(t + h, self.x, 0.0, self.i);
            if asked.abs() > fs {
                self.sticks = false;
                self.v = 1e-12 * asked.signum();
            }
            return;
        }
        let direction = self.v.signum();
        let slope = |t: f64, [x, v, i]: [f64; 3]| {
            let level = fc
                + (fs - fc) * if d.stribeck_velocity > 0.0 { (-(v / d.stribeck_velocity).powi(2)).exp() } else { 0.0 };
            [v, demand(t, x, v, i) - b * v - direction * level, wind(t, x, v)]
        };
        let z = [self.x, self.v, self.i];
        let plus = |z: [f64; 3], k: [f64; 3], h: f64| [z[0] + h * k[0], z[1] + h * k[1], z[2] + h * k[2]];
        let k1 = slope(t, z);
        let k2 = slope(t + 0.5 * h, plus(z, k1, 0.5 * h));
        let k3 = slope(t + 0.5 * h, plus(z, k2, 0.5 * h));
        let k4 = slope(t + h, plus(z, k3, h));
        for n in 0..3 {
            let sum = h / 6.0 * (k1[n] + 2.0 * k2[n] + 2.0 * k3[n] + k4[n]);
            [&mut self.x, &mut self.v, &mut self.i][n].add_assign_to(sum);
        }
        if self.v * direction <= 0.0 {
            self.v = 0.0;
            self.sticks = true;
        }
    }
}

trait AddTo {
    fn add_assign_to(&mut self, v: f64);
}

impl AddTo for &mut f64 {
    fn add_assign_to(&mut self, v: f64) {
        **self += v;
    }
}

/// The spike of the error after a reversal on a circle of `radius` at `feed`: largest difference to the
/// motion without dry friction. Second: the whole curve's largest difference between drive and oracle.
fn quadrant(d: &Drive, radius: f64, feed: f64, cycle: f64) -> [f64; 3] {
    let w = feed / radius;
    let r = move |t: f64| [radius * (w * t).sin(), radius * w * (w * t).cos()];
    let until = 1.0 * TAU / w;
    let m = model(d, cycle);
    let free =
        model(&Drive { coulomb_friction: 0.0, static_friction: 0.0, stribeck_velocity: 0.0, ..d.clone() }, cycle);
    let mut without = Vec::new();
    run(&free, cycle, until, r, |_, _, s| without.push(s.error()));
    let (mut spikes, mut errors) = (Vec::new(), Vec::new());
    // The first quarter settles the start; the reversals are at 1/4 and 3/4.
    let mut n = 0;
    run(&m, cycle, until, r, |t, _, s| {
        if t > 0.5 * TAU / w {
            spikes.push((s.error() - without[n]).abs());
        }
        errors.push(s.error());
        n += 1;
    });
    let mut oracle = Oracle { x: 0.0, v: 1e-12, i: 0.0, sticks: false };
    let fine = 1e-6;
    let per = (cycle / fine).round() as usize;
    let (mut worst, mut highest) = (0.0_f64, 0.0_f64);
    for n in 0..errors.len() {
        for k in 0..per {
            oracle.step(d, n as f64 * cycle + k as f64 * fine, fine, &r);
        }
        let t = (n + 1) as f64 * cycle;
        let error = r(t)[0] - oracle.x;
        if t > 0.25 * TAU / w {
            worst = worst.max((error - errors[n]).abs());
        }
        if t > 0.5 * TAU / w {
            highest = highest.max((error - without[n]).abs());
        }
    }
    [spikes.iter().fold(0.0, |m: f64, s| m.max(*s)), highest, worst]
}

#[test]
fn the_spike_behind_a_reversal_is_that_of_a_fine_integration() {
    let base = Drive { velocity_feed_forward: 1.0, viscous_friction: 2.0, ..drive() };
    let dry = Drive { coulomb_friction: 300.0, static_friction: 300.0, ..base.clone() };
    let stribeck = Drive { coulomb_friction: 250.0, static_friction: 420.0, stribeck_velocity: 1.5, ..base };
    for (name, d) in [("dry", &dry), ("stribeck", &stribeck)] {
        for (radius, feed) in [(30.0, 25.0), (10.0, 60.0)] {
            let [height, expected, worst] = quadrant(d, radius, feed, 1e-3);
            // The step of 0.125 ms sees a reversal late by half a step on the mean: a few percent of a spike
            // that is some milliseconds long.
            assert!(expected > 5e-4, "{name}: no spike to measure: {expected}");
            assert!((height / expected - 1.0).abs() < 0.04, "{name} {radius} {feed}: {height} {expected}");
            assert!(worst < 0.06 * expected, "{name} {radius} {feed}: {worst} of {expected}");
        }
    }
}

#[test]
fn a_slow_reversal_under_proportional_control_jumps_by_twice_the_friction() {
    // Without an integral part the drive is off by friction over k Kv M; the reversal turns it round.
    let d = Drive { integral_time: None, coulomb_friction: 300.0, static_friction: 300.0, ..drive() };
    let VelocityGain::Bandwidth(k) = d.velocity_gain else { panic!("a bandwidth") };
    let m = model(&d, 2e-3);
    let v = 0.5;
    let r = |t: f64| if t < 2.0 { [v * t, v] } else { [v * (4.0 - t), -v] };
    let (mut up, mut down) = (0.0, 0.0);
    run(&m, 2e-3, 4.0, r, |t, _, s| {
        if t < 2.0 {
            up = s.error();
        }
        down = s.error();
    });
    let off = 300.0 * 1e3 / MASS / (k * d.position_gain);
    let lag = v / d.position_gain + 0.0;
    assert!((up - (lag + off)).abs() < 1e-9 && (down + lag + off).abs() < 1e-9, "{up} {down} {lag} {off}");
}

/// Hysteresis of the load over a slow triangle of 2 mm/s: load position on the way out minus on the way back
/// at the same set point.
fn hysteresis(d: &Drive) -> f64 {
    let m = model(d, 2e-3);
    let v = 2.0;
    let r = |t: f64| {
        let phase = t.rem_euclid(4.0);
        if phase < 2.0 { [v * phase, v] } else { [v * (4.0 - phase), -v] }
    };
    let (mut out, mut back) = (f64::NAN, f64::NAN);
    run(&m, 2e-3, 8.0, r, |t, set, s| {
        if (t - 5.0).abs() < 1e-9 {
            out = set - s.error();
        }
        if (t - 7.0).abs() < 1e-9 {
            back = set - s.error();
        }
    });
    back - out
}

#[test]
fn lost_motion_shows_behind_the_motor_encoder_and_not_behind_a_scale() {
    let forward = Drive { velocity_feed_forward: 1.0, coulomb_friction: 100.0, static_friction: 100.0, ..drive() };
    let play = Drive { backlash: 0.02, ..forward.clone() };
    assert!((hysteresis(&play) - 0.02).abs() < 1e-9, "{}", hysteresis(&play));
    let scale = Drive { encoder: Encoder::Load, ..play.clone() };
    assert!(hysteresis(&scale).abs() < 1e-9, "{}", hysteresis(&scale));
    // Elastic: the spring winds up by the friction to both sides, the flanks add their gap.
    let frequency = TAU * 80.0;
    let elastic = Some(ElasticMode { frequency, damping: 0.1 });
    let wound = 2.0 * 100.0 * 1e3 / (MASS * frequency * frequency);
    for backlash in [0.0, 0.02] {
        let d = Drive { elastic, motor_inertia: Some(120.0), backlash, ..forward.clone() };
        let h = hysteresis(&d);
        // The load is at rest 2 s after each reversal in steady motion; the damper's part cancels.
        assert!((h - wound - backlash).abs() < 1e-6, "{backlash}: {h} {wound}");
    }
}

#[test]
fn a_saturated_drive_gives_its_force_and_no_more_and_comes_back() {
    let d = Drive { max_force: Some(2000.0), velocity_feed_forward: 0.0, ..drive() };
    let m = model(&d, 1e-3);
    let mut s = m.rest(0.0);
    s.jump(100.0);
    let a = 2000.0 * 1e3 / MASS;
    let (mut force, mut lowest) = (0.0_f64, f64::INFINITY);
    for n in 1..=2000 {
        m.cycle(&mut s, SetPointRates::default(), 0.0);
        let t = n as f64 * 1e-3;
        if t <= 0.1 {
            // Full force from rest: 100 mm - a t²/2, until the position loop asks for less.
            assert!((s.error() - (100.0 - 0.5 * a * t * t)).abs() < 1e-9, "{t}: {}", s.error());
        }
        force = force.max(m.force(&s).abs());
        lowest = lowest.min(s.error());
    }
    assert!(force <= 2000.0 * (1.0 + 1e-12) && force > 1999.0, "{force}");
    assert!(s.error().abs() < 1e-9 && s.velocity().abs() < 1e-9);
    // Full force holds until Kv times the error is down to the velocity: (50 e)² = 2 a (100 - e). From there
    // full braking takes v²/(2a) to stop, more than e. Windup would come on top of that overshoot: a tenth of
    // it is allowed for the velocity loop's own answer.
    let e = (a / 2500.0) * ((1.0 + 2.0 * 100.0 * 2500.0 / a).sqrt() - 1.0);
    let overshoot = (50.0 * e).powi(2) / (2.0 * a) - e;
    assert!(-lowest > 0.98 * overshoot && -lowest < 1.1 * overshoot, "{lowest} {overshoot}");
}

#[test]
fn what_sticks_stands_still_and_holds_weight() {
    for integral_time in [None, Some(0.01)] {
        let d =
            Drive { integral_time, coulomb_friction: 500.0, static_friction: 700.0, stribeck_velocity: 2.0, ..drive() };
        let m = model(&d, 2e-3);
        let mut s = m.rest(0.0);
        for _ in 0..500 {
            m.cycle(&mut s, SetPointRates::default(), -650.0); // below the static friction: not even a creep
            assert_eq!(s.velocity(), 0.0);
        }
        // The force turns up within the step: standing is exact at its ends, and what it moves within one is
        // of the third order: below a tenth of a nanometer a step.
        assert!(s.error().abs() < 1e-6, "{}", s.error());
    }
    // Weight from the start is carried by the integral part, and by a sag without one.
    let m = model(&drive(), 2e-3);
    let mut s = m.rest(-900.0);
    m.cycle(&mut s, SetPointRates::default(), -900.0);
    assert!(s.error().abs() < 1e-12 && (m.force(&s) - 900.0).abs() < 1e-6);
    let soft = Drive { integral_time: None, ..drive() };
    let m = model(&soft, 2e-3);
    let mut s = m.rest(-900.0);
    m.cycle(&mut s, SetPointRates::default(), -900.0);
    let sag = 900.0 * 1e3 / MASS / (TAU * 40.0 * 50.0);
    assert!((s.error() - sag).abs() < 1e-12, "{} {sag}", s.error());
}

#[test]
fn work_is_friction_times_way() {
    let d = Drive {
        velocity_feed_forward: 1.0,
        coulomb_friction: 150.0,
        static_friction: 150.0,
        viscous_friction: 1.0,
        ..drive()
    };
    let m = model(&d, 2e-3);
    let mut at = [0.0; 2];
    run(
        &m,
        2e-3,
        4.0,
        |t| [50.0 * t, 50.0],
        |t, _, s| {
            if (t - 3.0).abs() < 1e-9 {
                at[0] = s.energy();
            }
            at[1] = s.energy();
        },
    );
    // 1 s at 50 mm/s: (150 + 1 x 50) N over 0.05 m.
    assert!((at[1] - at[0] - 200.0 * 0.05).abs() < 1e-9, "{at:?}");
}

/// Any loop that is stable in continuous time is stable at any control cycle, and no other is accepted.
#[test]
fn stability_is_that_of_the_continuous_loop_at_any_cycle() {
    let mut random = Random::new(11);
    let (mut taken, mut refused) = (0, 0);
    for _ in 0..400 {
        let mut pick = |low: f64, high: f64| (random.range(low.ln(), high.ln())).exp();
        let (kv, k, tn) = (pick(5.0, 400.0), pick(20.0, 2000.0), pick(1e-3, 0.1));
        let b = pick(1e-3, 10.0);
        let cycle = pick(2e-5, 2e-2);
        let d = Drive {
            position_gain: kv,
            velocity_gain: VelocityGain::Bandwidth(k),
            integral_time: Some(tn),
            viscous_friction: b,
            coulomb_friction: pick(1.0, 1000.0),
            ..drive()
        };
        let d = Drive { static_friction: d.coulomb_friction * 1.3, stribeck_velocity: 3.0, ..d };
        // s^3 + (k + b/M) s^2 + (k Kv + k/Tn) s + k Kv/Tn: Routh.
        let stable = (k + b * 1e3 / MASS) * (k * kv + k / tn) > k * kv / tn;
        let made = DriveModel::new(&d, MASS, cycle);
        assert_eq!(made.is_ok(), stable, "{d:?}");
        let Ok(m) = made else {
            refused += 1;
            continue;
        };
        taken += 1;
        let mut s = m.rest(0.0);
        s.jump(1.0);
        let (mut worst, cycles) = (0.0_f64, (2.0 / cycle) as usize);
        for _ in 0..cycles.min(20_000) {
            m.cycle(&mut s, SetPointRates::default(), 0.0);
            assert!(s.is_finite());
            worst = worst.max(s.error().abs());
        }
        // A stable third-order loop of these gains answers a step by less than ten times it.
        assert!(worst < 10.0, "{worst} {d:?} {cycle}");
    }
    assert!(taken > 100 && refused > 10, "{taken} {refused}");
}

#[test]
fn elastic_loops_that_are_taken_come_to_rest_at_any_cycle() {
    let mut random = Random::new(12);
    let mut taken = 0;
    for n in 0..150 {
        let mut pick = |low: f64, high: f64| (random.range(low.ln(), high.ln())).exp();
        let d = Drive {
            position_gain: pick(5.0, 100.0),
            velocity_gain: VelocityGain::Bandwidth(pick(20.0, 600.0)),
            integral_time: Some(pick(0.005, 0.1)),
            elastic: Some(ElasticMode { frequency: TAU * pick(15.0, 300.0), damping: pick(0.01, 0.5) }),
            motor_inertia: Some(pick(20.0, 800.0)),
            encoder: if n % 2 == 0 { Encoder::Motor } else { Encoder::Load },
            ..drive()
        };
        let cycle = pick(1e-4, 1e-2);
        let Ok(m) = DriveModel::new(&d, MASS, cycle) else { continue };
        taken += 1;
        let mut s = m.rest(0.0);
        s.jump(1.0);
        let mut worst = 0.0_f64;
        for _ in 0..(4.0 / cycle) as usize {
            m.cycle(&mut s, SetPointRates::default(), 0.0);
            worst = worst.max(s.error().abs());
        }
        assert!(worst < 20.0 && s.error().abs() < worst * 0.9 + 1e-6, "{worst} {} {d:?}", s.error());
    }
    assert!(taken > 60, "{taken}");
}

#[test]
fn data_that_make_no_drive_are_refused_with_a_remedy() {
    for (d, mass, cycle) in [
        (drive(), 0.0, 1e-3),
        (drive(), f64::NAN, 1e-3),
        (drive(), 10.0, 0.0),
        (Drive { position_gain: f64::NAN, ..drive() }, 10.0, 1e-3),
        (Drive { viscous_friction: -1.0, ..drive() }, 10.0, 1e-3),
        (Drive { elastic: Some(ElasticMode { frequency: 100.0, damping: 0.1 }), ..drive() }, 10.0, 1e-3),
    ] {
        let e = DriveModel::new(&d, mass, cycle).expect_err("no drive");
        assert!(!e.message.is_empty() && !e.help.is_empty());
    }
    let wild = Drive { position_gain: 500.0, integral_time: Some(1e-3), ..drive() };
    let e = DriveModel::new(&wild, MASS, 1e-3).expect_err("not stable");
    assert!(e.message.contains("not stable") && e.help.contains("position_gain_1_s"), "{e}");
}
