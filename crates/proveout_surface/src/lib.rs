//! How far a cut surface is from its design: gouge, excess, mean and root mean square deviation.
//!
//! Data in: points of the cut surface and a design, both in one frame (the workpiece frame W), mm. Data out:
//! signed deviations, mm; positive where material is left outside of the design, negative where it is missing
//! inside.
//!
//! * [`DesignSurface`] – signed distance to a design: [`DesignMesh`] for meshes; [`HalfSpaceDesign`],
//!   [`Sphere`], [`ConeFrustum`], [`ConeFlank`] and blades ([`proveout_blade::Blade`]) in closed form;
//!   [`chord_error`] of a mesh against one.
//! * [`measure`] – [`Deviation`] of [`SurfacePoint`]s, with one value a point for a map; [`Tally`] for
//!   points as they come.
//! * [`Survey`] – a whole stock, band by band: its points, and the [`Gap`]s between design and material on
//!   its rays.
//! * [`ThinFins`] – sheets of material as thin as the error of their own faces.
//! * [`Areas`] – what is too deep or too high, area by area.
//! * [`refined`] – the worst place of an area on the swept surface itself, between the rays.
//! * [`unseen`] – parts of the design that no ray resolves.
//! * [`overcuts`] – gouges between the rays, decided on the swept pieces.
//! * [`uncut`] – places next to the design that no piece has cleared.
//!
//! Nearest points of a mesh are found by branch and bound over a bounding volume hierarchy; their sign by
//! angle-weighted pseudo-normals (Baerentzen and Aanaes 2005).
//!
//! Known limits: the deviation of a cut point is its distance to the nearest design point. What this misses
//! (walls thinner than a gouge is deep) is found on the rays, for designs that bound a solid. A groove of
//! the cut part narrower than the cells, between all rays, is not seen. A design mesh counts as exact; its
//! chord error is the caller's tolerance floor. The rays of a solid are compared with its mesh even where
//! the points are compared with a closed form.
//!
//! # Files
//!
//! | file or folder | holds |
//! |---|---|
//! | `design`, `mesh`, `analytic`, `blade` | designs, and the distance of a point from them |
//! | `deviation`, `areas`, `survey` | gouge and excess: of points, area by area, of a whole stock |
//! | `gaps`, `thin_fins` | the same on the rays, and fins as thin as the error |
//! | `gouge_proof`, `excess`, `worst_place`, `coverage` | between the rays |
//! | `scallop` | ridges between passes |
//! | `topography` | heights that a cutter leaves on a lattice |
//! | `texture` | roughness: filters, parameters, files |

mod analytic;
mod areas;
mod blade;
mod coverage;
mod design;
mod deviation;
mod excess;
mod gaps;
mod gouge_proof;
mod mesh;
pub mod scallop;
mod survey;
pub mod texture;
mod thin_fins;
pub mod topography;
mod worst_place;

pub use analytic::{ConeFlank, ConeFrustum, HalfSpaceDesign, Sphere};
pub use areas::{Area, AreaPart, Areas, MOST_CELLS, MOST_STARTS, Seed, Starts};
pub use blade::chord_error;
pub use coverage::{Unseen, Watcher, unseen};
pub use design::{DesignSurface, NearestOnDesign};
pub use deviation::{
    Deviation, DeviationSettings, Judged, SurfacePoint, Tally, WorstPoint, judge, measure, measure_where,
};
pub use excess::{LeftMaterial, Uncut, UncutFound, uncut};
pub use gaps::{Gap, GapEnd, GapSettings, OnRay, Side, gaps};
pub use gouge_proof::{Overcut, Overcuts, overcuts};
pub use mesh::{DesignError, DesignMesh};
pub use survey::{Band, FoundGap, Solid, Survey};
pub use thin_fins::{FinCrossing, ThinFins};
pub use worst_place::{Refine, Worst, refined};
