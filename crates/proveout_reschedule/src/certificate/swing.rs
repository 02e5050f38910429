//! Least time of a joint for a distance between two places where it turns back.
//!
//! A joint that turns back has velocity zero there, and any acceleration: it passes the place with its full
//! acceleration. Times from rest to rest, whose acceleration is zero at both ends, are longer by up to a
//! tenth and bound nothing here.
//!
//! *Both ends turn back.* Let a motion take T = 2 h for the distance D > 0, v = 0 at both ends, |v| <= V, |a|
//! <= A, |jerk| <= J. Its mean with itself run backwards, `w(t) = (v(t) + v(T - t)) / 2`, keeps the same
//! limits and goes as far; its acceleration `b(t) = (a(t) - a(T - t)) / 2` is zero at h, so that `|b(t)| <=
//! min(A, J |t - h|)`. Integration by parts gives
//!
//! ```text
//!   D = - int b(t) (t - h) dt  <=  2 int_0^h x min(A, J x) dx  =  2/3 J h^3             up to h = A/J =: tj
//!                                                                A h^2 - A tj^2 / 3     above
//! ```
//!
//! With the velocity: let w be at t < h, and rising. It stays below V up to h and comes down to b = 0 no
//! faster than by J, so that `w + b^2 / (2 J) <= V`, and `w' <= min(A, sqrt(2 J (V - w)))`. The motion E with
//! E(0) = 0 that keeps this as an equation reaches V at `t1` after the way `D1`; w' - E' <= 0 wherever w > E,
//! so that w <= E, and `D <= 2 (D1 + V (h - t1))` for h >= t1. Each bound is reached, so that the least time
//! is known exactly.
//!
//! *One end turns back*, the other is passed in motion: `|v(t)| <= min(V, A t)`.

/// Limits of a joint, mm or radian and seconds; infinite where none is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwingLimits {
    /// Velocity.
    pub velocity: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Jerk.
    pub jerk: f64,
}

impl SwingLimits {
    /// Least time for a distance at the velocity, s.
    pub fn travel_time(&self, distance: f64) -> f64 {
        distance / self.velocity
    }

    /// Least time for a distance between two places where the joint turns back, s.
    pub fn swing_time(&self, distance: f64) -> f64 {
        let Self { velocity: v, acceleration: a, jerk: j } = *self;
        if distance <= 0.0 {
            return 0.0;
        }
        // Time in which the acceleration falls from its limit to zero.
        let fall = a / j;
        // Time and way to the velocity limit.
        let [time, way] = if a.is_finite() && v / a >= 0.5 * fall {
            let even = v / a - 0.5 * fall;
            [even + fall, 0.5 * a * even * even + a * even * fall + a * fall * fall / 3.0]
        } else {
            let start = (2.0 * v * j).sqrt();
            if j.is_finite() { [start / j, start.powi(3) / (3.0 * j * j)] } else { [0.0, 0.0] }
        };
        if distance >= 2.0 * way {
            2.0 * time + (distance - 2.0 * way) / v
        } else if a.is_finite() && distance >= 2.0 / 3.0 * a * fall * fall {
            2.0 * (fall * fall / 3.0 + distance / a).sqrt()
        } else {
            2.0 * (1.5 * distance / j).cbrt()
        }
    }

    /// Least time for a distance from a place where the joint turns back to one that it passes in motion, s.
    pub fn half_swing_time(&self, distance: f64) -> f64 {
        let Self { velocity: v, acceleration: a, .. } = *self;
        let way = if a.is_finite() { 0.5 * v * v / a } else { 0.0 };
        if distance <= 0.0 {
            0.0
        } else if distance <= way {
            (2.0 * distance / a).sqrt()
        } else if way > 0.0 {
            distance / v + 0.5 * v / a
        } else {
            distance / v
        }
    }

    /// The same limits, all passed by a part.
    #[must_use]
    pub fn passed_by(&self, part: f64) -> Self {
        let factor = 1.0 + part;
        Self { velocity: self.velocity * factor, acceleration: self.acceleration * factor, jerk: self.jerk * factor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        /// Between 10^low and 10^high, evenly by size; one in eight is infinite.
        fn limit(&mut self, low: f64, high: f64) -> f64 {
            if self.next() < 0.125 { f64::INFINITY } else { 10_f64.powf(low + (high - low) * self.next()) }
        }
    }

    fn limits(random: &mut Random) -> SwingLimits {
        SwingLimits {
            velocity: 10_f64.powf(2.0 * random.next() - 1.0),
            acceleration: random.limit(-1.0, 2.0),
            jerk: random.limit(-1.0, 3.0),
        }
    }

    /// The extreme motion, summed in small steps: acceleration from its limit, falling by the jerk in time to
    /// meet the velocity and the middle of the time. Gives the way in a time.
    fn extreme_way(l: &SwingLimits, time: f64) -> f64 {
        let (n, h) = (200_000, 0.5 * time);
        let step = h / f64::from(n);
        let (mut v, mut way) = (0.0, 0.0);
        for i in 0..n {
            let left = h - (f64::from(i) + 0.5) * step;
            let to_velocity =
                if l.jerk.is_finite() { (2.0 * l.jerk * (l.velocity - v).max(0.0)).sqrt() } else { f64::INFINITY };
            let a = l.acceleration.min(l.jerk * left).min(to_velocity);
            let next = if a.is_finite() { (v + a * step).min(l.velocity) } else { l.velocity };
            way += 0.5 * (v + next) * step;
            v = next;
        }
        2.0 * way
    }

    #[test]
    fn the_extreme_motion_goes_as_far_in_the_time() {
        let mut random = Random(5);
        for _ in 0..60 {
            let l = limits(&mut random);
            let distance = 10_f64.powf(3.0 * random.next() - 2.0);
            let way = extreme_way(&l, l.swing_time(distance));
            // The sum is of first order where the acceleration jumps, at most two places: 2 V h / n.
            assert!((way / distance - 1.0).abs() < 1e-3, "{l:?}: {way} of {distance}");
        }
    }

    /// Random motions with zero velocity at both ends, made to just keep the limits, take at least the time.
    #[test]
    fn no_random_motion_is_faster() {
        let mut random = Random(11);
        let mut nearest = f64::INFINITY;
        for _ in 0..4000 {
            // Velocity as a sum of sines over [0, 1], sampled; every third one is a pulse, which comes near
            // the extreme.
            let terms: Vec<f64> = (0..1 + (4.0 * random.next()) as usize).map(|_| 2.0 * random.next() - 1.0).collect();
            let omega = |k: usize| std::f64::consts::PI * (k + 1) as f64;
            let at = |t: f64, order: usize| -> f64 {
                let wave = |k: usize| match order {
                    0 => (omega(k) * t).sin(),
                    1 => omega(k) * (omega(k) * t).cos(),
                    _ => -omega(k).powi(2) * (omega(k) * t).sin(),
                };
                terms.iter().enumerate().map(|(k, c)| c * wave(k)).sum()
            };
            let largest = |order| (0..=400).map(|i| at(f64::from(i) / 400.0, order).abs()).fold(1e-12, f64::max);
            let distance: f64 = (0..400).map(|i| at((f64::from(i) + 0.5) / 400.0, 0)).sum::<f64>() / 400.0;
            let time = 10_f64.powf(2.0 * random.next() - 1.0);
            let slack = 1.002; // between the 401 places a motion may pass its sampled extremes
            let mut l = SwingLimits {
                velocity: largest(0) * slack,
                acceleration: largest(1) / time * slack,
                jerk: largest(2) / (time * time) * slack,
            };
            if random.next() < 0.3 {
                l.jerk = f64::INFINITY;
            }
            let bound = l.swing_time(distance.abs() * time);
            assert!(bound <= time * 1.001, "{l:?}: {bound} above {time}");
            assert!(l.half_swing_time(distance.abs() * time) <= bound * (1.0 + 1e-12));
            nearest = f64::min(nearest, time / bound);
        }
        assert!(nearest < 1.1, "no random motion comes near: {nearest}");
    }

    #[test]
    fn limits_that_are_raised_never_lengthen_it_and_parts_never_take_less_than_the_whole() {
        let mut random = Random(23);
        for _ in 0..20_000 {
            let l = limits(&mut random);
            let [a, b] = [0; 2].map(|_| 10_f64.powf(4.0 * random.next() - 3.0));
            let wider = SwingLimits {
                velocity: l.velocity * (1.0 + random.next()),
                acceleration: l.acceleration * (1.0 + random.next()),
                jerk: l.jerk * (1.0 + random.next()),
            };
            for time in [SwingLimits::swing_time, SwingLimits::half_swing_time, SwingLimits::travel_time] {
                assert!(time(&wider, a) <= time(&l, a) * (1.0 + 1e-12), "{l:?} {wider:?} {a}");
                assert!(time(&l, a.max(b)) >= time(&l, a.min(b)) * (1.0 - 1e-12));
                assert!(time(&l, a + b) <= (time(&l, a) + time(&l, b)) * (1.0 + 1e-12), "{l:?} {a} {b}");
            }
        }
    }

    #[test]
    fn the_time_from_rest_to_rest_is_no_bound() {
        // A sine of amplitude 1 turns back with its full acceleration. Its swing of 2 takes pi/w.
        let w: f64 = 3.0;
        let l = SwingLimits { velocity: w, acceleration: w * w, jerk: w.powi(3) };
        let sine = std::f64::consts::PI / w;
        // From rest to rest the acceleration rises and falls by the jerk at both ends: for these limits the
        // acceleration is not reached, and D = 2 J (T/4)^3 gives T.
        let rest = 4.0 * (2.0 / (2.0 * l.jerk)).cbrt();
        let peak = l.jerk * 0.25 * rest;
        assert!(peak <= l.acceleration && 0.25 * rest * peak <= l.velocity, "the closed form holds");
        assert!(rest > 1.2 * sine, "it would prove {rest} where {sine} is done");
        assert!(l.swing_time(2.0) <= sine);
    }
}
