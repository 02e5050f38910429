//! Scallop and strip width: from the geometry of the program at each contact, and measured on the cut
//! surface.
//!
//! * [`ball_scallop`], [`ball_step`] – two passes of a ball on plane, convex and concave surfaces in closed
//!   form.
//! * [`CutterContact`] – any convex cutter at one contact: curvatures, widths of the strip of the standing
//!   and of the moving cutter; [`scallop_between`] two of them.
//! * [`ridges`] – the [`Ridge`]s between passes on a cut stock, each found on the swept surfaces themselves,
//!   with the two adjacent valleys, the spacing, and the height that the geometry of both contacts gives.
//! * [`heights`], [`by_patch`], [`by_pass`], [`histogram`] – their figures.

mod closed;
mod contact;
mod ridges;
mod summary;
mod valley;

pub use closed::{ball_scallop, ball_step};
pub use contact::{CutterContact, scallop_between};
pub use ridges::{Ridge, RidgeSettings, Ridges, ridges};
pub use summary::{Heights, Histogram, PassHeights, PatchHeights, by_pass, by_patch, heights, histogram};
pub use valley::Valley;
