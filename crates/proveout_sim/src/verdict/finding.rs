//! The registry of findings: codes, families, severities.

use std::collections::BTreeMap;

use proveout_tool::Role;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::verdict::gate::Gate;

/// Group of a finding; decides which gate it closes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// The text of the program.
    Program,
    /// Scene, machine, tools.
    Setup,
    /// Travel and drive limits.
    Limits,
    /// Rapid in material, spindle, depth, rubbing.
    Process,
    /// Bodies that touch.
    Collision,
    /// Gouge and excess.
    Geometry,
    /// Texture.
    Surface,
}

/// Weight of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// For information.
    Info,
    /// Worth a look; fails no gate.
    Warning,
    /// Fails a gate.
    Error,
}

/// One fault that the run found, with its place in the program and on the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// Stable code, see [`CODES`].
    pub code: String,
    /// Group.
    pub family: Family,
    /// Weight.
    pub severity: Severity,
    /// Program file as given.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<u32>,
    /// Index of the executed block.
    pub block: Option<u32>,
    /// Simulated time, s.
    pub time_s: Option<f64>,
    /// Joint positions at that time; mm or degrees.
    pub axes: BTreeMap<String, f64>,
    /// Bodies concerned.
    pub bodies: Vec<String>,
    /// Place in the workpiece frame, mm.
    pub point_mm: Option<[f64; 3]>,
    /// Depth of penetration, mm.
    pub penetration_mm: Option<f64>,
    /// Clearance that is left, mm.
    pub clearance_mm: Option<f64>,
    /// Measured value.
    pub value: Option<f64>,
    /// Limit that it passed.
    pub limit: Option<f64>,
    /// Unit of value and limit.
    pub unit: Option<String>,
    /// Gouge and excess: area of the design's surface that is concerned, mm².
    #[serde(default)]
    pub area_mm2: Option<f64>,
    /// Gouge and excess: volume that is missing or left, mm³.
    #[serde(default)]
    pub volume_mm3: Option<f64>,
    /// Gouge and excess: number of connected areas in this finding; more than one where it sums up
    /// the smaller ones.
    #[serde(default)]
    pub areas: Option<u64>,
    /// Further blocks with the same finding after this one (findings of one code, body and tool in a row are
    /// joined).
    pub repeats: u32,
    /// For people: what, where, by how much.
    pub message: String,
    /// The part of a tool that it is about, where it is about one. Known while the run lasts, not written to
    /// files.
    #[serde(skip)]
    pub tool: Option<ToolPart>,
    /// Where its limit comes from. Known while the run lasts, not written to files.
    #[serde(skip)]
    pub limit_source: Option<LimitSource>,
}

impl Finding {
    /// With the part of a tool that it is about.
    #[must_use]
    pub fn about_tool(self, part: Option<ToolPart>) -> Self {
        Self { tool: part, ..self }
    }

    /// With the source of its limit.
    #[must_use]
    pub fn limited_by(self, source: LimitSource) -> Self {
        Self { limit_source: Some(source), ..self }
    }

    /// Its entry in the registry of codes; none for a code of another version.
    pub fn registered(&self) -> Option<&'static Code> {
        CODES.iter().find(|c| c.code == self.code)
    }

    /// The gate that it fails; none for notes and warnings.
    pub fn fails(&self) -> Option<Gate> {
        self.registered().filter(|_| self.severity == Severity::Error)?.fails
    }
}

/// A part of a tool in a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolPart {
    /// Index of the tool in the library.
    pub tool: usize,
    /// Which part of it; none for the core round its axis.
    pub role: Option<Role>,
    /// Which of the two bodies of the finding it is.
    pub body: usize,
    /// Swept through the stock: the axes of the finding are those at the begin of its piece of motion.
    pub swept: bool,
}

/// Where the limit of a finding comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitSource {
    /// The travel of a joint of the machine file, by the index of the joint.
    Travel(usize),
    /// `tolerances.near_miss_mm` of the scene.
    NearMissTolerance,
    /// `tolerances.gouge_mm` of the scene.
    GougeTolerance,
    /// `tolerances.excess_mm` of the scene.
    ExcessTolerance,
    /// The feature of the inspection plan.
    InspectedFeature,
    /// The spindle of the machine file, or the tool in its library.
    SpindleOrTool,
    /// The tool in its library.
    Tool,
    /// The check of the compensated contour, which allows 0.001 mm.
    ContourCheck,
}

/// An entry of the registry of codes.
#[derive(Clone, Copy, Debug)]
pub struct Code {
    /// Stable code.
    pub code: &'static str,
    /// Group.
    pub family: Family,
    /// Weight.
    pub severity: Severity,
    /// The gate that an error of this code fails.
    pub fails: Option<Gate>,
    /// Where its limit comes from, where that is the same for all findings of the code.
    pub limit_source: Option<LimitSource>,
    /// One sentence.
    pub summary: &'static str,
}

macro_rules! option {
    ($kind:ident) => {
        None
    };
    ($kind:ident $value:ident) => {
        Some($kind::$value)
    };
}

macro_rules! codes {
    ($($name:ident = $code:literal, $family:ident, $severity:ident, $(fails $gate:ident,)? $(limit $limit:ident,)? $summary:literal;)*) => {
        $(#[doc = $summary] pub const $name: Code = Code {
            code: $code,
            family: Family::$family,
            severity: Severity::$severity,
            fails: option!(Gate $($gate)?),
            limit_source: option!(LimitSource $($limit)?),
            summary: $summary,
        };)*
        /// Every code that a run can raise; each has its page in `docs/findings`. Those of a gate are in the
        /// order in which its reason names them.
        pub const CODES: &[Code] = &[$($name),*];
    };
}

codes! {
    STOPPED = "program-stopped", Program, Error, fails Program, "The program could not be executed to its end.";
    NOTE = "program-note", Program, Info, "A word of the program has no effect in the twin.";
    ASSUMED = "program-assumed", Program, Warning, "The meaning of a word depends on the control or its setup: one reading is assumed.";
    TEXT_LOST = "program-text-lost", Program, Error, fails Program, "Motion of the program follows its end and is never run.";
    TEXT_UNPROVEN = "program-text-unproven", Program, Warning, "A file holds another main program, which is not run.";
    TEXT_SKIPPED = "program-text-skipped", Program, Warning, "Conditions or jumps skip motion of the program.";
    TEXT_NOT_CALLED = "program-text-not-called", Program, Info, "Text of a file has no effect: nothing calls it.";
    LONG_DWELL = "program-long-dwell", Program, Warning, "The program waits for a minute or more.";
    FLAT_TRIANGLES = "setup-mesh-flat", Setup, Info, "Triangles of a mesh have no area and enclose nothing.";
    STEP_READ = "setup-step-read", Setup, Info, "A STEP file was read, and its chord error was measured.";
    STEP_COARSE = "setup-step-coarse", Setup, Warning, "The mesh of a STEP file is coarser than what was asked for.";
    OVERTRAVEL = "limits-overtravel", Limits, Error, fails Limits, "A joint leaves its travel.";
    UNREACHABLE = "limits-unreachable", Limits, Error, fails Limits, "No joint positions give the programmed tool pose.";
    OFF_CIRCLE = "limits-off-circle", Limits, Error, fails Limits, "The tool axis leaves the programmed great circle.";
    POLE_CROSSED = "limits-pole-crossed", Limits, Warning, "The tool axis goes through a pole that its great circle only passes near.";
    SPINDLE_SPEED = "limits-spindle-speed", Limits, Error, fails Limits, limit SpindleOrTool, "The programmed spindle speed is above the limit of spindle or tool.";
    DRIVE_SATURATED = "limits-drive-saturated", Limits, Error, fails Limits, "A drive lacks the force that the motion needs.";
    PLANNED_MOTION = "limits-planned-motion", Limits, Error, fails Limits, "The planned motion exceeds a limit of a joint.";
    RAPID_IN_MATERIAL = "process-rapid-in-material", Process, Error, fails Process, "The cutter meets material at rapid rate.";
    SPINDLE_OFF = "process-spindle-off", Process, Error, fails Process, "The cutter meets material while the spindle is stopped.";
    SPINDLE_WRONG_WAY = "process-spindle-wrong-way", Process, Error, fails Process, "The spindle turns against the hand of the tool.";
    PLUNGE = "process-plunge", Process, Error, fails Process, limit Tool, "A tool that is not center-cutting plunges into material.";
    TAP_PITCH = "process-tap-pitch", Process, Error, fails Process, limit Tool, "Feed per revolution does not match the tap's pitch.";
    NO_TOOL = "process-no-tool", Process, Error, fails Process, "Feed motion without a tool in the spindle.";
    PROBED = "process-probed", Process, Warning, "A probing motion is run to its end: the probe result is not known.";
    PROBE_SPINDLE = "process-probe-spindle", Process, Error, fails Process, "The spindle turns while the probe measures.";
    NECK_RUBS = "process-neck-rubs", Process, Error, fails Process, "The neck above the flutes meets material.";
    SHANK_RUBS = "process-shank-rubs", Process, Error, fails Process, "The shank meets material.";
    LOOSE_PART = "process-loose-part", Process, Warning, "A part of the stock is cut off.";
    LOOSE_PART_HITS = "process-loose-part-hits", Process, Warning, "A part that was cut off hits a body on its way.";
    LOOSE_PART_CUT = "process-loose-part-cut", Process, Error, fails Process, "The cutter cuts a part that was cut off and that nothing clamps.";
    HOLDER_IN_STOCK = "collision-holder-stock", Collision, Error, fails Collision, "The holder meets material.";
    STOCK_HIT = "collision-stock-body", Collision, Error, fails Collision, "A body of machine or setup meets the stock, or comes closer to it than its rays can resolve.";
    STOCK_AT_REST = "collision-stock-at-rest", Collision, Error, fails Collision, "A fixture or the table overlaps the stock before any motion.";
    COLLISION = "collision-bodies", Collision, Error, fails Collision, "Two bodies collide.";
    NEAR_MISS = "collision-near-miss", Collision, Error, fails NearMiss, limit NearMissTolerance, "Two bodies come closer than the required clearance.";
    GOUGE = "geometry-gouge", Geometry, Error, fails Gouge, limit GougeTolerance, "The cut part is below the design by more than the tolerance.";
    OVERCUT = "geometry-overcut", Geometry, Error, fails Gouge, limit ContourCheck, "The compensated tool does not fit between two parts of its contour, and cuts one of them.";
    CONTOUR_TOUCHED = "geometry-contour-touched", Geometry, Warning, limit ContourCheck, "The compensated tool cuts its contour while leading in or out, at an open end, or above it.";
    EXCESS = "geometry-excess", Geometry, Error, fails Excess, limit ExcessTolerance, "Material is left on the design by more than the tolerance.";
    FILM = "geometry-film", Geometry, Info, "A sheet of material above the design is thinner than the twin can resolve.";
    THREAD = "geometry-thread", Geometry, Info, "A tap has cut its thread outside of the core holes of the design.";
    INSPECTION = "geometry-inspection", Geometry, Error, fails Excess, limit InspectedFeature, "A feature of the inspection plan is out of tolerance.";
    SCALLOP = "surface-scallop", Surface, Error, fails Surface, "The passes leave scallops higher than the tolerance.";
    ROUGHNESS = "surface-roughness", Surface, Error, fails Surface, "Ra or Rz of the surface is above its tolerance.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_unique_and_carry_their_family() {
        for (i, a) in CODES.iter().enumerate() {
            assert!(CODES[i + 1..].iter().all(|b| a.code != b.code), "{} twice", a.code);
            assert!(a.summary.ends_with('.'));
        }
    }
}
