//! Scenes, the prove-out loop, findings, gates, observers: the one place that knows all parts of the twin.
//!
//! A [`Scene`](scene::Scene) names machine, tools, stock, mounting, design, fixtures, offsets and
//! programs. [`Prepared`] reads and checks all of it; [`run`](run::run) executes the program
//! stretch by stretch: the controller yields motion, the stock is swept, bodies are checked,
//! [`Finding`](finding::Finding)s are collected, the cut part is measured, and the
//! [`Verdict`](verdict::Verdict) says pass, fail or unchecked for every gate. [`Observer`]s see
//! everything; this crate itself writes no file except the frame of the run folder.
//!
//! Frames: workpiece W of the scene (stock, part, inspection), table K (fixtures, motion pieces), machine M (joints).
//! Millimeter, radian, second inside; files carry units in their keys.
//!
//! Known limits: one setup a run ([`job`] hands the stock on from one to the next); drive loads leave workpiece, tool and cutting forces out.

pub mod certificate;
pub mod compare;
mod control_file;
mod control_settings;
mod cuts;
pub mod finding;
pub mod first_part;
mod fixture_bodies;
mod fixtures;
pub mod gates;
pub mod job;
pub mod listing;
pub mod log;
pub mod measure;
pub mod observer;
pub mod overhang;
pub mod planning;
pub mod programs;
pub mod run;
pub mod scene;
mod scene_asked;
mod scene_blade;
mod scene_choice;
mod scene_compare;
mod scene_control;
mod scene_fixture;
mod scene_inspect;
mod scene_limits;
mod scene_numbers;
mod scene_part;
mod scene_patch;
mod scene_place;
mod scene_plan;
mod scene_program;
mod scene_reschedule;
mod scene_run_limits;
mod scene_setup;
mod scene_stock;
mod scene_surface;
mod scene_tolerance;
mod set_values;
pub mod shards;
pub mod sweep;
pub mod verdict;

mod between;
mod between_rays;
mod block_slope;
mod bodies;
mod choice;
mod damage;
mod design;
pub mod digest;
mod engagement;
mod engine;
mod error;
pub mod free_axes;
mod inputs;
mod inspect;
pub mod journal;
mod judge;
mod kept_motion;
mod legs;
mod loose;
mod machine_data;
mod made_program;
mod manifest;
mod memory;
mod mesh_unit;
mod names;
mod part_mesh;
mod part_on_table;
pub mod partial;
mod plunge;
pub mod preflight;
mod prepare;
mod process;
mod program_survey;
mod program_text;
mod raw_shape;
mod raw_stock;
mod reader_settings;
mod readings;
mod run_folder;
mod scallop;
mod scallop_figures;
mod scallop_judge;
pub mod schedule;
mod shape;
mod show_mesh;
mod signature;
mod stock_bodies;
mod stock_on_rays;
mod surface_gate;
mod surface_map;
mod survey;
mod tap_pitch;
mod texture;
mod thread_strokes;
mod tools_of_run;
mod units;
mod unstated;

pub use choice::{Choice, StockChoice, resolution_fault};
pub use control_file::{control_of, settings_on};
pub use engagement::Engagement;
pub use error::SimError;
pub use machine_data::with_machine;
pub use made_program::MadeProgram;
pub use manifest::{MANIFEST, Manifest, ManifestError, Verified, verify};
pub use memory::{Memory, Recorded};
pub use observer::Observer;
pub use part_on_table::PartOnTable;
pub use prepare::Prepared;
pub use proveout_collision::{AxisState, OrientationCell};
pub use proveout_geom::{InputError, nearest as nearest_word, read_regular_text};
pub use raw_stock::{RawStock, STOCK_FILE, patch_file};
pub use reader_settings::tool_radii;
pub use readings::Reading;
pub use run_folder::{Committed, RunFolder};
pub use set_values::SetValue;
pub use shape::{BladeMesh, blade_mesh_of};
pub use signature::{SIGNATURE, SignatureError, check_signature, sign};
pub use surface_map::{MapPoint, PatchMap, PatchShape, SurfaceKeeper, SurfaceMap, SurfaceShape};
pub use texture::{Maker, SurfaceTexture, TextureMap, TextureProfile};
