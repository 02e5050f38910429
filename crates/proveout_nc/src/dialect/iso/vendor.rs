//! Facts of the controls that speak ISO 6983, one field a fact: what a Fanuc, a Haas and a `LinuxCNC` do
//! where they differ. The grammar of a language, RS274 or macro B, is a question to [`Flavor`] itself.
//!
//! Sources: those of the words (`words.rs`) and of the coverage table in the README.

use super::flavor::Flavor;
use super::interpreter::Interpreter;

/// What a control does.
#[derive(Debug)]
pub(crate) struct Vendor {
    /// `,C` and `,R` between a line and a circle.
    pub(crate) rounds_circles: bool,
    /// `M98 P32000` calls program 2000 three times.
    pub(crate) passes_before_number: bool,
    /// `G53` moves in feed under `G1`.
    pub(crate) g53_in_feed: bool,
    /// A parameter decides whether the tool length stays in force after `G28 G30 G53`.
    pub(crate) length_after_reference_is_set_up: bool,
    /// Word of tool center point control with rotary axes.
    pub(crate) tcp_word: &'static str,
    /// `G28` without an axis is refused.
    pub(crate) reference_needs_axis: bool,
    /// `G28` cancels the tool length.
    pub(crate) g28_cancels_length: bool,
    /// `L` repeats a motion in feed.
    pub(crate) l_repeats_motion: bool,
    /// Axis words before any `G0` or `G1` move.
    pub(crate) moves_at_power_on: bool,
    /// A number without a decimal point may count least increments.
    pub(crate) has_increments: bool,
    /// `ATAN` gives 0 to 360 degrees (parameter 6004 bit 0 is 0).
    pub(crate) angles_to_360: bool,
    /// The variables #200 to #499 are for the program.
    pub(crate) variables_to_499: bool,
    /// Highest number of an additional work offset.
    pub(crate) highest_extra_offset: f64,
    /// `G54 P1` is another spelling of `G54.1 P1`.
    pub(crate) g54_takes_p: bool,
    /// `G92` with `F` is a thread of a lathe.
    pub(crate) g92_f_cuts_threads: bool,
    /// Work offset of `G10 L20` without `P`.
    pub(crate) offset_of_l20: f64,
    /// `G10` adds to an offset under `G91`.
    pub(crate) g10_adds: bool,
    /// A change of the tool length alone moves the tool axis.
    pub(crate) length_word_moves: bool,
    /// `H` alone changes the tool length in force.
    pub(crate) h_is_modal: bool,
    /// `D` alone changes the cutter compensation in force.
    pub(crate) d_is_modal: bool,
    /// `G73 G83` take their infeeds in `I J K`.
    pub(crate) pecks_in_ijk: bool,
    /// The unit must not change under a cycle.
    pub(crate) unit_stays_in_cycle: bool,
    /// `G99` is in force at the start.
    pub(crate) returns_to_r_at_start: bool,
    /// A cycle takes no motion of rotary axes.
    pub(crate) cycles_refuse_rotary: bool,
    /// Stored numbers of a cycle are read by the `G90` or `G91` now in force, not by that of their block.
    pub(crate) cycle_numbers_follow_mode: bool,
    /// `G98` comes back to the R plane where it is above the initial level.
    pub(crate) returns_to_higher_plane: bool,
    /// `P` of an arc counts its turns.
    pub(crate) arcs_take_turns: bool,
    /// An arc with `R` leaves `I J K` out of account.
    pub(crate) radius_before_center: bool,
    /// Start and end of an arc may differ in radius.
    pub(crate) runs_spirals: bool,
    /// `D` of `G96` is the highest speed.
    pub(crate) speed_limit_in_d: bool,
    /// `M5` and `M9` act before the motion of their block.
    pub(crate) stops_before_motion: bool,
    /// A tool change leaves X and Y where they are.
    pub(crate) tool_change_keeps_xy: bool,
    /// A G word must not be written twice in a block.
    pub(crate) refuses_word_twice: bool,
    /// A change of the unit forgets the feed.
    pub(crate) unit_forgets_feed: bool,
}

static FANUC: Vendor = Vendor {
    rounds_circles: true,
    passes_before_number: true,
    g53_in_feed: true,
    length_after_reference_is_set_up: true,
    tcp_word: "G43.4",
    reference_needs_axis: true,
    g28_cancels_length: false,
    l_repeats_motion: false,
    moves_at_power_on: true,
    has_increments: true,
    angles_to_360: true,
    variables_to_499: false,
    highest_extra_offset: 300.0,
    g54_takes_p: true,
    g92_f_cuts_threads: true,
    offset_of_l20: 1.0,
    g10_adds: true,
    length_word_moves: true,
    h_is_modal: true,
    d_is_modal: true,
    pecks_in_ijk: false,
    unit_stays_in_cycle: false,
    returns_to_r_at_start: false,
    cycles_refuse_rotary: false,
    cycle_numbers_follow_mode: false,
    returns_to_higher_plane: false,
    arcs_take_turns: false,
    radius_before_center: true,
    runs_spirals: false,
    speed_limit_in_d: false,
    stops_before_motion: false,
    tool_change_keeps_xy: false,
    refuses_word_twice: false,
    unit_forgets_feed: true,
};

static HAAS: Vendor = Vendor {
    rounds_circles: false,
    passes_before_number: false,
    g53_in_feed: false,
    length_after_reference_is_set_up: false,
    tcp_word: "G234",
    reference_needs_axis: false,
    g28_cancels_length: true,
    l_repeats_motion: true,
    moves_at_power_on: true,
    has_increments: true,
    angles_to_360: false,
    variables_to_499: true,
    highest_extra_offset: 99.0,
    g54_takes_p: false,
    g92_f_cuts_threads: true,
    offset_of_l20: 1.0,
    g10_adds: true,
    length_word_moves: false,
    h_is_modal: true,
    d_is_modal: true,
    pecks_in_ijk: true,
    unit_stays_in_cycle: false,
    returns_to_r_at_start: false,
    cycles_refuse_rotary: false,
    cycle_numbers_follow_mode: false,
    returns_to_higher_plane: false,
    arcs_take_turns: false,
    radius_before_center: false,
    runs_spirals: false,
    speed_limit_in_d: false,
    stops_before_motion: false,
    tool_change_keeps_xy: false,
    refuses_word_twice: false,
    unit_forgets_feed: true,
};

static LINUXCNC: Vendor = Vendor {
    rounds_circles: false,
    passes_before_number: false,
    g53_in_feed: false,
    length_after_reference_is_set_up: false,
    tcp_word: "G43.4",
    reference_needs_axis: false,
    g28_cancels_length: false,
    l_repeats_motion: false,
    moves_at_power_on: false,
    has_increments: false,
    angles_to_360: false,
    variables_to_499: false,
    highest_extra_offset: 300.0,
    g54_takes_p: false,
    g92_f_cuts_threads: false,
    offset_of_l20: 0.0,
    g10_adds: false,
    length_word_moves: false,
    h_is_modal: false,
    d_is_modal: false,
    pecks_in_ijk: false,
    unit_stays_in_cycle: true,
    returns_to_r_at_start: true,
    cycles_refuse_rotary: true,
    cycle_numbers_follow_mode: true,
    returns_to_higher_plane: true,
    arcs_take_turns: true,
    radius_before_center: false,
    runs_spirals: true,
    speed_limit_in_d: true,
    stops_before_motion: true,
    tool_change_keeps_xy: true,
    refuses_word_twice: true,
    unit_forgets_feed: false,
};

impl Flavor {
    /// The facts of this control.
    pub(crate) fn vendor(self) -> &'static Vendor {
        match self {
            Self::Fanuc => &FANUC,
            Self::Haas => &HAAS,
            Self::LinuxCnc => &LINUXCNC,
        }
    }
}

impl Interpreter {
    /// The facts of the control that the program is read for.
    pub(super) fn vendor(&self) -> &'static Vendor {
        self.own.flavor.vendor()
    }
}
