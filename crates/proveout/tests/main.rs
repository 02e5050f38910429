//! Integration tests of `proveout`, one module a subject, in one program: it links once.

mod asked_and_stated;
mod bad_input;
mod blade;
mod blade_kinds;
mod collision;
mod command_lines;
mod compensation;
mod controls;
mod feeds;
mod first_part;
mod free_axes;
mod hostile;
mod jobs;
mod measure;
mod memory;
mod one_judgement;
mod overhang;
mod partial;
mod plan;
mod positions;
mod programs;
mod report_page;
mod reschedule;
mod reschedule_smooth;
mod roughness;
mod scallop;
mod schedule_recording;
#[cfg(unix)]
mod step;
mod sweep;
mod texture;
mod tilted_planes;
