//! Distance of a tool in one pose from fixed solids: which tool axes are free at a place. For all
//! axes of a contact at once, with proof and including the cutter near the contact, see
//! [`OrientationSpace`](crate::OrientationSpace).

use std::sync::Arc;

use proveout_geom::{Pose, ToolPose, TriMesh, Vector};
use proveout_tool::{Role, Tool};

use crate::distance::{Separation, gap};
use crate::parts::{MeshDemand, mesh_shape};
use crate::report::CollisionError;
use crate::shape::{PartShape, Revolved};

/// Sine of the angle to Z below which a tool stands upright.
const UPRIGHT: f64 = 1e-12;

/// Solids fixed in one frame, prepared once for any number of tools. A copy shares them.
#[derive(Clone, Debug)]
pub struct StandingSolids(Arc<[PartShape]>);

impl StandingSolids {
    /// Named solids, mm.
    ///
    /// # Errors
    /// A mesh that does not bound a solid.
    pub fn new(solids: &[(String, TriMesh)]) -> Result<Self, CollisionError> {
        let solid = |(name, mesh): &(String, TriMesh)| {
            Ok(PartShape::Mesh(Box::new(mesh_shape("solid", name, mesh, MeshDemand::Solid)?)))
        };
        Ok(Self(solids.iter().map(solid).collect::<Result<Vec<PartShape>, _>>()?.into()))
    }
}

/// Neck, shank and holder of a tool among solids; the cutting end, which touches what it cuts, is left out.
///
/// ```
/// use proveout_collision::ToolClearance;
/// use proveout_geom::{Aabb, Point, ToolPose, Vector, box_mesh};
/// use proveout_tool::{Cutter, ToolBuilder};
///
/// // Flutes of 20 mm, then a shank up to the gauge line.
/// let builder = ToolBuilder::new(1, "BALL_D12", Cutter::ball(12.0)?, 20.0, 120.0);
/// let tool = builder.shank(10.0).build()?;
/// let plate = Aabb { min: Point::new(-30.0, -20.0, -10.0), max: Point::new(30.0, 20.0, 0.0) };
/// let clearance = ToolClearance::new(&tool, &[("plate".to_owned(), box_mesh(&plate))])?;
/// // The ball cuts 5 mm deep: the shank begins 15 mm above the plate.
/// let pose = ToolPose { tip: Point::new(0.0, 0.0, -5.0), axis: Vector::z() };
/// assert!((clearance.distance(&pose, 100.0) - 15.0).abs() < 1e-3);
/// assert_eq!(clearance.distance(&pose, 10.0), 10.0); // no more than is asked for
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ToolClearance {
    tool: PartShape,
    solids: StandingSolids,
}

impl ToolClearance {
    /// A tool among named solids, all in one frame, mm.
    ///
    /// # Errors
    /// A mesh that does not bound a solid.
    pub fn new(tool: &Tool, solids: &[(String, TriMesh)]) -> Result<Self, CollisionError> {
        Ok(Self::among(tool, &StandingSolids::new(solids)?))
    }

    /// The same among solids that are prepared already.
    pub fn among(tool: &Tool, solids: &StandingSolids) -> Self {
        let bodies = tool.bodies.iter().filter(|b| b.role != Role::Cutting).map(|b| Revolved::new(&b.profile));
        Self { tool: PartShape::Convex(bodies.collect()), solids: solids.clone() }
    }

    /// Smallest distance of the tool from the solids where it is below `limit`, else `limit`, mm; zero where
    /// skins meet. Never larger than the true distance. A tool wholly inside of a solid does not meet its
    /// skin: no tool is that short.
    pub fn distance(&self, pose: &ToolPose, limit: f64) -> f64 {
        let solid_from_tip = upright(pose);
        self.solids.0.iter().fold(limit, |least, solid| {
            match gap(&self.tool, solid, &solid_from_tip, [least; 2], &mut None) {
                Separation::Beyond(_) | Separation::Between(..) => least,
                Separation::At(distance, ..) => distance,
                Separation::Meeting(_) => 0.0,
            }
        })
    }
}

/// A frame with its z along the tool axis; bodies of revolution do not care for the rest.
fn upright(pose: &ToolPose) -> Pose {
    let across = Vector::z().cross(&pose.axis);
    let turn = match across.try_normalize(UPRIGHT) {
        Some(axis) => Pose::from_axis_angle(&axis, across.norm().atan2(pose.axis.z)),
        None if pose.axis.z > 0.0 => Pose::identity(),
        None => Pose::from_axis_angle(&Vector::x(), std::f64::consts::PI),
    };
    Pose { translation: pose.tip.coords, ..turn }
}
