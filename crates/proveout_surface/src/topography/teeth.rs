//! From a tool of a library to the edges of its teeth, and what must be known of their motion.

use std::f64::consts::{FRAC_PI_2, TAU};

use proveout_geom::Vector;
use proveout_tool::{RakeAbout, Segment, Tool};
use thiserror::Error;

use super::{CutterPiece, Edge};

/// Why the teeth of a tool leave no topography.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TeethError {
    /// The library says nothing of the edges.
    #[error(
        "tool \"{tool}\" has no [tool.edges]: the marks of its teeth are not known; describe helix and run-out of its edges, or ask for the envelope"
    )]
    NotDescribed {
        /// By name.
        tool: String,
    },
    /// Their number is not known.
    #[error("tool \"{tool}\" has no number of flutes: its teeth cannot be placed; add `flutes`")]
    NotCounted {
        /// By name.
        tool: String,
    },
    /// One run-out a tooth.
    #[error("tool \"{tool}\" has {given} run-outs for {teeth} teeth; give one a tooth")]
    RunOuts {
        /// By name.
        tool: String,
        /// In the description.
        given: usize,
        /// Its flutes.
        teeth: usize,
    },
    /// Edges are arcs.
    #[error(
        "tool \"{tool}\" has no rounded edge: a sharp corner leaves no height of its own; give a corner radius, round inserts, or ask for the envelope"
    )]
    NoArc {
        /// By name.
        tool: String,
    },
    /// A tooth that never cuts.
    #[error(
        "tool \"{tool}\": radial run-out differs by {run_out_mm} mm between two teeth, more than the chip of {chip_mm} mm a tooth; a tooth would not cut: correct the run-out or the feed"
    )]
    RunOutAboveChip {
        /// By name.
        tool: String,
        /// Largest difference, mm.
        run_out_mm: f64,
        /// Feed a tooth, mm.
        chip_mm: f64,
    },
    /// Teeth leave no marks while the spindle is stopped.
    #[error(
        "the spindle is stopped at {time_s} s: its teeth leave no marks; program a speed before the motion, or ask for the envelope"
    )]
    Standing {
        /// Begin of the piece, s.
        time_s: f64,
        /// Its index.
        piece: usize,
    },
    /// A number that is none.
    #[error("the motion at piece {piece} has a value that is not finite, or no time passes along a way")]
    NotFinite {
        /// Its index.
        piece: usize,
    },
}

/// The edges of a tool: all arcs of tooth 0, then those of tooth 1 and so on, each tooth with as many.
///
/// For tooth k of z, with the outer radius R, helix beta and run-outs dr and da, the point at corner angle
/// kappa of an arc (c, h, r) of the outline has
///
/// ```text
///   radius   c + r sin kappa + dr
///   height   h - r cos kappa + da
///   azimuth  2 pi k / z + (h - r cos kappa) tan(beta) / R  (+- rake about the axis)
/// ```
///
/// Bull nose: c = R - r, h = r. Ball: c = 0, h = r = R. Round insert: c is half of the nose circle, kappa
/// goes from -90 to 90 degrees.
///
/// A rake turns in the sense in which the tool cuts: clockwise seen from the holder for M3, against it for a
/// left-handed tool. Straight parts of the outline (flank, face, cone) are no edges here; heights are right
/// where an arc touches the surface.
///
/// # Errors
/// A tool whose edges are not described, counted or rounded.
pub fn edges_of(tool: &Tool) -> Result<Vec<Edge>, TeethError> {
    let name = || tool.name.clone();
    let described = tool.edges.as_ref().ok_or_else(|| TeethError::NotDescribed { tool: name() })?;
    let teeth = tool.flutes.filter(|n| *n > 0).ok_or_else(|| TeethError::NotCounted { tool: name() })? as usize;
    if described.run_out.len() != teeth {
        return Err(TeethError::RunOuts { tool: name(), given: described.run_out.len(), teeth });
    }
    // Center radius, center height, radius, range of the corner angle.
    let arcs: Vec<(f64, f64, f64, [f64; 2])> = match described.round_insert {
        Some(i) => vec![(0.5 * i.nose_circle_diameter, i.insert_radius, i.insert_radius, [-FRAC_PI_2, FRAC_PI_2])],
        None => tool
            .cutting()
            .flat_map(|b| b.profile.segments())
            .filter_map(|s| match *s {
                Segment::Arc { center, radius, from, to } => {
                    let corner = |p: [f64; 2]| (p[0] - center[0]).atan2(center[1] - p[1]);
                    Some((center[0], center[1], radius, [corner(from), corner(to)]))
                }
                Segment::Line { .. } => None,
            })
            .collect(),
    };
    if arcs.is_empty() {
        return Err(TeethError::NoArc { tool: name() });
    }
    let outer = match described.round_insert {
        Some(i) => 0.5 * i.nose_circle_diameter + i.insert_radius,
        None => tool.cutting().fold(0.0, |r, b| b.profile.max_radius().max(r)),
    };
    let lead = described.helix.tan() / outer;
    let rake = if tool.left_handed { described.radial_rake } else { -described.radial_rake };
    let (ahead, nose_turn) = match described.rake_about {
        RakeAbout::Axis => (rake, 0.0),
        RakeAbout::Nose => (0.0, rake),
    };
    let tooth = |k: usize| TAU * k as f64 / teeth as f64 + ahead;
    Ok(described
        .run_out
        .iter()
        .enumerate()
        .flat_map(|(k, off)| arcs.iter().map(move |arc| (k, off, arc)))
        .map(|(k, off, &(center_radius, center_height, radius, corner))| Edge {
            center_radius: center_radius + off.radial,
            center_height: center_height + off.axial,
            radius,
            corner,
            azimuth: tooth(k) + (center_height - radius) * lead,
            lead,
            nose_turn,
        })
        .collect())
}

/// Checks the run-out of a tool against the feed per tooth (mm): with more run-out, some tooth always
/// trails the one before it.
///
/// # Errors
/// Run-out above the chip.
pub fn check_chip(tool: &Tool, feed_per_tooth: f64) -> Result<(), TeethError> {
    let Some(described) = &tool.edges else { return Ok(()) };
    let (low, high) = described
        .run_out
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |a, off| (a.0.min(off.radial), a.1.max(off.radial)));
    if high - low > feed_per_tooth {
        let tool = tool.name.clone();
        return Err(TeethError::RunOutAboveChip { tool, run_out_mm: high - low, chip_mm: feed_per_tooth });
    }
    Ok(())
}

/// Finds pieces that leave no marks by teeth: a stopped spindle, numbers that are not finite.
///
/// # Errors
/// The first such piece.
pub fn check_motion(pieces: &[CutterPiece]) -> Result<(), TeethError> {
    for (i, piece) in pieces.iter().enumerate() {
        if !piece.is_finite() {
            return Err(TeethError::NotFinite { piece: i });
        }
        if piece.azimuth_rate == 0.0 {
            return Err(TeethError::Standing { time_s: piece.time[0], piece: i });
        }
    }
    Ok(())
}

/// Azimuth in the housing from which the phase of the spindle is counted: the direction of feed (W) projected
/// across the axis. For a feed along the axis, that of +X, and where the axis is along X, that of +Y.
pub fn phase_zero(housing: &[Vector; 3], feed: &Vector) -> f64 {
    // The sine of a tenth of a microradian: below it a direction across is made of rounding.
    const ACROSS: f64 = 1e-7;
    let azimuth = |v: &Vector| {
        let (x, y) = (housing[0].dot(v), housing[1].dot(v));
        (x.hypot(y) > ACROSS * v.norm()).then(|| y.atan2(x))
    };
    [*feed, Vector::x(), Vector::y()].iter().find_map(azimuth).unwrap_or(0.0)
}
