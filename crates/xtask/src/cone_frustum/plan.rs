//! The setup of the scene and the passes of its program. Every number of the test piece is here.

use super::geometry::{Cone, Location, Rotaries, along, entry_between, on_generator};

/// Half apex angle of the test cone, degrees.
pub(crate) const HALF_ANGLE_DEG: f64 = 15.0;
/// Tilt of the cone's axis against the table normal, degrees, from +Z toward +X.
pub(crate) const TILT_DEG: f64 = 10.0;
/// Radius of the base circle, mm.
pub(crate) const BASE_RADIUS: f64 = 40.0;
/// Depth of the base circle's center below the top face, mm.
pub(crate) const BASE_DEPTH: f64 = 30.0;
/// The tool's lower end passes the base circle by this much along the generator, mm.
pub(crate) const RUN_PAST: f64 = 2.0;
/// Radius of the round blank, mm; its axis is the Z axis of W.
pub(crate) const BLANK_RADIUS: f64 = 50.0;
/// Height of the blank, mm; its top face is z = 0.
pub(crate) const BLANK_HEIGHT: f64 = 80.0;
/// A cutter of `tools/cone-frustum.toml` with its cutting data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ConeCutter {
    /// Name in the program and in the tool library.
    pub(crate) name: &'static str,
    /// Radius of the flutes, mm.
    pub(crate) radius: f64,
    /// Spindle speed, 1/min.
    pub(crate) spindle_rpm: u32,
    /// Feed of the tip in the cut, mm/min.
    pub(crate) feed_mm_min: f64,
}

/// Roughing; in aluminum 393 m/min and 0.1 mm a tooth with four teeth.
pub(crate) const ROUGHER: ConeCutter =
    ConeCutter { name: "BULL_D25_R2", radius: 12.5, spindle_rpm: 5000, feed_mm_min: 2000.0 };
/// Flank; in aluminum 377 m/min and 0.083 mm a tooth with four teeth.
pub(crate) const FINISHER: ConeCutter =
    ConeCutter { name: "END_D20", radius: 10.0, spindle_rpm: 6000, feed_mm_min: 2000.0 };

/// Feed down at the side of the blank, mm/min.
pub(crate) const PLUNGE_MM_MIN: f64 = 5000.0;
/// The tool keeps at least this distance from the blank before it enters and after it left, mm.
pub(crate) const CLEARANCE: f64 = 3.0;
/// Height of the tip over the top face between passes, mm.
pub(crate) const SAFE_HEIGHT: f64 = 100.0;
/// Angle about the cone's axis in which a pass rolls in, and out, degrees.
pub(crate) const LEAD_DEG: f64 = 40.0;
/// A pass goes this much further than one turn, degrees.
pub(crate) const OVERLAP_DEG: f64 = 5.0;

/// The cone of the test piece in W.
pub(crate) fn cone() -> Cone {
    Cone::from_base([0.0, 0.0, -BASE_DEPTH], BASE_RADIUS, HALF_ANGLE_DEG.to_radians(), TILT_DEG.to_radians())
}

/// Distance from the apex to the base circle along a generator, mm.
pub(crate) fn base_distance() -> f64 {
    BASE_RADIUS / HALF_ANGLE_DEG.to_radians().sin()
}

/// Distance from the apex to the top face along the generator `theta`, mm.
pub(crate) fn top_distance(theta: f64) -> f64 {
    let cone = cone();
    -cone.apex[2] / cone.generator(theta)[2]
}

/// Greatest length of tool in material along its axis, mm: the flutes must be longer.
pub(crate) fn greatest_depth() -> f64 {
    base_distance() + RUN_PAST - top_distance(0.0)
}

/// One turn of the tool about the cone.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ConePass {
    /// For the operator.
    pub(crate) name: &'static str,
    /// The cutter.
    pub(crate) cutter: ConeCutter,
    /// Distance of the tool's lower end from the apex along the generator, mm.
    pub(crate) lower_end: f64,
    /// Material left on the cone, mm.
    pub(crate) allowance: f64,
    /// Bound of the entry between two blocks beyond the allowance, mm.
    pub(crate) chord_bound: f64,
    /// Contour tolerance for the control (CYCLE832), mm.
    pub(crate) path_tolerance: f64,
}

/// The passes in order: three levels in two rings each, the semi-finish pass with 1 mm allowance, the finish
/// pass.
pub(crate) fn passes() -> Vec<ConePass> {
    /// Left on the floor by roughing, mm.
    const FLOOR_ALLOWANCE: f64 = 0.5;
    /// Largest step from level to level along the generator, mm.
    const LEVEL: f64 = 13.0;
    /// Rings of a level: outer, inner; mm off the cone.
    const RINGS: [f64; 2] = [13.0, 3.0];
    let end = base_distance() + RUN_PAST;
    let rough_end = end - FLOOR_ALLOWANCE;
    let top = top_distance(0.0);
    let levels = ((rough_end - top) / LEVEL).ceil();
    let mut passes = Vec::new();
    for level in 1..=levels as u32 {
        for allowance in RINGS {
            passes.push(ConePass {
                name: "ROUGH",
                cutter: ROUGHER,
                lower_end: top + (rough_end - top) * f64::from(level) / levels,
                allowance,
                chord_bound: 0.01,
                path_tolerance: 0.05,
            });
        }
    }
    passes.push(ConePass {
        name: "SEMI_FINISH",
        cutter: FINISHER,
        lower_end: end,
        allowance: 1.0,
        chord_bound: 0.005,
        path_tolerance: 0.02,
    });
    passes.push(ConePass {
        name: "FINISH",
        cutter: FINISHER,
        lower_end: end,
        allowance: 0.0,
        chord_bound: 0.0005,
        path_tolerance: 0.005,
    });
    passes
}

impl ConePass {
    /// The tool on the cone at `theta`, `extra` mm further off than the allowance.
    pub(crate) fn location(&self, theta: f64, extra: f64) -> Location {
        on_generator(&cone(), theta, self.lower_end, self.cutter.radius, self.allowance + extra)
    }

    /// Blocks of a full turn such that no block enters the allowance by more than the bound.
    ///
    /// The tip runs on a circle of radius `rho` about the cone's axis; the chord over the angle `w` lies
    /// `rho w² / 8` inside, of which the cosine of the half angle counts along the normal. Points higher on
    /// the tool run on smaller circles. The interpolation of the two rotary angles adds to it where C runs
    /// fast, so the number is checked with [`entry_between`] over the whole turn and raised until it holds.
    pub(crate) fn blocks_per_turn(&self, rotaries: Rotaries) -> u32 {
        let cone = cone();
        let rho =
            self.lower_end * cone.half_angle.sin() + (self.cutter.radius + self.allowance) * cone.half_angle.cos();
        let step = (8.0 * self.chord_bound / (rho * cone.half_angle.cos())).sqrt();
        let mut blocks = (std::f64::consts::TAU / step).ceil() as u32;
        while self.entry(rotaries, blocks) > self.chord_bound {
            blocks += 1;
        }
        blocks
    }

    /// Largest entry into the allowance over a turn of `blocks` blocks, mm.
    pub(crate) fn entry(&self, rotaries: Rotaries, blocks: u32) -> f64 {
        let cone = cone();
        let at = |i: u32| self.location(std::f64::consts::TAU * f64::from(i) / f64::from(blocks), 0.0);
        let reach = greatest_depth();
        (0..blocks)
            .map(|i| entry_between(&cone, rotaries, &at(i), &at(i + 1), self.cutter.radius + self.allowance, reach))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Distance further off the cone at which the tool is clear of the blank where the pass starts and ends,
    /// mm.
    pub(crate) fn clear_offset(&self) -> f64 {
        let lead = LEAD_DEG.to_radians();
        let ends = [lead, -lead - OVERLAP_DEG.to_radians()];
        let mut extra = 0.0;
        while ends
            .iter()
            .any(|&theta| distance_from_blank(&self.location(theta, extra), self.cutter.radius) < CLEARANCE)
        {
            extra += 0.5;
        }
        extra
    }
}

/// Bound from below on the distance of the tool from the blank, mm: every point of the tool lies within the
/// radius of a point of its axis.
pub(crate) fn distance_from_blank(tool: &Location, radius: f64) -> f64 {
    (0..=400)
        .map(|i| {
            let p = along(tool.tip, 0.5 * f64::from(i), tool.axis);
            let beside = (p[0].hypot(p[1]) - BLANK_RADIUS).max(0.0);
            let beyond = p[2].max(-BLANK_HEIGHT - p[2]).max(0.0);
            beside.hypot(beyond) - radius
        })
        .fold(f64::INFINITY, f64::min)
        - 0.25 // half the step of the samples
}
