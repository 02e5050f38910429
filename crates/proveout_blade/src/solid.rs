//! A blade with both of its ends: cut off flat, or on a platform with a fillet.
//!
//! The fillet is what a ball of its radius f leaves that rolls along blade and platform. Its center runs
//! where the surface at the distance f from the blade meets the plane at the distance f from the platform,
//! whatever the twist:
//!
//! ```text
//!   c(u) = S(u, v) + f n(u, v)      v such that  c_x = x_platform +- f      (Newton on v)
//!
//!         blade     |  .
//!               n --+--> c
//!                   |   /
//!         ----------'--+--- x_platform
//! ```
//!
//! The ball touches the blade at `S(u, v(u))` and the platform at `c - f e_x`. c' is at right angles to both
//! normals, so that the fillet is the arc from -n to `-e_x` round every c (canal surface, Monge 1850).
//!
//! The airfoil is trimmed at v(u), or where `S_x` is that of a flat end. The span of a blade is along +X.
//! An allowance a moves every face outward: blade S + a n, platform by a, and leaves the fillet around the
//! same centers with f - a; flat ends, rims and undersides stay.

use std::sync::Arc;

use proveout_geom::{Point, Vector};
use proveout_input::MAX_LENGTH_MM;
use thiserror::Error;

use super::{
    MOST_PLATFORM_MM, flat,
    surface::{Local, ParametricSurface},
};

/// A platform at an end of a blade: a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Radius of the fillet between blade and platform, mm.
    pub fillet_radius: f64,
    /// Thickness, mm.
    pub thickness: f64,
    /// From and to along y, mm.
    pub y: [f64; 2],
    /// From and to along z, mm.
    pub z: [f64; 2],
}

/// An end of a blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BladeEnd {
    /// X of the platform's face towards the blade, or of the flat end, mm.
    pub x: f64,
    /// The platform, if there is one.
    pub plate: Option<Plate>,
}

/// Why numbers do not make a blade with its ends.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SolidError {
    /// A number is not finite or outside of its range.
    #[error("{name} is {value}; it must be {range}")]
    Value {
        /// The number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The surface has rims along u, so that nothing closes round.
    #[error("the surface is not a blade: it does not close round its section")]
    Open,
    /// The surface does not reach the end.
    #[error(
        "at u = {u:.4} the blade does not reach its end at X = {x_mm} mm; put the end where the blade is, or make the fillet smaller"
    )]
    Short {
        /// Parameter round the section.
        u: f64,
        /// Where the end lies, mm.
        x_mm: f64,
    },
    /// The ball is larger than the concave side.
    #[error(
        "the fillet of {radius_mm} mm does not fit at u = {u:.4}: the blade is hollow there with a radius of {hollow_mm:.3} mm"
    )]
    Fillet {
        /// Radius of the fillet, mm.
        radius_mm: f64,
        /// Parameter round the section.
        u: f64,
        /// Radius of the hollow, mm.
        hollow_mm: f64,
    },
    /// The foot of the fillet crosses itself.
    #[error("the fillet at X = {x_mm} mm meets itself at u = {u:.4}; make it smaller")]
    Meets {
        /// Where the platform lies, mm.
        x_mm: f64,
        /// Parameter round the section.
        u: f64,
    },
    /// The platform is smaller than the foot of the blade.
    #[error("the platform at X = {x_mm} mm ends within the fillet at y {y_mm:.3}, z {z_mm:.3} mm; make it wider")]
    Narrow {
        /// Where the platform lies, mm.
        x_mm: f64,
        /// Where the foot lies outside, mm.
        y_mm: f64,
        /// Likewise.
        z_mm: f64,
    },
    /// Both ends overlap.
    #[error("at u = {u:.4} nothing is left of the blade between its ends; move them apart or make the fillets smaller")]
    Overlap {
        /// Parameter round the section.
        u: f64,
    },
}

/// Places round the section at which ends are checked.
const CHECKED: usize = 720;
/// Steps of Newton's method along v.
const STEPS: usize = 60;
/// Where its steps end: part of the range of v.
const SETTLED: f64 = 1e-14;
/// Where they may end if they no longer shrink: likewise.
const NEARLY: f64 = 1e-10;

/// A place beyond the end of the airfoil by this still belongs to it: rounding where faces join.
const JOINED: f64 = 1e-9;
/// An end is reached within this part of the range of v, and within this in mm and as a part of its place:
/// rounding.
const REACHED: f64 = 1e-9;
/// Shortest way between the ends, smallest fillet radius and platform, mm.
const LEAST_MM: f64 = 1e-3;
/// Smallest fillet radius less the allowance, mm.
const LEAST_FILLET_MM: f64 = 1e-4;
/// Largest allowance and fillet radius, mm.
const MOST_FILLET_MM: f64 = 1e3;

/// A blade between two ends.
#[derive(Clone, Debug)]
pub struct BladeSolid {
    surface: Arc<dyn ParametricSurface>,
    ends: [BladeEnd; 2],
    allowance: f64,
    /// Outlines on both end planes, y and z: contact of the fillet, or the flat end.
    pub(super) feet: [Vec<[f64; 2]>; 2],
    /// v where the airfoil ends, at the same places.
    pub(super) ended: [Vec<f64>; 2],
}

/// Where the airfoil ends at a parameter u.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trim {
    pub(super) v: f64,
    pub(super) at: Local,
    /// Center of the ball; on a flat end the point of its rim.
    pub(super) center: Point,
}

impl BladeSolid {
    /// A blade between its ends, the one of lower X first.
    ///
    /// # Errors
    /// A number is out of its range, or the ends do not fit the blade: named with the place.
    pub fn new(surface: Arc<dyn ParametricSurface>, ends: [BladeEnd; 2], allowance: f64) -> Result<Self, SolidError> {
        if !surface.domain().u_closed {
            return Err(SolidError::Open);
        }
        let value = |name, value: f64, low: f64, high: f64, range| {
            let fits = value.is_finite() && value >= low && value <= high;
            if fits { Ok(()) } else { Err(SolidError::Value { name, value, range }) }
        };
        value("the allowance", allowance, 0.0, MOST_FILLET_MM, "0 to 1000 mm")?;
        value("X of the first end", ends[0].x, -MAX_LENGTH_MM, MAX_LENGTH_MM, "within 100 m")?;
        value("X of the second end", ends[1].x, ends[0].x + LEAST_MM, MAX_LENGTH_MM, "above that of the first end")?;
        for plate in ends.iter().filter_map(|e| e.plate) {
            value("the fillet radius", plate.fillet_radius, LEAST_MM, MOST_FILLET_MM, "0.001 to 1000 mm")?;
            value(
                "the fillet radius less the allowance",
                plate.fillet_radius - allowance,
                LEAST_FILLET_MM,
                MOST_FILLET_MM,
                "above zero",
            )?;
            value("the thickness of the platform", plate.thickness, LEAST_MM, MOST_PLATFORM_MM, "above zero")?;
            for side in [plate.y, plate.z] {
                value("the width of the platform", side[1] - side[0], LEAST_MM, MAX_LENGTH_MM, "above zero")?;
                value("the rim of the platform", side[0], -MAX_LENGTH_MM, MAX_LENGTH_MM, "within 100 m")?;
            }
        }
        let mut solid =
            Self { surface, ends, allowance, feet: [Vec::new(), Vec::new()], ended: [Vec::new(), Vec::new()] };
        for k in 0..2 {
            (solid.feet[k], solid.ended[k]) = solid.foot_outline(k)?;
        }
        Ok(solid)
    }

    /// The airfoil before it is trimmed.
    pub fn surface(&self) -> &Arc<dyn ParametricSurface> {
        &self.surface
    }

    /// Its ends.
    pub fn ends(&self) -> &[BladeEnd; 2] {
        &self.ends
    }

    /// Material left on it, mm.
    pub fn allowance(&self) -> f64 {
        self.allowance
    }

    /// Whether both ends leave the airfoil at parameters; a place on the line that it shares with a fillet is
    /// left.
    pub fn leaves(&self, u: f64, v: f64) -> bool {
        (0..2).all(|end| {
            let Ok(trim) = self.trim(end, u) else { return false };
            if end == 0 { v >= trim.v - JOINED } else { v <= trim.v + JOINED }
        })
    }

    /// Outward direction of the face of an end towards the blade: +X at the first end.
    pub(super) fn sense(end: usize) -> f64 {
        if end == 0 { 1.0 } else { -1.0 }
    }

    /// Radius of the design's fillet, zero at a flat end.
    pub(super) fn fillet(&self, end: usize) -> f64 {
        self.ends[end].plate.map_or(0.0, |p| p.fillet_radius)
    }

    fn foot_outline(&self, end: usize) -> Result<(Vec<[f64; 2]>, Vec<f64>), SolidError> {
        let domain = self.surface.domain();
        let (radius, x_mm) = (self.fillet(end), self.ends[end].x);
        let place = |k: usize| domain.u[0] + (domain.u[1] - domain.u[0]) * k as f64 / CHECKED as f64;
        let (mut outline, mut ended) = (Vec::with_capacity(CHECKED), Vec::with_capacity(CHECKED));
        for k in 0..CHECKED {
            let u = place(k);
            let trim = self.trim(end, u)?;
            let [_, (low, _)] = trim.at.principal();
            if low < 0.0 && -1.0 / low <= radius {
                return Err(SolidError::Fillet { radius_mm: radius, u, hollow_mm: -1.0 / low });
            }
            if end == 1 && self.trim(0, u)?.v >= trim.v {
                return Err(SolidError::Overlap { u });
            }
            let foot = trim.center;
            if let Some(p) = self.ends[end].plate {
                let inside = |side: [f64; 2], v: f64| v > side[0] && v < side[1];
                if !(inside(p.y, foot.y) && inside(p.z, foot.z)) {
                    return Err(SolidError::Narrow { x_mm, y_mm: foot.y, z_mm: foot.z });
                }
            }
            outline.push([foot.y, foot.z]);
            ended.push(trim.v);
        }
        match flat::crossing(&outline) {
            Some((k, _)) => Err(SolidError::Meets { x_mm, u: place(k) }),
            None => Ok((outline, ended)),
        }
    }

    /// Where the airfoil ends at u: `S_x + f n_x` is that of the ball's center, or, with the allowance for f,
    /// that of the flat end.
    pub(super) fn trim(&self, end: usize, u: f64) -> Result<Trim, SolidError> {
        let sense = Self::sense(end);
        // The rim of a flat end lies on the surface with its allowance.
        let radius = if self.ends[end].plate.is_some() { self.fillet(end) } else { self.allowance };
        let wanted = self.ends[end].x + sense * self.fillet(end);
        let range = self.surface.domain().v;
        let far = |at: &Local| at.point.x + radius * at.normal.x - wanted;
        let rise = |at: &Local| at.first[1].x + radius * normal_changes(at)[1].x;
        // From the checked place nearby, or the middle of the span; the function rises along v, since the
        // span is along X.
        let domain = self.surface.domain();
        let part = (u - domain.u[0]) / (domain.u[1] - domain.u[0]);
        let place = ((part - part.floor()) * CHECKED as f64) as usize % CHECKED;
        let mut v = self.ended[end].get(place).copied().unwrap_or(0.5 * (range[0] + range[1]));
        let mut at = self.surface.local(u, v);
        let wide = range[1] - range[0];
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let slope = rise(&at);
            if slope == 0.0 || !slope.is_finite() {
                break;
            }
            let step = (far(&at) / slope).clamp(-0.5 * wide, 0.5 * wide);
            // A hair beyond the rim is continued, so that an end may lie on the rim itself.
            let next = (v - step).clamp(range[0] - 0.25 * wide, range[1] + 0.25 * wide);
            let moved = (next - v).abs();
            v = next;
            at = self.surface.local(u, v);
            // Rounding is all that is left where steps are short and no longer shrink.
            if moved <= SETTLED * wide || (moved <= NEARLY * wide && moved >= 0.5 * last) {
                break;
            }
            last = moved;
        }
        let reaches = v >= range[0] - REACHED * wide
            && v <= range[1] + REACHED * wide
            && far(&at).abs() < REACHED * (1.0 + wanted.abs());
        if !reaches {
            return Err(SolidError::Short { u, x_mm: self.ends[end].x });
        }
        Ok(Trim { v, at, center: at.point + at.normal * radius })
    }
}

/// Change of the unit normal along u and v: of `N / |N|` with `N_i = S_ui x S_v + S_u x S_vi`.
pub(super) fn normal_changes(at: &Local) -> [Vector; 2] {
    let [su, sv] = &at.first;
    let [suu, suv, svv] = &at.second;
    let normal = su.cross(sv);
    let scale = normal.dot(&at.normal).signum() / normal.norm();
    [suu.cross(sv) + su.cross(suv), suv.cross(sv) + su.cross(svv)].map(|change| {
        let change = change * scale;
        change - at.normal * at.normal.dot(&change)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ClosedSurface, Lu, Sine};

    fn plate(fillet_radius: f64) -> Plate {
        Plate { fillet_radius, thickness: 8.0, y: [-30.0, 30.0], z: [-30.0, 30.0] }
    }

    fn lu() -> Arc<dyn ParametricSurface> {
        Arc::new(ClosedSurface::new(Lu::stand_in()))
    }

    #[test]
    fn the_ball_of_a_fillet_touches_blade_and_platform_of_a_twisted_blade() {
        let ends = [BladeEnd { x: 2.0, plate: Some(plate(3.0)) }, BladeEnd { x: 97.0, plate: Some(plate(2.0)) }];
        let solid = BladeSolid::new(lu(), ends, 0.0).expect("a blade");
        for k in 0..500 {
            let u = f64::from(k) * std::f64::consts::TAU / 500.0;
            for (end, radius) in [(0, 3.0), (1, 2.0)] {
                let trim = solid.trim(end, u).expect("a trim");
                let to_plane = (trim.center.x - ends[end].x) * BladeSolid::sense(end);
                let foot = solid.surface.nearest(&trim.center);
                let near = solid.surface.local(foot[0], foot[1]);
                assert!((to_plane - radius).abs() < 1e-9, "{u} {end}");
                // No point of the blade is nearer to the center than the radius: the ball touches and does
                // not cut.
                assert!(((near.point - trim.center).norm() - radius).abs() < 2e-6, "{u} {end}");
            }
        }
    }

    #[test]
    fn ends_that_do_not_fit_are_named() {
        let cut = |x| BladeEnd { x, plate: None };
        let refused = |ends, words: &str| {
            let error = BladeSolid::new(lu(), ends, 0.0).map(|_| words).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        };
        refused([cut(-10.0), cut(90.0)], "does not reach its end at X = -10");
        refused([cut(90.0), cut(10.0)], "X of the second end");
        let wide = Plate { y: [-300.0, 300.0], z: [-300.0, 300.0], ..plate(90.0) };
        refused([BladeEnd { x: 2.0, plate: Some(wide) }, cut(100.0)], "u = ");
        let narrow = BladeEnd { x: 2.0, plate: Some(Plate { y: [-10.0, 10.0], ..plate(2.0) }) };
        refused([narrow, cut(100.0)], "make it wider");
        let flat = Arc::new(ClosedSurface::new(Sine::gentle()));
        assert_eq!(BladeSolid::new(flat, [cut(0.0), cut(1.0)], 0.0).map(|_| ()).expect_err("open"), SolidError::Open);
    }
}
