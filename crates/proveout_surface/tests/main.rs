//! Integration tests of `proveout_surface`, one module a subject, in one program: it links once.

mod between_rays;
mod blade;
mod deviation;
mod dong;
mod missing;
mod recall;
mod scallop;
mod scallop_measured;
mod texture;
mod texture_closed_forms;
mod texture_files;
mod texture_reference;
mod texture_report;
mod topography;
mod topography_motions;
