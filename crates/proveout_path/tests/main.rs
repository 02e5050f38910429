//! Integration tests of `proveout_path`, one module a subject, in one program: it links once.

mod contact;
mod flank;
mod strategies;
mod studies;
