//! Cutting tools: what cuts (cutter and flutes), what must not touch (neck, shank, holder), and the library
//! files that describe them.
//!
//! Every part of a tool assembly is a convex body of revolution about the tool axis. Its generating curve is
//! a [`Profile`] of lines and circular arcs in the half plane (r, z), mm: z = 0 at the programmed tip, +z
//! towards the holder. Frame T: origin at the tip, +z along the axis away from the tip.
//!
//! * [`Profile`] – exact generating curve; distance, normal, curvature, radius at a height, volume.
//! * [`Body`] – profile and [`Role`].
//! * [`Tool`] – assembly with gauge length, flute length and technology limits.
//! * [`Cutter`] – cutting ends by catalogue dimensions; [`ToolBuilder`] puts neck, shank and holder on them.
//! * [`ToolLibrary`] – reads library files (TOML); [`library_schema`] publishes their JSON Schema.
//!
//! * [`import_tools`] – libraries of other programs as [`ToolDraft`]s, which [`library_text`] writes as a
//!   library file.
//!
//! A part that is not convex is divided by planes across the axis where its curve turns outward again. The
//! bodies of a tool follow one another from the tip to the gauge line without gap.
//!
//! * [`Thread`] – what a tap cuts outside of its core hole.
//! * [`CuttingEdges`] – the teeth where they are described: helix, run-out, round inserts, rake.
//!
//! Known limits: a cutter is the body that its edges sweep; relief is not described, and all teeth have
//! equal pitch. Arcs are convex; a concave fillet between shank and neck is given as short cones.
//!
//! # Files
//!
//! | file or folder | holds |
//! |---|---|
//! | `profile`, `outline` | generating curves, and their division into convex bodies |
//! | `cutter`, `edges`, `thread`, `residual` | what cuts: shapes, teeth, threads, residual marks |
//! | `assembly`, `builder`, `holder` | cutter, neck, shank and holder together; how far the tool projects |
//! | `library`, `library_file`, `entry` | library files and their JSON Schema |
//! | `draft`, `import` | tools from files of other programs |

mod assembly;
mod builder;
mod cutter;
mod draft;
mod edges;
mod entry;
mod holder;
mod import;
mod library;
mod library_file;
mod outline;
mod profile;
mod residual;
mod thread;

pub use assembly::{Body, Role, Tool, ToolId};
pub use builder::ToolBuilder;
pub use cutter::{Apt, Cutter, ShapeError};
pub use draft::{PlainHolder, ToolDraft, library_text, plain_number, quoted};
pub use edges::{CuttingEdges, RakeAbout, RoundInsert, RunOut};
pub use entry::library_schema;
pub use holder::HolderSection;
pub use import::words::{
    SubstituteBody, center_cutting_of as tool_center_cutting_of_words, flutes_of as tool_teeth_of_words,
    kind_of as tool_kind_of_words,
};
pub use import::{ImportCall, Imported, LengthUnit, import_tools};
pub use library::{ToolLibrary, ToolNotes};
pub use profile::{Profile, ProfileError, Segment, SkinPoint};
pub use residual::Residual;
pub use thread::{Thread, ThreadSize, coarse_pitch, thread_of};
