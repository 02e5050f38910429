//! Scallop and strip width: from the geometry of the program at each contact, and measured on the cut surface.
//!
//! * [`ball_scallop`], [`ball_step`] – two passes of a ball on plane, convex and concave surfaces in closed form.
//! * [`CutterContact`] – any convex cutter at one contact: curvatures, widths of the strip of the standing and of the moving cutter;
//!   [`scallop_between`] two of them.

mod closed;
mod contact;

pub use closed::{ball_scallop, ball_step};
pub use contact::{CutterContact, scallop_between};
