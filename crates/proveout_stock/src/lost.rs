//! Who took material of which nothing is left on a ray.
//!
//! An end of material remembers the motion that made it. Where a motion takes the whole interval that it meets, no end is left
//! to remember it: a wall that was milled away would have no one to answer for it. So each ray keeps the last motion that took
//! a whole interval; one number a ray, only in tiles where that has happened.

use proveout_geom::Point;

use crate::{
    dexel::{SurfacePoint, TriDexel},
    grid::{Grid, TILE, TILE_RAYS},
    rows::RayPlace,
    span::INITIAL,
};

/// The last motion that took a whole interval, for each ray of a tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lost(Option<Box<[u32; TILE_RAYS]>>);

impl Lost {
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

    /// The point of the surface nearest to a place that a motion has made; among equals the first in the order of
    /// [`Self::surface_points`]. None where nothing was cut.
    pub fn nearest_cut(&self, place: &Point) -> Option<SurfacePoint> {
        let mut best: Option<(f64, SurfacePoint)> = None;
        for (t, tile) in self.tiles.iter().enumerate().filter(|(_, tile)| !tile.is_empty()) {
            let (a, [i0, j0]) = self.grid.tile_place(t);
            let (u, v) = ((a + 1) % 3, (a + 2) % 3);
            let beside = |axis: usize, first: usize| {
                let (low, high) = (self.grid.center(axis, first), self.grid.center(axis, first + TILE - 1));
                (low - place[axis]).max(place[axis] - high).max(0.0)
            };
            let along = (tile.lo - place[a]).max(place[a] - tile.hi).max(0.0);
            let least = beside(u, i0).powi(2) + beside(v, j0).powi(2) + along * along;
            if best.is_some_and(|b| least >= b.0) {
                continue;
            }
            for r in 0..TILE_RAYS {
                let at = [self.grid.center(u, i0 + r % TILE), self.grid.center(v, j0 + r / TILE)];
                for end in tile.ray(r).iter().flat_map(|s| s.ends()) {
                    let Some(id) = end.mark.made_by() else { continue };
                    let point = Grid::point(a, end.s, at[0], at[1]);
                    let apart = (point - place).norm_squared();
                    if best.is_none_or(|b| apart < b.0) {
                        let normal = Some(end.mark.normal());
                        best = Some((apart, SurfacePoint { point, normal, made_by: Some(id), axis: a as u8 }));
                    }
                }
            }
        }
        best.map(|b| b.1)
    }
}
