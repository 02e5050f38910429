//! Observers: Rerun, HTML report, glTF, Parquet, JSON.
#![allow(dead_code, unreachable_pub, reason = "the observers that use the file formats follow")]
mod color;
mod encode;
mod envelope;
mod error;
mod glb;
mod picture;
mod report;
mod table;
