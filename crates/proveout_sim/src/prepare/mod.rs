//! Everything that a run needs, read and checked before the first motion.
//! In: a scene, the files that it names, and what the call chooses. Out: [`Prepared`](crate::Prepared).
//!
//! | file | what it does |
//! |---|---|
//! | `choice.rs` | what the call chooses in addition to the scene |
//! | `control_file.rs` | which control reads a program |
//! | `control_settings.rs` | settings of the motion controller |
//! | `depth_gauge.rs` | the depth of a cut under a ball |
//! | `error.rs` | `SimError`: why a run cannot be made |
//! | `fixture_bodies.rs` | meshes of fixtures that are given by dimensions |
//! | `fixtures.rs` | fixtures and platforms in the table frame |
//! | `machine_data.rs` | reference points and kinematics for the reader |
//! | `made_program.rs` | `MadeProgram`: the text that runs instead of a program |
//! | `memory.rs` | the memory of a run, announced before the stock is made |
//! | `motion_only.rs` | motion of a program without stock |
//! | `part_mesh.rs` | the mesh of a design |
//! | `part_on_table.rs` | what re-scheduling asks about the part |
//! | `part_shape.rs` | the part as a closed form |
//! | `planning.rs` | paths over a blade that the scene plans |
//! | `prepared.rs` | `Prepared`: what a run needs |
//! | `preview.rs` | `--preview`: coarse cells, and what else is left out |
//! | `program_extent.rs` | what a program does, from one pass of its reader |
//! | `program_source.rs` | what a program is made from, and the making |
//! | `program_survey.rs` | whether all that a program names exists |
//! | `program_text.rs` | which program runs, and its text |
//! | `program_trace.rs` | where a program takes its tool, without a plan of the motion |
//! | `programs.rs` | programs that are made: planned and re-scheduled |
//! | `raw_shape.rs` | the raw stock as a solid, for places between its rays |
//! | `raw_stock.rs` | the stock before the first cut |
//! | `read_inputs.rs` | how all of it is read and checked, in order |
//! | `reader_settings.rs` | how programs are read: language, offsets, tool radii |
//! | `reading.rs` | how block skip and optional stop are set |
//! | `set_value.rs` | `KEY=VALUE` of a call |
//! | `set_values.rs` | `run --set KEY=VALUE` |
//! | `stock_on_rays.rs` | refuses a raw stock that its rays do not hold |
//! | `stop_at.rs` | `--stop-at`: a finding, a line, a time |
//! | `texture_places.rs` | patches and profiles as lattices on the design |
//! | `texture_plan.rs` | the places of `[surface]`, checked against the design |
//! | `tools_and_holders.rs` | tools as clamped, the start tool, room round the holders |

pub(crate) mod choice;
pub(crate) mod control_file;
pub(crate) mod control_settings;
pub(crate) mod depth_gauge;
pub(crate) mod error;
pub(crate) mod fixture_bodies;
pub(crate) mod fixtures;
pub(crate) mod machine_data;
pub(crate) mod made_program;
pub(crate) mod memory;
pub(crate) mod motion_only;
pub(crate) mod part_mesh;
pub(crate) mod part_on_table;
pub(crate) mod part_shape;
pub mod planning;
pub(crate) mod prepared;
pub(crate) mod preview;
pub(crate) mod program_extent;
pub(crate) mod program_source;
pub(crate) mod program_survey;
pub(crate) mod program_text;
pub(crate) mod program_trace;
pub(crate) mod programs;
pub(crate) mod raw_shape;
pub(crate) mod raw_stock;
mod read_inputs;
pub(crate) mod reader_settings;
pub(crate) mod reading;
pub(crate) mod set_value;
pub(crate) mod set_values;
pub(crate) mod stock_on_rays;
pub(crate) mod stop_at;
pub(crate) mod texture_places;
pub(crate) mod texture_plan;
pub(crate) mod tools_and_holders;
