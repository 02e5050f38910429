//! Feeds of a program under the limits of its tools: `proveout feeds`.
//!
//! In: a scene, a program with a text, limits of the tools. Out: the text with other F words, and for every
//! block what sets its feed. The force model is that of [`proveout_feeds`]; here are engagement along the
//! path, the text, and the loop with the twin.
//!
//! | file | what it does |
//! |---|---|
//! | `twin.rs` | one run of the twin: samples of engagement, what the machine made of each block |
//! | `window.rs` | samples joined over a cell of path |
//! | `demand.rs` | loads of samples, largest feeds of lines |
//! | `program_feeds.rs` | which lines may get another feed; the text with new ones |
//! | `schedule.rs` | the loop, and what is reported |

mod demand;
mod program_feeds;
mod schedule;
mod twin;
mod window;

pub use program_feeds::KeptWhy;
pub use proveout_feeds::{Binds, FeedMode, LimitsFile, Loads, Material, ToolLimits};
pub use schedule::{EngagementRow, FeedRow, FeedSetBy, FeedsCall, FeedsResult, MOST_RUNS, MachinePace, schedule};
pub use twin::JointLimit;
