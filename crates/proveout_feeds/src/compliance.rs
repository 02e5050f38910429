//! How far the tip of a stepped tool bends for a force across its axis.
//!
//! A cantilever (Euler and Bernoulli) from the nose of the holder, or from the gauge line where the library
//! has no holder. With the height z above the tip, the force F at the height a and the clamping at L, the tip
//! moves by
//!
//! ```text
//! w(0) = F  integral from a to L of  (z - a) z / (E I(z)) dz,     I = pi r^4 / 4
//! ```
//!
//! which is F L^3 / (3 E I) for a plain shank with the force at its tip. Fluted lengths count with a part of
//! their diameter (Kops and Vo 1990: about 0.8). Holder, spindle and part are rigid here.

use std::f64::consts::PI;

use proveout_tool::{Role, Tool};

/// Slices of the tool, each a cylinder.
const SLICES: usize = 400;

/// A cylinder of the tool: from, to, E I in N mm².
type Stage = (f64, f64, f64);

/// The stepped tool as cylinders.
#[derive(Clone, Debug, PartialEq)]
pub struct Compliance {
    stages: Vec<Stage>,
}

impl Compliance {
    /// `youngs_modulus` in N/mm²; `fluted` is the part of its diameter that a fluted length counts with. None
    /// where nothing of the tool is outside of its clamping.
    pub fn of_tool(tool: &Tool, youngs_modulus: f64, fluted: f64) -> Option<Self> {
        let holder = tool.bodies.iter().filter(|b| b.role == Role::Holder).map(|b| b.profile.z_min());
        let clamped = holder.fold(tool.gauge_length, f64::min);
        let radius = |z: f64| {
            let of = |b: &proveout_tool::Body| {
                let part = if b.role == Role::Cutting { fluted } else { 1.0 };
                b.profile.radius_at(z).map(|r| r * part)
            };
            tool.bodies.iter().filter(|b| b.role != Role::Holder).filter_map(of).reduce(f64::max)
        };
        if !(clamped.is_finite() && clamped > 0.0 && youngs_modulus > 0.0 && fluted > 0.0) {
            return None;
        }
        let at = |k: usize| clamped * k as f64 / SLICES as f64;
        let mut last = None;
        let mut stages = Vec::with_capacity(SLICES);
        for k in 0..SLICES {
            let (from, to) = (at(k), at(k + 1));
            // Between the last body and the holder the shank goes on.
            let r = radius(0.5 * (from + to)).filter(|r| *r > 0.0).or(last)?;
            last = Some(r);
            stages.push((from, to, youngs_modulus * PI * r.powi(4) / 4.0));
        }
        Some(Self { stages })
    }

    /// Deflection of the tip for each N at a height above it, mm/N.
    pub fn at_tip(&self, height: f64) -> f64 {
        let of = |&(from, to, stiffness): &Stage| {
            let from = from.max(height);
            if to <= from {
                return 0.0;
            }
            // Of (z - a) z, in closed form.
            let whole = |z: f64| z * z * (z / 3.0 - height / 2.0);
            (whole(to) - whole(from)) / stiffness
        };
        self.stages.iter().map(of).sum()
    }
}
