//! Free axes of a ball end: every place of a solid forbids a cap of axes, or a ring (`extent.rs`).
//!
//! ```text
//!     cell of axes          ball of the tree, seen from the center of the cutter's ball under the direction u
//!       .---.                      .-----.       half the angle under which it is seen: e
//!      ( d V )         a          (   u e )      free when   a - d > hi(r - rho .. r + rho) + e
//!       '---' <-------------------->'-----'               or a + d < lo(..) - e
//!                                                blocked when  lo < a' - d  and  a' + d < hi  of in(|anchor|)
//! ```
//!
//! with a (a') the angle between the center of the cell and u (an anchor on the skin) and d the largest angle between the axes of
//! the cell and its center. What a ball of the tree forbids does not hang on the cell, so that it is found once for a contact, and held against a cell by
//! two products of cosines and sines. Triangles are quartered until they are seen under a small part of the finest cell.

use std::collections::BinaryHeap;

use super::extent::Extent;
use super::grid::{Cell, Grid};
use super::map::{AxisState, MapNode, NodeState};
use super::solids::Solid;
use super::space::{Place, split};
use super::spots::{Around, CLOSED, Spots, Verdict, turn};

/// Triangles are quartered down to this share of the angle of a finest cell.
const PIECE_SHARE: f64 = 0.4;
/// Where a place of the skin is met that may forbid an axis of the cell, so many more spots are looked at for one that forbids all of them.
const MORE_LOOKS: u32 = 4;
/// So many spots are held against a cell before it is given up: where the side of a tool lies along a face, ever smaller pieces of it decide nothing.
const MOST_LOOKS: u64 = 20_000;
/// So many of the deepest spots are opened for one that forbids all axes of a finest cell.
const DEEP_LOOKS: u32 = 400;
/// Added to the angle of a cell, radian, for the rounding of what a spot says (some 2e-7 of its cosines and sines): by itself, and divided by that
/// angle, near which a cosine tells less of it.
const ROUNDING: f64 = 1e-6;

/// The search at one contact.
pub(crate) struct Caps<'a> {
    spots: Spots<'a>,
    levels: u32,
    /// Pieces seen under a smaller sine than this are not quartered.
    finest: f64,
    stack: Vec<u32>,
    heap: BinaryHeap<Deep>,
    looked: u64,
}

/// A spot in the order of the depth that it may have.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Deep(f64, u32);

impl Eq for Deep {}

impl PartialOrd for Deep {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Deep {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl<'a> Caps<'a> {
    /// A cutter's ball at a contact; `extents` are those for solids that are cut and for others.
    pub(crate) fn new(extents: &'a [Extent; 2], solids: &'a [Solid], place: &Place, grid: &Grid) -> Self {
        let limit = grid.step * (grid.starts.len() - 1) as f64 + ROUNDING;
        Self {
            spots: Spots::new(extents, solids, place, limit),
            levels: grid.levels,
            finest: PIECE_SHARE * grid.step / f64::from(1_u32 << grid.levels.min(31)),
            stack: Vec::new(),
            heap: BinaryHeap::new(),
            looked: 0,
        }
    }

    /// Balls and pieces that were held against cells.
    pub(crate) fn looked(&self) -> u64 {
        self.looked
    }

    /// Decides the root cells of a map and what is below them.
    pub(crate) fn fill(&mut self, place: &Place, nodes: &mut Vec<MapNode>) {
        let mut hint = None;
        for index in 0..nodes.len() {
            hint = self.refine(place, nodes, index, hint, 0);
        }
    }

    /// `hint` is a spot that forbade axes nearby; gives one back.
    fn refine(
        &mut self,
        place: &Place,
        nodes: &mut Vec<MapNode>,
        index: usize,
        hint: Option<u32>,
        level: u32,
    ) -> Option<u32> {
        let cell: Cell = nodes[index].cell;
        let spread = cell.spread(&place.frame);
        let angle = 2.0 * (0.5 * spread.chord).min(1.0).asin();
        let angle = angle + ROUNDING + ROUNDING / angle;
        let around = Around { axis: spread.axis, turn: turn(angle) };
        let last = level >= self.levels;
        let (mut verdict, mut hint) = self.settle(&around, hint);
        if last && verdict == Verdict::Open {
            (verdict, hint) = self.go_deep(&around, hint);
        }
        nodes[index].state = match verdict {
            Verdict::Apart => NodeState::Leaf(AxisState::Free),
            Verdict::Blocked => NodeState::Leaf(AxisState::Blocked),
            Verdict::Open | Verdict::Met if last => NodeState::Leaf(AxisState::Unknown),
            Verdict::Open | Verdict::Met => {
                let halving = cell.halving(false);
                let (first, count) = split(nodes, &cell, halving);
                for child in first..first + count {
                    hint = self.refine(place, nodes, child, hint, level + 1);
                }
                NodeState::Split { first: first as u32, halving }
            }
        };
        hint
    }

    /// Holds all spots against the axes of a cell, the one of the hint first, and gives the one that forbids most.
    fn settle(&mut self, cell: &Around, hint: Option<u32>) -> (Verdict, Option<u32>) {
        let mut stack = std::mem::take(&mut self.stack);
        stack.clear();
        stack.extend(0..self.spots.roots);
        stack.extend(hint);
        let (mut open, mut left) = (false, MORE_LOOKS);
        let mut deepest = (f64::NEG_INFINITY, hint);
        let mut verdict = Verdict::Apart;
        let end = self.looked + MOST_LOOKS;
        while let Some(index) = stack.pop() {
            self.looked += 1;
            if self.looked > end {
                open = true;
                break;
            }
            if open {
                left -= 1;
                if left == 0 {
                    break;
                }
            }
            let spot = self.spots.get(index);
            let near = spot.near(&cell.axis);
            if spot.is_beyond(cell, near) {
                continue;
            }
            let (found, depth) = self.spots.anchor(index).against(cell, near);
            if found != Verdict::Apart && depth > deepest.0 {
                deepest = (depth, Some(index));
            }
            match found {
                Verdict::Apart => continue,
                Verdict::Blocked => {
                    verdict = Verdict::Blocked;
                    break;
                }
                Verdict::Met => open = true,
                Verdict::Open => {}
            }
            if f64::from(spot.size) <= self.finest {
                open = true;
                continue;
            }
            match self.spots.opened(index) {
                // What lies nearer is looked at first.
                Some((from, to)) => {
                    let at = stack.len();
                    stack.extend(from..to);
                    let near = |i: u32| self.spots.get(i).near(&cell.axis);
                    if to == from + 2 && near(from) > near(from + 1) {
                        stack.swap(at, at + 1);
                    }
                }
                None => open = true,
            }
        }
        self.stack = stack;
        if open && verdict == Verdict::Apart {
            verdict = Verdict::Open;
        }
        (verdict, deepest.1)
    }

    /// Looks for a spot that forbids all axes of a cell, always in the parts of the one that may be deepest.
    fn go_deep(&mut self, cell: &Around, hint: Option<u32>) -> (Verdict, Option<u32>) {
        let mut heap = std::mem::take(&mut self.heap);
        heap.clear();
        heap.extend(hint.into_iter().chain([CLOSED]).map(|i| Deep(f64::MAX, i)));
        let (mut verdict, mut deepest) = (Verdict::Open, (f64::NEG_INFINITY, hint));
        let mut left = DEEP_LOOKS;
        let mut next = None;
        'all: while let Some(index) = next.take().or_else(|| heap.pop().map(|d| d.1)) {
            left -= 1;
            if left == 0 {
                break;
            }
            let (from, to) = match index {
                CLOSED => (0, self.spots.roots),
                _ if f64::from(self.spots.get(index).size) <= self.finest => continue,
                _ => match self.spots.opened(index) {
                    Some(parts) => parts,
                    None => continue,
                },
            };
            // Down to the end on the way of the deepest points; the rest waits.
            let mut best = f64::NEG_INFINITY;
            for part in from..to {
                self.looked += 1;
                let spot = self.spots.get(part);
                let near = spot.near(&cell.axis);
                if spot.is_beyond(cell, near) {
                    continue;
                }
                let (found, depth) = self.spots.anchor(part).against(cell, near);
                if depth > deepest.0 {
                    deepest = (depth, Some(part));
                }
                match found {
                    Verdict::Blocked => {
                        verdict = found;
                        break 'all;
                    }
                    Verdict::Apart => continue,
                    Verdict::Open | Verdict::Met => {}
                }
                let other = if depth > best {
                    best = depth;
                    next.replace(part)
                } else {
                    Some(part)
                };
                if let Some(other) = other {
                    let spot = self.spots.get(other);
                    heap.push(Deep(spot.depth(spot.near(&cell.axis)), other));
                }
            }
        }
        self.heap = heap;
        (verdict, deepest.1)
    }
}
