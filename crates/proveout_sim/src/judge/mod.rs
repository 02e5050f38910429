//! The cut part against design and tolerances, and the facts of the run against the gates, up to the verdict.
//!
//! | file | what it does |
//! |---|---|
//! | `design.rs` | the design that the cut part is compared with |
//! | `excess_between_rays.rs` | gouges and excess between the rays of the stock |
//! | `final_verdict.rs` | from the cut part and the facts of the run to the verdict |
//! | `free_axes.rs` | collision-free tool axes at contacts of the motion |
//! | `gouge_findings.rs` | findings for gouges, excess, fins and threads |
//! | `probe_inspection.rs` | the inspection plan: touches and walls |
//! | `scallop.rs` | ridges between passes |
//! | `scallop_limits.rs` | ridges against `[tolerances] scallop_um` |
//! | `surface_gate.rs` | the gate `surface` |
//! | `surface_survey.rs` | the cut part compared with the design, band by band |
//! | `text_not_run.rs` | text of a program that its run does not reach |
//! | `texture/` | roughness maps: Ra and Rz of patches and profiles |
//! | `unstated.rs` | what gates leave unchecked since no file states it |

pub(crate) mod design;
pub(crate) mod excess_between_rays;
pub(crate) mod final_verdict;
pub mod free_axes;
pub(crate) mod gouge_findings;
pub(crate) mod probe_inspection;
pub(crate) mod scallop;
pub(crate) mod scallop_limits;
pub(crate) mod surface_gate;
pub(crate) mod surface_survey;
pub(crate) mod text_not_run;
pub(crate) mod texture;
pub(crate) mod unstated;
