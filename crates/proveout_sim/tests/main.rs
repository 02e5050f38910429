//! Integration tests of `proveout_sim`, one module a subject, in one program: it links once.

mod between_rays;
mod design_between_rays;
mod judging;
mod li_2022;
mod li_2022_bad_input;
mod loose_parts;
mod next_setup;
mod patches;
mod probing;
mod rescheduling_interface;
mod roughness_maps;
