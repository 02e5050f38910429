//! What is read off a stock: surface, rows, sections, distances, parts.

pub(crate) mod ball_touch;
pub(crate) mod bands;
pub(crate) mod coherence;
pub(crate) mod mesh_error;
pub(crate) mod moments;
pub(crate) mod overlap;
pub(crate) mod parts;
pub(crate) mod probe;
pub(crate) mod qef;
pub(crate) mod rows;
pub(crate) mod section;
pub(crate) mod sheets;
pub(crate) mod surface;
pub(crate) mod tile_tree;
pub(crate) mod volume;
