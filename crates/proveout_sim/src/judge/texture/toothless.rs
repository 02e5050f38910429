//! What an envelope leaves out: a cutter without teeth leaves no marks along its path.
//!
//! The envelope is the least height that the motion can leave: it may miss a tolerance. It keeps one only
//! with what its tools state of the rest (`[tool.residual]`), and with the marks of the teeth on top:
//!
//! ```text
//!   h = f^2 / 8 r      f: way in one turn of the spindle (with run-out one tooth may cut alone)
//!                      r: smallest arc of the cutter; a sharp corner has none, and the residual covers
//!                         its marks
//!   Ra = 4 h / 9 sqrt(3), that of a parabola
//! ```

use std::f64::consts::TAU;

use proveout_controller::MoveKind;
use proveout_surface::topography::Cut;
use proveout_tool::{Segment, Tool};

use super::evaluate::Work;
use crate::{
    scene::surface::SurfaceModelFile,
    units::UM_PER_MM,
    verdict::{surface_words::FLAT, verdict_file::TextureUsed},
};

/// Ra of a parabola of height one.
pub(super) const PARABOLA_RA: f64 = 0.256_600_119_639_833_7;
/// Heights that differ by less than this are none, µm.
const FLAT_UM: f64 = 1e-4;

impl Work<'_> {
    /// The marks that teeth could leave where an envelope has none.
    pub(super) fn toothless(&mut self, cuts: &[Option<Cut>]) {
        if self.surface.model == SurfaceModelFile::Teeth {
            return;
        }
        let mut motions: Vec<u32> = cuts.iter().flatten().map(|c| c.motion).collect();
        motions.sort_unstable();
        motions.dedup();
        let marks = motions.iter().filter_map(|motion| {
            let kept = self.kept(*motion);
            let radius = self.tool(kept).and_then(smallest_arc)?;
            let piece = &kept.piece;
            let span = piece.time[1] - piece.time[0];
            let way = (piece.tip[1] - piece.tip[0]).norm() / span * (TAU / piece.azimuth_rate.abs());
            (kept.kind == MoveKind::Feed && way.is_finite()).then(|| UM_PER_MM * way * way / (8.0 * radius))
        });
        let highest = marks.fold(0.0, f64::max);
        self.used.teeth_rz_um = Some(self.used.teeth_rz_um.unwrap_or(0.0).max(highest));
        let heights = || cuts.iter().flatten().map(|c| UM_PER_MM * c.height);
        let spread = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
        if spread.abs() <= FLAT_UM && !std::mem::replace(&mut self.used.is_flat, true) {
            self.used.remarks.push(FLAT.to_owned());
        }
    }
}

/// Radius of the smallest arc of the edge, mm; none without one.
fn smallest_arc(tool: &Tool) -> Option<f64> {
    let arcs = tool.cutting().flat_map(|body| body.profile.segments()).filter_map(|segment| match segment {
        Segment::Arc { radius, .. } => Some(*radius),
        Segment::Line { .. } => None,
    });
    arcs.reduce(f64::min).filter(|r| *r > 0.0)
}

/// What keeps an envelope from a pass: tools that state no residual; none where all do, or where teeth are
/// modeled.
pub(super) fn missing(texture: &TextureUsed) -> Option<String> {
    if texture.model != "envelope" || (texture.residual.missing.is_empty() && !texture.tools.is_empty()) {
        return None;
    }
    let flat = if texture.is_flat { format!("{FLAT}; ") } else { String::new() };
    let tools =
        if texture.residual.missing.is_empty() { "the tools".to_owned() } else { texture.residual.missing.join(", ") };
    Some(format!(
        "{flat}an envelope is a lower bound: marks of the teeth, run-out, vibration, ploughing and tear are left \
         out; give flutes and [tool.edges] of {tools} with model = \"teeth\", or [tool.residual]"
    ))
}
