//! The rays in their tiles: how they are filled, and how batches of motions are carried out on them.

pub(crate) mod dexel;
pub(crate) mod grid;
pub(crate) mod lost;
pub(crate) mod mesh_rays;
pub(crate) mod raw;
pub(crate) mod raw_body;
pub(crate) mod span;
pub(crate) mod step;
pub(crate) mod sweep;
pub(crate) mod tile;
pub(crate) mod tile_cut;
pub(crate) mod tile_field;
pub(crate) mod tile_gather;
pub(crate) mod tile_work;
