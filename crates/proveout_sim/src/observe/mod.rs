//! What observers get. Recorders, reports and progress bars implement [`Observer`](crate::Observer).
//!
//! | file | what it does |
//! |---|---|
//! | `block_rows.rs` | rows of blocks, signals, clearance proofs, detached parts |
//! | `observer.rs` | the trait, and the data that it hands over |
//! | `observer_error.rs` | why an observer could not write |
//! | `surface_keeper.rs` | the observer that gathers the whole surface |
//! | `surface_map.rs` | the surface of the cut part |

pub(crate) mod block_rows;
pub mod observer;
pub(crate) mod observer_error;
pub(crate) mod surface_keeper;
pub(crate) mod surface_map;
