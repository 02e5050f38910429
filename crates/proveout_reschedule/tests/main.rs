//! Integration tests of `proveout_reschedule`, one module a subject, in one program: it links once.

mod blade_surface;
mod min_angular_acceleration;
mod multi_scale;
mod s_theta;
mod singularity;
mod smooth;
mod smooth_rows;
mod taut_string_lp;
