//! Counts the parts of a stock, at the cost of what has changed since the last call.
//!
//! A block is the intervals of one tile of the rays along z. Their connections with each other, and
//! with intervals of the next blocks along x and y, are kept with the tiles that were read for it:
//! mostly its own, its two neighbors and the lowest rows across. As long as none of them was cut,
//! reading them again would give the same result. The blocks' own parts, a few thousand at most,
//! are then joined as the intervals of [`TriDexel::parts`] are.

use crate::{
    field::dexel::TriDexel,
    field::grid::{TILE, TILE_RAYS},
    query::parts::Sets,
};

/// Parts of the blocks of a stock, see the text of the file.
#[derive(Clone, Debug, Default)]
pub struct Coherence {
    /// The pass over the stock that was seen last.
    seen: u32,
    blocks: Vec<LabelBlock>,
    parts: usize,
}

#[derive(Clone, Debug, Default)]
struct LabelBlock {
    /// Part within the block of each interval of its tile, in the order of the tile, and how many there are.
    part: Vec<u32>,
    parts: u32,
    /// Part, which neighbor (0 along x, 1 along y), and the interval there that it is connected to.
    links: Vec<(u32, usize, u32)>,
    /// The same by parts of the neighbor, each once.
    joined: Vec<(u32, usize, u32)>,
    /// Tiles that were read.
    read: Vec<u32>,
}

impl Coherence {
    /// Number of parts that [`TriDexel::parts`] would return. The stock must be that of the last
    /// call, unchanged except for cuts, parts that were taken out and parts that were put back.
    pub fn parts(&mut self, stock: &TriDexel) -> usize {
        let first = stock.grid.first_tile[2];
        let count = stock.grid.first_tile[3] - first;
        let anew = self.blocks.len() != count || stock.passes < self.seen;
        if anew {
            self.blocks = vec![LabelBlock::default(); count];
        } else if stock.passes == self.seen {
            return self.parts;
        }
        let cut = |tile: &u32| stock.cut_in[*tile as usize] > self.seen;
        let stale: Vec<bool> = self.blocks.iter().map(|b| anew || b.read.iter().any(cut)).collect();
        self.seen = stock.passes;
        let across = stock.grid.tiles[2][0];
        let beyond = |k: usize, which: usize| if which == 0 { k + 1 } else { k + across };
        for k in (0..count).filter(|k| stale[*k]) {
            self.blocks[k] = LabelBlock::of(stock, k);
        }
        for k in 0..count {
            if [k, beyond(k, 0), beyond(k, 1)].iter().any(|b| stale.get(*b).is_some_and(|s| *s)) {
                let links = self.blocks[k].links.iter();
                let there = |&(own, which, at): &(u32, usize, u32)| {
                    (own, which, self.blocks[beyond(k, which)].part[at as usize])
                };
                let mut joined: Vec<_> = links.map(there).collect();
                joined.sort_unstable();
                joined.dedup();
                self.blocks[k].joined = joined;
            }
        }
        self.parts = self.join(beyond);
        self.parts
    }

    /// Parts of all blocks joined.
    fn join(&self, beyond: impl Fn(usize, usize) -> usize) -> usize {
        let mut starts = Vec::with_capacity(self.blocks.len());
        let mut all = 0;
        for block in &self.blocks {
            starts.push(all);
            all += block.parts as usize;
        }
        let mut sets = Sets::new(all);
        for (k, block) in self.blocks.iter().enumerate() {
            for &(own, which, there) in &block.joined {
                sets.unite(starts[k] + own as usize, starts[beyond(k, which)] + there as usize);
            }
        }
        (0..all).filter(|&at| sets.root(at) == at).count()
    }
}

impl LabelBlock {
    /// Reads what hangs together in block `k` and with its neighbors.
    fn of(stock: &TriDexel, k: usize) -> Self {
        let index = stock.grid.first_tile[2] + k;
        let (tile, (_, [i0, j0])) = (&stock.tiles[index], stock.grid.tile_place(index));
        let mut sets = Sets::new(tile.ends() / 2);
        let mut read = vec![index as u32];
        let mut far = Vec::new();
        for r in 0..TILE_RAYS {
            let [i, j] = [i0 + r % TILE, j0 + r / TILE];
            if i >= stock.grid.n[0] || j >= stock.grid.n[1] {
                continue;
            }
            let own = tile.first(r);
            for (axis, [i2, j2]) in [(0, [i + 1, j]), (1, [i, j + 1])] {
                if i2 >= stock.grid.n[0] || j2 >= stock.grid.n[1] {
                    continue;
                }
                let (there, ray) = stock.grid.ray_place(2, i2, j2);
                note(&mut read, there);
                let (inside, other) = (there == index, stock.tiles[there].first(ray));
                stock.each_overlap([stock.spans(2, i, j), stock.spans(2, i2, j2)], |a, b, range| {
                    let known = inside && sets.root(own + a) == sets.root(other + b);
                    if known || !stock.bridged([i, j], axis, range, |tile| note(&mut read, tile)) {
                        return;
                    }
                    if inside {
                        sets.unite(own + a, other + b);
                    } else {
                        far.push((own + a, axis, (other + b) as u32));
                    }
                });
            }
        }
        let (number, parts) = sets.numbers();
        let part: Vec<u32> = number.into_iter().map(|n| n as u32).collect();
        let links = far.into_iter().map(|(own, which, at)| (part[own], which, at)).collect();
        Self { part, parts: parts as u32, links, joined: Vec::new(), read }
    }
}

/// Adds a tile that is not there yet; the one asked for last mostly is.
fn note(read: &mut Vec<u32>, tile: usize) {
    let tile = tile as u32;
    if !read.iter().rev().any(|t| *t == tile) {
        read.push(tile);
    }
}
