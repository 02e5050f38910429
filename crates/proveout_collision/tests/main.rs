//! Integration tests of `proveout_collision`, one module a subject, in one program: it links once.

mod common;
mod events;
mod free_turns;
mod interference;
mod least;
mod needles;
mod neighbors;
mod orientation;
mod stock_events;
mod tool_clearance;
