//! Integration tests of `proveout_machine`, one module a subject, in one program: it links once.

mod bad_input;
mod drive;
mod golden;
mod kinematics;
mod library;
mod urdf;
