//! What a run leaves as evidence: the files that it read and wrote, with digests, and who vouches for them.
//!
//! | file | what it does |
//! |---|---|
//! | `digest.rs` | SHA-256 of input files |
//! | `inputs.rs` | the files that a run reads, and what is noticed in them |
//! | `manifest.rs` | `manifest.json`, and `verify` |
//! | `run_folder.rs` | the run folder, moved into place when it is complete |
//! | `signature.rs` | `manifest.sig` |

pub mod digest;
pub(crate) mod inputs;
pub(crate) mod manifest;
pub(crate) mod run_folder;
pub(crate) mod signature;
