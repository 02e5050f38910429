//! The text form of a tool library: one structure a table, as read and as published in the JSON Schema.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::RakeAbout;
use crate::residual::ResidualEntry;

/// Cutting-tool library: cutters with their holders. Lengths are in millimeter, angles in degree.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LibraryFile {
    /// Unit of all lengths of this file. With `inch` every key that ends in `_mm` here ends in `_inch`, and
    /// one in millimeters is refused.
    #[serde(default)]
    #[allow(dead_code, reason = "the text is in millimeters before it comes here")]
    pub(crate) unit: Unit,
    /// What the library is for and where its numbers come from.
    #[serde(default)]
    pub(crate) description: String,
    /// The tools.
    #[serde(default)]
    pub(crate) tool: Vec<ToolEntry>,
}

/// Unit of the lengths of a file.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Unit {
    /// Millimeters: keys end in `_mm`.
    #[default]
    Mm,
    /// Inches: keys end in `_inch`.
    Inch,
}

/// Shape of the cutter.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum CutterKind {
    /// Ball end mill.
    Ball,
    /// Flat end mill with a sharp corner.
    Flat,
    /// End mill with a corner radius.
    BullNose,
    /// Ball, tangent cone, cylinder.
    TaperBall,
    /// Ball and a tangent side arc.
    Barrel,
    /// Ball, a tangent side arc up to its equator, cylinder.
    Oval,
    /// Disk with a crowned rim and rounded corners.
    DrumWheel,
    /// Flat arc over the tip with a corner radius.
    Lens,
    /// Cone and cylinder.
    Drill,
    /// Flat or pointed tip, cone, cylinder.
    Chamfer,
    /// Cutter head with inserts.
    FaceMill,
    /// Tap: the cylinder round its teeth, and the pitch of the thread that it cuts, where it is known.
    Tap,
    /// Touch probe: the ball of its stylus, with the stem as neck. It touches and never cuts.
    Probe,
    /// Seven parameters of the APT cutter statement: D R E F alpha beta H.
    Apt,
    /// Lines and convex arcs.
    Profile,
}

/// Sense of rotation.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Hand {
    /// Cuts when the spindle turns clockwise (M3).
    Right,
    /// Cuts when the spindle turns counter-clockwise (M4).
    Left,
}

/// Source of the length of a tool.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum GaugeLengthSource {
    /// Measured on a presetter or on the machine.
    Measured,
    /// The setup prescribes it: the tool is clamped to this length.
    Prescribed,
}

/// One tool assembly.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolEntry {
    /// Place in the tool table; unique.
    pub(crate) number: u32,
    /// Name as programs call it; unique.
    pub(crate) name: String,
    /// Description for the reader.
    #[serde(default)]
    pub(crate) description: String,
    /// Shape of the cutter.
    pub(crate) kind: CutterKind,
    /// Cutting diameter (D).
    pub(crate) diameter_mm: Option<f64>,
    /// Corner radius (R).
    pub(crate) corner_radius_mm: Option<f64>,
    /// Radial position of the corner center (E of `apt`).
    pub(crate) corner_center_radius_mm: Option<f64>,
    /// Height of the corner center above the tip (F of `apt`).
    pub(crate) corner_center_height_mm: Option<f64>,
    /// Rise of the lower line (alpha of `apt`).
    pub(crate) lower_angle_deg: Option<f64>,
    /// Inclination of the upper line to the axis (beta of `apt`).
    pub(crate) upper_angle_deg: Option<f64>,
    /// Height of the cutter (H of `apt`).
    pub(crate) cutter_height_mm: Option<f64>,
    /// Full angle of the point of a drill or chamfer cutter.
    pub(crate) point_angle_deg: Option<f64>,
    /// Diameter of the tip of a taper ball (its ball) or chamfer cutter (its flat; 0 is a point).
    pub(crate) tip_diameter_mm: Option<f64>,
    /// Radius of the ball at the tip of a barrel or oval.
    pub(crate) tip_radius_mm: Option<f64>,
    /// Radius of the side of a barrel or oval, or of the rim of a drum wheel.
    pub(crate) side_radius_mm: Option<f64>,
    /// Radius of the arc over the tip of a lens.
    pub(crate) lens_radius_mm: Option<f64>,
    /// Angle of a taper ball to its axis.
    pub(crate) half_angle_deg: Option<f64>,
    /// Angle between the face and the side of the inserts of a face mill.
    pub(crate) entering_angle_deg: Option<f64>,
    /// Pitch of the thread of a tap; without it the thread is not known, and neither thread nor tapping feed
    /// is checked. What the tap cuts between the core of that thread and its diameter is reported as thread,
    /// not as gouge.
    pub(crate) pitch_mm: Option<f64>,
    /// Whether a `flat` cutter is a thread mill, drawn as the cylinder around its teeth. A gouge that it
    /// leaves in a design with the hole before the thread may then be the thread; the finding says so.
    #[serde(default)]
    pub(crate) thread_mill: bool,
    /// Curve of a `profile` cutter from the tip `[0, 0]` upward.
    pub(crate) segments: Option<Vec<SegmentEntry>>,
    /// Length of the flutes from the tip.
    pub(crate) flute_length_mm: Option<f64>,
    /// Diameter of the neck above the flutes (or of the body of a face mill).
    pub(crate) neck_diameter_mm: Option<f64>,
    /// Length of the neck above the flutes.
    pub(crate) neck_length_mm: Option<f64>,
    /// Length of the cone from flutes or neck to the shank.
    pub(crate) transition_length_mm: Option<f64>,
    /// Diameter of the shank.
    pub(crate) shank_diameter_mm: Option<f64>,
    /// Length of the cutting tool without holder.
    pub(crate) overall_length_mm: Option<f64>,
    /// From the programmed tip to the gauge line of the spindle.
    pub(crate) gauge_length_mm: f64,
    /// Source of `gauge_length_mm` where `chosen` names it: `measured` removes it from `chosen`, `prescribed`
    /// means that the tool is clamped to this length. When left out, a chosen length leaves collision and
    /// near miss of the holder unchecked.
    pub(crate) gauge_length_source: Option<GaugeLengthSource>,
    /// Number of flutes or inserts.
    pub(crate) flutes: Option<u32>,
    /// Whether the cutting edges reach the center, so that the tool may plunge. When left out, they do where
    /// the end rises from the axis (ball, point), a tap has none there, and of another flat end it is not
    /// known.
    pub(crate) center_cutting: Option<bool>,
    /// Diameter of the region round the axis that no edge sweeps, of a tool with `center_cutting = false`: on
    /// a helix that keeps this region over one place it leaves a pillar.
    pub(crate) dead_center_diameter_mm: Option<f64>,
    /// Steepest ramp or helix into material of a tool with `center_cutting = false`, as its maker states it.
    pub(crate) max_ramp_angle_deg: Option<f64>,
    /// Highest spindle speed.
    pub(crate) max_speed_rpm: Option<f64>,
    /// Sense of rotation; right when absent.
    pub(crate) hand: Option<Hand>,
    /// Edges of the teeth for the topography of the surface: helix, run-out, inserts, rake. Needs `flutes`.
    pub(crate) edges: Option<EdgesEntry>,
    /// What the tool adds to the roughness of its motion.
    pub(crate) residual: Option<ResidualEntry>,
    /// Holder; without one, checks against the holder are unchecked.
    pub(crate) holder: Option<HolderEntry>,
    /// Catalogue reference of the dimensions.
    #[serde(default)]
    pub(crate) source: String,
    /// Keys whose values come from no catalogue, with the reason for the value.
    #[serde(default)]
    pub(crate) chosen: Vec<ChosenEntry>,
}

/// A piece of a curve, in the half plane of radius and height.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SegmentEntry {
    /// End `[radius, height]`; it begins where the one before ended.
    pub(crate) to_mm: [f64; 2],
    /// Center `[radius, height]` of a counter-clockwise arc; without it the piece is straight.
    pub(crate) center_mm: Option<[f64; 2]>,
}

/// Edges of the teeth, which are equally spaced: tooth k at azimuth 360 k / `flutes`, right-handed about the
/// axis from tip to holder. Arcs of the cutter's outline are the edges unless inserts are given.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct EdgesEntry {
    /// Helix angle at the largest radius, right-hand positive, with constant lead from the tip plane; 0
    /// (straight) when absent.
    pub(crate) helix_deg: Option<f64>,
    /// Radial run-out of each tooth, outward positive; none when absent.
    pub(crate) radial_run_out_mm: Option<Vec<f64>>,
    /// Axial run-out of each tooth, away from the work positive; none when absent.
    pub(crate) axial_run_out_mm: Option<Vec<f64>>,
    /// Round inserts; both sides of their circle cut.
    pub(crate) round_insert: Option<RoundInsertEntry>,
    /// Radial rake: turns the plane of the edge in the sense in which the tool cuts (`hand`); 0 when absent.
    pub(crate) radial_rake_deg: Option<f64>,
    /// What the rake turns the plane about: the axis of the tool (when absent), or the line through the
    /// lowest point of the edge parallel to it.
    pub(crate) rake_about: Option<RakeAbout>,
}

/// Inserts whose edge is a circle. The corner of the cutter must be their outer lower quarter.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RoundInsertEntry {
    /// Diameter of the circle on which the lowest points of the inserts lie.
    pub(crate) nose_circle_diameter_mm: f64,
    /// Radius of an insert.
    pub(crate) insert_radius_mm: f64,
}

/// Holder as a stack of cylinders and cones.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HolderEntry {
    /// Description for the reader.
    #[serde(default)]
    pub(crate) name: String,
    /// From the tip side to the gauge line.
    pub(crate) sections: Vec<SectionEntry>,
}

/// One cylinder or cone of a holder.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SectionEntry {
    /// Diameter at the end nearer to the tip.
    pub(crate) diameter_mm: f64,
    /// Diameter at the end nearer to the spindle; the same when absent.
    pub(crate) top_diameter_mm: Option<f64>,
    /// Length along the axis.
    pub(crate) length_mm: f64,
}

/// Reason for values that come from no catalogue.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChosenEntry {
    /// Keys of this tool (`holder` for the whole holder).
    pub(crate) keys: Vec<String>,
    /// Why these values.
    pub(crate) reason: String,
}
