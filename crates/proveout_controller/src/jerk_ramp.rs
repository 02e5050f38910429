//! Closed forms of velocity changes with bounded acceleration and jerk.
//!
//! A *ramp* changes the speed from `v0` to `v1` with zero acceleration at both ends, in the shortest time
//! under the limits A and J. Its acceleration is a symmetric trapezoid (or triangle) in time, so that with
//! `dv = |v1 - v0|`
//!
//! ```text
//!    a                      T = dv/A + A/J          if dv > A^2/J      (three phases)
//!    |   ______             T = 2 sqrt(dv/J)        otherwise          (two phases)
//!    |  /      \            D = T (v0 + v1) / 2     by the symmetry of v(t) about its middle
//!    | /        \
//!    +-------------- t      A = infinity: two phases always; J = infinity: T = dv/A
//!      tj   tc   tj
//! ```
//!
//! The classical seven-phase move (for example Biagiotti and Melchiorri 2008, section 3.4) is two ramps and a
//! cruise between them; [`peak_speed`] finds the speed of the cruise.

/// Width of the bracket at which the search for a speed ends, part of it.
const FOUND: f64 = 1e-14;

/// Acceleration and jerk that a ramp may use; infinite where there is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rates {
    /// Highest acceleration along the path parameter.
    pub(crate) acceleration: f64,
    /// Highest jerk along the path parameter.
    pub(crate) jerk: f64,
}

impl Rates {
    pub(crate) const FREE: Self = Self { acceleration: f64::INFINITY, jerk: f64::INFINITY };

    pub(crate) fn min(self, other: Self) -> Self {
        Self { acceleration: self.acceleration.min(other.acceleration), jerk: self.jerk.min(other.jerk) }
    }
}

/// Shape of a ramp: time of each jerk phase, time between them, peak of the acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RampShape {
    pub(crate) jerk_time: f64,
    pub(crate) hold_time: f64,
    pub(crate) acceleration: f64,
}

/// Phases of the ramp that changes the speed by `dv >= 0`.
pub(crate) fn ramp_shape(dv: f64, r: Rates) -> RampShape {
    if dv <= 0.0 || r.acceleration.is_infinite() && r.jerk.is_infinite() {
        return RampShape { jerk_time: 0.0, hold_time: 0.0, acceleration: 0.0 };
    }
    if r.jerk.is_infinite() {
        return RampShape { jerk_time: 0.0, hold_time: dv / r.acceleration, acceleration: r.acceleration };
    }
    let full = r.acceleration / r.jerk;
    if dv > r.acceleration * full {
        RampShape { jerk_time: full, hold_time: dv / r.acceleration - full, acceleration: r.acceleration }
    } else {
        let jerk_time = (dv / r.jerk).sqrt();
        RampShape { jerk_time, hold_time: 0.0, acceleration: r.jerk * jerk_time }
    }
}

/// Duration of the ramp that changes the speed by `dv >= 0`.
pub(crate) fn ramp_time(dv: f64, r: Rates) -> f64 {
    let shape = ramp_shape(dv, r);
    2.0 * shape.jerk_time + shape.hold_time
}

/// Path that a ramp between two speeds takes.
pub(crate) fn ramp_distance(v0: f64, v1: f64, r: Rates) -> f64 {
    0.5 * (v0 + v1) * ramp_time((v1 - v0).abs(), r)
}

/// Highest speed that a ramp from `v0` reaches, with zero acceleration at its end, within `distance`.
pub(crate) fn reach(v0: f64, distance: f64, r: Rates) -> f64 {
    if distance <= 0.0 {
        return v0;
    }
    let (a, j) = (r.acceleration, r.jerk);
    if j.is_infinite() {
        return (v0 * v0 + 2.0 * a * distance).sqrt();
    }
    // Two phases: x = sqrt(dv) solves x^3 + 2 v0 x = D sqrt(J).
    let x = positive_root(2.0 * v0, distance * j.sqrt());
    let dv = x * x;
    if a.is_infinite() || dv <= a * a / j {
        return v0 + dv;
    }
    // Three phases: dv^2 + dv (2 v0 + A^2/J) + 2 v0 A^2/J - 2 A D = 0.
    let k = a * a / j;
    let half = 0.5 * (2.0 * v0 + k);
    let c = 2.0 * v0 * k - 2.0 * a * distance;
    v0 + (-c / (half + (half * half - c).max(0.0).sqrt())).max(0.0)
}

/// Speed after `distance` of the hardest acceleration from `v0`: jerk up to the full acceleration, which then
/// stays on. An upper bound for every motion that leaves `v0` with zero acceleration.
pub(crate) fn max_speed_after(v0: f64, distance: f64, r: Rates) -> f64 {
    if distance <= 0.0 {
        return v0;
    }
    let (a, j) = (r.acceleration, r.jerk);
    if j.is_infinite() {
        return (v0 * v0 + 2.0 * a * distance).sqrt();
    }
    // Within the jerk phase: J t^3 / 6 + v0 t = D.
    let t = positive_root(6.0 * v0 / j, 6.0 * distance / j);
    let full = a / j;
    if t <= full {
        return v0 + 0.5 * j * t * t;
    }
    let v = v0 + 0.5 * a * full;
    let rest = distance - (v0 * full + j * full * full * full / 6.0);
    (v * v + 2.0 * a * rest.max(0.0)).sqrt()
}

/// The root x >= 0 of x^3 + p x = q with p, q >= 0 (Cardano, in the form without cancellation).
fn positive_root(p: f64, q: f64) -> f64 {
    if q <= 0.0 {
        return 0.0;
    }
    if q.is_infinite() {
        return f64::INFINITY;
    }
    let h = 0.5 * q;
    let third = p / 3.0;
    let u = (h + (h * h + third * third * third).sqrt()).cbrt();
    // x = u - third/u cancels when p is large; q / (u^2 + third + (third/u)^2) does not.
    let w = third / u;
    let mut x = q / (u * u + third + w * w);
    if !x.is_finite() {
        x = q / p.max(f64::MIN_POSITIVE);
    }
    // One Newton step takes the last digits of the cube root.
    let f = (x * x + p) * x - q;
    let slope = 3.0 * x * x + p;
    if slope > 0.0 && f.is_finite() {
        x -= f / slope;
    }
    x.max(0.0)
}

/// Highest speed `<= ceiling` between a ramp up from `v0` and a ramp down to `v1` that both fit into
/// `distance`.
///
/// Returns max(v0, v1) when not even that fits.
pub(crate) fn peak_speed(v0: f64, v1: f64, distance: f64, ceiling: f64, up: Rates, down: Rates) -> f64 {
    let need = |v: f64| ramp_distance(v0, v, up) + ramp_distance(v1, v, down);
    let mut low = v0.max(v1);
    if ceiling <= low {
        return low;
    }
    if need(ceiling) <= distance {
        return ceiling;
    }
    if v0 == v1 && up == down {
        return reach(v0, 0.5 * distance, up).min(ceiling).max(low);
    }
    // Illinois variant of the false position (Dowell and Jarratt 1971); need() grows strictly with the speed.
    let mut high = ceiling;
    let (mut f_low, mut f_high) = (need(low) - distance, need(high) - distance);
    if f_low >= 0.0 {
        return low;
    }
    for _ in 0..80 {
        if high - low <= FOUND * high {
            break;
        }
        let mut mid =
            if f_high.is_finite() { (low * f_high - high * f_low) / (f_high - f_low) } else { 0.5 * (low + high) };
        if !(mid > low && mid < high) {
            mid = 0.5 * (low + high);
            if !(mid > low && mid < high) {
                break;
            }
        }
        let f = need(mid) - distance;
        if f <= 0.0 {
            low = mid;
            f_low = f;
            f_high *= 0.5;
            if f == 0.0 {
                break;
            }
        } else {
            high = mid;
            f_high = f;
            f_low *= 0.5;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: Rates = Rates { acceleration: 2000.0, jerk: 40_000.0 };

    fn all_rates() -> [Rates; 4] {
        let free = f64::INFINITY;
        [R, Rates { jerk: free, ..R }, Rates { acceleration: free, ..R }, Rates { acceleration: 1e7, ..R }]
    }

    #[test]
    fn ramps_integrate_to_their_distance() {
        for r in all_rates() {
            for (v0, v1) in [(0.0_f64, 30.0), (0.0, 300.0), (100.0, 400.0), (20.0, 20.001), (0.0, 1e-6)] {
                let s = ramp_shape(v1 - v0, r);
                let (tj, th, a) = (s.jerk_time, s.hold_time, s.acceleration);
                let speed = v0 + a * (tj + th);
                assert!((speed - v1).abs() <= 1e-12 * v1, "{r:?} {v0} {v1}: {speed}");
                let j = if tj > 0.0 { a / tj } else { 0.0 };
                let x1 = v0 * tj + j * tj.powi(3) / 6.0;
                let va = v0 + 0.5 * a * tj;
                let x2 = va * th + 0.5 * a * th * th;
                let vb = va + a * th;
                let x3 = vb * tj + 0.5 * a * tj * tj - j * tj.powi(3) / 6.0;
                let d = ramp_distance(v0, v1, r);
                assert!((x1 + x2 + x3 - d).abs() <= 1e-12 * d);
                assert!((reach(v0, d, r) - v1).abs() <= 1e-9 * v1, "{r:?} {v0} {v1} {}", reach(v0, d, r));
                assert!(max_speed_after(v0, d, r) >= v1 * (1.0 - 1e-12));
            }
        }
    }

    #[test]
    fn rush_matches_small_steps() {
        for v0 in [0.0, 10.0, 200.0] {
            let (mut s, mut v, mut a) = (0.0, v0, 0.0_f64);
            let dt = 1e-6;
            for _ in 0..120_000 {
                let next = (a + R.jerk * dt).min(R.acceleration);
                s += v * dt + 0.5 * a * dt * dt;
                v += 0.5 * (a + next) * dt;
                a = next;
            }
            // The steps cut the corner at the full acceleration: error A dt.
            assert!((max_speed_after(v0, s, R) - v).abs() < 0.01, "{} {v}", max_speed_after(v0, s, R));
        }
    }

    #[test]
    fn peak_fills_the_distance() {
        let other = Rates { acceleration: 900.0, jerk: 90_000.0 };
        for (v0, v1, d) in [(0.0, 0.0, 10.0), (0.0, 50.0, 12.0), (80.0, 10.0, 9.0), (0.0, 0.0, 1e-4)] {
            for down in [R, other] {
                let v = peak_speed(v0, v1, d, 1e5, R, down);
                let used = ramp_distance(v0, v, R) + ramp_distance(v1, v, down);
                assert!((used - d).abs() < 1e-9 * d, "{v0} {v1} {d}: {used}");
            }
        }
        assert_eq!(peak_speed(0.0, 0.0, 1e6, 250.0, R, R), 250.0);
    }
}
