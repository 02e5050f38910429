//! Roughness maps: the surface that a run leaves on patches of its design, and what it says of Ra and Rz.
//!
//! ```text
//!   [surface] of the scene ──► Plan (places on design)       before the run: refused where a place is none
//!   motion of the run ───────► Recorder (pieces near places) during the run
//!   both ────────────────────► SurfaceTexture, one a place   after it: heights, parameters, doubts
//!                                   └──► observers, verdict, judgement of ra_um and rz_um
//! ```
//!
//! `Plan` lies in `prepare/texture_plan.rs`, `Recorder` in `cut/texture_motion.rs`, `SurfaceTexture` in
//! `observe/surface_texture.rs`; what is here runs after the motion.
//!
//! Heights come from [`proveout_surface::topography`], exact for the pieces of motion; parameters
//! from [`proveout_surface::texture`]. What a value depends on is given with it. What could not be
//! evaluated is named, and then Ra and Rz are unchecked.

mod analytic;
mod doubts;
mod evaluate;
mod roughness;
mod toothless;

pub(crate) use evaluate::evaluate;
pub(crate) use roughness::judge;
