//! The fast analytic answer for a simulated profile across the lay: the profile model of Dong et
//! al. 2023 (`proveout_surface::texture::Dong`).
//!
//! All that the model asks for is read off the profile. The pass that cut each point gives the
//! distance of the passes, the contact at the middle of the profile gives the tilt of the cutter,
//! and the normals of the design give its curvature. The cutter enters by its two curvatures at the
//! contact, as the torus that osculates it there, so that every cutter with a round contact has an
//! answer. Both Ra are those of the unfiltered profile over whole passes; their difference is what
//! the model's assumptions (parallel, equal, straight passes) are worth.

use proveout_geom::Vector;
use proveout_surface::{
    scallop::CutterContact,
    texture::dong::{Cut as DongCut, Dong},
    topography::{Cut, Lattice},
};
use proveout_tool::Tool;

use crate::{
    cut::texture_motion::{Kept, rotated},
    units::UM_PER_MM,
    verdict::verdict_file::AnalyticUsed,
};

/// Two neighboring points were cut by different passes if the tip ran farther between them than
/// this, mm, plus two turns of the spindle.
const OTHER_PASS: f64 = 2.0;
/// Points of the model's profile in a pitch.
const POINTS: f64 = 400.0;
/// Part by which the two curvatures of a ball may differ: rounding.
const SAME_CURVATURE: f64 = 1e-9;

/// A simulated profile across the lay.
pub(super) struct Across<'a> {
    pub(super) lattice: &'a Lattice,
    pub(super) step: f64,
    pub(super) cuts: &'a [Option<Cut>],
    pub(super) teeth: bool,
}

/// The model's answer, or why it has none. `kept` gives the piece of a cut.
pub(super) fn beside<'k>(
    across: &Across<'_>,
    tools: &[Tool],
    kept: impl Fn(&Cut) -> &'k Kept,
) -> Result<AnalyticUsed, String> {
    let cuts: Vec<&Cut> = across.cuts.iter().flatten().collect();
    if cuts.len() < across.cuts.len() || cuts.len() < 3 {
        return Err("not every point is cut".into());
    }
    let middle = cuts.len() / 2;
    let at = kept(cuts[middle]);
    if cuts.iter().any(|c| kept(c).tool != at.tool) {
        return Err("more than one tool cuts the profile".into());
    }
    let tool = tools.get(at.tool).ok_or("the tool is not known")?;
    let way = at.piece.tip[1] - at.piece.tip[0];
    let duration = at.piece.time[1] - at.piece.time[0];
    let speed = way.norm() / duration;
    if !(speed > 0.0 && speed.is_finite()) {
        return Err("the tip does not move at the middle of the profile".into());
    }
    let turn = std::f64::consts::TAU / at.piece.azimuth_rate.abs() * speed;
    let apart = OTHER_PASS + if across.teeth { 2.0 * turn } else { 0.0 };
    let ridges: Vec<usize> =
        (1..cuts.len()).filter(|k| (cuts[*k].time - cuts[k - 1].time).abs() * speed > apart).collect();
    let (Some(&first), Some(&last)) = (ridges.first(), ridges.last()) else {
        return Err("one pass cuts the whole profile".into());
    };
    if ridges.len() < 2 {
        return Err("fewer than two ridges lie on the profile".into());
    }
    let pitch = (last - first) as f64 * across.step / (ridges.len() - 1) as f64;
    let normal = across.lattice.normals()[middle];
    let axis = rotated_axis(at, cuts[middle].time);
    let contact = tool
        .cutting()
        .find_map(|body| CutterContact::new(&body.profile, axis, normal, way))
        .ok_or("the cutter has no contact there")?;
    let [k1, k2] = contact.curvatures();
    let [inclination, azimuth] = contact.lean();
    if !(k1.is_finite() && k1 > 0.0 && k2 > 0.0) {
        return Err("the cutter touches with a flat or a sharp corner".into());
    }
    let corner = 1.0 / k1;
    // A ball is the same from all sides; the model wants some lean.
    let ball = (k1 - k2).abs() <= SAME_CURVATURE * k1;
    let inclination = if ball { inclination.clamp(0.1, 1.4) } else { inclination };
    let radius = if ball { corner } else { corner + inclination.sin() * (1.0 / k2 - corner) };
    let points = across.lattice.points();
    let chord = points[last] - points[first];
    let bend = across.lattice.normals()[last] - across.lattice.normals()[first];
    let curvature = -bend.dot(&chord) / chord.norm_squared();
    let model = Dong::new(radius, corner, inclination, azimuth, curvature).map_err(|e| e.to_string())?;
    let teeth = f64::from(tool.flutes.unwrap_or(1).max(1));
    let feed_per_tooth = across.teeth.then(|| turn / teeth).filter(|f| f.is_finite() && *f > 0.0);
    let cut = feed_per_tooth.map_or(DongCut::Swept, DongCut::Stops);
    let profile = model.profile(pitch, pitch, pitch / POINTS, cut).map_err(|e| e.to_string())?;
    let simulated: Vec<f64> = cuts[first..last].iter().map(|c| c.height).collect();
    // Both ends of a pitch are one place.
    let of_model = profile.heights();
    let (ra_um, simulated_ra_um) = (UM_PER_MM * ra(&of_model[..of_model.len() - 1]), UM_PER_MM * ra(&simulated));
    Ok(AnalyticUsed {
        pitch_mm: pitch,
        inclination_deg: inclination.to_degrees(),
        azimuth_deg: azimuth.to_degrees(),
        radius_mm: radius,
        corner_radius_mm: corner,
        curvature_per_mm: curvature,
        feed_per_tooth_mm: feed_per_tooth,
        ra_um,
        simulated_ra_um,
        difference_um: simulated_ra_um - ra_um,
    })
}

/// Axis of the tool at a time of its piece, in the workpiece frame.
fn rotated_axis(kept: &Kept, time: f64) -> Vector {
    let piece = &kept.piece;
    let span = piece.time[1] - piece.time[0];
    let part = if span > 0.0 { ((time - piece.time[0]) / span).clamp(0.0, 1.0) } else { 0.0 };
    rotated(&piece.housing[2], &(piece.turn * part))
}

/// Mean distance from the mean, of heights at equal steps.
fn ra(heights: &[f64]) -> f64 {
    let count = heights.len().max(1) as f64;
    let mean = heights.iter().sum::<f64>() / count;
    heights.iter().map(|h| (h - mean).abs()).sum::<f64>() / count
}
