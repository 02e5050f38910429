//! The cutter as its edges: elements of its outline in the half plane of radius and height.

use proveout_tool::{Profile, Tool};

/// Elements of one slice of the outline.
const ELEMENTS: usize = 4;
/// Rings of a flat end.
const RINGS: usize = 4;
/// Height over which the lowest part of the outline counts as the end of the tool, mm.
const END_MM: f64 = 1e-6;

/// A short piece of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeElement {
    /// Distance from the axis, mm.
    pub(crate) radius: f64,
    /// Height above the tip, mm.
    pub(crate) height: f64,
    /// Length along the outline: the width of its chip, mm.
    pub(crate) width: f64,
    /// Outward normal of the outline: radial part, and downward part.
    pub(crate) normal: [f64; 2],
    /// Angle by which it lags the same edge at the tip, radian.
    pub(crate) lag: f64,
}

/// What the force model knows of a tool.
#[derive(Clone, Debug)]
pub(crate) struct CutterEdges {
    profiles: Vec<Profile>,
    /// Teeth at equal pitch.
    pub(crate) teeth: u32,
    /// Tangent of the helix angle over the largest radius: lag for each mm of height.
    lag_per_mm: f64,
    /// Radius within which no edge cuts, mm.
    dead: f64,
    /// Most by which the run-out of one tooth is above that of the tooth before it, mm.
    pub(crate) run_out_step: f64,
    /// Highest point that cuts, mm.
    pub(crate) length: f64,
}

impl CutterEdges {
    /// None for a tool without teeth, or without a cutting body.
    pub(crate) fn of_tool(tool: &Tool) -> Option<Self> {
        let teeth = tool.flutes.filter(|n| *n > 0)?;
        let profiles: Vec<Profile> = tool.cutting().map(|b| b.profile.clone()).collect();
        let radius = profiles.iter().map(Profile::max_radius).fold(0.0, f64::max);
        if radius <= 0.0 || radius.is_nan() {
            return None;
        }
        let edges = tool.edges.as_ref();
        let steps = edges.map_or(0.0, |e| {
            let radial: Vec<f64> = e.run_out.iter().map(|r| r.radial).collect();
            (0..radial.len()).map(|k| radial[k] - radial[(k + radial.len() - 1) % radial.len()]).fold(0.0, f64::max)
        });
        Some(Self {
            length: profiles.iter().map(Profile::z_max).fold(0.0, f64::max),
            profiles,
            teeth,
            lag_per_mm: edges.map_or(0.0, |e| e.helix.tan() / radius),
            dead: tool.dead_center.unwrap_or(0.0),
            run_out_step: steps,
        })
    }

    /// Radius of the cutter at a height, mm.
    fn radius(&self, z: f64) -> Option<f64> {
        self.profiles.iter().filter_map(|p| p.radius_at(z)).reduce(f64::max)
    }

    /// Elements between two heights, mm; none where the cutter has no outline there.
    pub(crate) fn between(&self, [low, high]: [f64; 2]) -> Vec<EdgeElement> {
        let (low, high) = (low.max(0.0), high.min(self.length));
        if high <= low || high.is_nan() || low.is_nan() {
            return Vec::new();
        }
        let at = |k: usize| low + (high - low) * k as f64 / ELEMENTS as f64;
        let of = |k: usize| {
            let (z0, z1) = (at(k), at(k + 1));
            let (r0, r1) = (self.radius(z0)?, self.radius(z1)?);
            self.element([r0, z0], [r1, z1])
        };
        (0..ELEMENTS).filter_map(of).collect()
    }

    /// Elements of a flat end, from its dead center to its rim; none of an end that rises from the axis.
    pub(crate) fn end(&self) -> Vec<EdgeElement> {
        let rim = self.radius(0.0).unwrap_or(0.0);
        if rim - self.dead <= END_MM {
            return Vec::new();
        }
        let at = |k: usize| self.dead + (rim - self.dead) * k as f64 / RINGS as f64;
        (0..RINGS).filter_map(|k| self.element([at(k), 0.0], [at(k + 1), 0.0])).collect()
    }

    fn element(&self, from: [f64; 2], to: [f64; 2]) -> Option<EdgeElement> {
        let (dr, dz) = (to[0] - from[0], to[1] - from[1]);
        let width = dr.hypot(dz);
        if width <= 0.0 || width.is_nan() {
            return None;
        }
        let height = 0.5 * (from[1] + to[1]);
        let normal = [dz / width, dr / width];
        Some(EdgeElement { radius: 0.5 * (from[0] + to[0]), height, width, normal, lag: height * self.lag_per_mm })
    }
}
