//! Who took material of which nothing is left on a ray.
//!
//! An end of material remembers the motion that made it. Where a motion takes the whole interval that it
//! meets, no end is left to remember it: a wall that was milled away would have no one to answer for it. So
//! each ray keeps the last motion that took a whole interval; one number a ray, only in tiles where that has
//! happened.

use crate::{field::grid::TILE_RAYS, field::span::INITIAL};

/// The last motion that took a whole interval, for each ray of a tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct LastEmptied(Option<Box<[u32; TILE_RAYS]>>);

impl LastEmptied {
    pub(crate) fn set(&mut self, ray: usize, id: u32) {
        self.0.get_or_insert_with(|| Box::new([INITIAL; TILE_RAYS]))[ray] = id;
    }

    pub(crate) fn of(&self, ray: usize) -> Option<u32> {
        self.0.as_ref().map(|all| all[ray]).filter(|id| *id != INITIAL)
    }

    pub(crate) fn heap_bytes(&self) -> u64 {
        self.0.as_ref().map_or(0, |all| size_of_val(all.as_ref()) as u64)
    }
}
