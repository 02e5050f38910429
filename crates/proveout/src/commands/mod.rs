//! One file a command.

mod advise;
pub(crate) mod blade;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod diff;
pub(crate) mod install;
pub(crate) mod job;
pub(crate) mod kinematics;
pub(crate) mod machine;
pub(crate) mod measure;
pub(crate) mod migrate;
pub(crate) mod nc;
pub(crate) mod new;
mod output_file;
mod pairing;
pub(crate) mod plan;
pub(crate) mod reader;
mod reports;
pub(crate) mod roughness;
pub(crate) mod run;
pub(crate) mod sweep;
pub(crate) mod tools;
pub(crate) mod verify;
pub(crate) mod view;
