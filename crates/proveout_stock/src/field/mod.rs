//! The rays in their tiles: how they are filled, how batches of motions are carried out on them, and what a
//! motion was engaged in.

pub(crate) mod batch;
pub(crate) mod depth;
pub(crate) mod dexel;
pub(crate) mod engagement;
pub(crate) mod grid;
pub(crate) mod last_emptied;
pub(crate) mod mesh_rays;
pub(crate) mod opening;
pub(crate) mod raw_body;
pub(crate) mod raw_stock;
pub(crate) mod regrid_bound;
pub(crate) mod slices;
pub(crate) mod span;
pub(crate) mod sweep;
pub(crate) mod tile;
pub(crate) mod tile_cut;
pub(crate) mod tile_field;
pub(crate) mod tile_gather;
pub(crate) mod tile_work;
pub(crate) mod undo;
pub(crate) mod watch;
