//! Integration tests of `proveout_controller`, one module a subject, in one program: it links once.

mod against_copp;
mod bad_numbers;
mod closed_forms;
mod commands;
mod common;
mod control_parameters;
mod difference;
mod drive;
mod fit;
mod holes;
mod library_drives;
mod limits;
mod optimum;
mod path_and_time;
mod pieces;
mod platform_drives;
mod poles;
mod positions;
mod real_program;
mod rigid_bodies;
mod sample_limits;
mod schedule_bound;
mod servo_run;
mod streaming;
mod tcp;
mod turned_frame;
