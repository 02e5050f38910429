//! Whole prove-outs of the scenes, at coarse cells where the judged quantity does not depend on them.

#![allow(clippy::print_stdout, reason = "a test that was left out says so")]

mod actual_machine;
mod axis_cross;
mod bench;
mod coarse;
mod compare;
mod cone_frustum;
mod control;
mod dong_2023;
mod experiments;
mod feed_and_rapid;
mod holes;
mod languages;
mod li_2022;
mod lu_2022;
mod planned;
mod planned_kinds;
mod plunge;
mod poles;
mod stock_and_machine;
mod tool_list;
