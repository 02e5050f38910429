//! Cutting tools: what cuts (cutter and flutes), what must not touch (neck, shank, holder), and the library files that
//! describe them.
//!
//! Every part of a tool assembly is a convex body of revolution about the tool axis. Its generating curve is a
//! [`Profile`] of lines and circular arcs in the half plane (r, z), mm: z = 0 at the programmed tip, +z towards the
//! holder. Frame T: origin at the tip, +z along the axis away from the tip.
//!
//! * [`Profile`] – exact generating curve; distance, radius at a height.
//! * [`Body`] – profile and [`Role`].
//! * [`Tool`] – assembly with gauge length, flute length and technology limits.

mod assembly;
mod profile;

pub use assembly::{Body, Role, Tool, ToolId};
pub use profile::{Profile, ProfileError, Segment};
