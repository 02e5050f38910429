//! The Python module `proveout._proveout`: the twin as Python calls it.
//!
//! Thin: each function takes plain values, calls what the command line calls ([`proveout::front`]) and gives
//! plain values back. Names, dataclasses and defaults for people are those of the Python package round it
//! (`python/proveout`).
//!
//! | module | does | data out |
//! |---|---|---|
//! | `work` | runs a long task apart from the interpreter: signals, progress, panics | |
//! | `watcher` | an observer that reports progress, ends a run, keeps the surface | |
//! | `runs` | prove-outs and comparisons | run folder, `Part`, height maps |
//! | `tables` | Parquet files and canonical commands as Arrow | `Table`, `__arrow_c_stream__` |
//! | `arrays` | numbers as read-only numpy arrays, without a copy | |
//! | `kinematics` | joints and tool poses | numpy, mm and degrees |
//! | `programs` | planned and re-scheduled programs, NC text | text, JSON, tables |
//! | `scenes` | what a scene holds, and copies of it with other values | |
//! | `errors` | faults as exceptions of `proveout.errors` | |
//!
//! Known limits: a run that is broken off ends at the next batch of the engine, some seconds of simulated
//! time later; planning and reading are not broken off.

mod arrays;
mod errors;
mod kinematics;
mod programs;
mod runs;
mod scenes;
mod tables;
mod watcher;
mod work;

#[pyo3::pymodule]
mod _proveout {
    use std::ffi::OsString;

    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        kinematics::PyKinematics,
        programs::{plan, read_nc, reschedule},
        runs::{CutPart, compare, run},
        scenes::{scene_copy, scene_facts},
        tables::{Table, read_parquet},
    };

    /// Does what a command line says; the exit code. The first word is the name of the program.
    #[pyfunction]
    fn call(py: Python<'_>, words: Vec<OsString>) -> u8 {
        py.detach(|| proveout::call(words))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("records_rerun", cfg!(feature = "rerun"))
    }
}
