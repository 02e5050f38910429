//! Blades and faces with closed forms, one kind a file, each a map S(u, v) that can be asked through [`ParametricSurface`].
//!
//! * [`Blade`] – circles on a circular camber line, extruded, twisted, on a platform; its airfoil is [`CamberSide`].
//! * [`SkinnedBlade`] – a bicubic spline through sections of points.
//! * [`Lu`], [`Sine`], [`Dong`], [`Cui`] – formulas on which published methods are tried, through [`ClosedSurface`].
//! * [`BladeSolid`] – any of them that closes round, with flat ends or platforms and rolling-ball fillets; its closed mesh.

mod ball_tree;
mod bicubic;
mod body;
mod camber;
mod cells;
mod closed_form;
mod cui;
mod discs;
mod dong;
mod flat;
mod lu;
mod mesh;
mod nearest;
pub mod scalar;
mod section;
mod section_file;
mod sections;
mod sine;
mod solid;
mod solid_mesh;
mod solid_nearest;
mod spline;
mod surface;

pub use body::{Blade, BladeError, BladeSpec, Platform, SurfacePoint};
pub use camber::CamberSide;
pub use cells::FOOT_ERROR_MM;
pub use closed_form::{ClosedForm, ClosedSurface};
pub use cui::Cui;
pub use dong::Dong;
pub use lu::{AlongSpan, Lu, SectionLength};
pub use nearest::{NEAREST_ERROR_MM, NearestOnBlade};
pub use section::{CamberSection, SectionCurve, SectionError, SectionPoint};
pub use section_file::{PointedSection, SectionFileError, SectionPart, read_sections};
pub use sections::{SectionsError, SkinnedBlade};
pub use sine::Sine;
pub use solid::{BladeEnd, BladeSolid, Plate, SolidError};
pub use solid_mesh::{Backing, MeasuredMesh, MeshingError, face_mesh};
pub use solid_nearest::NearestOnSolid;
pub use surface::{Domain, Foot, Local, ParametricSurface};

/// Largest thickness and margin of a platform, mm.
const MOST_PLATFORM_MM: f64 = 1e4;
/// A bend that a chord error is divided by is this at least: what is flat has steps as long as it is.
const LEAST_BEND: f64 = 1e-12;
/// Smallest part of a step of Newton's method that is tried before its search ends.
const LEAST_PART: f64 = 1e-4;
