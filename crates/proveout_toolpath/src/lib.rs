//! Tool paths independent of any control: passes over blades, and published methods that re-plan the tool axes of a path.
//!
//! * [`HelicalPass`] – a ball end mill round a blade, as a CAM system posts it.
//! * [`BladeSurface`] – contacts on a blade: nearest point, normal, principal curvatures.
//! * [`path`] – paths over blades by contacts: strategies, chord error, scallop, cutter locations, what they ask of a machine.
//! * [`reschedule`] – published methods that re-plan the tool axes of a path, and a bound of the time of every schedule in a channel.
//!
//! Units: mm, s, radian. CL data in text are a dialect of `proveout_nc`.

mod blade_surface;
mod helix;
pub mod path;
pub mod reschedule;

pub use blade_surface::BladeSurface;
pub use helix::{HelicalPass, PassError, PassPoint};
