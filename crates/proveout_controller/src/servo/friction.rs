//! Dry friction of a drive with the Stribeck curve.
//!
//! *Dry friction* is a set at rest: any force up to the static one. It is taken at the end of the step
//! (implicit, Acary and Brogliato 2008, chapter 14): the linear map gives the velocity without friction and
//! what a constant friction force adds to it, `v = free + gain f` with gain > 0, so that
//!
//! ```text
//!   |free / gain| <= level   it sticks: f = -free / gain, v = 0 exactly
//!   else                     it slips:  f = -level sign(free), and v keeps the sign of free
//! ```
//!
//! has one solution at any step: no chatter, no threshold of velocity. The level follows the Stribeck curve
//! `Fc + (Fs - Fc) exp(-(v / vs)^2)` (Tustin 1947; Armstrong-Hélouvry 1994) at the velocity before the step.

/// Dry friction over M.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Friction {
    pub(crate) coulomb: f64,
    pub(crate) stiction: f64,
    pub(crate) stribeck: f64,
}

impl Friction {
    /// Level at a velocity.
    pub(crate) fn level(&self, velocity: f64) -> f64 {
        if self.stiction <= self.coulomb || self.stribeck <= 0.0 {
            return self.coulomb;
        }
        let x = velocity / self.stribeck;
        self.coulomb + (self.stiction - self.coulomb) * (-x * x).exp()
    }

    /// Force of friction, and whether the mass sticks.
    #[inline]
    pub(crate) fn force(&self, free: f64, gain: f64, velocity: f64) -> (f64, bool) {
        if self.stiction == 0.0 {
            return (0.0, false);
        }
        let level = self.level(velocity);
        let need = -free / gain;
        if need.abs() <= level { (need, true) } else { (level * need.signum(), false) }
    }
}
