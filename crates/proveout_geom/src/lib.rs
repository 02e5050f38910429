//! Vocabulary types of the twin: angles, rigid poses, boxes, triangle meshes and their files.
//!
//! Data in and out is in millimeter and radian. A pose named `a_from_b` maps coordinates of frame b to
//! coordinates of frame a; a point named `p_in_a` has coordinates of frame a.
//!
//! * [`Pose`] – rigid transform whose right angles are exact.
//! * [`TriMesh`] – indexed triangles; [`TriMesh::check_solid`] proves that they bound a solid,
//!   [`TriMesh::check_uncrossed`] that it does not cross or overlap itself.
//! * [`read_mesh`], [`read_glb_nodes`], [`write_stl`] – STL, OBJ and glTF binary files;
//!   [`write_glb_container`] – header and chunks of the latter.
//!
//! A type enters this crate when two crates need it.
//!
//! | file or folder | holds |
//! |---|---|
//! | `angle.rs`, `pose.rs`, `tool_pose.rs` | exact right angles; rigid poses; tool tip with tool axis |
//! | `aabb.rs`, `cell_map.rs` | boxes; hash maps over the cells of a grid |
//! | `mesh.rs`, `primitives.rs` | triangle meshes; boxes, cylinders, bodies of revolution as meshes |
//! | `ball_way.rs` | where a ball on a straight way touches a mesh |
//! | `crossing.rs`, `overlap.rs` | where a mesh crosses itself; where its faces lie in each other |
//! | `mesh_file/` | readers and writers: STL, OBJ, glTF binary |

mod aabb;
mod angle;
mod ball_way;
mod cell_map;
mod crossing;
mod mesh;
mod mesh_file;
mod overlap;
mod pose;
mod primitives;
mod tool_pose;

pub use aabb::Aabb;
pub use angle::{deg, rad, sin_cos, wrap_near};
pub use ball_way::{BallTouch, BallWay};
pub use cell_map::{CellHasher, CellMap};
pub use crossing::Crossing;
pub use mesh::{MeshError, TriMesh};
pub use mesh_file::{
    FlatTriangles, GlbNode, MeshFileError, read_glb_nodes, read_mesh, read_mesh_and_flat, write_glb_container,
    write_stl,
};
pub use overlap::Overlap;
pub use pose::Pose;
pub use primitives::{box_mesh, cylinder_mesh, revolved_mesh};
pub use tool_pose::{AxisTurn, ToolPose};

/// Point in millimeter.
pub type Point = nalgebra::Point3<f64>;
/// Free vector in millimeter, or a direction of length one where the name says so.
pub type Vector = nalgebra::Vector3<f64>;
