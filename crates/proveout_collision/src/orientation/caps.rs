//! Free axes of a ball end: every place of a solid forbids a cap of axes, or a ring (`extent.rs`).
//!
//! ```text
//!     cell of axes          ball of the tree, seen from the center of the cutter's ball in direction u
//!       .---.                      .-----.       half the angle under which it is seen: e
//!      ( d V )         a          (   u e )      free when   a - d > hi(r - rho .. r + rho) + e
//!       '---' <-------------------->'-----'               or a + d < lo(..) - e
//!                                                blocked when lo < a' - d and a' + d < hi of in(|anchor|)
//! ```
//!
//! with a (a') the angle between the center of the cell and u (an anchor on the skin) and d the
//! largest angle between the axes of the cell and its center. What a ball of the tree forbids does
//! not depend on the cell. It is computed once for a contact, and compared with sixteen neighboring
//! cells at once (`packet.rs`). Balls that are not apart from some of them are where the search for
//! their quarters begins. Triangles are quartered until they are seen under a small part of the
//! finest cell.

use std::ops::Range;

use super::extent::Extent;
use super::grid::{AxisCell, AxisGrid};
use super::map::{AxisState, MapNode, NodeState};
use super::obstacle_solids::ObstacleSolid;
use super::obstacle_spots::{Spots, turn};
use super::packet::{Cells, LANES, Packet};
use super::space::{PivotedContact, split};

/// Triangles are quartered down to this share of the angle of a finest cell.
const PIECE_SHARE: f64 = 0.5;
/// Number of spots compared with a packet before it is given up: where the side of a tool lies
/// along a face, ever smaller pieces of it decide nothing.
const MOST_LOOKS: u64 = 20_000;
/// So many looks at a packet of finest cells only serve to block those of which a point of the skin forbids
/// an axis.
const DEEP_LOOKS: u32 = 100;
/// Added to the angle of a cell, radian, for the rounding of a spot: by itself, and divided by that
/// angle, near which a cosine is less precise.
const ROUNDING: f64 = 1e-6;

/// The search at one contact.
pub(crate) struct Caps<'a> {
    spots: Spots<'a>,
    levels: u32,
    /// Pieces seen under a smaller sine than this are not quartered.
    finest: f32,
    stack: Vec<u32>,
    /// Spots that are not apart from the cells under way, in consecutive lists; the last spots of a
    /// list are checked first.
    lists: Vec<u32>,
    looked: u64,
}

/// What is known of the cells of a packet; the others are free.
struct CellVerdict {
    blocked: Cells,
    open: Cells,
}

/// A call of [`Caps::settle`] with the instructions of this processor: a closure would be compiled without
/// them.
struct SettleOnLanes<'b, 'a> {
    caps: &'b mut Caps<'a>,
    packet: &'b Packet,
    list: Range<usize>,
    last: bool,
}

impl pulp::WithSimd for SettleOnLanes<'_, '_> {
    type Output = CellVerdict;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> CellVerdict {
        self.caps.settle(simd, self.packet, self.list, self.last)
    }
}

impl<'a> Caps<'a> {
    /// A cutter's ball at a contact; `extents` are those for solids that are cut and for others.
    pub(crate) fn new(
        extents: &'a [Extent; 2],
        solids: &'a [ObstacleSolid],
        place: &PivotedContact,
        grid: &AxisGrid,
    ) -> Self {
        let limit = grid.step * (grid.starts.len() - 1) as f64 + ROUNDING;
        Self {
            spots: Spots::new(extents, solids, place, limit),
            levels: grid.levels,
            finest: (PIECE_SHARE * grid.step / f64::from(1_u32 << grid.levels.min(31))) as f32,
            stack: Vec::new(),
            lists: Vec::new(),
            looked: 0,
        }
    }

    /// Balls and pieces that were compared with packets of cells.
    pub(crate) fn looked(&self) -> u64 {
        self.looked
    }

    /// Decides the root cells of a map and what is below them.
    pub(crate) fn fill(&mut self, place: &PivotedContact, nodes: &mut Vec<MapNode>) {
        self.lists.clear();
        self.lists.extend(0..self.spots.roots);
        let mut roots: Vec<usize> = (0..nodes.len()).collect();
        // Neighbors in sequence: by eighths of a turn, from the pole outward.
        roots.sort_by_key(|&i| {
            let [_, yaw] = nodes[i].cell.middle();
            ((yaw * 4.0 / std::f64::consts::PI).floor() as i64, i)
        });
        for packet in roots.chunks(LANES) {
            self.refine(place, nodes, packet, 0..self.spots.roots as usize, 0);
        }
    }

    /// Decides up to sixteen cells; `list` holds all spots that may forbid an axis of one.
    fn refine(
        &mut self,
        place: &PivotedContact,
        nodes: &mut Vec<MapNode>,
        cells: &[usize],
        list: Range<usize>,
        level: u32,
    ) {
        let packet = Packet::new(cells.iter().map(|&i| {
            let cell: AxisCell = nodes[i].cell;
            let spread = cell.spread(&place.frame);
            let angle = 2.0 * (0.5 * spread.chord).min(1.0).asin();
            (spread.axis, turn(angle + ROUNDING + ROUNDING / angle))
        }));
        let last = level >= self.levels;
        let start = self.lists.len();
        let settled = pulp::Arch::new().dispatch(SettleOnLanes { caps: self, packet: &packet, list, last });
        let own = start..self.lists.len();
        let mut parts = Vec::new();
        for (lane, &index) in cells.iter().enumerate() {
            let is = |cells: Cells| cells >> lane & 1 == 1;
            nodes[index].state = if is(settled.blocked) {
                NodeState::Leaf(AxisState::Blocked)
            } else if !is(settled.open) {
                NodeState::Leaf(AxisState::Free)
            } else if last {
                NodeState::Leaf(AxisState::Unknown)
            } else {
                let cell = nodes[index].cell;
                let halving = cell.halving(false);
                let (first, count) = split(nodes, &cell, halving);
                parts.extend(first..first + count);
                NodeState::Split { first: first as u32, halving }
            };
        }
        for packet in parts.chunks(LANES) {
            self.refine(place, nodes, packet, own.clone(), level + 1);
        }
        self.lists.truncate(start);
    }

    /// Compares the spots of a list with the cells of a packet. Spots that may forbid an axis of a
    /// cell that stays open are appended to the lists.
    #[inline(always)]
    fn settle<S: pulp::Simd>(&mut self, simd: S, packet: &Packet, list: Range<usize>, last: bool) -> CellVerdict {
        let mut stack = std::mem::take(&mut self.stack);
        stack.clear();
        stack.extend_from_slice(&self.lists[list]);
        let mut settled = CellVerdict { blocked: 0, open: 0 };
        let middle = [packet.middle.x as f32, packet.middle.y as f32, packet.middle.z as f32];
        let mut left = DEEP_LOOKS;
        let end = self.looked + MOST_LOOKS;
        while let Some(index) = stack.pop() {
            if self.looked >= end {
                settled.open |= packet.cells & !settled.blocked;
                self.lists.push(index);
                self.lists.append(&mut stack);
                break;
            }
            self.looked += 1;
            let spot = self.spots.get(index);
            let mut active = packet.reached(simd, &spot) & !settled.blocked;
            if active == 0 {
                continue;
            }
            let said = packet.anchor_answer(simd, &spot, self.spots.anchor(index));
            active &= !said.apart;
            settled.blocked |= active & said.blocked;
            active &= !settled.blocked;
            settled.open |= active & said.met;
            let mut wanted = active & !settled.open;
            if last && wanted == 0 && left > 0 {
                left -= 1;
                wanted = active;
            }
            if active == 0 {
                continue;
            }
            let parts = if wanted != 0 && spot.size > self.finest { self.spots.open_parts(index) } else { None };
            let Some((from, to)) = parts else {
                // What is small enough or cannot be opened decides no more.
                settled.open |= active;
                self.lists.push(index);
                continue;
            };
            let at = stack.len();
            stack.extend(from..to);
            if to == from + 2 {
                let (a, b) = (self.spots.get(from).way, self.spots.get(from + 1).way);
                // What lies nearer is looked at first.
                if along(&a, &middle) > along(&b, &middle) {
                    stack.swap(at, at + 1);
                }
            }
        }
        settled.open &= !settled.blocked;
        self.stack = stack;
        settled
    }
}

/// As a sum from the first number on.
#[inline(always)]
fn along(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
