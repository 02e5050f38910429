//! Cutter location data: where the tool tip and axis shall be, independent of any machine.
//!
//! * [`ClFile`] – a tool path as a list of [`ClRecord`]s; [`ClFile::from_apt`] reads APT CL text, [`ClFile::to_apt`]
//!   writes it.
//! * [`ClStatement`] – one statement; motions carry a [`proveout_geom::ToolPose`] in the frame of the part program, mm.
//!
//! * [`HelicalPass`] – a ball end mill round a blade, as a CAM system posts it.
//! * [`BladeSurface`] – contacts on a blade: nearest point, normal, principal curvatures.
//! * [`reschedule`] – published methods that re-plan the tool axes of a path.
//!
//! Units of the file (`UNITS/MM`, `UNITS/INCHES`) are converted while reading: mm, mm/s, radian, second inside.
//!
//! Limits: circular and surface motions of APT source (`CIRCLE`, `GORGT`, `TLLFT`) are refused, since their meaning
//! needs the geometry statements of the source; CL files as written by CAM systems have them resolved into `GOTO`.

mod apt;
mod apt_words;
mod blade_surface;
mod cl;
mod error;
mod helix;
pub mod reschedule;

pub use blade_surface::BladeSurface;
pub use cl::{ClFile, ClRecord, ClStatement, CoolantState, SpindleState};
pub use error::ClError;
pub use helix::{HelicalPass, PassError, PassPoint};
