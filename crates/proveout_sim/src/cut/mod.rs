//! The prove-out of one stretch of motion: the stock is swept, bodies are checked against bodies and stock,
//! detached parts are followed. What it finds goes into the log, what it measures into the facts of the run.
//!
//! | file | what it does |
//! |---|---|
//! | `block_sums.rs` | what a block removes, and how its cutter is engaged |
//! | `bodies.rs` | machine bodies against each other along the motion |
//! | `body_facts.rs` | what the checks of bodies report to the gates |
//! | `cut_source.rs` | cuts that are replayed from a journal or from shards |
//! | `cutting.rs` | stock and patches, as they are cut |
//! | `detached_parts/` | parts that come off the stock, and where they fall |
//! | `engaged_samples.rs` | engagement along the path, by slices of the cutter |
//! | `engine.rs` | one stretch of motion through stock and bodies |
//! | `journal.rs` | what the sweeps did, so that an interrupted run can resume |
//! | `journal_error.rs` | why a run cannot keep or resume a journal |
//! | `kept_motion.rs` | the motion pieces that cut, kept to the end of the run |
//! | `shard_cuts.rs` | the cuts of all shards, as a merged run takes them |
//! | `shard_records.rs` | records in the files of a run in shards |
//! | `stages.rs` | wall time of the stages, effort of the checks |
//! | `stock_bodies.rs` | machine bodies against the stock while it is cut |
//! | `texture_motion.rs` | the motion near the places of `[surface]` |
//! | `tool_between_rays.rs` | contact of the tool with stock between the rays |
//! | `tool_sweeps.rs` | what a tool sweeps through the stock, and the state of the spindle |
//! | `tool_uses.rs` | which tool is in the spindle, and what each tool did |

pub(crate) mod block_sums;
pub(crate) mod bodies;
pub(crate) mod body_facts;
pub(crate) mod cut_source;
pub(crate) mod cutting;
pub(crate) mod detached_parts;
pub(crate) mod engaged_samples;
pub(crate) mod engine;
pub mod journal;
pub(crate) mod journal_error;
pub(crate) mod kept_motion;
pub(crate) mod shard_cuts;
pub(crate) mod shard_records;
pub(crate) mod stages;
pub(crate) mod stock_bodies;
pub(crate) mod texture_motion;
pub(crate) mod tool_between_rays;
pub(crate) mod tool_sweeps;
pub(crate) mod tool_uses;
