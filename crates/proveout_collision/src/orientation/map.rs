//! The region at one contact: which axes are free, the nearest one that is, ways between two.

use proveout_geom::Vector;

use super::contact::LocalFrame;
use super::grid::{AxisCell, AxisGrid, Halving};
use super::space::unit;

/// Added to distances on the sphere, so that rounding leaves no cell out, radian.
const ROUNDING: f64 = 1e-9;
/// The nearest free axis lies this far inside of its cell, radian: on the border itself no way could begin.
const INSIDE: f64 = 2e-5;
/// Pieces of a way below this are not halved any more, radian.
const SHORTEST_WAY: f64 = 1e-5;
/// A way of a bull-nose this near to the normal passes from one side of its corner to the other, radian.
const AT_POLE: f64 = 1e-6;
/// Axes whose sum is shorter are opposite.
const OPPOSITE: f64 = 1e-6;

/// What is known of the axes of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AxisState {
    /// All of them keep what is asked for.
    Free,
    /// None of them does.
    Blocked,
    /// Not decided at the finest cell; does not count as free.
    Unknown,
}

impl AxisState {
    /// Word in files and pictures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Blocked => "blocked",
            Self::Unknown => "unknown",
        }
    }
}

/// Why no axis at all is free at a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// The tool around the contact is inside of a solid: a contact deeper than the surface, or a
    /// normal that points inward.
    Inside,
    /// The surface is more hollow than the ball is round.
    Curvature,
    /// The ball is deeper in a solid than the gouge allowance, or nearer to one that it does not cut than the
    /// clearance.
    Cutter,
}

impl Refusal {
    /// Words for a report.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Inside => "the cutter's end lies inside of a solid",
            Self::Curvature => "the surface is more hollow than the ball is round",
            Self::Cutter => "the ball gouges next to the contact",
        }
    }
}

/// A cell of a map: tilt from the normal and yaw from the feed, radian, from the low to the high end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationCell {
    /// From and to.
    pub tilt: [f64; 2],
    /// From and to, counted from the feed about the normal.
    pub yaw: [f64; 2],
    /// What is known of it.
    pub state: AxisState,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MapNode {
    pub(crate) cell: AxisCell,
    pub(crate) state: NodeState,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NodeState {
    Leaf(AxisState),
    Split { first: u32, halving: Halving },
}

/// The feasible region of the tool axis at a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientationMap {
    pub(crate) frame: LocalFrame,
    pub(crate) grid: AxisGrid,
    /// The root cells, then all others.
    pub(crate) nodes: Vec<MapNode>,
    pub(crate) circle_at_pole: bool,
    pub(crate) refusal: Option<Refusal>,
    pub(crate) looked: u64,
}

impl OrientationMap {
    pub(crate) fn new(frame: LocalFrame, grid: &AxisGrid, circle_at_pole: bool) -> Self {
        let node = |cell| MapNode { cell, state: NodeState::Leaf(AxisState::Unknown) };
        let nodes = grid.roots().map(node).collect();
        Self { frame, grid: grid.clone(), nodes, circle_at_pole, refusal: None, looked: 0 }
    }

    pub(crate) fn block_all(&mut self) {
        for node in &mut self.nodes {
            node.state = NodeState::Leaf(AxisState::Blocked);
        }
    }

    /// The local frame: feed direction T, K = N x T, normal N.
    pub fn frame(&self) -> [Vector; 3] {
        [self.frame.along, self.frame.across, self.frame.normal]
    }

    /// Why no axis at all is free, where that was known before any cell was checked.
    pub fn refusal(&self) -> Option<Refusal> {
        self.refusal
    }

    /// Balls and triangles of the solids that were looked at.
    pub fn looked(&self) -> u64 {
        self.looked
    }

    /// Tilt from the normal and yaw from the feed of an axis, radian.
    pub fn angles(&self, axis: &Vector) -> [f64; 2] {
        self.frame.angles(axis)
    }

    /// The axis of a tilt and a yaw, radian.
    pub fn axis(&self, tilt: f64, yaw: f64) -> Vector {
        let ((s, c), (sy, cy)) = (proveout_geom::sin_cos(tilt), proveout_geom::sin_cos(yaw));
        self.frame.direction([s, c], [sy, cy])
    }

    /// The cells that were not divided, in no order that means anything.
    pub fn cells(&self) -> impl Iterator<Item = OrientationCell> + '_ {
        self.nodes.iter().filter_map(|n| match n.state {
            NodeState::Leaf(state) => Some(OrientationCell { tilt: n.cell.tilt, yaw: n.cell.yaw, state }),
            NodeState::Split { .. } => None,
        })
    }

    /// Number of free cells, large and small.
    pub fn free_cells(&self) -> usize {
        self.cells().filter(|c| c.state == AxisState::Free).count()
    }

    /// Shares of the map by solid angle: free, blocked, unknown.
    pub fn shares(&self) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for node in &self.nodes {
            if let NodeState::Leaf(state) = node.state {
                sums[state as usize] += node.cell.solid_angle();
            }
        }
        let all: f64 = sums.iter().sum();
        sums.map(|s| s / all)
    }

    /// What is known of an axis; none beyond the largest tilt of the map, and for a vector without a
    /// direction.
    pub fn state(&self, axis: &Vector) -> Option<AxisState> {
        let at = self.frame.angles(&unit(axis)?);
        let mut index = self.grid.root_of(at)?;
        loop {
            let node = self.nodes.get(index)?;
            match node.state {
                NodeState::Leaf(state) => return Some(state),
                NodeState::Split { first, halving } => index = first as usize + node.cell.part_of(halving, at),
            }
        }
    }

    /// True where the axis is proved free.
    pub fn is_free(&self, axis: &Vector) -> bool {
        self.state(axis) == Some(AxisState::Free)
    }

    /// All axes nearer to this one than the angle given back, radian, are proved free; zero where it is not
    /// free itself. Axes beyond the largest tilt of the map do not count as free.
    pub fn room(&self, axis: &Vector) -> f64 {
        let Some(axis) = unit(axis).filter(|a| self.is_free(a)) else { return 0.0 };
        let at = self.frame.angles(&axis);
        let rim = self.grid.step * (self.grid.starts.len() - 1) as f64 - at[0];
        let others =
            self.nodes.iter().filter(|n| matches!(n.state, NodeState::Leaf(AxisState::Blocked | AxisState::Unknown)));
        let angle = |n: &MapNode| {
            let [tilt, yaw] = n.cell.nearest(at);
            2.0 * (0.5 * (self.axis(tilt, yaw) - axis).norm()).min(1.0).asin()
        };
        (others.map(angle).fold(rim, f64::min) - ROUNDING).max(0.0)
    }

    /// The free axis that is nearest to a direction, within 0.003 degrees; none where nothing is free.
    pub fn nearest_free(&self, axis: &Vector) -> Option<Vector> {
        let axis = unit(axis)?;
        if self.is_free(&axis) {
            return Some(axis);
        }
        let at = self.frame.angles(&axis);
        let mut best: Option<(f64, Vector)> = None;
        for node in &self.nodes {
            if node.state != NodeState::Leaf(AxisState::Free) {
                continue;
            }
            let [tilt, yaw] = node.cell.nearest(at);
            let [t, y] = node.cell.middle();
            let inward = |value: f64, middle: f64| value + (middle - value).clamp(-INSIDE, INSIDE);
            let found = self.axis(inward(tilt, t), inward(yaw, y));
            let far = (found - axis).norm();
            if best.is_none_or(|(least, _)| far < least) {
                best = Some((far, found));
            }
        }
        best.map(|(_, found)| found)
    }

    /// True where every axis on the great circle from one axis to another is proved free; then the tool may
    /// turn on it about the contact. Opposite axes have no such way, and a bull-nose cannot pass the normal:
    /// its contact would jump across.
    pub fn way_is_free(&self, from: &Vector, to: &Vector) -> bool {
        let (Some(a), Some(b)) = (unit(from), unit(to)) else { return false };
        if !self.is_free(&a) || !self.is_free(&b) || (a + b).norm() < OPPOSITE {
            return false;
        }
        if self.circle_at_pole {
            let off = |v: &Vector| v.dot(&self.frame.normal).clamp(-1.0, 1.0).acos();
            let plane = a.cross(&b);
            let between =
                plane.dot(&a.cross(&self.frame.normal)) >= 0.0 && plane.dot(&self.frame.normal.cross(&b)) >= 0.0;
            let distance = unit(&plane).map_or(f64::MAX, |n| n.dot(&self.frame.normal).abs());
            if off(&a).min(off(&b)) < AT_POLE || between && distance < AT_POLE {
                return false;
            }
        }
        self.piece_is_free(a, b)
    }

    fn piece_is_free(&self, a: Vector, b: Vector) -> bool {
        let Some(middle) = unit(&(a + b)) else { return false };
        // Largest distance of the piece's axes from its middle, as a chord.
        let half = 0.5 * (b - a).norm();
        let half = 2.0 * (0.5 * half.min(1.0).asin()).sin();
        if self.cap_is_free(&middle, half + ROUNDING) {
            return true;
        }
        half > SHORTEST_WAY && self.piece_is_free(a, middle) && self.piece_is_free(middle, b)
    }

    /// All cells that an axis nearer than a chord may lie in are free.
    fn cap_is_free(&self, axis: &Vector, chord: f64) -> bool {
        let at = self.frame.angles(axis);
        let roots = self.grid.starts.last().copied().unwrap_or(0);
        let mut stack: Vec<usize> = (0..roots).collect();
        while let Some(node) = stack.pop().and_then(|i| self.nodes.get(i)) {
            if node.state == NodeState::Leaf(AxisState::Free) {
                continue;
            }
            let [tilt, yaw] = node.cell.nearest(at);
            if (self.axis(tilt, yaw) - axis).norm() > chord {
                continue;
            }
            match node.state {
                NodeState::Leaf(_) => return false,
                NodeState::Split { first, halving } => {
                    let count = if halving == Halving::Tilt { 2 } else { 4 };
                    stack.extend(first as usize..first as usize + count);
                }
            }
        }
        true
    }
}
