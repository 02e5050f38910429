//! Integration tests of `proveout_tool`, one module a subject, in one program: it links once.

mod cutters;
mod library;
