//! Scenes, the prove-out loop, findings, gates, observers: the one place that knows all parts of the twin.
//!
//! A [`Scene`](scene::Scene) names machine, tools, stock, mounting, design, fixtures, offsets and
//! programs. [`Prepared`] reads and checks all of it; [`run`](run::run) executes the program
//! stretch by stretch: the controller yields motion, the stock is swept, bodies are checked,
//! [`Finding`](finding::Finding)s are collected, the cut part is measured, and the
//! [`Verdict`](verdict::Verdict) says pass, fail or unchecked for every gate. [`Observer`]s see
//! everything; this crate itself writes no file except the frame of the run folder.
//!
//! | folder or file | what it does |
//! |---|---|
//! | `scene/` | the scene file: one file a table of it |
//! | `prepare/` | from a scene to `Prepared`: all files read and checked |
//! | `cut/` | one stretch of motion: stock, bodies, parts that come off |
//! | `checks/` | checks on motion and cuts |
//! | `judge/` | the cut part against design and tolerances, up to the verdict |
//! | `run/` | the main loop, shards, partial runs, questions to a finished run |
//! | `batch/` | jobs of several setups, sweeps of many values |
//! | `evidence/` | manifest, digests, signature, run folder |
//! | `observe/` | what observers get |
//! | `verdict/` | findings, gates and figures as data |
//! | `feeds/` | feeds of a program under the limits of its tools |
//! | `compare/` | programs side by side, certificates of a schedule |
//! | `setup/` | a scene from a program, causes known before a run |
//! | `units.rs` | factors between the units inside and those of files |
//! | `latin_hypercube.rs` | draws for sweeps and comparisons |
//!
//! Frames: workpiece W of the scene (stock, part, inspection), table K (fixtures, motion pieces), machine M
//! (joints). Millimeter, radian, second inside; files carry units in their keys.
//!
//! Known limits: one setup a run ([`job`] hands the stock on from one to the next); drive loads leave
//! workpiece, tool and cutting forces out.

mod batch;
mod checks;
pub mod compare;
mod cut;
mod evidence;
pub mod feeds;
mod judge;
mod latin_hypercube;
mod observe;
mod prepare;
pub mod run;
pub mod scene;
mod setup;
mod units;
pub mod verdict;

pub use batch::{job, sweep};
pub use checks::engagement::Engagement;
pub use compare::{certificate, schedule};
pub use cut::engaged_samples::{EngagedSample, EngagedSlice};
pub use cut::journal;
pub use evidence::digest;
pub use evidence::manifest::{MANIFEST, Manifest, ManifestError, Verified, verify};
pub use evidence::run_folder::{Committed, RunFolder};
pub use evidence::signature::{SIGNATURE, SignatureError, check_signature, sign};
pub use judge::free_axes;
pub use observe::observer;
pub use observe::observer::Observer;
pub use observe::surface_texture::{Maker, SurfaceTexture, TextureMap, TextureProfile};
pub use observe::{
    surface_keeper::SurfaceKeeper,
    surface_map::{MapPoint, PatchMap, PatchShape, SurfaceMap, SurfaceShape},
};
pub use prepare::control_file::{control_of, settings_on};
pub use prepare::error::SimError;
pub use prepare::machine_data::with_machine;
pub use prepare::made_program::MadeProgram;
pub use prepare::memory::{MEMORY, Memory, Recorded};
pub use prepare::part_on_table::PartOnTable;
pub use prepare::part_shape::{BladeMesh, blade_mesh_of};
pub use prepare::planning;
pub use prepare::prepared::Prepared;
pub use prepare::raw_stock::{RawStock, STOCK_FILE, patch_file};
pub use prepare::reader_settings::tool_radii;
pub use prepare::reading::Reading;
pub use prepare::set_value::SetValue;
pub use proveout_collision::{AxisState, OrientationCell};
pub use proveout_input::{InputError, Migration, migrate, nearest as nearest_word, read_input, read_regular_text};
pub use run::{listing, measure, overhang, partial, shards};
pub use setup::{first_part, preflight};
pub use verdict::{finding, gates, log};
pub use {
    prepare::choice::{Choice, StockChoice},
    scene::stock::resolution_fault,
};

/// STEP files: where their helper is, and what it reads.
pub mod step {
    pub use proveout_step::{DEFAULT_CHORD_UM, Helper, StepError, StepFiles, StepMesh, VARIABLE, is_step};
}

/// Programs that are made: a pass over the blade of the scene, and re-scheduled programs.
pub mod programs {
    pub use crate::{
        compare::remade::Remade,
        prepare::programs::{Original, Rescheduling, helix, rescheduled, text},
    };
}
