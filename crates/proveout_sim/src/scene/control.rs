//! Control and dynamics of a scene.

use std::collections::BTreeMap;

use proveout_controller::{Dynamics, servo::Plant};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_spanned::Spanned;

use crate::scene::joint_limits::JointLimitFile;

/// Control and dynamics.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControlFile {
    /// Control file that says what words of the programs mean: the name of a built-in one (fanuc-30i), or a
    /// path from the folder of the scene; otherwise that of the machine. Programs in another language are
    /// read without it.
    pub file: Option<String>,
    /// Which motion cuts the stock.
    #[serde(default)]
    pub dynamics: Dynamics,
    /// What moves under the forces of the drives, for dynamics = "servo".
    #[serde(default)]
    pub plant: Plant,
    /// Path tolerance where the program sets none, mm; otherwise as the machine says.
    pub path_tolerance_mm: Option<f64>,
    /// By how much the pieces of motion that cut may leave the true motion at the cutting edges, mm; 0.0005
    /// when left out.
    #[schemars(with = "Option<f64>")]
    pub piece_tolerance_mm: Option<Spanned<f64>>,
    /// Cone about a pole of the rotary axes, 0 to 5 degrees: a great circle of the tool axis that
    /// passes the pole nearer than this is led through it, which a finding reports; otherwise as
    /// the machine says.
    pub pole_cone_deg: Option<f64>,
    /// Limits of joints below those of the machine, by joint; in force for all programs.
    #[serde(default)]
    pub joint_limits: BTreeMap<String, JointLimitFile>,
}
