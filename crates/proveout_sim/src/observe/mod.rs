//! What observers get. Recorders, reports and progress bars implement [`Observer`](crate::Observer).
//!
//! | file | what it does |
//! |---|---|
//! | `observer.rs` | the trait, and the data that it hands over |
//! | `surface_map.rs` | the surface of the cut part |

pub mod observer;
pub(crate) mod surface_map;
