//! From a program to a scene that runs, and the causes of findings that can be known before a run.
//!
//! | file | what it does |
//! |---|---|
//! | `causes.rs` | causes that the text of a program shows by itself |
//! | `first_part/` | a scene from a program, with questions |
//! | `preflight.rs` | causes of findings, named before a run |

pub(crate) mod causes;
pub mod first_part;
pub mod preflight;
