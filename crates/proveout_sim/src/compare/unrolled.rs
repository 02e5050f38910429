//! The side of a blade laid flat: arc length of the section to the right, height upward.

use std::f64::consts::TAU;

use proveout_geom::{Point, blade::Blade};
use rayon::prelude::*;

/// Points on the outline; a point of the surface is told to the nearest of them.
const SAMPLES: usize = 4096;

/// Arc length on the outline of the section and height (both mm) of points near the blade's side; not a number for those
/// that are not wanted.
///
/// The twist is taken back about the X axis, so that one outline serves every height.
pub(crate) fn unrolled(blade: &Blade, points: &[Point], wanted: impl Fn(usize) -> bool + Sync) -> Vec<[f64; 2]> {
    let (outline, twist) = (blade.outline(), blade.spec().twist % TAU);
    let step = outline.perimeter() / SAMPLES as f64;
    let samples: Vec<[f64; 2]> = (0..SAMPLES).map(|i| outline.at(i as f64 * step).position).collect();
    let place = |(i, p): (usize, &Point)| {
        if !wanted(i) {
            return [f64::NAN; 2];
        }
        let (s, c) = (twist * p.x).sin_cos();
        let (y, z) = (c * p.y + s * p.z, c * p.z - s * p.y);
        let away = |q: &[f64; 2]| (q[0] - y).powi(2) + (q[1] - z).powi(2);
        let nearest = (0..SAMPLES).min_by(|&a, &b| away(&samples[a]).total_cmp(&away(&samples[b])));
        [nearest.unwrap_or(0) as f64 * step, p.x]
    };
    points.par_iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod tests {
    use proveout_geom::blade::{BladeSpec, CamberSection};

    use super::*;

    #[test]
    fn points_of_a_twisted_blade_come_back_to_their_arc_length() {
        let spec = BladeSpec { section: CamberSection::stand_in(), length: 60.0, twist: 0.01, platform: None };
        let blade = Blade::new(spec).expect("a blade");
        let perimeter = blade.outline().perimeter();
        let places: Vec<[f64; 2]> =
            (0..200).map(|i| [perimeter * f64::from(i) / 200.0, 5.0 + 0.2 * f64::from(i)]).collect();
        // A little off the surface, as a cut part is.
        let point = |[arc, x]: &[f64; 2]| {
            let on = blade.at(*arc, *x);
            on.point + on.normal * 0.01
        };
        let points: Vec<Point> = places.iter().map(point).collect();
        let flat = unrolled(&blade, &points, |i| i != 7);
        for (i, (got, wanted)) in flat.iter().zip(&places).enumerate() {
            if i == 7 {
                assert!(got[0].is_nan(), "not wanted");
                continue;
            }
            let away = (got[0] - wanted[0]).abs();
            let away = away.min(perimeter - away);
            // Half a step, and the shift along X that the leaning normal makes.
            assert!(away < perimeter / SAMPLES as f64 && (got[1] - wanted[1]).abs() < 0.01, "{got:?} {wanted:?}");
        }
    }
}
