//! The drives that follow the set points: the actual motion of the joints.
//!
//! * [`DriveModel`] – one joint: cascade control, friction, backlash, one elastic mode, force limit, in exact
//!   discrete form; [`DriveState`] is all that changes.
//! * [`Plant`] – how the machine's bodies load the drives.
//! * `legs` – platforms, whose drives move legs instead of joints.
//! * [`size_drives`] – drives by a rule where none are published.
//! * `stage` – the stream of the planned run turned into the actual one.

mod backlash;
pub(crate) mod contour;
mod friction;
mod legs;
mod linear;
mod model;
mod plant_run;
mod sizing;
pub(crate) mod stage;
mod step;
pub(crate) mod trail;

pub use legs::leg_names;
pub use model::{DriveFault, DriveModel};
pub use plant_run::{Plant, without_drive};
pub use sizing::{SizedDrive, largest_loads, size_drives};
pub use step::{DriveState, SetPointRates};
