//! Checks on motion and cuts, each for the findings that it names.
//! They get motion, cutting state and sweep reports as arguments, and know neither loop nor verdict.
//!
//! | file | what it does |
//! |---|---|
//! | `block_slope.rs` | the slope of a block as programmed |
//! | `descent.rs` | going down with a tool without edges at its center |
//! | `engagement.rs` | engagement of the cutter in a block |
//! | `leg_limits.rs` | limits of the legs of a platform |
//! | `tap_pitch.rs` | feed of a tap per revolution |
//! | `thread_strokes.rs` | what taps cut outside of the core holes of the design |

pub(crate) mod block_slope;
pub(crate) mod descent;
pub(crate) mod engagement;
pub(crate) mod leg_limits;
pub(crate) mod tap_pitch;
pub(crate) mod thread_strokes;
