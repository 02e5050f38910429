//! What the page is made from: plain data, free of engine state.

use proveout_sim::{listing::Listing, verdict::Verdict};

use crate::{
    contact::ContactPicture,
    envelope::Envelope,
    free_axes::ShownAxes,
    picture::Picture,
    report::{
        blocks::{Blocks, LineNumbers},
        findings::FindingContext,
        gouge_excess_scale::Scales,
        operations::Operation,
        path::ToolPath,
        player::PlayerView,
    },
    roughness_map::ShownTexture,
};

/// Signals of one joint over the run, mm or degrees, seconds.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointSignals {
    pub(crate) name: String,
    /// What its drive gives: `force` or `torque`.
    pub(crate) effort: &'static str,
    /// `mm` or `deg`.
    pub(crate) unit: &'static str,
    /// Travel, where the machine has it.
    pub(crate) travel: Option<[f64; 2]>,
    /// Limits of speed, acceleration and jerk, where the machine has them.
    pub(crate) limits: [Option<f64>; 3],
    /// Commanded position, velocity, acceleration, jerk.
    pub(crate) signals: [Envelope; 4],
    /// Actual less commanded position, mm or degrees; empty where drives are not simulated.
    pub(crate) following: Envelope,
    /// Force (N) or torque (Nm) of the drive; empty where drives are not simulated.
    pub(crate) force: Envelope,
    /// Mechanical power of the drive, W; empty where drives are not simulated.
    pub(crate) power: Envelope,
    /// Has samples where the drive is at its highest force.
    pub(crate) saturated: Envelope,
    /// `N` or `Nm`.
    pub(crate) force_unit: &'static str,
    /// Highest force or torque of the drive, where it is stated.
    pub(crate) force_limit: Option<f64>,
}

/// Signals of the process over the run.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProcessSignals {
    /// mm/min.
    pub(crate) feed_programmed: Envelope,
    /// mm/min.
    pub(crate) feed: Envelope,
    /// mm³/s.
    pub(crate) removal: Envelope,
    /// mm.
    pub(crate) clearance: Envelope,
    /// Time (s) and name of each tool that comes into the spindle.
    pub(crate) tool_changes: Vec<(f64, String)>,
}

/// The cut part as the page shows it.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartView {
    /// Reduced mesh in the workpiece frame, with the deviation (mm) of every vertex where there is a design.
    pub(crate) picture: Picture,
    /// The colors, where there is a design.
    pub(crate) scales: Option<Scales>,
    /// Triangles of the mesh before reduction.
    pub(crate) triangles: usize,
    /// Edge of the cells of the reduction, mm; none when nothing was reduced.
    pub(crate) cell: Option<f64>,
    /// Share of the measured points in each of equal classes from the end of the gouge's scale to that of the
    /// excess.
    pub(crate) shares: Vec<f64>,
    /// Shares below and above the scales.
    pub(crate) outside: [f64; 2],
}

/// The program as the page shows it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProgramView {
    /// Lines of the files: all of them, or those round the reported places.
    pub(crate) listings: Vec<Listing>,
    /// Why lines are missing; empty when none are.
    pub(crate) left_out: String,
    pub(crate) blocks: Blocks,
    pub(crate) numbers: LineNumbers,
    pub(crate) path: ToolPath,
    pub(crate) operations: Vec<Operation>,
    /// Number and name of the tools in the library.
    pub(crate) tools: Vec<(u32, String)>,
    /// Details of each finding of the verdict.
    pub(crate) explained: Vec<FindingContext>,
    /// What was not checked in addition to the gates, and why.
    pub(crate) unchecked: Vec<[String; 2]>,
}

/// Everything on the page.
#[derive(Clone, Debug)]
pub(crate) struct Page<'a> {
    pub(crate) verdict: &'a Verdict,
    pub(crate) machine: &'a str,
    /// What the scene says about itself.
    pub(crate) description: &'a str,
    /// Rows of "inputs and method" in addition to those of the verdict: name and value.
    pub(crate) method: Vec<(String, String)>,
    pub(crate) joints: &'a [JointSignals],
    pub(crate) process: &'a ProcessSignals,
    pub(crate) part: &'a PartView,
    pub(crate) textures: &'a [ShownTexture],
    pub(crate) contacts: &'a [ContactPicture],
    /// The program, shown next to the part.
    pub(crate) program: &'a ProgramView,
    /// The run at every moment; none where nothing moves.
    pub(crate) player: Option<&'a PlayerView>,
    /// Free tool axes along the program, where the call asks for them.
    pub(crate) axes: Option<&'a ShownAxes>,
}
