//! Distance of two solids in given poses.

use proveout_geom::{Pose, TriMesh};

use crate::distance::{Separation, WarmStart, skins};
use crate::parts::{MeshDemand, mesh_shape};
use crate::report::CollisionError;
use crate::shape::MeshShape;

/// Two closed meshes whose distance is asked for in pose after pose: each query begins with the triangles
/// that were nearest in the last.
///
/// ```
/// use proveout_collision::SolidPair;
/// use proveout_geom::{Aabb, Point, Pose, Vector, box_mesh};
///
/// let cube = box_mesh(&Aabb { min: Point::origin(), max: Point::new(10.0, 10.0, 10.0) });
/// let mut pair = SolidPair::new(&cube, &cube)?;
/// // Gaps of 3 mm along X and 4 mm along Y: 5 mm from edge to edge.
/// let apart = Pose::from_translation(Vector::new(13.0, 14.0, 0.0));
/// assert!((pair.distance(&apart) - 5.0).abs() < 1e-6);
/// assert_eq!(pair.distance(&Pose::from_translation(Vector::new(5.0, 5.0, 5.0))), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SolidPair {
    first: MeshShape,
    second: MeshShape,
    warm: WarmStart,
}

impl SolidPair {
    /// Two meshes, each in its own frame, mm.
    ///
    /// # Errors
    /// A mesh that does not bound a solid.
    pub fn new(first: &TriMesh, second: &TriMesh) -> Result<Self, CollisionError> {
        let of = |name: &str, mesh: &TriMesh| mesh_shape("solid", name, mesh, MeshDemand::Solid);
        Ok(Self { first: of("first", first)?, second: of("second", second)?, warm: None })
    }

    /// Distance of the skins, mm; zero where they meet. A solid wholly inside of the other has the distance
    /// of its skin.
    pub fn distance(&mut self, second_from_first: &Pose) -> f64 {
        match skins(&self.first.boxes, &self.second.boxes, second_from_first, [f64::INFINITY; 2], &mut self.warm) {
            Separation::Beyond(distance) | Separation::At(distance, ..) | Separation::Between([distance, _], ..) => {
                distance
            }
            Separation::Meeting(_) => 0.0,
        }
    }
}
