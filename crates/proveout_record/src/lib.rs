//! Observers of a prove-out run: they write the files of a run folder and the recording for the Rerun viewer.
//!
//! Each file format is a function over plain data (rows, mesh, page); each observer gathers that data while
//! the run goes on. The engine knows none of them. This is the only crate that uses the `rerun` library
//! (feature `rerun`, on by default; without it everything else still builds).
//!
//! # Data in and out
//!
//! In: [`Setup`], [`Batch`], [`Outcome`] of `proveout_sim`; mm, radian, second. Out, in the run folder, each
//! file with its observer, content, frame and units:
//!
//! - `verdict.json` ([`JsonObserver`]): the verdict as it is
//! - `NAME.mpf` ([`ProgramObserver`]): the text that runs, where a re-scheduled program was made
//! - `run.json` ([`write_run_json`]): [`RunInfo`]: times, memory, versions, host
//! - `signals.parquet`, `blocks.parquet` ([`TableObserver`]): a row a control sample, a row a block; tip and
//!   axis in W; the unit ends each column's name and is its field metadata
//! - `surface.parquet` ([`TableObserver`]): exact surface points in W, mm, with normal, deviation, scallop,
//!   making piece, patch; nodes of the roughness maps with their heights
//! - `stock.dexel`, `stock-patch-NAME.dexel` ([`StockObserver`]): the stock that is left and its patches, bit
//!   for bit, as raw stock of the next setup; W, mm
//! - `part.glb`, `deviation.glb` ([`GltfObserver`]): extracted surface; vertices in W, mm; the root node
//!   turns to meter, Y up
//! - `clearance.parquet` ([`ClearanceObserver`]): spans of time that prove the least clearance of every pair
//!   of bodies
//! - `maps/NAME.png`, `.sdf`, `.x3p` ([`MapFilesObserver`]): roughness maps that are cut at all nodes:
//!   picture with color bar, and files of ISO 25178-71 and -72
//! - `roughness.glb` ([`MapFilesObserver`]): roughness maps colored by height, where the scene asks for them
//! - `report.html` ([`ReportObserver`]): one page without any load from elsewhere
//! - `inspection.csv`, `inspection.qif` ([`ReportObserver`]): the measured features, where the scene has
//!   some; QIF 3.0
//! - `setup.html` ([`SetupSheetObserver`]): zero point, clamping, tools, stops, with pictures, to be printed
//! - `compare.json`, `compare.html` ([`compare::write_comparison`]): several programs side by side, one page
//! - `job.json`, `job.html` ([`write_job`]): the setups of a job, one page
//! - `sweep.parquet`, `.csv`, `.json`, `.html` ([`merge_sweep`]): a row a job of a sweep, one page
//! - a file as named ([`write_engagement_table`]): engagement and loads along the path, by slices of the
//!   cutter
//! - a file as named ([`write_section_svg`], [`write_section_csv`]): a section of a stock, in the plane and
//!   in W, mm
//! - a file as named ([`exchange::sarif()`], [`exchange::junit()`]): findings and gates for other programs
//! - a file as named ([`machine_png`]): a machine at home with its axes and bodies
//! - a file as named ([`write_height_map_png`]): a height map with color bar, units, direction of the lay
//! - `recording.rrd` ([`RerunObserver`]): machine, tool, stock, signals, findings on the timeline `sim_time`
//!
//! [`observers`] gives all of them. `verdict.json`, the tables, the glTF files and the page are functions of
//! the run alone: same run, same bytes. `run.json` and the recording (which carries random ids) are not.
//!
//! # Methods
//!
//! * Colors of deviations: [`DeviationMap`], straight in `OKLab` (Ottosson 2020).
//! * Reduction of large meshes: vertex clustering (Rossignac and Borrel 1993) with quadric placement
//!   (Lindstrom 2000).
//! * The page: findings by cause, the part in three dimensions whose vertices know the line that cut them,
//!   the path by block; bytes compressed, scripts in the page.
//! * Plots of the page: smallest and largest value of equal stretches of time, which double as the run grows.
//! * Tables: Parquet, zstd, real columns as byte streams split by weight, row groups of 65 536.
//!
//! # Known limits
//!
//! * Pictures are reduced: 2 million triangles in glTF, 400 000 in the recording, 200 000 on the page; each
//!   says so.
//! * The stock of the recording is coarser than the stock itself and is shown at up to 64 times and at tool
//!   changes.
//! * Roughness maps are thinned for glTF, recording and page; all nodes are in `surface.parquet`.
//!
//! [`Setup`]: proveout_sim::observer::Setup
//! [`Batch`]: proveout_sim::observer::Batch
//! [`Outcome`]: proveout_sim::observer::Outcome
//!
//! # Files
//!
//! | file or folder | holds |
//! |---|---|
//! | `all_observers.rs` | the observers of a run, together |
//! | `json.rs`, `tables.rs`, `parquet_table.rs`, `clearance.rs` | JSON files, Parquet tables |
//! | `part.rs`, `picture.rs`, `surface_picture.rs`, `glb.rs`, `mesh_file.rs` | the cut part as glTF; meshes |
//! | `engagement.rs` | engagement and loads along the path |
//! | `stock.rs`, `section.rs` | stock files; sections of a stock |
//! | `roughness_map.rs`, `roughness_files.rs`, `roughness_picture.rs` | roughness maps |
//! | `inspection.rs`, `qif.rs`, `qif/` | measured features: CSV, QIF |
//! | `exchange/` | results as SARIF and JUnit XML |
//! | `in_process/` | stock and tool at moments of the run, for recording and player |
//! | `recording/`, `rerun_mode.rs` | the recording for the Rerun viewer; where it goes |
//! | `report/` | `report.html`: findings, part, path, signals |
//! | `setup_sheet/` | `setup.html` |
//! | `compare/` | `compare.json`, `compare.html` and drawings |
//! | `chart/` | charts of the pages as SVG |
//! | `contact/` | pictures of first contacts |
//! | `job_page.rs`, `sweep.rs` | results of a job, of a sweep |
//! | `free_axes.rs`, `program.rs` | free tool axes along a program; text of a re-scheduled program |
//! | `page_template.rs`, `page_scripts.rs`, `page_encoding.rs` | templates, scripts, bytes as text |
//! | `canvas.rs`, `font.rs`, `projection.rs`, `color.rs`, `machine_picture.rs` | drawing of PNG pictures |
//! | `deviation_classes.rs`, `envelope.rs`, `units.rs` | bounded counts and signals; units of files |
//! | `error.rs` | why a file could not be written |

mod all_observers;
mod canvas;
mod chart;
mod clearance;
mod color;
pub mod compare;
mod contact;
mod deviation_classes;
mod engagement;
mod envelope;
mod error;
pub mod exchange;
mod font;
mod free_axes;
mod glb;
mod in_process;
mod inspection;
mod job_page;
mod json;
mod machine_picture;
mod mesh_file;
mod page_encoding;
mod page_scripts;
mod page_template;
mod parquet_table;
mod part;
mod picture;
mod program;
mod projection;
mod qif;
#[cfg(feature = "rerun")]
mod recording;
mod report;
mod rerun_mode;
mod roughness_files;
mod roughness_map;
mod roughness_picture;
mod section;
mod setup_sheet;
mod stock;
mod surface_picture;
mod sweep;
mod tables;
mod units;

pub use all_observers::observers;
pub use clearance::ClearanceObserver;
pub use color::{DeviationMap, Rgba};
pub use engagement::write_engagement_table;
pub use error::RecordError;
pub use free_axes::FreeAxesObserver;
pub use job_page::write_job;
pub use json::{CheckCounts, JsonObserver, RunInfo, StageTimes, write_json, write_run_json};
pub use machine_picture::machine_png;
pub use mesh_file::write_mesh;
pub use part::{GltfObserver, write_part_files};
pub use program::ProgramObserver;
#[cfg(feature = "rerun")]
pub use recording::{RecordedEntity, RerunObserver, read_recording};
pub use report::ReportObserver;
pub use rerun_mode::{RECORDING_FILE, RerunMode};
pub use roughness_files::MapFilesObserver;
pub use roughness_picture::{height_map_png, write_height_map_png};
pub use section::{write_section_csv, write_section_svg};
pub use setup_sheet::SetupSheetObserver;
pub use stock::{StockObserver, write_stock};
pub use sweep::{Fastest, MergeError, SweepSummary, merge_sweep};
pub use tables::{TableObserver, write_surface_table};
