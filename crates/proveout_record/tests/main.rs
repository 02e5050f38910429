//! Integration tests of `proveout_record`, one module a subject, in one program: it links once.

mod player;
mod run_folder;
mod support;
