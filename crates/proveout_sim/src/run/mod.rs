//! Runs: the main loop, and what is run or asked in other ways: in shards, partly, for the stickout of tools,
//! and questions to the stock of a finished run.
//!
//! | file | what it does |
//! |---|---|
//! | `listing.rs` | program lines as findings and blocks name them |
//! | `main_loop.rs` | the prove-out loop |
//! | `measure.rs` | sections, distances and walls of a finished run |
//! | `motion_plan.rs` | the control of a run, and its motion in stretches |
//! | `overhang.rs` | the least stickout of each tool |
//! | `partial.rs` | `--preview` and `--stop-at` |
//! | `probing.rs` | what the probing motions of a program find, on the stock of their moment |
//! | `readings.rs` | block skip and optional stop, both ways |
//! | `shards/` | one run on several machines |
//! | `show_mesh.rs` | the surface of the cut part for the observers |

pub mod listing;
pub(crate) mod main_loop;
pub mod measure;
pub(crate) mod motion_plan;
pub mod overhang;
pub mod partial;
pub(crate) mod probing;
pub(crate) mod readings;
pub mod shards;
pub(crate) mod show_mesh;

pub use self::main_loop::{Checks, RunResult, Stages, run, run_journaled, run_merged, run_with_surface};
