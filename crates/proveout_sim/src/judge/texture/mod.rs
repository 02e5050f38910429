//! Roughness maps: the surface that a run leaves on patches of its design, and what it says of Ra and Rz.
//!
//! ```text
//!   [surface] of the scene ──► Plan (places on the design)        before the run: refused where a place is none
//!   motion of the run ───────► Recorder (pieces near the places)  during the run
//!   both ────────────────────► SurfaceTexture, one a place        after it: heights, parameters, doubts
//!                                   └──► observers, verdict, judgement of ra_um and rz_um
//! ```
//!
//! Heights come from [`proveout_surface::topography`], exact for the pieces of motion; parameters
//! from [`proveout_surface::texture`]. What a value depends on is given with it. What could not be
//! evaluated is named, and then Ra and Rz are unchecked.

mod analytic;
mod doubts;
mod evaluate;
mod roughness;
mod toothless;

use std::sync::Arc;

use proveout_geom::{Point, Step::Key, TriMesh, Vector, blade::FOOT_ERROR_MM};
use proveout_surface::{
    DesignMesh, DesignSurface,
    texture::{Profile, SettingClass},
};
use proveout_tool::ToolLibrary;

pub(crate) use evaluate::evaluate;
pub(crate) use roughness::judge;

use crate::{
    prepare::{
        error::SimError,
        part_shape::{Shape, flank},
        texture_places::{Ground, Place, Refused},
        texture_plan::Area,
    },
    scene::{ProfileDirectionFile, Scene, SurfaceFile, surface::Middle},
    units::MM_PER_UM,
};

