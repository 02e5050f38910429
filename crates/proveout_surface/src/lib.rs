//! How far a cut surface is from its design: gouge, excess, mean and root mean square deviation.
//!
//! Data in: points of the cut surface and a design, both in one frame (the workpiece frame W), mm. Data out: signed
//! deviations, mm; positive where material is left outside of the design, negative where it is missing inside.
//!
//! * [`DesignSurface`] – signed distance to a design: [`DesignMesh`] for meshes; [`Plane`], [`Sphere`], [`ConeFrustum`]
//!   and [`ConeFlank`] in closed form.
//! * [`measure`] – [`Deviation`] of [`SurfaceSample`]s, with one value a point for a map; [`measure_where`] and
//!   [`Deviation::joined`] where parts of a surface have finer cells.
//!
//! Nearest points of a mesh are found by branch and bound over a bounding volume hierarchy; their sign by angle-weighted
//! pseudo-normals (Baerentzen and Aanaes 2005).
//!
//! Known limits: the deviation of a cut point is its distance to the nearest design point. Design surface that has no cut
//! point near it (a boss that was milled off) shows only as the gouge of the points that were cut in its place. A design
//! mesh counts as exact; its chord error is the caller's tolerance floor.

mod analytic;
mod design;
mod deviation;
mod mesh;
pub mod texture;
pub mod topography;

pub use analytic::{ConeFlank, ConeFrustum, Plane, Sphere};
pub use design::{DesignSurface, Nearest};
pub use deviation::{Deviation, DeviationSettings, SurfaceSample, WorstPoint, measure, measure_where};
pub use mesh::{DesignError, DesignMesh};
