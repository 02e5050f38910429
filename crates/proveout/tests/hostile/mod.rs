//! Bad days and hostile files, typed as a person types them: bounded in time and memory whatever the input,
//! nothing of anybody lost, evidence that holds. `docs/hostile-input.md` has the list.

mod before;
mod bounds;
mod chains;
mod evidence;
mod kept;
mod kills;
#[cfg(target_os = "linux")]
mod long;
mod meshes;
mod mutation;
mod one_reader;
mod same_bytes;
mod sizes;
pub(crate) mod workshop;
