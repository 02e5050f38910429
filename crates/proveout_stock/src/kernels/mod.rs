//! How a moving body meets rays: closed forms, searches for one ray and for several at once.

#[cfg(test)]
mod kernel_tests;
pub(crate) mod lane_ball;
pub(crate) mod lane_bits;
pub(crate) mod lane_blocks;
pub(crate) mod lane_body;
pub(crate) mod lane_sample;
pub(crate) mod lane_search;
pub(crate) mod lane_set;
#[cfg(test)]
mod lane_tests;
pub(crate) mod lanes;
pub(crate) mod meridian;
pub(crate) mod motion;
pub(crate) mod ray;
pub(crate) mod ray_ball;
pub(crate) mod ray_translate;
pub(crate) mod ray_turn;
pub(crate) mod sweep_step;
pub(crate) mod vec3;
