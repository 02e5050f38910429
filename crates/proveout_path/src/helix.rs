//! A ball end mill on a helix round a blade, with the tool axis at a fixed lead in the section: how a CAM
//! system programs the region near a root for a table that turns the blade about X and a head that is tilted
//! once.
//!
//! ```text
//!            t  travel (counter-clockwise round the section)
//!      T ^  /        T = sin(tilt) e_x + cos(tilt) [direction in the section]
//!        | / lead    The direction in the section is the outward normal of the ball center's path,
//!   n    |/          turned by the lead towards the travel.
//!   <----Q   ball center = contact point + R * normal of the blade
//! ```

use proveout_blade::{Blade, SectionError};
use proveout_geom::{Point, ToolPose, Vector};
use thiserror::Error;

/// A helical pass over a [`Blade`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HelicalPass {
    /// Radius of the ball, mm.
    pub ball_radius: f64,
    /// Material left on the blade, mm.
    pub allowance: f64,
    /// Inclination of the tool axis towards +X, radian.
    pub head_tilt: f64,
    /// Lean of the tool axis from the outward normal towards the travel, radian.
    pub lead: f64,
    /// X of the contact point where the pass begins, mm.
    pub from_x: f64,
    /// X where it ends, mm.
    pub to_x: f64,
    /// Advance along X for each turn, mm.
    pub pitch: f64,
    /// Distance of the points along the ball center's path in the section, mm.
    pub step: f64,
    /// Where on the section the pass begins, part of the perimeter from the leading end of the pressure side.
    pub start: f64,
}

/// A point of the pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassPoint {
    /// Tip and axis, frame of the blade.
    pub pose: ToolPose,
    /// Contact point, mm.
    pub contact: Point,
    /// Ball center, mm.
    pub center: Point,
    /// Outward unit normal at the contact point.
    pub normal: Vector,
}

/// Why numbers make no pass.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PassError {
    /// The ball does not fit the section.
    #[error(transparent)]
    Section(#[from] SectionError),
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

/// Points of a pass beyond which the numbers are a mistake.
const MOST_POINTS: f64 = 1e7;
/// Smallest ball radius, pitch and step, mm: what the messages say.
const SMALLEST_MM: f64 = 1e-3;
/// Largest ball radius, allowance and pitch, mm: what the messages say.
const LARGEST_MM: f64 = 1e3;
/// Longest step, mm: what its message says.
const LONGEST_STEP_MM: f64 = 1e2;

impl HelicalPass {
    /// The points of the pass, in order.
    ///
    /// # Errors
    /// A number is out of its range, the pass leaves the airfoil, or the ball is too large for the concave
    /// side.
    pub fn points(&self, blade: &Blade) -> Result<Vec<PassPoint>, PassError> {
        let value = |name, value: f64, low: f64, high: f64, range| {
            let fits = value.is_finite() && value >= low && value <= high;
            if fits { Ok(()) } else { Err(PassError::Value { name, value, range }) }
        };
        value("the ball radius", self.ball_radius, SMALLEST_MM, LARGEST_MM, "0.001 to 1000 mm")?;
        value("the allowance", self.allowance, 0.0, LARGEST_MM, "0 to 1000 mm")?;
        value("the head tilt", self.head_tilt, -1.5, 1.5, "within 85 degrees either way")?;
        value("the lead", self.lead, -1.5, 1.5, "within 85 degrees either way")?;
        value("the pitch", self.pitch, SMALLEST_MM, LARGEST_MM, "0.001 to 1000 mm")?;
        value("the step", self.step, SMALLEST_MM, LONGEST_STEP_MM, "0.001 to 100 mm")?;
        value("the start", self.start, 0.0, 1.0, "0 to 1")?;
        value("the first X", self.from_x, blade.airfoil_start(), blade.spec().length, "on the airfoil")?;
        value("the last X", self.to_x, self.from_x, blade.spec().length, "on the airfoil, above the first X")?;
        let reach = self.ball_radius + self.allowance;
        let curve = blade.spec().section.curve(reach)?;
        let turns = (self.to_x - self.from_x) / self.pitch;
        let count = (turns * curve.perimeter() / self.step).ceil().max(1.0);
        value("the number of points", count, 1.0, MOST_POINTS, "at most ten million")?;
        let count = count as usize;
        let (tilt_sin, tilt_cos) = self.head_tilt.sin_cos();
        let points = (0..=count).map(|i| {
            let part = i as f64 / count as f64;
            let x = self.from_x + (self.to_x - self.from_x) * part;
            let on_path = curve.at((self.start + turns * part) * curve.perimeter());
            let n = on_path.normal();
            let on_section = [on_path.position[0] - reach * n[0], on_path.position[1] - reach * n[1]];
            let at = blade.raised(on_section, on_path.normal_angle, x);
            let contact = at.point + at.normal * self.allowance;
            let center = contact + at.normal * self.ball_radius;
            let (s, c) = (on_path.normal_angle + blade.spec().twist * x + self.lead).sin_cos();
            let axis = Vector::new(tilt_sin, tilt_cos * c, tilt_cos * s);
            PassPoint {
                pose: ToolPose { tip: center - axis * self.ball_radius, axis },
                contact,
                center,
                normal: at.normal,
            }
        });
        Ok(points.collect())
    }
}

#[cfg(test)]
mod tests {
    use proveout_blade::{BladeSpec, CamberSection, Platform};

    use super::*;

    #[test]
    #[ignore = "nightly, 14 s"]
    fn the_ball_touches_the_blade_and_the_tip_is_a_radius_from_its_center() {
        let platform = Platform { fillet_radius: 10.0, margin: 18.0, thickness: 12.0 };
        let spec =
            BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist: 0.004, platform: Some(platform) };
        let blade = Blade::new(spec).unwrap();
        let pass = HelicalPass {
            ball_radius: 8.0,
            allowance: 0.0,
            head_tilt: 5.0_f64.to_radians(),
            lead: 15.0_f64.to_radians(),
            from_x: 12.0,
            to_x: 15.0,
            pitch: 1.0,
            step: 0.5,
            start: 0.3,
        };
        let points = pass.points(&blade).unwrap();
        assert!(points.len() > 3 * 370 && points.len() < 3 * 373);
        for p in points.iter().step_by(7) {
            assert!((p.pose.tip - p.center).norm() - 8.0 < 1e-12);
            assert!(
                (p.pose.axis.x - 5.0_f64.to_radians().sin()).abs() < 1e-12 && (p.pose.axis.norm() - 1.0).abs() < 1e-12
            );
            // The contact lies on the blade: nearest of a fine row of surface points at the same X.
            let nearest = (0..27_000)
                .map(|k| (blade.at(f64::from(k) * 0.005, p.contact.x).point - p.contact).norm())
                .fold(f64::MAX, f64::min);
            assert!(nearest < 0.003, "{nearest}");
        }
        assert!(HelicalPass { from_x: 2.0, ..pass }.points(&blade).is_err(), "in the fillet");
        assert!(HelicalPass { ball_radius: 60.0, ..pass }.points(&blade).is_err(), "larger than the concave side");
        assert!(HelicalPass { step: 0.0, ..pass }.points(&blade).is_err());
    }
}
