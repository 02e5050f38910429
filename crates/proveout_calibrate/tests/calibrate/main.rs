//! Estimators on the twin as plant, whose truth is known; bad input; air programs of the library.

mod air;
mod bad_input;
mod machine_file;
mod plant;
mod truth;
