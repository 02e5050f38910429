//! What probing motions have found: answers that come from the outside, one a motion, in the order of the
//! run.
//!
//! The reader knows no workpiece. It hands a probing motion out with [`Contact::Asked`] and stops there until
//! the list has one more answer; then it hands the same motion out with its true end, gives the variables of
//! the control their values, and goes on. A list that is complete is an input like a work offset: the same
//! text with the same list gives the same commands.
//!
//! ```text
//!   reader ──Probe, asked──► whoever has the stock ──Touch──► list
//!     ▲                                                        │
//!     └────────── end of the motion, #5061, $AA_MW ◄───────────┘
//! ```

use std::sync::{Arc, Mutex, PoisonError};

/// What is known of the end of a probing motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Contact {
    /// Nothing: the motion runs to its programmed end, and what the probe finds is not known.
    #[default]
    Unknown,
    /// Not known yet: the tool waits at the start of the motion for the answer.
    Asked,
    /// The probe has switched at the end of the motion.
    Touched,
    /// The motion ran to its programmed end, and the probe has not switched.
    Missed,
}

/// The answer to one probing motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// What was met.
    pub met: Met,
    /// The probe touches, or is off the surface it is to leave, before the motion begins.
    pub at_start: bool,
    /// Radius of the ball of the stylus, mm; zero where it is not known.
    pub ball_radius: f64,
}

/// How a probing motion ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Met {
    /// It is not known: no stylus in the spindle.
    #[default]
    Unknown,
    /// The probe switched after this part of the way, 0 to 1.
    After(f64),
    /// It did not switch.
    Nothing,
}

/// The answers of a run, which a copy of the list shares.
#[derive(Clone, Debug, Default)]
pub struct TouchList(Arc<Mutex<Vec<Touch>>>);

impl TouchList {
    /// Adds the answer to the next probing motion.
    pub fn push(&self, touch: Touch) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(touch);
    }

    /// The answer to the probing motion of this number, from zero.
    pub fn get(&self, number: usize) -> Option<Touch> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(number).copied()
    }

    /// All answers.
    pub fn all(&self) -> Vec<Touch> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl PartialEq for TouchList {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.all() == other.all()
    }
}

impl FromIterator<Touch> for TouchList {
    fn from_iter<I: IntoIterator<Item = Touch>>(touches: I) -> Self {
        Self(Arc::new(Mutex::new(touches.into_iter().collect())))
    }
}
