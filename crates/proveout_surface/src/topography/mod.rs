//! The surface that a motion leaves, point by point: by the cutter's envelope, or by the edges of its teeth.
//!
//! Data in: points and normals of the design ([`Lattice`]), pieces of the motion with times and spindle ([`CutterPiece`]), and the
//! nominal cutter ([`proveout_tool::Profile`]) or its [`Edge`]s. Data out: a height for each point ([`Topography`]), mm: the least signed
//! distance along the normal of the design to what the edges sweep, with the time, the motion and the tooth that made it.
//!
//! # By inverse contact
//!
//! Nothing is stamped on a grid and time is not sampled. For each point the contact is solved for:
//!
//! ```text
//!   envelope:  d(P + h n, t) = 0,  d/dt = 0       one unknown time a piece (or one of its ends)
//!   edges:     P + h n on edge k at time t        two equations in (t, h), one solution a revolution, tooth and pass
//! ```
//!
//! and the lowest height over all pieces, teeth and revolutions is kept. Which pieces can matter is found for blocks of the lattice
//! (`block`): the tangent half space of the cutter at its touch with the middle of the block bounds the piece from below over the
//! whole block, so that far pieces and passes are left out with proof. The idea of inverting the contact of a tooth for plane face milling
//! is that of Duong and Nguyen (2026); here for any motion in five axes.
//!
//! # Error
//!
//! Heights are exact to rounding (1e-10 mm) for the pieces as given; what the pieces miss of the motion is the caller's bound. Within a
//! piece the speed counts as constant: an acceleration a over a piece of duration T moves marks along the path by a T^2 / 8, and
//! leaves their heights across it.
//!
//! Limits: edges are rounded corners (arcs); a straight flank or face edge without rounding leaves no height here. Where the spindle
//! stands, edges leave nothing. Points within 4 v / w of the path of the axis: see `contact`.

mod block;
mod contact;
mod edge;
mod envelope;
mod lattice;
mod motion;
mod outline;
mod path;
mod teeth;
#[cfg(test)]
mod tests;

pub use block::{Cut, Settings, Topography, heights_by_edges, heights_by_envelope};
pub use edge::{Corner, Edge};
pub use lattice::Lattice;
pub use motion::CutterPiece;
pub use path::{PathContact, PathPiece, StandingCutter, SweptPath, Touching};
pub use proveout_tool::RunOut;
pub use teeth::{TeethError, check_chip, check_motion, edges_of, phase_zero};
