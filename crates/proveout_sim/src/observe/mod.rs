//! What observers get. Recorders, reports and progress bars implement [`Observer`](crate::Observer).
//!
//! | file | what it does |
//! |---|---|
//! | `block_rows.rs` | rows of blocks, signals, clearance proofs, detached parts |
//! | `free_axes_map.rs` | collision-free tool axes along the motion |
//! | `observer.rs` | the trait, and the data that it hands over |
//! | `observer_error.rs` | why an observer could not write |
//! | `schedule_rows.rs` | a re-scheduled program compared with its source |
//! | `study.rs` | curves and numbers that a method shows of its work |
//! | `surface_keeper.rs` | the observer that gathers the whole surface |
//! | `surface_map.rs` | the surface of the cut part |
//! | `surface_texture.rs` | maps and profiles of the texture |

pub(crate) mod block_rows;
pub(crate) mod free_axes_map;
pub mod observer;
pub(crate) mod observer_error;
pub(crate) mod schedule_rows;
pub(crate) mod study;
pub(crate) mod surface_keeper;
pub(crate) mod surface_map;
pub(crate) mod surface_texture;
