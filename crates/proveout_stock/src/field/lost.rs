//! Who took material of which nothing is left on a ray.
//!
//! An end of material remembers the motion that made it. Where a motion takes the whole interval that it meets, no end is left
//! to remember it: a wall that was milled away would have no one to answer for it. So each ray keeps the last motion that took
//! a whole interval; one number a ray, only in tiles where that has happened.

use crate::{field::dexel::TriDexel, field::grid::TILE_RAYS, field::span::INITIAL, looking::rows::RayPlace};

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

impl TriDexel {
    /// The last sweep item that took a whole interval of a ray; none where no item has, and in a stock from a file.
    pub fn last_to_empty(&self, ray: &RayPlace) -> Option<u32> {
        let [i, j] = ray.index;
        if ray.axis > 2 || i >= self.grid.n[(ray.axis + 1) % 3] || j >= self.grid.n[(ray.axis + 2) % 3] {
            return None;
        }
        let (tile, ray) = self.grid.ray_place(ray.axis, i, j);
        self.lost.get(tile)?.of(ray)
    }
}
