//! Blades with closed forms: a section as the envelope of circles on a circular camber line, extruded, twisted, on a platform.

mod body;
mod discs;
mod mesh;
mod nearest;
mod section;
mod surface;

pub use body::{Blade, BladeError, BladeSpec, Platform, SurfacePoint};
pub use nearest::{NEAREST_ERROR_MM, NearestOnBlade};
pub use section::{CamberSection, SectionCurve, SectionError, SectionPoint};
pub use surface::{Domain, Local, ParametricSurface};
