//! The surface that a motion leaves, point by point: by the cutter's envelope, or by the edges of its teeth.
//!
//! Data in: points and normals of the design ([`Lattice`]), pieces of the motion with times and spindle
//! ([`CutterPiece`]), and the nominal cutter ([`proveout_tool::Profile`]) or its [`Edge`]s. Data out: a
//! height for each point ([`Topography`]), mm: the least signed distance along the normal of the design to
//! what the edges sweep, with the time, the motion and the tooth that made it.
//!
//! # By inverse contact
//!
//! Nothing is stamped on a grid and time is not sampled. For each point the contact is solved for:
//!
//! ```text
//!   envelope:  d(P + h n, t) = 0,  d/dt = 0       one unknown time a piece (or one of its ends)
//!   edges:     P + h n on edge k at time t        two equations in (t, h), one solution a revolution,
//!                                                 tooth and pass
//! ```
//!
//! and the lowest height over all pieces, teeth and revolutions is kept. Which pieces can matter is found for
//! blocks of the lattice (`height_search`): the tangent plane of the cutter at its lowest touch with the
//! middle of the block bounds the piece from below over the whole block, so that far pieces and passes are
//! left out with proof. Times at which nothing can be lower are leapt over (`edge_contact`). The idea of
//! inverting the contact of a tooth for plane face milling is that of Duong and Nguyen (2026); here for any
//! motion in five axes.
//!
//! A contact counts where the cutter comes from outside of the design: one that lies wholly below the design
//! point (the other side of a thin wall) does not.
//!
//! Edges come from a tool of a library by [`edges_of`], the zero of the spindle's phase by [`phase_zero`];
//! [`check_motion`] and [`check_chip`] name what leaves no marks.
//!
//! # Error
//!
//! Heights are exact to rounding (1e-12 mm for coordinates of 100 mm; 1e-9 mm by the envelope of turning
//! pieces) for the pieces as given. To that come
//!
//! * what the pieces miss of the motion: a tip off by e and an axis off by an angle d move the height by e +
//!   d |q| at most, q from the tip to the contact;
//! * the constant speed within a piece: an acceleration a over a piece of duration T puts the tip a T^2 / 8
//!   off its place along the path in the middle of the piece, and the azimuth of a tooth w T dv / (8 v), dv
//!   the change of the speed v. Marks are shifted by the first, heights change by it times the slope of the
//!   marks (a ball: half of feed a revolution over radius). Where the spindle changes its speed, pieces must
//!   be as short;
//! * 1e-7 of the feed a revolution times the slope of the mark, where a contact falls on the joint of two
//!   pieces with different velocities.
//!
//! Time per point on one core of a busy two-core machine
//! (`cargo bench -p proveout_surface --bench topography`): 1.0 to 1.2 us by the envelope on straight
//! paths, 2.1 to 3.4 us in five axes; by two teeth with helix and run-out 2.0 to 2.2 us and 3.0 to 4.2
//! us, 7 us where the axis is normal to the surface and points pass to its side. Distances from the
//! cutter, and sine and cosine of the teeth, limit the speed.
//!
//! Limits: edges are rounded corners (arcs); a straight flank or face edge without rounding leaves no
//! height here. With the spindle stopped, edges leave nothing. Some contacts may be missed: one at which
//! the normal of the design grazes the cutter within a degree of 90, and, near the axis, two contacts of a
//! tooth within a sixteenth of a revolution whose distance from the tooth turns more than once between
//! them.

mod depth_in_sweep;
mod edge;
mod edge_contact;
mod envelope;
mod height_search;
mod lattice;
mod motion;
mod outline;
mod path;
mod teeth;
#[cfg(test)]
mod tests;

pub use depth_in_sweep::{MoveDistance, SweepItem, SweptBodies};
pub use edge::{Edge, TeethCorner};
pub use height_search::{Cut, Settings, Topography, heights_by_edges, heights_by_envelope};
pub use lattice::Lattice;
pub use motion::CutterPiece;
pub use path::{ContactDirections, PathContact, PathPiece, StandingCutter, SweptPath};
pub use proveout_tool::RunOut;
pub use teeth::{TeethError, check_chip, check_motion, edges_of, phase_zero};

/// Coordinates, times and angles are smaller than this, mm, s and radian: far beyond any program.
const LARGEST: f64 = 1e9;
/// A divisor that may be zero is this at least, so that what is divided by it is without bound.
const NOT_ZERO: f64 = 1e-300;
/// Nearer to a center or an axis than this no direction leads away from it, mm.
const AT_CENTER: f64 = 1e-15;
/// A cutter with a larger radius, or none, is taken for a ball of this one where a search begins, mm.
const MOST_RADIUS: f64 = 1e3;
