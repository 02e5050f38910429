//! Regions of contacts that follow each other: what holds for a neighborhood of contacts is proved once.

use proveout_geom::Point;

use super::contact::{OrientationError, SurfaceContact};
use super::grid::AxisCell;
use super::map::{AxisState, MapNode, NodeState, OrientationMap, Refusal};
use super::obstacle_solids::ObstacleSolid;
use super::search::{Candidate, CellSearch, Verdict};
use super::space::{OrientationSpace, PivotedContact, split};

/// A neighborhood reaches as far as so many steps like the last one. Farther, and fewer cells are decided for
/// all of it; nearer, and its cost is shared by fewer contacts.
const STEPS: f64 = 4.0;
/// Its cells are halved until the motion inside of them is at most so many times the drift that it allows
/// for.
const STOP_SHARE: f64 = 3.0;

/// Regions of contacts one after the other, each from what was proved for its neighborhood.
#[derive(Clone, Debug)]
pub struct OrientationWalk<'a> {
    space: &'a OrientationSpace,
    last: Option<PivotedContact>,
    base: Option<Base>,
    /// Of a ball end: a place outside of all solids, and how far no skin is nearer to it, mm.
    outside: Option<(Point, f64)>,
    cold: usize,
    warm: usize,
}

/// Cells that are decided for all contacts near one, and lists of what is near to the others.
#[derive(Clone, Debug)]
struct Base {
    place: PivotedContact,
    /// Shift of Q, mm, and |R' - R|, for which it holds.
    drift: [f64; 2],
    /// The witness is outside of all solids, and no skin is nearer to it than this, mm.
    outside: (Point, f64),
    nodes: Vec<MapNode>,
    /// For a leaf that is not decided: its candidates, its level.
    open: Vec<Option<(Box<[Candidate]>, u32)>>,
    roots: usize,
}

impl<'a> OrientationWalk<'a> {
    pub(crate) fn new(space: &'a OrientationSpace) -> Self {
        Self { space, last: None, base: None, outside: None, cold: 0, warm: 0 }
    }

    /// Contacts that were looked at from nothing, and with something that was proved for one before.
    pub fn counts(&self) -> [usize; 2] {
        [self.cold, self.warm]
    }

    /// The region at the next contact. It is the same as that of [`OrientationSpace::map`] but for how large
    /// the cells are that are decided as a whole.
    ///
    /// # Errors
    /// As [`OrientationSpace::map`].
    pub fn next(&mut self, contact: &SurfaceContact) -> Result<OrientationMap, OrientationError> {
        if self.space.extents.is_some() {
            return self.ball(contact);
        }
        let place = self.space.place(contact)?;
        let step = self.last.replace(place).map(|last| drift(&last, &place));
        if !self.base.as_ref().is_some_and(|base| holds(base, &place)) {
            self.base = step.and_then(|step| self.survey(&place, step.map(|s| STEPS * s)));
        }
        let Some(base) = &self.base else {
            self.cold += 1;
            return self.space.map(contact);
        };
        self.warm += 1;
        let mut map = OrientationMap::new(place.frame, &self.space.grid, self.space.end.circle > 0.0);
        map.refusal = self.space.refusal(&place, Some(base.outside));
        if map.refusal.is_some() {
            map.block_all();
            return Ok(map);
        }
        let mut search = CellSearch::new(&self.space.limbs, &self.space.solids);
        for root in 0..base.roots {
            search.lists.clear();
            self.copy_decided(base, &mut search, &place, &mut map.nodes, (root, root), 0);
        }
        map.looked = search.looked;
        Ok(map)
    }

    /// The region of a ball end, found for each contact alone. That its center lies outside of the solids is
    /// known from one before as long as no skin lies between them.
    fn ball(&mut self, contact: &SurfaceContact) -> Result<OrientationMap, OrientationError> {
        let place = self.space.place(contact)?;
        let known = self.outside.is_some_and(|(p, far)| (place.witness - p).norm() < far);
        let map = self.space.map_at(&place, self.outside);
        if !known {
            let reach = 2.0 * self.space.end.round;
            let clear = |s: &ObstacleSolid| s.skin_distance(&place.witness, reach);
            self.outside = (map.refusal != Some(Refusal::Inside))
                .then(|| (place.witness, self.space.solids.iter().map(clear).fold(reach, f64::min)));
        }
        self.cold += usize::from(!known);
        self.warm += usize::from(known);
        Ok(map)
    }

    /// Copies the node `from` of the base to the node `to` of a map and decides what is open.
    fn copy_decided(
        &self,
        base: &Base,
        search: &mut CellSearch<'_>,
        place: &PivotedContact,
        nodes: &mut Vec<MapNode>,
        (from, to): (usize, usize),
        level: u32,
    ) {
        match base.nodes[from].state {
            NodeState::Split { first, halving } => {
                let cell = nodes[to].cell;
                let (start, count) = split(nodes, &cell, halving);
                nodes[to].state = NodeState::Split { first: start as u32, halving };
                for k in 0..count {
                    self.copy_decided(base, search, place, nodes, (first as usize + k, start + k), level + 1);
                }
            }
            NodeState::Leaf(AxisState::Blocked) => nodes[to].state = NodeState::Leaf(AxisState::Blocked),
            NodeState::Leaf(_) => {
                // Free of solids; curvatures belong to each contact.
                let start = search.lists.len();
                if let Some((list, _)) = &base.open[from] {
                    search.lists.extend_from_slice(list);
                }
                let list = start..search.lists.len();
                self.space.refine(search, place, nodes, to, list, level);
                search.lists.truncate(start);
            }
        }
    }

    /// What can be decided for all contacts that are not farther than a drift.
    fn survey(&self, place: &PivotedContact, drift: [f64; 2]) -> Option<Base> {
        let space = self.space;
        if !drift.iter().all(|d| d.is_finite()) || drift == [0.0; 2] {
            return None;
        }
        if space.solids.iter().any(|s| s.contains(&place.witness)) {
            return None;
        }
        let reach = space.limbs.iter().map(|l| l.reach).fold(0.0, f64::max) + space.end.circle;
        let clear = space.solids.iter().fold(reach, |least, s| least.min(s.skin_distance(&place.witness, least)));
        let nodes: Vec<MapNode> = OrientationMap::new(place.frame, &space.grid, space.end.circle > 0.0).nodes;
        let roots = nodes.len();
        let open = vec![None; roots];
        let mut base = Base { place: *place, drift, outside: (place.witness, clear), nodes, open, roots };
        let mut search = CellSearch::new(&space.limbs, &space.solids);
        let all = 0..search.lists.len();
        let stop = STOP_SHARE * (drift[0] / reach + drift[1]);
        for root in 0..roots {
            self.prove(&mut base, &mut search, root, all.clone(), (0, stop));
        }
        Some(base)
    }

    fn prove(
        &self,
        base: &mut Base,
        search: &mut CellSearch<'_>,
        index: usize,
        list: std::ops::Range<usize>,
        (level, stop): (u32, f64),
    ) {
        let cell: AxisCell = base.nodes[index].cell;
        let start = search.lists.len();
        let pose = self.space.cell_pose(&base.place, &cell, base.drift);
        match search.settle(&pose, list, false) {
            Verdict::Free => base.nodes[index].state = NodeState::Leaf(AxisState::Free),
            Verdict::Blocked => base.nodes[index].state = NodeState::Leaf(AxisState::Blocked),
            Verdict::Open if level >= self.space.grid.levels || pose.chord <= stop => {
                base.open[index] = Some((search.lists[start..].into(), level));
            }
            Verdict::Open => {
                let halving = cell.halving(self.space.end.circle > 0.0);
                let (first, count) = split(&mut base.nodes, &cell, halving);
                base.open.resize(base.nodes.len(), None);
                base.nodes[index].state = NodeState::Split { first: first as u32, halving };
                let list = start..search.lists.len();
                for child in first..first + count {
                    self.prove(base, search, child, list.clone(), (level + 1, stop));
                }
            }
        }
        search.lists.truncate(start);
    }
}

/// Shift of Q and |R' - R| between two contacts.
fn drift(a: &PivotedContact, b: &PivotedContact) -> [f64; 2] {
    [(b.pivot - a.pivot).norm(), a.frame.turn_to(&b.frame)]
}

fn holds(base: &Base, place: &PivotedContact) -> bool {
    let d = drift(&base.place, place);
    d[0] <= base.drift[0] && d[1] <= base.drift[1]
}
