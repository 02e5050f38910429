//! What re-scheduling may ask about the part of a scene: where the tool touches the design, and what the rest
//! of the tool must keep away from.

use std::sync::{Arc, OnceLock};

use proveout_collision::{
    CollisionError, Obstacle, OrientationError, OrientationSettings, OrientationSpace, StandingSolids, ToolClearance,
};
use proveout_geom::{Pose, ToolPose, TriMesh};
use proveout_input::InputError;
use proveout_reschedule::{AxisTurn, BladeSurface, ContactSurface, FeasibleRegion};
use proveout_tool::Tool;

use crate::{prepare::part_shape::Shape, scene::Scene};

/// Clearances above this are not distinguished, mm: a method asks whether a pose is free and by how
/// much, not how far away everything else is.
const REACH_MM: f64 = 50.0;

/// Design part and fixtures in the frame of the table, which is that of programs under tool center point
/// control. A copy shares the solids.
#[derive(Clone, Debug, Default)]
pub struct PartOnTable {
    surface: Option<BladeSurface>,
    solids: Arc<[(String, TriMesh)]>,
    /// The solids prepared for tools, once a method asks for them: that takes longer than many a method.
    standing: Arc<OnceLock<StandingSolids>>,
    /// Number of the solids that the tool cuts: the first ones.
    cut: usize,
}

impl PartOnTable {
    /// The part of a scene (mesh in the workpiece frame) and its fixtures (table frame).
    ///
    /// # Errors
    /// Numbers that make no blade.
    pub fn new(
        scene: &Scene,
        table_from_work: &Pose,
        part: Option<&TriMesh>,
        fixtures: &[(String, TriMesh)],
    ) -> Result<Self, InputError> {
        let part = part.map(|mesh| ("part".to_owned(), mesh.transformed(table_from_work)));
        Ok(Self {
            cut: usize::from(part.is_some()),
            surface: surface(scene, table_from_work)?,
            solids: part.into_iter().chain(fixtures.iter().cloned()).collect(),
            standing: Arc::default(),
        })
    }

    /// The same solids under the surface of another scene.
    ///
    /// # Errors
    /// Numbers that make no blade.
    pub(crate) fn under_surface_of(&self, scene: &Scene, table_from_work: &Pose) -> Result<Self, InputError> {
        Ok(Self { surface: surface(scene, table_from_work)?, ..self.clone() })
    }

    /// The airfoil, where the part is a blade.
    pub fn surface(&self) -> Option<&dyn ContactSurface> {
        self.surface.as_ref().map(|s| s as &dyn ContactSurface)
    }

    /// What a tool must keep away from; none where there is nothing.
    ///
    /// # Errors
    /// A mesh that does not bound a solid.
    pub fn region(&self, tool: &Tool) -> Result<Option<Box<dyn FeasibleRegion>>, CollisionError> {
        if self.solids.is_empty() {
            return Ok(None);
        }
        let standing = match self.standing.get() {
            Some(standing) => standing,
            None => {
                let made = StandingSolids::new(&self.solids)?;
                self.standing.get_or_init(|| made)
            }
        };
        let clearance = ToolClearance::among(tool, standing);
        let solids = Arc::clone(&self.solids);
        Ok(Some(Box::new(Region { clearance, tool: tool.clone(), solids, cut: self.cut, space: OnceLock::new() })))
    }
}

/// The airfoil of a scene, where its part is a blade.
fn surface(scene: &Scene, table_from_work: &Pose) -> Result<Option<BladeSurface>, InputError> {
    let Some(blade) = scene.file.part.as_ref().and_then(|p| p.blade) else { return Ok(None) };
    Ok(Some(BladeSurface::of(Shape::of_scene(scene, &blade, 0.0)?.surface(), *table_from_work)))
}

/// Solids of a tool; the search for free turns is made when it is first asked for.
struct Region {
    clearance: ToolClearance,
    tool: Tool,
    solids: Arc<[(String, TriMesh)]>,
    cut: usize,
    space: OnceLock<Result<OrientationSpace, OrientationError>>,
}

impl FeasibleRegion for Region {
    fn clearance(&self, pose: &ToolPose) -> f64 {
        self.clearance.distance(pose, REACH_MM)
    }

    fn clearance_up_to(&self, pose: &ToolPose, most: f64) -> f64 {
        self.clearance.distance(pose, most.min(REACH_MM))
    }

    fn reach(&self) -> Option<f64> {
        // The farthest corner of a body of revolution from the tip lies on its widest circle at one of its
        // ends.
        let of = |b: &proveout_tool::Body| {
            let up = b.profile.z_max().abs().max(b.profile.z_min().abs());
            b.profile.max_radius().hypot(up)
        };
        Some(self.tool.bodies.iter().map(of).fold(0.0, f64::max))
    }

    fn free_turns(&self, turn: &AxisTurn) -> Option<Vec<[f64; 2]>> {
        let space = self.space.get_or_init(|| {
            let solids = self.solids.iter().enumerate();
            let solids: Vec<Obstacle<'_>> =
                solids.map(|(k, (name, mesh))| Obstacle { name, mesh, cut: k < self.cut }).collect();
            OrientationSpace::new(&self.tool, &solids, &OrientationSettings::default())
        });
        space.as_ref().ok()?.free_turns(turn)
    }
}
