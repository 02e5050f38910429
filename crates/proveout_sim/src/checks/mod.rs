//! Checks on motion and cuts, each for the findings that it names.
//! They get motion, cutting state and sweep reports as arguments, and know neither loop nor verdict.
//!
//! | file | what it does |
//! |---|---|
//! | `block_slope.rs` | the slope of a block as programmed |
//! | `engagement.rs` | engagement of the cutter in a block |
//! | `leg_limits.rs` | limits of the legs of a platform |
//! | `plunge.rs` | going down with a tool without edges at its center |
//! | `spindle_and_holder.rs` | contact of holder, shank and neck; rapids in material; spindle direction |
//! | `tap_pitch.rs` | feed of a tap per revolution |
//! | `thread_strokes.rs` | what taps cut outside of the core holes of the design |

pub(crate) mod block_slope;
pub(crate) mod engagement;
pub(crate) mod leg_limits;
pub(crate) mod plunge;
pub(crate) mod spindle_and_holder;
pub(crate) mod tap_pitch;
pub(crate) mod thread_strokes;
