//! Blades and faces with closed forms: one kind a file, each a map S(u, v) that is used through
//! [`ParametricSurface`].
//!
//! Data in: the numbers of a kind ([`BladeSpec`] and others) or a file of sections. Data out: points,
//! normals, curvatures, nearest points with a stated error, closed meshes with a measured chord error.
//! Lengths are in mm, angles in radian. Everything is in the frame of the blade; where it lies on a table is
//! up to the caller.
//!
//! * [`Blade`] – circles on a circular camber line, extruded, twisted, on a platform; its airfoil is
//!   [`CamberSide`].
//! * [`SkinnedBlade`] – a bicubic spline through sections of points.
//! * [`Lu`], [`Sine`], [`Dong`], [`Cui`] – formulas on which published methods are tried, through
//!   [`ClosedSurface`].
//! * [`BladeSolid`] – any of them that closes round, with flat ends or platforms and rolling-ball fillets;
//!   its closed mesh.
//!
//! ```
//! use proveout_blade::{ClosedSurface, FOOT_ERROR_MM, ParametricSurface, Sine};
//!
//! let face = ClosedSurface::new(Sine::gentle()); // waves along y, 40 mm long and 12 mm high
//! let crest = face.local(15.0, 20.0); // u and v are x and y, mm
//! assert!((crest.point.z - 12.0).abs() < 1e-9 && (crest.normal.z - 1.0).abs() < 1e-9);
//! let above = crest.point + crest.normal * 2.0;
//! let [u, v] = face.nearest(&above);
//! let distance = (face.local(u, v).point - above).norm();
//! assert!((distance - 2.0).abs() < 2.0 * FOOT_ERROR_MM);
//! ```
//!
//! | file | holds |
//! |---|---|
//! | `surface.rs` | [`ParametricSurface`], [`Local`]: what every kind answers |
//! | `body.rs`, `camber.rs` | [`Blade`] and its airfoil as a surface |
//! | `section.rs` | sections of circles |
//! | `section_file.rs`, `sections.rs` | sections of points: their files, the blade through them |
//! | `lu.rs`, `sine.rs`, `dong.rs`, `cui.rs` | the formulas of papers |
//! | `closed_form.rs`, `scalar.rs` | a formula as a surface: derivatives and bounds |
//! | `bicubic.rs`, `spline.rs` | patches and slopes of splines |
//! | `nearest.rs`, `nearest/`, `cells.rs`, `ball_tree.rs`, `discs.rs` | nearest points, with proof |
//! | `solid.rs`, `solid_nearest.rs` | a blade with its ends |
//! | `mesh.rs`, `solid_mesh.rs`, `flat.rs` | closed meshes |

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
