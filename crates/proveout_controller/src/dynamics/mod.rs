//! Forces that a machine's bodies put on its drives: recursive Newton-Euler, and Rapier as an alternative
//! plant.
//!
//! Everything is in mm, kg, s; forces come out in N, torques in N mm. The tree of joints is that of
//! [`proveout_machine::Machine`]: tool side and table side share the same base. Masses are those of
//! the machine file; [`MassReport`] lists what is estimated or missing. Workpiece, fixtures, tool
//! and cutting forces are not included.

mod newton_euler;
#[cfg(feature = "rapier")]
mod rapier_plant;
#[cfg(not(feature = "rapier"))]
#[path = "no_rapier.rs"]
mod rapier_plant;
mod tree;

pub(crate) use newton_euler::TO_NEWTON;
pub use newton_euler::{MassMatrix, STANDARD_GRAVITY};
pub use rapier_plant::RapierPlant;
pub use tree::{MassReport, RigidTree};
