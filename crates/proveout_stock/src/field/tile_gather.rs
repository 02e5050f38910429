//! The kernels on the lanes that the steps of an item may meet: where these are, or side by side.

use crate::{
    field::batch::{Batch, ReadyItem},
    field::tile_work::Scratch,
    kernels::lane_bits::{ROW, rows_with},
    kernels::lane_search::STEPS,
    kernels::lane_set::Maker,
};

impl Batch<'_> {
    /// The steps on all lanes that they may meet; true when some may be left without proof.
    pub(crate) fn on_near(&self, ready: &ReadyItem, a: usize, scratch: &mut Scratch) -> bool {
        if self.gathers(a, scratch) { self.gathered(ready, a, scratch) } else { self.in_place(ready, a, scratch) }
    }

    /// Whether the lanes that are asked for fill fewer rows when they are gathered.
    fn gathers(&self, a: usize, scratch: &mut Scratch) -> bool {
        let Scratch { near, asked, .. } = scratch;
        // A ball takes less than the gathering.
        if near.iter().any(|n| self.steps[a][n.0].ball.is_some()) {
            return false;
        }
        asked.clear();
        for &(_, l, lanes) in near.iter() {
            if l >= asked.len() {
                asked.resize(l + 1, 0);
            }
            asked[l] |= lanes;
        }
        let rows: u32 = asked.iter().map(|lanes| rows_with(*lanes).count_ones()).sum();
        let count: u32 = asked.iter().map(|lanes| lanes.count_ones()).sum();
        count.div_ceil(ROW as u32) < rows
    }

    /// The steps on the lanes that they may meet, where these are; true when some may be left without proof.
    fn in_place(&self, ready: &ReadyItem, a: usize, scratch: &mut Scratch) -> bool {
        let Scratch { field, near, .. } = scratch;
        let mut open = false;
        for &(_, l, which) in near.iter() {
            let lanes = &mut field.layers_mut()[l].lanes;
            // Two steps may take intervals apart from each other.
            open |= lanes.rows != 0;
            lanes.request_lanes(which);
        }
        for &(k, l, which) in near.iter() {
            let lanes = &mut field.layers_mut()[l].lanes;
            let all = std::mem::replace(&mut lanes.rows, rows_with(which));
            open |= self.on_lanes(&self.steps[a][k], ready, Maker::whole(k), STEPS, lanes);
            lanes.rows = all;
        }
        open
    }

    /// The same, the lanes of all layers side by side.
    fn gathered(&self, ready: &ReadyItem, a: usize, scratch: &mut Scratch) -> bool {
        let Scratch { field, near, asked, gathered, .. } = scratch;
        let mut open = false;
        // Layers and lanes that wait for their turn.
        let (mut layer, mut left) = (0, asked[0]);
        loop {
            let first = (layer, left);
            gathered.clear_requested();
            loop {
                left = gathered.gather(&field.layers()[layer].lanes, left);
                if left != 0 || layer + 1 == asked.len() {
                    break;
                }
                layer += 1;
                left = asked[layer];
            }
            let n = gathered.len();
            let mut last = usize::MAX;
            for &(k, _, _) in near.iter() {
                if k == last {
                    continue;
                }
                // Two steps may take intervals apart from each other.
                open |= last != usize::MAX;
                last = k;
                open |= self.on_lanes(&self.steps[a][k], ready, Maker::whole(k), STEPS, gathered);
            }
            let (mut l, mut lanes) = first;
            for i in 0..n {
                while lanes == 0 {
                    l += 1;
                    lanes = asked[l];
                }
                field.layers_mut()[l].lanes.take_answer(lanes.trailing_zeros() as usize, gathered, i);
                lanes &= lanes - 1;
            }
            if left == 0 {
                return open;
            }
        }
    }
}
