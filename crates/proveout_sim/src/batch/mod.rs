//! Many runs from one file: the setups of a part in their order, or one scene with many values of its inputs.
//!
//! | file | what it does |
//! |---|---|
//! | `job.rs` | `job.toml`: several setups of one part |
//! | `sweep/` | `sweep.toml`: one scene with many values |

pub mod job;
pub mod sweep;
