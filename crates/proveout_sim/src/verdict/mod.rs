//! What a run says: findings, gates and figures, as data. Nothing here measures or judges.
//!
//! | file | what it does |
//! |---|---|
//! | `finding.rs` | finding codes, families, severities, where a limit comes from |
//! | `gate.rs` | the eight gates |
//! | `gates.rs` | from findings and what is unchecked to the gates |
//! | `log.rs` | findings as they come in, joined block by block |
//! | `partial_run.rs` | in what a run is less than the whole check |
//! | `scallop_figures.rs` | figures of the scallop |
//! | `surface_words.rs` | what was evaluated of the surface, in words |
//! | `verdict_file.rs` | `verdict.json` |

pub mod finding;
pub mod gate;
pub mod gates;
pub mod log;
pub(crate) mod partial_run;
pub(crate) mod scallop_figures;
pub(crate) mod surface_words;
pub(crate) mod verdict_file;

pub use self::gate::{Gate, PerGate};
pub use self::verdict_file::{
    AnalyticUsed, Axis, AxisUnit, BlockShare, Clearance, Deviation, GateVerdict, Inspected, MachineUsed, PairClearance,
    Partial, PatchUsed, Path, PhaseSpread, PreviewUsed, Probed, ProfileUsed, Removal, ResidualUsed, SCHEMA_VERSION,
    Scallop, ScallopBar, ScallopHeights, ScallopPass, ScallopPatch, ScallopRegion, Spread, State, Stopped, Surface,
    TextureUsed, Time, ToolUse, UncheckedPair, Verdict,
};
