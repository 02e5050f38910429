//! The stock as tiles of its surface, at a coarse level of detail.

use std::collections::{BTreeMap, BTreeSet};

use proveout_geom::Aabb;
use proveout_stock::{Patch, SurfaceMesh, TileId, TriDexel};

use crate::picture::{NO_PIECE, Picture};

/// Groups along the longest edge: each is an entity of the recording.
const GROUPS: f64 = 6.0;

/// Numbers of groups that a stock or a patch has to itself.
const GROUPS_OF_ONE: u32 = 1000;

/// The part of the surface of a stock that is shown.
#[derive(Debug, Default)]
enum SurfaceWindow {
    #[default]
    Whole,
    /// Outside of the windows of its patches.
    Outside(Vec<Aabb>),
    /// In the window of a patch.
    Inside(Aabb),
}

/// Keeps the surface of each tile and joins tiles to groups, which are re-logged when one of their tiles
/// changes.
#[derive(Debug, Default)]
pub(crate) struct StockTiles {
    /// Every `step`-th node of the stock is used.
    step: usize,
    shown: SurfaceWindow,
    /// Group of each tile.
    group_of: Vec<u32>,
    tiles: Vec<Picture>,
    changed: BTreeSet<TileId>,
}

impl StockTiles {
    /// Of a stock with its patches: the stock outside of their windows first, then each patch. `triangles`:
    /// of the first picture of each, about; it decides the level of detail.
    pub(crate) fn all(stock: &TriDexel, patches: &[Patch], triangles: f64) -> Vec<Self> {
        let windows: Vec<Aabb> = patches.iter().map(|p| *p.window()).collect();
        let own = if windows.is_empty() { SurfaceWindow::Whole } else { SurfaceWindow::Outside(windows) };
        let mut all = vec![Self::new(stock, 0, own, triangles)];
        for (patch, number) in patches.iter().zip(1..) {
            all.push(Self::new(patch.stock(), number, SurfaceWindow::Inside(*patch.window()), triangles));
        }
        all
    }

    /// `number`: 0 of the stock, else the place of the patch in the scene, from 1.
    fn new(stock: &TriDexel, number: u32, shown: SurfaceWindow, triangles: f64) -> Self {
        let size = stock.bounds().size();
        let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
        // Two triangles a cell of surface; the stock takes powers of two.
        let wanted = (2.0 * area / triangles).sqrt() / stock.cell_mm();
        let step = (wanted.max(1.0).ceil() as usize).next_power_of_two().min(32);
        let edge = size.max() / GROUPS;
        let group = |tile: usize| {
            let center = stock.tile_bounds(TileId(tile as u32)).center() - stock.bounds().min;
            let index = |k: usize| (center[k] / edge).floor().clamp(0.0, GROUPS - 1.0) as u32;
            number * GROUPS_OF_ONE + (index(2) * GROUPS as u32 + index(1)) * GROUPS as u32 + index(0)
        };
        let count = stock.tile_count();
        Self {
            step,
            shown,
            group_of: (0..count).map(group).collect(),
            tiles: vec![Picture::default(); count],
            changed: (0..count as u32).map(TileId).collect(),
        }
    }

    /// Distance of the nodes that are used, in cells.
    pub(crate) fn step(&self) -> usize {
        self.step
    }

    pub(crate) fn mark(&mut self, tiles: &[TileId]) {
        self.changed.extend(tiles.iter().filter(|t| (t.0 as usize) < self.tiles.len()));
    }

    fn cut(&self, surface: SurfaceMesh) -> SurfaceMesh {
        match &self.shown {
            SurfaceWindow::Whole => surface,
            SurfaceWindow::Outside(windows) => surface.outside(windows),
            SurfaceWindow::Inside(window) => surface.inside(window),
        }
    }

    /// Surface of every group with a tile that changed since the last call; without triangles when nothing is
    /// left.
    pub(crate) fn take_changed(&mut self, stock: &TriDexel) -> BTreeMap<u32, Picture> {
        let mut groups = BTreeMap::new();
        for tile in std::mem::take(&mut self.changed) {
            let surface = self.cut(stock.tile_surface(tile, self.step));
            let mut picture = Picture::new(&surface.mesh, &surface.normals, &[]);
            picture.pieces = surface.made_by.iter().map(|piece| piece.unwrap_or(NO_PIECE)).collect();
            self.tiles[tile.0 as usize] = picture;
            groups.insert(self.group_of[tile.0 as usize], Picture::default());
        }
        for (tile, picture) in self.tiles.iter().enumerate() {
            if let Some(all) = groups.get_mut(&self.group_of[tile]) {
                all.append(picture);
            }
        }
        groups
    }

    /// All groups that hold tiles, in rising order.
    #[cfg(feature = "rerun")]
    pub(crate) fn groups(&self) -> BTreeSet<u32> {
        self.group_of.iter().copied().collect()
    }

    /// Parts of the path of a group: name of the patch, where it is one, and place along x, y and z.
    #[cfg(feature = "rerun")]
    pub(crate) fn name(group: u32, patches: &[String]) -> Vec<String> {
        let n = GROUPS as u32;
        let (number, group) = (group / GROUPS_OF_ONE, group % GROUPS_OF_ONE);
        let place = format!("{}_{}_{}", group % n, group / n % n, group / (n * n));
        let patch = number.checked_sub(1).and_then(|k| patches.get(k as usize));
        patch.map(|name| format!("patch_{name}")).into_iter().chain([place]).collect()
    }
}
