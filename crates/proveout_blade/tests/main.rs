//! Integration tests of `proveout_blade`, one module a subject, in one program: it links once.

mod kinds;
mod meshes;
mod nearest;
mod sections;
