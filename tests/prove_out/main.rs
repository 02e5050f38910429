//! Whole prove-outs of the scenes, at coarse cells where the judged quantity does not depend on them.

#![allow(clippy::print_stdout, reason = "a test that was left out says so")]

mod axis_cross;
mod compare;
mod cone_frustum;
mod control;
mod languages;
mod li_2022;
mod poles;
mod tool_list;
