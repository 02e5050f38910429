//! Which tool axes are free at a contact: the feasible region (C-space) of the tool orientation, with proof.
//!
//! At a contact with outward normal N and feed direction T the axis has a tilt t from N and a yaw y about N
//! from T:
//!
//! ```text
//!        N
//!        |   V         V = T sin t cos y + K sin t sin y + N cos t,    K = N x T
//!        | t/          t >= 0, y in -pi .. pi: every axis once. Signed tilts would count each axis
//!        | /           twice, as (t, y) and (-t, y + pi).
//!        |/
//!  ------p------ T     the part lies below
//! ```
//!
//! Cells are pieces of rings of equal tilt; a ring has as many cells as its length asks for, and a
//! cell is halved along its longer sides only, so that the pole (V = N) is a corner that some cells
//! share and no place of slivers. A ball end has one pose for an axis. A bull-nose touches with a
//! place of its corner, the one that leans down: at tilt 0 the yaw still decides which, and the
//! pole is a circle of poses.
//!
//! # Motion of the tool inside of a cell
//!
//! The center Q = p + r N of the corner circle (of the ball) stays where it is while the axis turns. With e
//! the derivative of V by t, the center of the cutter's end is O = Q - m e (m the radius of the circle on
//! which corner centers lie, 0 for a ball). Two poses of a body of revolution differ by the least rotation
//! about O that takes V to V' and the shift from O to O', so that no point at the distance L from O moves by
//! more than
//!
//! ```text
//!   |V' - V| L + m |e' - e|                                                                          (1)
//! ```
//!
//! and by the rotation about Q, of an angle of at most |t' - t| + |y' - y|, no point of distance l from Q by
//! more than that angle times l. In (1) a rotation by a moves a point by at most `2 sin(a/2) L = |V' - V| L`.
//! V and e are both unit vectors given by (polar angle, yaw), polar angles t and t + 90 degrees, and the
//! largest |V' - V| over a cell from its center is that of a corner: for a given tilt it grows with |y' - y|,
//! and for a given yaw difference up to 90 degrees V . V' is A cos(t' - f) with f in 0 .. 180 degrees, whose
//! least value over an interval of tilts is at one of its ends.
//!
//! *Near the contact* (1) would never end: the cutter touches there in every pose. A bull-nose is a
//! disk (the core) widened by r; Q lies on the core in every pose and all of the core above the
//! plane through Q across N. So Q is the nearest point of the core to every point of the ray from Q
//! against N. Nearest points of a convex core are no farther apart than what they are nearest to:
//! the nearest point P of the core to an obstacle X is no farther from Q than X is from that ray.
//! The distance f of X from the core changes by `df = g . (w x (X - Q))` with the unit vector g
//! from P to X, and (X - Q) - (P - Q) is along g, hence
//!
//! ```text
//!   |df| <= |w| |P - Q| <= |w| dist(X, ray from Q against N)                                         (2)
//! ```
//!
//! which is 0 at the contact. A ball does not change with the axis at all and is compared with the
//! solids once. The rest of a tool with a ball end turns about the ball's center as a body of
//! revolution, so that a place of a solid forbids a cap of axes about the direction in which it is
//! seen from there: `extent.rs` has the caps for every distance, `caps.rs` the search with them. It
//! needs a small part of the time of the general search, which is left to bull-noses and flat ends.
//!
//! # Proofs
//!
//! A cell is *free* when every piece of every solid has a distance from the tool in the pose at the cell's
//! center above what is asked for and the motion together; *blocked* when one point of a skin is nearer than
//! what is asked for less its motion. Pieces are the balls of a tree over the triangles, and triangles: a
//! plane that supports the convex body of revolution bounds their distance from below by the least height of
//! a corner over it. What is not decided goes to the four quarters of the cell, with the list of pieces that
//! are not yet apart. What is left at the finest cells is *unknown* and does not count as free.
//!
//! A tool that does not meet the skin of a solid could still be wholly inside of it: one point of
//! the tool near the contact is tested by its winding number.
//!
//! # The next contact
//!
//! The pose at (t', y') of a contact goes over to that of another contact by the rigid motion between their
//! frames. A piece at the distance l from Q then moves against the tool by at most
//!
//! ```text
//!   |Q' - Q| + |R' - R| l     (R' - R: 2 sin of half the angle of the rotation between the frames)   (3)
//! ```
//!
//! [`OrientationWalk`] proves the cells of one contact with (3) added for a neighborhood: what is
//! free or blocked there is so at all contacts of the neighborhood. Other cells keep their lists of
//! pieces and are decided again at each contact. A ball end is faster without: sixteen cells at
//! once are compared with the cap of a place of a solid, and only the fact that the tool lies
//! outside is kept of the previous contact.
//!
//! # Known limits
//!
//! The machine and its spindle are not checked. A bull-nose or flat end on a flat face leaves the
//! cells near tilt 0 unknown, where its bottom lies on the face, and costs several times as much as
//! a ball. The most work arises where the side of the tool lies along a face; a walk then saves
//! little. Nothing is stated between contacts. Faceted designs are taken as they are: give a gouge
//! allowance above the error of their chords.

mod ball_turn;
mod caps;
mod contact;
mod curvature;
mod cutter_end;
mod extent;
mod grid;
mod map;
mod obstacle_solids;
mod obstacle_spots;
mod packet;
mod search;
mod space;
mod tool_part;
mod walk;

pub use contact::{OrientationError, SurfaceContact};
pub use map::{AxisState, OrientationCell, OrientationMap, Refusal};
pub use space::{Obstacle, OrientationSettings, OrientationSpace};
pub use walk::OrientationWalk;

/// Balls are larger by this part, and by as much in mm, so that rounding leaves no corner out.
const BALL_ROUNDING: f64 = 1e-12;
/// Shorter vectors have no direction: zero alone.
const NOT_ZERO: f64 = 1e-300;
