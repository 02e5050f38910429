//! A section extruded along X, twisted, on a platform with a fillet.

use proveout_geom::{Point, Vector};
use proveout_input::MAX_LENGTH_MM;
use thiserror::Error;

use super::{
    MOST_PLATFORM_MM,
    discs::Discs,
    section::{CamberSection, SectionCurve, SectionError},
};

/// Platform below the blade: the outline of the section at a distance, with flat faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Platform {
    /// Radius of the fillet between blade and platform, mm.
    pub fillet_radius: f64,
    /// Distance of the platform's rim from the outline of the section, mm; more than the fillet radius.
    pub margin: f64,
    /// Thickness below its top face, mm.
    pub thickness: f64,
}

/// Numbers of a blade.
#[derive(Clone, Debug, PartialEq)]
pub struct BladeSpec {
    /// The section, in y and z.
    pub section: CamberSection,
    /// Height above the platform's top face, mm.
    pub length: f64,
    /// Turn of the section about the X axis for each mm of X, radian/mm.
    pub twist: f64,
    /// Platform at X = 0, if there is one.
    pub platform: Option<Platform>,
}

/// Why numbers do not make a blade.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BladeError {
    /// The section.
    #[error(transparent)]
    Section(#[from] SectionError),
    /// Another kind of blade.
    #[error("this asks for a blade of kind \"camber\"")]
    Kind,
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
}

/// A point of the blade's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// mm.
    pub point: Point,
    /// Outward unit normal.
    pub normal: Vector,
}

/// Places at which an outline is asked whether it crosses itself.
const TOUCHES: u32 = 400;
/// Crossings below this are rounding, mm.
const CROSSING_MM: f64 = 1e-6;

/// A blade along +X: its section turns by `twist` for each mm; the platform's top face lies at X = 0.
///
/// In the fillet the outline of the section has the offset `f - sqrt(f^2 - (f - X)^2)`: for a blade without
/// twist that is the surface of a ball of radius f rolling in the corner; with twist it differs from one by
/// the small tilt of the sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Blade {
    spec: BladeSpec,
    outline: SectionCurve,
    discs: Discs,
}

impl Blade {
    /// A blade from its numbers.
    ///
    /// # Errors
    /// A number is out of its range, or an outline folds.
    pub fn new(spec: BladeSpec) -> Result<Self, BladeError> {
        let value = |name, value: f64, low: f64, high: f64, range| {
            let fits = value.is_finite() && value > low && value < high;
            if fits { Ok(()) } else { Err(BladeError::Value { name, value, range }) }
        };
        let outline = spec.section.curve(0.0)?;
        value("the length", spec.length, 0.0, MAX_LENGTH_MM, "above zero")?;
        value("the twist", spec.twist, -0.2, 0.2, "less than 0.2 radian/mm either way")?;
        if let Some(platform) = &spec.platform {
            value("the fillet radius", platform.fillet_radius, 0.0, spec.length, "above zero, below the length")?;
            value("the margin", platform.margin, platform.fillet_radius, MOST_PLATFORM_MM, "above the fillet radius")?;
            value("the thickness of the platform", platform.thickness, 0.0, MOST_PLATFORM_MM, "above zero")?;
            spec.section.curve(platform.margin)?;
        }
        let discs = Discs::new(&spec.section);
        let largest = spec.platform.map_or(0.0, |p| p.margin);
        // The outline that lies farthest out crosses itself where any does.
        for k in 0..=TOUCHES {
            let at = f64::from(k) / f64::from(TOUCHES);
            let touches = spec.section.pair(at, largest).1;
            if touches.iter().any(|p| discs.nearest(p.position).1.value < largest - CROSSING_MM) {
                return Err(SectionError::Crosses { offset_mm: largest, at }.into());
            }
        }
        Ok(Self { spec, outline, discs })
    }

    /// Its section as discs.
    pub(super) fn discs(&self) -> &Discs {
        &self.discs
    }

    /// Its numbers.
    pub fn spec(&self) -> &BladeSpec {
        &self.spec
    }

    /// Outline of the section without offset.
    pub fn outline(&self) -> &SectionCurve {
        &self.outline
    }

    /// Where the fillet ends and the airfoil begins, mm.
    pub fn airfoil_start(&self) -> f64 {
        self.spec.platform.map_or(0.0, |p| p.fillet_radius)
    }

    /// A point of the airfoil: arc length on the outline, mm, and X. The normal of a twisted blade leans
    /// along X: with `P_x = e_x + twist (e_x x P)` it is the outline's normal less `twist (e_x x P) . n e_x`.
    pub fn at(&self, arc: f64, x: f64) -> SurfacePoint {
        let point = self.outline.at(arc);
        self.raised(point.position, point.normal_angle, x)
    }

    /// A point of an outline (y, z and angle of its normal, as [`SectionCurve::at`] gives them) in the plane
    /// X, turned with the blade, with the normal of the airfoil there.
    pub fn raised(&self, position: [f64; 2], normal_angle: f64, x: f64) -> SurfacePoint {
        let turn = self.spec.twist * x;
        let (s, c) = turn.sin_cos();
        let [y, z] = [c * position[0] - s * position[1], s * position[0] + c * position[1]];
        let (ns, nc) = (normal_angle + turn).sin_cos();
        let lean = self.spec.twist * (y * ns - z * nc);
        SurfacePoint { point: Point::new(x, y, z), normal: Vector::new(-lean, nc, ns).normalize() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blade(twist: f64) -> Blade {
        let platform = Platform { fillet_radius: 10.0, margin: 18.0, thickness: 12.0 };
        Blade::new(BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist, platform: Some(platform) })
            .unwrap()
    }

    #[test]
    fn the_normal_is_at_right_angles_to_the_surface() {
        let blade = blade(0.004);
        for i in 0..200 {
            // None of these arc lengths is a joint of two pieces, where the curvature jumps.
            let (arc, x, h) = (0.31 + f64::from(i) * 0.67, 12.0 + f64::from(i % 40), 1e-5);
            let at = blade.at(arc, x);
            let along = (blade.at(arc + h, x).point - blade.at(arc - h, x).point) / (2.0 * h);
            let up = (blade.at(arc, x + h).point - blade.at(arc, x - h).point) / (2.0 * h);
            // Central differences of step 1e-5 on radii above 1 mm: error below 1e-9, rounding 1e-10.
            assert!(at.normal.dot(&along).abs() < 1e-7 && at.normal.dot(&up).abs() < 1e-7);
            assert!((at.normal.norm() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn numbers_that_make_no_blade_are_named() {
        let spec = |platform| BladeSpec {
            section: CamberSection::stand_in(),
            length: 60.0,
            twist: 0.0,
            platform: Some(platform),
        };
        let base = Platform { fillet_radius: 10.0, margin: 18.0, thickness: 12.0 };
        assert!(Blade::new(spec(Platform { margin: 5.0, ..base })).unwrap_err().to_string().contains("margin"));
        assert!(Blade::new(spec(Platform { margin: 80.0, ..base })).is_err(), "the concave side folds");
        assert!(Blade::new(spec(Platform { fillet_radius: f64::NAN, ..base })).is_err());
        assert!(Blade::new(BladeSpec { twist: f64::INFINITY, ..spec(base) }).is_err());
    }
}
