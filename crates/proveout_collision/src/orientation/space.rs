//! A tool among solids: what all contacts have in common, and the search at one of them.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use proveout_geom::{Point, ToolPose, TriMesh, Vector, sin_cos};
use proveout_tool::{Role, Tool};

use super::NOT_ZERO;
use super::caps::Caps;
use super::contact::{LocalFrame, OrientationError, SurfaceContact};
use super::curvature::{judge, least_difference};
use super::cutter_end::CutterEnd;
use super::extent::Extent;
use super::grid::{AxisCell, AxisGrid};
use super::map::{AxisState, MapNode, NodeState, OrientationMap, Refusal};
use super::obstacle_solids::ObstacleSolid;
use super::search::{CellPose, CellSearch, Verdict};
use super::tool_part::ToolPart;
use super::walk::OrientationWalk;

/// Cells are at least this high, radian: 0.02 degrees, a fifth of what a rotary axis of a machine holds under
/// load.
const LEAST_CELL: f64 = 3.5e-4;
/// Cells are at most this high before they are halved, radian: yaws of the bounds must not differ by more
/// than a right angle.
const LARGEST_CELL: f64 = std::f64::consts::FRAC_PI_4;
/// Part by which a limit of the settings, which are given in degrees, may round above the largest, and below
/// the least.
const ABOVE: f64 = 1e-12;
const BELOW: f64 = 1e-6;

/// A solid near a contact, in the frame of the contacts.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle<'a> {
    /// Name, for errors.
    pub name: &'a str,
    /// Closed mesh, mm.
    pub mesh: &'a TriMesh,
    /// The cutter touches it: the part. It may go into it as deep as the gouge allowance; from all others it
    /// keeps the clearance.
    pub cut: bool,
}

/// How a region is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationSettings {
    /// Height of the first cells, radian.
    pub largest_cell: f64,
    /// Cells are halved until they are at most this high, radian.
    pub finest_cell: f64,
    /// Tilts up to this one are looked at, radian, at most a right angle.
    pub tilt_limit: f64,
    /// Distance that neck, shank and holder keep from everything, and the cutter from what it does not cut,
    /// mm.
    pub clearance: f64,
    /// Depth that the cutter may have in the part, mm: above what the facets of its mesh are off.
    pub gouge: f64,
}

impl Default for OrientationSettings {
    /// From 16 down to 0.5 degrees, up to a tilt of 75; 0.2 mm of clearance, 0.02 mm of gouge allowance.
    /// Nearer to 90 degrees the side of a cutter lies along the surface, and the finest cells decide little.
    fn default() -> Self {
        Self {
            largest_cell: 16_f64.to_radians(),
            finest_cell: 0.5_f64.to_radians(),
            tilt_limit: 75_f64.to_radians(),
            clearance: 0.2,
            gouge: 0.02,
        }
    }
}

impl OrientationSettings {
    fn check(&self) -> Result<(), OrientationError> {
        let wrong = |key, value, limit| Err(OrientationError::Setting { key, value, limit });
        let deg = f64::to_degrees;
        if !(self.largest_cell > 0.0 && self.largest_cell <= LARGEST_CELL * (1.0 + ABOVE)) {
            return wrong("largest_cell_deg", deg(self.largest_cell), "above 0 and at most 45");
        }
        if !(self.finest_cell >= LEAST_CELL * (1.0 - BELOW) && self.finest_cell <= self.largest_cell) {
            return wrong("finest_cell_deg", deg(self.finest_cell), "at least 0.02 and at most the largest cell");
        }
        if !(self.tilt_limit > 0.0 && self.tilt_limit <= FRAC_PI_2 * (1.0 + ABOVE)) {
            return wrong("tilt_limit_deg", deg(self.tilt_limit), "above 0 and at most 90");
        }
        if !(self.clearance >= 0.0 && self.clearance.is_finite()) {
            return wrong("clearance_mm", self.clearance, "a length of zero or more");
        }
        if !(self.gouge > 0.0 && self.gouge.is_finite()) {
            return wrong("gouge_mm", self.gouge, "a length above zero");
        }
        Ok(())
    }
}

/// A tool among fixed solids.
///
/// ```
/// use proveout_collision::{OrientationSettings, OrientationSpace, Refusal, SurfaceContact};
/// use proveout_geom::{Point, Vector};
/// use proveout_tool::{Cutter, ToolBuilder};
///
/// let tool = ToolBuilder::new(1, "BALL_D6", Cutter::ball(6.0)?, 12.0, 120.0).build()?; // mm
/// let space = OrientationSpace::new(&tool, &[], &OrientationSettings::default())?;
/// let (point, normal, feed) = (Point::origin(), Vector::z(), Vector::x());
/// let in_groove = |radius: f64| {
///     let curvatures = Some([(0.0, Vector::x()), (-1.0 / radius, Vector::y())]); // hollow, 1/mm
///     SurfaceContact { point, normal, feed, curvatures }
/// };
/// assert_eq!(space.map(&in_groove(2.9))?.refusal(), Some(Refusal::Curvature));
/// assert_eq!(space.map(&in_groove(3.1))?.refusal(), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct OrientationSpace {
    pub(crate) limbs: Vec<ToolPart>,
    pub(crate) solids: Vec<ObstacleSolid>,
    pub(crate) end: CutterEnd,
    pub(crate) grid: AxisGrid,
    /// Of a ball end: from solids that are cut and from all others.
    pub(crate) extents: Option<[Extent; 2]>,
    settings: OrientationSettings,
}

/// A contact with the center of the corner circle over it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PivotedContact {
    pub(crate) frame: LocalFrame,
    /// Q.
    pub(crate) pivot: Point,
    /// A point of the tool in every pose.
    pub(crate) witness: Point,
}

impl OrientationSpace {
    /// A tool among solids, all in one frame.
    ///
    /// # Errors
    /// A setting out of range, a cutter that is neither ball nor bull-nose, a mesh that bounds no solid.
    pub fn new(tool: &Tool, solids: &[Obstacle<'_>], settings: &OrientationSettings) -> Result<Self, OrientationError> {
        settings.check()?;
        let end = CutterEnd::of(tool)?;
        let (clear, cutter) = ([settings.clearance; 2], [-settings.gouge, settings.clearance]);
        let mut limbs = Vec::new();
        if end.circle > 0.0 {
            limbs.push(ToolPart::disk(end.circle, end.round, cutter));
        }
        limbs.push(ToolPart::body(&end.rest, end.height, cutter));
        limbs.extend(tool.cutting().skip(1).map(|b| ToolPart::body(&b.profile, end.height, cutter)));
        let rest = tool.bodies.iter().filter(|b| b.role != Role::Cutting);
        limbs.extend(rest.map(|b| ToolPart::body(&b.profile, end.height, clear)));
        let grid =
            AxisGrid::new(settings.tilt_limit.min(end.largest_tilt), settings.largest_cell, settings.finest_cell);
        let solids = solids.iter().map(|s| ObstacleSolid::new(s.name, s.mesh, s.cut)).collect::<Result<_, _>>()?;
        let extents = (end.circle <= 0.0).then(|| [0, 1].map(|kind| Extent::new(&limbs, kind, end.round)));
        Ok(Self { limbs, solids, end, grid, extents, settings: *settings })
    }

    /// How regions are looked for.
    pub fn settings(&self) -> &OrientationSettings {
        &self.settings
    }

    /// Largest tilt of the map, radian: that of the settings, or where the rounding of the cutter's end goes
    /// over into its side.
    pub fn tilt_limit(&self) -> f64 {
        self.grid.step * (self.grid.starts.len() - 1) as f64
    }

    /// The region at one contact.
    ///
    /// # Errors
    /// A contact without point, normal, feed direction or finite curvatures.
    pub fn map(&self, contact: &SurfaceContact) -> Result<OrientationMap, OrientationError> {
        Ok(self.map_at(&self.place(contact)?, None))
    }

    /// The region at a place; `outside` as in [`Self::refusal`].
    pub(crate) fn map_at(&self, place: &PivotedContact, outside: Option<(Point, f64)>) -> OrientationMap {
        let mut map = OrientationMap::new(place.frame, &self.grid, self.end.circle > 0.0);
        map.refusal = self.refusal(place, outside);
        if map.refusal.is_some() {
            map.block_all();
            return map;
        }
        if let Some(extents) = &self.extents {
            let mut caps = Caps::new(extents, &self.solids, place, &self.grid);
            caps.fill(place, &mut map.nodes);
            map.looked = caps.looked();
            return map;
        }
        let mut search = CellSearch::new(&self.limbs, &self.solids);
        let roots = 0..search.lists.len();
        for index in 0..map.nodes.len() {
            self.refine(&mut search, place, &mut map.nodes, index, roots.clone(), 0);
        }
        map.looked = search.looked;
        map
    }

    /// The point nearest to `center` on what is cut; none where it is no nearer than `limit`, mm.
    pub fn nearest_on_part(&self, center: &Point, limit: f64) -> Option<Point> {
        let mut best: Option<(f64, Point)> = None;
        for solid in self.solids.iter().filter(|s| s.cut) {
            let limit = best.map_or(limit, |(far, _)| far);
            best = solid.nearest(center, limit).map(|p| ((p - center).norm(), p)).or(best);
        }
        best.map(|(_, p)| p)
    }

    /// Radius of the ball end; none of another cutter.
    pub fn ball_radius(&self) -> Option<f64> {
        (self.end.circle <= 0.0).then_some(self.end.round)
    }

    /// Regions of contacts that follow each other.
    pub fn walk(&self) -> OrientationWalk<'_> {
        OrientationWalk::new(self)
    }

    /// Pose of the tool at a contact with a tilt and a yaw, radian; at tilt 0 the yaw decides which
    /// place of the corner of a bull-nose touches.
    ///
    /// # Errors
    /// A contact without point, normal or feed direction.
    pub fn pose(&self, contact: &SurfaceContact, tilt: f64, yaw: f64) -> Result<ToolPose, OrientationError> {
        let place = self.place(contact)?;
        let ((s, c), (sy, cy)) = (sin_cos(tilt), sin_cos(yaw));
        let axis = place.frame.direction([s, c], [sy, cy]);
        let center = place.pivot - place.frame.direction([c, -s], [sy, cy]) * self.end.circle;
        Ok(ToolPose { tip: center - axis * self.end.height, axis })
    }

    pub(crate) fn place(&self, contact: &SurfaceContact) -> Result<PivotedContact, OrientationError> {
        let frame = LocalFrame::new(contact)?;
        let pivot = frame.point + frame.normal * self.end.round;
        let inside = self.end.round.max(0.05 * self.end.circle);
        Ok(PivotedContact { frame, pivot, witness: frame.point + frame.normal * inside })
    }

    /// Why no axis at all is free. `outside` is the distance within which the witness is known to be outside
    /// of every solid.
    pub(crate) fn refusal(&self, place: &PivotedContact, outside: Option<(Point, f64)>) -> Option<Refusal> {
        let known = outside.is_some_and(|(p, far)| (place.witness - p).norm() < far);
        if !known && self.solids.iter().any(|s| s.contains(&place.witness)) {
            return Some(Refusal::Inside);
        }
        if self.end.circle > 0.0 {
            return None;
        }
        let round = self.end.round;
        let form = place.frame.curvature;
        if judge(0.0, round, form, 0.0, 0.0, 0.0, 0.0) != Verdict::Free {
            return Some(Refusal::Curvature);
        }
        let settings = &self.settings;
        let wanted = |s: &ObstacleSolid| if s.cut { round - settings.gouge } else { round + settings.clearance };
        let deep = self.solids.iter().any(|s| s.skin_distance(&place.pivot, wanted(s)) < wanted(s));
        deep.then_some(Refusal::Cutter)
    }

    /// The least difference of the normal curvatures of cutter and surface at a tilt and a yaw, 1/mm: below
    /// zero the cutter is flatter than the surface is hollow. None where the curvatures of the surface are
    /// not known.
    ///
    /// # Errors
    /// A contact without point, normal or feed direction, curvatures that are not finite.
    pub fn curvature_margin(
        &self,
        contact: &SurfaceContact,
        tilt: f64,
        yaw: f64,
    ) -> Result<Option<f64>, OrientationError> {
        let frame = LocalFrame::new(contact)?;
        Ok(frame.curvature.map(|form| least_difference(self.end.circle, self.end.round, form, sin_cos(tilt).0, yaw)))
    }

    pub(crate) fn cell_pose(&self, place: &PivotedContact, cell: &AxisCell, drift: [f64; 2]) -> CellPose {
        let spread = cell.spread(&place.frame);
        let circle = self.end.circle;
        CellPose {
            center: place.pivot - spread.lean * circle,
            pivot: place.pivot,
            normal: place.frame.normal,
            axis: spread.axis,
            chord: spread.chord,
            shift: circle * spread.lean_chord,
            turn: spread.turn,
            offset: circle,
            drift,
        }
    }

    /// Decides a cell of a map, with what is below it; `list` holds the candidates of the search that are not
    /// apart from it.
    pub(crate) fn refine(
        &self,
        search: &mut CellSearch<'_>,
        place: &PivotedContact,
        nodes: &mut Vec<MapNode>,
        index: usize,
        list: Range<usize>,
        level: u32,
    ) {
        let cell = nodes[index].cell;
        let last = level >= self.grid.levels;
        let start = search.lists.len();
        let round = if self.end.circle > 0.0 {
            let [_, yaw] = cell.middle();
            let half = 0.5 * (cell.yaw[1] - cell.yaw[0]);
            let form = place.frame.curvature;
            judge(self.end.circle, self.end.round, form, cell.tilt[0], cell.tilt[1], yaw, half)
        } else {
            Verdict::Free
        };
        let verdict = match round {
            Verdict::Blocked => Verdict::Blocked,
            _ if list.is_empty() => round,
            _ => match search.settle(&self.cell_pose(place, &cell, [0.0; 2]), list, last) {
                Verdict::Free => round,
                other => other,
            },
        };
        nodes[index].state = match verdict {
            Verdict::Free => NodeState::Leaf(AxisState::Free),
            Verdict::Blocked => NodeState::Leaf(AxisState::Blocked),
            Verdict::Open if last => NodeState::Leaf(AxisState::Unknown),
            Verdict::Open => {
                let halving = cell.halving(self.end.circle > 0.0);
                let (first, count) = split(nodes, &cell, halving);
                let list = start..search.lists.len();
                for child in first..first + count {
                    self.refine(search, place, nodes, child, list.clone(), level + 1);
                }
                NodeState::Split { first: first as u32, halving }
            }
        };
        search.lists.truncate(start);
    }
}

/// Appends the parts of a cell to the nodes: returns the first one and how many.
pub(crate) fn split(nodes: &mut Vec<MapNode>, cell: &AxisCell, halving: super::grid::Halving) -> (usize, usize) {
    let (parts, count) = cell.parts(halving);
    let first = nodes.len();
    nodes.extend(parts[..count].iter().map(|&cell| MapNode { cell, state: NodeState::Leaf(AxisState::Unknown) }));
    (first, count)
}

/// A unit vector, where there is one.
pub(crate) fn unit(v: &Vector) -> Option<Vector> {
    let finite = v.iter().all(|x| x.is_finite());
    v.try_normalize(NOT_ZERO).filter(|_| finite)
}
