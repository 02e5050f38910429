//! The recording for the Rerun viewer.
//!
//! ```text
//! /machine                      frame M, mm, right-handed, Z up
//!   /base/<body>                bodies of the bed
//!   /axis_<joint>               pose over time; the bodies that hang on the joint below it
//!   /tool                       pose of the tip frame T over time; cutting, neck, shank, holder as of
//!                               each tool change
//!   /table                      pose of the table frame K over time
//!     /fixtures/<name>
//!     /loose/<n>                a part that came off the stock, from then on; pose over time
//!     /work                     workpiece frame W, fixed on the table
//!       /stock/<i_j_k>          tiles of the stock, logged again when they change
//!       /stock/patch_<name>/<i_j_k>  the same of a patch, in its window instead of the stock
//!       /part                   design part
//!       /path/{feed,rapid}/<n>  path of the tip, growing with time, in feed colored by the feed
//!                               reached over the programmed one
//!       /findings               places of the findings
//!       /surface                cut part at the end, colored by deviation
//! /axes/<joint>/{position,velocity,acceleration,jerk,following_error}   mm or degrees, seconds
//! /process/{feed,feed_programmed,removal,clearance}                     mm/min, mm³/s, mm
//! /program/block                file, line and text of the block that runs
//! /log                          findings and messages as text
//! ```
//!
//! The recording of a re-scheduled program has its schedule next to the original program:
//!
//! ```text
//! /schedule                     also on the timeline `path_um`: way of the tool over all runs, micrometers
//!   /text                       what is shown, times, bound, what is left to gain, numbers of the method
//!   /sphere/{original,new}      tool axes as ways on the unit sphere of frame W; `..._now` at the time
//!                               of the viewer
//!   /joints/<joint>/position/{lowest,highest,original,new}     ends of the channel, where there is one;
//!                                                              mm or degrees
//!   /joints/<joint>/in_channel/{lowest,highest,original,new}   the same less the middle of the channel
//!   /joints/<joint>/{velocity,acceleration}/{original,new}     at the programmed feed, differences over
//!                                                              blocks
//!   /method/<quantity>/<curve>  what the method shows along the path
//! /machine/table/work/schedule/{original,new}                  tool axes as arrows, at most 160 each
//! ```
//!
//! Everything lies on the timeline `sim_time`, and what the run shows on `nc_block` too: number of the
//! executed block, one step a block. Thinning: poses at most 50 a second, signals as smallest and
//! largest sample of stretches of 40 ms; both spacings double after every 15 000 rows. The stock is shown at
//! thirty to fifty times, closer at the begin, and at tool changes, from every 2ⁿ-th node so that its first
//! picture has about 150 000 triangles. Nothing of it is measured: exact values are in the Parquet tables.

mod about;
mod axis_caps;
mod block_text;
mod blueprint;
mod observer;
mod read_back;
mod schedule;
mod signal_thinning;
mod sink;
mod trace;
mod tracks;

pub use observer::RerunObserver;
pub use read_back::{RecordedEntity, read_recording};
