//! Integration tests of `proveout_geom`, one module a subject, in one program: it links once.

mod blade_kinds;
mod blade_meshes;
mod blade_sections;
mod nearest_on_blade;
