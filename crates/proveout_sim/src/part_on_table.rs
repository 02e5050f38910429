//! What re-scheduling may ask about the part of a scene: where the tool touches the design, and what the rest of the tool must
//! keep away from.

use std::sync::{Arc, OnceLock};

use proveout_collision::{
    CollisionError, Obstacle, OrientationMap, OrientationSettings, OrientationSpace, SurfaceContact, ToolClearance,
};
use proveout_geom::{Pose, ToolPose, TriMesh, Vector};
use proveout_tool::Tool;
use proveout_toolpath::BladeSurface;
use proveout_toolpath::reschedule::{Contact, ContactSurface, FeasibleRegion, FreeAxes};

use crate::{config::ConfigError, scene::Scene};

/// Clearances above this are not told apart, mm: a method asks whether a pose is free and by how much, not how far away
/// everything else is.
const REACH_MM: f64 = 50.0;

/// Design part and fixtures in the frame of the table, which is that of programs under tool center point control.
#[derive(Clone, Debug, Default)]
pub struct PartOnTable {
    surface: Option<BladeSurface>,
    /// The part, where there is one, and the fixtures.
    solids: Arc<Vec<(String, TriMesh)>>,
    has_part: bool,
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
    ) -> Result<Self, ConfigError> {
        let blade = scene.file.part.as_ref().and_then(|p| p.blade);
        let blade = blade.map(|b| b.blade(0.0)).transpose();
        let blade = blade.map_err(|e| ConfigError::file(&scene.path, e.to_string(), "correct [part.blade]"))?;
        let part = part.map(|mesh| ("part".to_owned(), mesh.transformed(table_from_work)));
        let has_part = part.is_some();
        Ok(Self {
            surface: blade.map(|b| BladeSurface::new(b, *table_from_work)),
            solids: Arc::new(part.into_iter().chain(fixtures.iter().cloned()).collect()),
            has_part,
        })
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
        Ok(Some(Box::new(Region {
            clearance: ToolClearance::new(tool, &self.solids)?,
            tool: tool.clone(),
            solids: Arc::clone(&self.solids),
            has_part: self.has_part,
            space: OnceLock::new(),
        })))
    }
}

struct Region {
    clearance: ToolClearance,
    tool: Tool,
    solids: Arc<Vec<(String, TriMesh)>>,
    has_part: bool,
    /// Made when the first region is asked for: its trees cost what single clearances do not need.
    space: OnceLock<Result<OrientationSpace, String>>,
}

impl FeasibleRegion for Region {
    fn clearance(&self, pose: &ToolPose) -> f64 {
        self.clearance.distance(pose, REACH_MM)
    }

    fn axes(&self, contact: &Contact, feed: &Vector) -> Result<Box<dyn FreeAxes>, String> {
        let make = || {
            let named = self.solids.iter().enumerate();
            let solids: Vec<Obstacle<'_>> =
                named.map(|(k, (name, mesh))| Obstacle { name, mesh, cut: self.has_part && k == 0 }).collect();
            OrientationSpace::new(&self.tool, &solids, &OrientationSettings::default()).map_err(|e| e.to_string())
        };
        let space = self.space.get_or_init(make).as_ref().map_err(Clone::clone)?;
        let contact = SurfaceContact {
            point: contact.point,
            normal: contact.normal,
            feed: *feed,
            curvatures: Some(contact.curvatures),
        };
        Ok(Box::new(Axes(space.map(&contact).map_err(|e| e.to_string())?)))
    }
}

struct Axes(OrientationMap);

impl FreeAxes for Axes {
    fn free_cells(&self) -> usize {
        self.0.free_cells()
    }

    fn free_share(&self) -> f64 {
        self.0.shares()[0]
    }

    fn is_free(&self, axis: &Vector) -> bool {
        self.0.is_free(axis)
    }

    fn nearest_free(&self, axis: &Vector) -> Option<Vector> {
        self.0.nearest_free(axis)
    }

    fn way_is_free(&self, from: &Vector, to: &Vector) -> bool {
        self.0.way_is_free(from, to)
    }
}
