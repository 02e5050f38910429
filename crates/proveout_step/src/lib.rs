//! STEP files as closed meshes with a measured chord error.
//!
//! A CAD kernel reads the exact surfaces. It runs as a process of its own, `proveout-step`, with limits of
//! time and memory, and writes three files ([docs/step.md](../../../docs/step.md) describes them). Nothing in
//! these files is trusted:
//!
//! ```text
//!  part.step ──┬─► proveout-step ─► mesh.json, mesh.bin, samples.bin
//!              │                          │
//!              └─► faces, solids, unit ───┴─► complete? closed? volume? distances ─► StepMesh
//!                  counted in the text
//! ```
//!
//! Data in: the path of a STEP file (AP203, AP214, AP242) and the chord error that is asked for, mm. Data
//! out: a [`StepMesh`] in millimeters, in the coordinates of the file, or a [`StepError`] with its remedy.
//!
//! * [`StepFiles`] – the files that one command has read, so that the helper runs once for each.
//! * [`StepMesh`] – the mesh with its chord error, and what was counted.
//! * [`StepText`] – faces, solids and unit, as the text itself has them.
//! * [`Helper`] – where the program is, and its limits.
//!
//! **Checks.** Every `ADVANCED_FACE` and every solid of the text is in the mesh, or there is an error. Each
//! solid is closed and oriented. Its volume is that of the exact surfaces, within area times chord error. The
//! chord error is the largest distance of exact points from the mesh, with the factor of [`QUADRATIC`].
//!
//! **Limits.** The error between the points is bounded where the surface is quadratic over a triangle; other
//! surfaces are sampled. Faces outside of solids are named and left out. A file that counts in two units is
//! refused.
//!
//! | file | holds |
//! |---|---|
//! | `text.rs`, `scan.rs`, `units.rs` | what the text says: instances, records, faces, solids, length unit |
//! | `helper.rs` | finds the program, runs it, ends it at its limits |
//! | `answer.rs` | the three files, checked against their own lengths |
//! | `distance.rs` | largest distance of points from a mesh |
//! | `step_mesh.rs` | all of it together |
//! | `step_error.rs` | what is refused, with its remedy |

mod answer;
mod distance;
mod helper;
mod scan;
mod step_error;
mod step_mesh;
mod text;
mod units;

pub use helper::{Helper, VARIABLE};
pub use step_error::StepError;
pub use step_mesh::{CHORD_UM, DEFAULT_CHORD_UM, QUADRATIC, StepFiles, StepMesh, is_step};
pub use text::{StepFace, StepText};
pub use units::LengthUnit;
