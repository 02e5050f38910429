//! Where a program depends on parameters of its control: what the feed counts, and which way a rotary axis
//! goes.

use std::f64::consts::{PI, TAU};

use super::{Channel, Language};
use crate::control::{MixedFeed, Rollover, TiltSolution};
use crate::{AXIS_LETTERS, Feed, FeedCounts, Motion, Op, RotarySolution};

/// Angles nearer than this are the same, radian.
const SAME: f64 = 1e-9;
/// Ways of linear axes below this are none, mm.
const NO_WAY: f64 = 1e-9;
/// Bits of A, B and C.
const ROTARY: u16 = 0b111000;
/// Radii of a rotary axis nearer than this are the same, mm.
const SAME_RADIUS_MM: f64 = 1e-6;

/// What commands and notes so far say of how the parameters count.
#[derive(Debug, Default)]
pub(crate) struct CountingState {
    /// Tool center point control is on.
    tcp: bool,
    /// F is the time of the block.
    inverse_time: bool,
    /// What the feed counts, as it was emitted.
    counts: Option<FeedCounts>,
    /// What the program itself says that the feed counts (FGROUP, FGREF).
    pub(crate) program_counts: Option<FeedCounts>,
    mixed: bool,
    rollover: bool,
}

/// What the language counts where neither program nor control file says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UsualFeed {
    /// The rule of the language: no parameter changes it.
    Rule(MixedFeed),
    /// Usual, and a parameter decides.
    Usual(MixedFeed),
}

impl CountingState {
    pub(super) fn look(&mut self, op: &Op) {
        match op {
            Op::Tcp(tcp) => self.tcp = tcp.on,
            Op::Feed(feed) => self.inverse_time = matches!(feed, Feed::InverseTime(_)),
            _ => {}
        }
    }
}

impl<L: Language> Channel<L> {
    /// Called before a motion in feed is emitted: emits what the feed counts, where rotary axes
    /// turn and it matters.
    #[inline]
    pub(crate) fn before_feed(&mut self, motion: &Motion) {
        if motion.programmed & ROTARY == 0 || self.told.tcp || self.told.inverse_time || motion.machine_coordinates {
            return;
        }
        self.tell_feed_counts(motion);
    }

    fn tell_feed_counts(&mut self, motion: &Motion) {
        let moves = |axis: usize, least: f64| {
            motion.programmed >> axis & 1 == 1
                && match (self.position.base.get(axis), motion.end_base.get(axis)) {
                    (Some(from), Some(to)) => (to - from).abs() > least,
                    _ => true,
                }
        };
        let linear = (0..3).any(|axis| moves(axis, NO_WAY));
        if !(3..6).any(|axis| moves(axis, SAME)) {
            return;
        }
        let parameters = &self.settings.control.parameters;
        let stated = parameters.mixed_feed;
        let usual = L::mixed_feed(self);
        let counted = match (self.told.program_counts, stated, usual) {
            (Some(counts), ..) => counts,
            (None, None, UsualFeed::Usual(MixedFeed::Linear) | UsualFeed::Rule(MixedFeed::Linear))
            | (None, Some(MixedFeed::Linear), _) => FeedCounts::LINEAR,
            _ => FeedCounts {
                radius: parameters.reference_radius.map(|r| r.unwrap_or(FeedCounts::DEGREE_IS_MM)),
                ..FeedCounts::LINEAR
            },
        };
        let assumed = linear && self.told.program_counts.is_none() && stated.is_none();
        if assumed
            && let UsualFeed::Usual(usual) = usual
            && !std::mem::replace(&mut self.told.mixed, true)
        {
            self.assume(match usual {
                MixedFeed::Vector => {
                    "F of a block that moves linear and rotary axes together is the speed along the vector of all axes, one degree \
                     counted as one millimeter; a parameter of the control decides: state it as parameters.mixed_feed of its control \
                     file (with parameters.reference_radius_mm where a diameter counts)"
                }
                MixedFeed::Linear => {
                    "F of a block that moves linear and rotary axes together is the speed of the linear axes, and the rotary axes \
                     arrive at the same time; the set-up of the control decides: state it as parameters.mixed_feed of its control \
                     file, or write FGROUP"
                }
            });
        }
        // A block of rotary axes alone counts degrees, unless a radius is stated.
        let alone = !linear
            && counted.radius.iter().all(|r| *r == 0.0 || (r - FeedCounts::DEGREE_IS_MM).abs() < SAME_RADIUS_MM);
        if alone || self.told.counts == Some(counted) {
            return;
        }
        self.told.counts = Some(counted);
        self.emit(Op::FeedCounts(counted));
    }

    /// The axis may go either way round, as far as it is known.
    fn rolls_over(&self, axis: usize) -> bool {
        let stated = self.settings.control.parameters.rollover_axes;
        let endless = self.settings.reference_points.as_ref().map(|points| points.endless);
        stated.or(endless).is_none_or(|axes| axes >> axis & 1 == 1)
    }

    /// Where a rotary axis goes that is sent to an absolute position.
    pub(crate) fn rolled(&mut self, axis: usize, value: f64) -> f64 {
        let Some(now) = self.position.work.get(axis) else { return value };
        if !self.rolls_over(axis) {
            return value;
        }
        match self.settings.control.parameters.rollover {
            Some(Rollover::AsWritten) => value,
            Some(Rollover::Shortest) => self.short_way(axis, value),
            Some(Rollover::Sign) if value.is_sign_negative() => now - turn_up(now + value),
            Some(Rollover::Sign) => now + turn_up(value - now),
            None => {
                if (value - now).abs() > PI + SAME && !std::mem::replace(&mut self.told.rollover, true) {
                    let letter = AXIS_LETTERS[axis];
                    self.assume(format!(
                        "{letter} goes from {:.3} to {:.3} degrees as written, by {:.3} degrees; with roll-over the axis takes another \
                         way: a parameter of the control decides, state it as parameters.rollover of its control file",
                        now.to_degrees(),
                        value.to_degrees(),
                        (value - now).to_degrees()
                    ));
                }
                value
            }
        }
    }

    /// Which position of the rotary axes a tilted plane takes where the program does not choose.
    pub(crate) fn usual_solution(&self) -> RotarySolution {
        let parameters = &self.settings.control.parameters;
        let reference = parameters.tilt_reference;
        match parameters.tilt_solution {
            None | Some(TiltSolution::Shortest) => RotarySolution::Nearest,
            Some(TiltSolution::Lower) => RotarySolution::Angle { higher: false, reference, or_other: true },
            Some(TiltSolution::Higher) => RotarySolution::Angle { higher: true, reference, or_other: true },
        }
    }

    /// The position with the lower or higher angle of the reference axis. `or_other`: where it is out of
    /// travel, the other one.
    pub(crate) fn chosen_solution(&self, higher: bool, or_other: bool) -> RotarySolution {
        RotarySolution::Angle { higher, reference: self.settings.control.parameters.tilt_reference, or_other }
    }
}

/// A turn in the positive direction, 0 to one turn; what is a full turn but for rounding is none.
pub(crate) fn turn_up(angle: f64) -> f64 {
    let turn = angle.rem_euclid(TAU);
    if TAU - turn < SAME { 0.0 } else { turn }
}
