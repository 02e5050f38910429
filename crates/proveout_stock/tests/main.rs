//! Integration tests of `proveout_stock`, one module a subject, in one program: it links once.

mod common;
mod depth;
mod engagement;
mod keep;
mod laws;
mod measure;
mod oracle;
mod parts;
mod patch_outline;
mod patches;
mod slices;
mod surface;
mod volume;
