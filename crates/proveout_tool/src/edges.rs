//! The cutting edges of a tool beyond its outline: helix, run-out, inserts, rake.

use serde::Deserialize;

use crate::cutter::{ShapeError, length, refuse};
use crate::library_file::EdgesEntry;
use crate::{Role, Segment, Tool};

/// Largest deviation of a round insert from the outline of its cutter, mm: rounding of dimensions in a
/// catalogue.
const OFF_OUTLINE_MM: f64 = 1e-3;

/// Run-out of one tooth, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunOut {
    /// Outward along the radius of each point of the edge.
    pub radial: f64,
    /// Away from the work, along the axis.
    pub axial: f64,
}

/// Inserts whose edge is a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundInsert {
    /// Diameter of the circle on which the lowest points of the inserts lie, mm.
    pub nose_circle_diameter: f64,
    /// Radius of an insert, mm.
    pub insert_radius: f64,
}

/// The line about which a rake turns the plane of an edge.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RakeAbout {
    /// The axis of the tool: every point of the edge goes ahead by the rake.
    #[default]
    Axis,
    /// The line through the lowest point of the edge, parallel to the axis: outer points lead, inner ones
    /// lag.
    Nose,
}

/// The edges of the teeth, at equal pitch; [`Tool::flutes`] counts them.
#[derive(Clone, Debug, PartialEq)]
pub struct CuttingEdges {
    /// Helix angle at the largest radius, radian; right-hand positive, of constant lead.
    pub helix: f64,
    /// Run-out of each tooth, in the order of their azimuths.
    pub run_out: Vec<RunOut>,
    /// Round inserts in place of the arcs of the outline.
    pub round_insert: Option<RoundInsert>,
    /// Radial rake, radian; positive turns the plane of the edge in the sense in which the tool cuts.
    pub radial_rake: f64,
    /// What it turns about.
    pub rake_about: RakeAbout,
}

/// The edges of an entry of a library file, checked against the tool made from that entry.
pub(crate) fn edges_of(e: &EdgesEntry, tool: &Tool) -> Result<CuttingEdges, ShapeError> {
    let Some(teeth) = tool.flutes else {
        return refuse("flutes", f64::NAN, "is missing: [tool.edges] describes each tooth, so that they are counted");
    };
    let helix = below_quarter_turn("helix_deg", e.helix_deg.unwrap_or(0.0))?;
    let radial_rake = below_quarter_turn("radial_rake_deg", e.radial_rake_deg.unwrap_or(0.0))?;
    if e.rake_about.is_some() && e.radial_rake_deg.is_none() {
        return refuse("rake_about", 0.0, "is for a tool with radial_rake_deg");
    }
    let round_insert = match &e.round_insert {
        Some(i) => {
            let insert = RoundInsert {
                nose_circle_diameter: length("nose_circle_diameter_mm", i.nose_circle_diameter_mm)?,
                insert_radius: length("insert_radius_mm", i.insert_radius_mm)?,
            };
            on_outline(&insert, tool)?;
            Some(insert)
        }
        None => None,
    };
    let largest = smallest_edge_radius(round_insert, tool);
    let list = |key: &'static str, values: &Option<Vec<f64>>| {
        let Some(values) = values else { return Ok(vec![0.0; teeth as usize]) };
        if values.len() != teeth as usize {
            let limit = format!("has {} values for {teeth} teeth (flutes); give one a tooth", values.len());
            return refuse(key, values.len() as f64, limit);
        }
        match values.iter().find(|v| v.abs() >= largest || v.is_nan()) {
            Some(v) => refuse(key, *v, format!("has {v}; run-out must be below the edge radius, {largest} mm")),
            None => Ok(values.clone()),
        }
    };
    let radial = list("radial_run_out_mm", &e.radial_run_out_mm)?;
    let axial = list("axial_run_out_mm", &e.axial_run_out_mm)?;
    let run_out = radial.into_iter().zip(axial).map(|(radial, axial)| RunOut { radial, axial }).collect();
    Ok(CuttingEdges { helix, run_out, round_insert, radial_rake, rake_about: e.rake_about.unwrap_or_default() })
}

fn below_quarter_turn(key: &'static str, degrees: f64) -> Result<f64, ShapeError> {
    if degrees.abs() < 90.0 {
        return Ok(proveout_geom::rad(degrees));
    }
    refuse(key, degrees, "must be above -90 and below 90")
}

/// Radius of the smallest arc that cuts, of the cutter itself where it has none, mm.
fn smallest_edge_radius(insert: Option<RoundInsert>, tool: &Tool) -> f64 {
    if let Some(insert) = insert {
        return insert.insert_radius;
    }
    let arcs = tool.cutting().flat_map(|b| b.profile.segments()).filter_map(|s| match s {
        Segment::Arc { radius, .. } => Some(*radius),
        Segment::Line { .. } => None,
    });
    arcs.fold(tool.cutting().fold(0.0, |r, b| b.profile.max_radius().max(r)), f64::min)
}

/// Refuses a round insert whose outer lower quarter is not the corner of the cutter: stock and edges would be
/// two tools.
fn on_outline(insert: &RoundInsert, tool: &Tool) -> Result<(), ShapeError> {
    let (c, r) = (0.5 * insert.nose_circle_diameter, insert.insert_radius);
    // Above the flutes the corner goes on as neck.
    let bodies = || tool.bodies.iter().filter(|b| matches!(b.role, Role::Cutting | Role::Neck));
    let off = |point: [f64; 2]| bodies().map(|b| b.profile.signed_distance(point)).fold(f64::INFINITY, f64::min).abs();
    // Two arcs of a quarter that agree at both ends and in the middle are one.
    let half = std::f64::consts::FRAC_1_SQRT_2 * r;
    let points = [[c, 0.0], [c + half, r - half], [c + r, r]];
    if !points.into_iter().all(|p| off(p) <= OFF_OUTLINE_MM) {
        let limit = format!(
            "does not lie on the cutter: its corner needs radius {r} mm and the cutter diameter {} mm, nose circle and two insert radii",
            2.0 * (c + r)
        );
        return refuse("round_insert", r, limit);
    }
    Ok(())
}
