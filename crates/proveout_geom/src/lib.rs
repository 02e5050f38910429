//! Vocabulary types of the twin: angles, rigid poses, boxes, triangle meshes and their files.
//!
//! Data in and out is in millimeter and radian. A pose named `a_from_b` maps coordinates of frame b to
//! coordinates of frame a; a point named `p_in_a` has coordinates of frame a.
//!
//! * [`Pose`] – rigid transform whose right angles are exact.
//! * [`TriMesh`] – indexed triangles; [`TriMesh::check_solid`] proves that they bound a solid, [`TriMesh::check_uncrossed`]
//!   that it does not cross or overlap itself.
//! * [`blade`] – blades with closed forms and their meshes.
//! * [`read_mesh`], [`read_glb_nodes`], [`write_stl`] – STL, OBJ and glTF binary files; [`write_glb_container`] – header and
//!   chunks of the latter.
//! * [`read_regular_file`] – bytes of an input file, which is no pipe and no device, up to a limit.
//! * [`Document`] – a TOML file read into a type, and the place of its keys; [`InputError`] is what is wrong with it.
//! * [`check_quantities`] – ranges of the numbers in input files, by the unit in which a key ends.
//!
//! A type enters this crate when two crates need it.

mod aabb;
mod angle;
pub mod blade;
mod cell_map;
mod crossing;
mod document;
mod inch;
mod input_error;
mod mesh;
mod mesh_file;
mod overlap;
mod pose;
mod primitives;
mod quantities;
mod regular_file;
mod tool_pose;

pub use aabb::Aabb;
pub use angle::{deg, rad, sin_cos, wrap_near};
pub use cell_map::{CellHasher, CellMap};
pub use crossing::Crossing;
pub use document::{Document, Step, nearest};
pub use inch::{add_inches_to_schema, in_millimeters};
pub use input_error::{InputError, InputFault, read_input};
pub use mesh::{MeshError, TriMesh};
pub use mesh_file::{
    FlatTriangles, GlbNode, MeshFileError, read_glb_nodes, read_mesh, read_mesh_and_flat, write_glb_container,
    write_stl,
};
pub use overlap::Overlap;
pub use pose::Pose;
pub use primitives::{box_mesh, cylinder_mesh, revolved_mesh};
pub use quantities::{
    MAX_LENGTH_MM, OutOfRange, add_ranges_to_schema, check_quantities, check_quantity, range_of, table_of_ranges,
};
pub use regular_file::{open_regular_file, read_regular_file, read_regular_text};
pub use tool_pose::ToolPose;

/// Point in millimeter.
pub type Point = nalgebra::Point3<f64>;
/// Free vector in millimeter, or a direction of length one where the name says so.
pub type Vector = nalgebra::Vector3<f64>;
