//! Least times of a joint, by the farthest way in a time.

/// Limits; infinite where there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PeakLimits {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
}

impl PeakLimits {
    /// Velocity in the middle of a swing that takes twice this time, were there no limit of velocity: the
    /// acceleration falls by the jerk to zero in the middle.
    fn middle_velocity(&self, half: f64) -> f64 {
        // From the middle backwards the acceleration is J x up to A.
        let falling = half.min(self.acceleration / self.jerk);
        let risen = if falling > 0.0 { 0.5 * self.jerk * falling * falling } else { 0.0 };
        let even = half - falling;
        risen + if even > 0.0 { self.acceleration * even } else { 0.0 }
    }

    /// Way in the first half of a swing without a limit of velocity.
    fn half_way(&self, half: f64) -> f64 {
        let falling = half.min(self.acceleration / self.jerk);
        let even = half - falling;
        // x times the acceleration at x before the middle, summed from the middle to the begin.
        let risen = if falling > 0.0 { self.jerk * falling.powi(3) / 3.0 } else { 0.0 };
        risen + if even > 0.0 { 0.5 * self.acceleration * (half * half - falling * falling) } else { 0.0 }
    }

    /// Farthest way in half of a swing.
    fn farthest(&self, half: f64) -> f64 {
        if self.middle_velocity(half) <= self.velocity {
            return self.half_way(half);
        }
        let ramp = bisect(half, |t| self.middle_velocity(t) > self.velocity);
        self.half_way(ramp) + self.velocity * (half - ramp)
    }

    /// Least time from a place where the joint turns back to the next.
    pub(crate) fn turn_to_turn(&self, way: f64) -> f64 {
        if self.acceleration.is_infinite() && self.jerk.is_infinite() {
            return way / self.velocity;
        }
        let mut most = way / self.velocity;
        while self.farthest(most) < 0.5 * way {
            most *= 2.0;
        }
        2.0 * bisect(most, |t| self.farthest(t) > 0.5 * way)
    }

    /// Least time from a place where the joint turns back to one that it passes, or the other way round.
    pub(crate) fn after_turn(&self, way: f64) -> f64 {
        if self.acceleration.is_infinite() {
            return way / self.velocity;
        }
        let farthest = |time: f64| {
            let ramp = time.min(self.velocity / self.acceleration);
            0.5 * self.acceleration * ramp * ramp + self.velocity * (time - ramp)
        };
        let mut most = way / self.velocity;
        while farthest(most) < way {
            most *= 2.0;
        }
        bisect(most, |t| farthest(t) > way)
    }
}

/// The smallest number up to `most` at which something begins to hold, from below.
fn bisect(most: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}
