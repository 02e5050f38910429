//! The side of a blade laid flat: arc length of the section to the right, height upward; any other surface by
//! the lengths of its lines.

use std::f64::consts::TAU;

use proveout_blade::{Blade, ParametricSurface};
use proveout_geom::Point;
use rayon::prelude::*;

use crate::prepare::part_shape::Shape;

/// Points on the outline; a point of the surface is assigned to the nearest of them.
const SAMPLES: usize = 4096;
/// Steps along a line whose length is summed, and lines between which lengths are interpolated.
const NET: [usize; 2] = [1024, 64];

/// The part laid flat by what it is; not a number for points that are not wanted.
pub(crate) fn of_shape(shape: &Shape, points: &[Point], wanted: impl Fn(usize) -> bool + Sync) -> Vec<[f64; 2]> {
    match shape {
        Shape::Camber(blade) => unrolled(blade, points, wanted),
        Shape::Ended(_) | Shape::Face(..) => by_its_lines(shape.surface().as_ref(), points, wanted),
    }
}

/// Lengths, mm, to the foot of each point: along the line of constant v from the beginning of u, and along
/// the line of constant u from the beginning of v.
fn by_its_lines(
    surface: &dyn ParametricSurface,
    points: &[Point],
    wanted: impl Fn(usize) -> bool + Sync,
) -> Vec<[f64; 2]> {
    let domain = surface.domain();
    let ranges = [domain.u, domain.v];
    // Lengths along u on lines of constant v, and the other way round.
    let sums: [Vec<Vec<f64>>; 2] = std::array::from_fn(|along| {
        let at = |k: usize, line: usize| {
            let part = [k as f64 / NET[0] as f64, line as f64 / NET[1] as f64];
            let of = |axis: usize| {
                let [low, high] = ranges[axis];
                low + (high - low) * part[usize::from(axis != along)]
            };
            surface.local(of(0), of(1)).point
        };
        let line = |line: usize| {
            let mut sum = vec![0.0];
            for k in 0..NET[0] {
                sum.push(sum[k] + (at(k + 1, line) - at(k, line)).norm());
            }
            sum
        };
        (0..=NET[1]).into_par_iter().map(line).collect()
    });
    let place = |(i, p): (usize, &Point)| {
        if !wanted(i) {
            return [f64::NAN; 2];
        }
        let foot = surface.nearest(p);
        let part = [0, 1].map(|axis| {
            let [low, high] = ranges[axis];
            ((foot[axis] - low) / (high - low)).clamp(0.0, 1.0)
        });
        [0, 1].map(|along| {
            let split = |part: f64, steps: usize| {
                let place = part * steps as f64;
                let k = (place as usize).min(steps - 1);
                (k, place - k as f64)
            };
            let ((k, a), (line, b)) = (split(part[along], NET[0]), split(part[1 - along], NET[1]));
            let on = |line: &[f64]| line[k] + (line[k + 1] - line[k]) * a;
            on(&sums[along][line]) * (1.0 - b) + on(&sums[along][line + 1]) * b
        })
    };
    points.par_iter().enumerate().map(place).collect()
}

/// Arc length on the outline of the section and height (both mm) of points near the blade's side; not a
/// number for those that are not wanted.
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
    use proveout_blade::{BladeSpec, CamberSection, ClosedSurface, Cui, Lu};

    use super::*;

    #[test]
    fn points_of_other_surfaces_come_back_to_the_lengths_of_their_lines() {
        // Ruled: lengths along u are u itself from its beginning; along v a helix of radius hypot(d, w),
        // whose slope is known.
        let cui = Cui::stand_in();
        let surface = ClosedSurface::new(cui);
        let places: Vec<[f64; 2]> = (0..60).map(|i| [-2.9 + 0.09 * f64::from(i), -59.0 + 1.9 * f64::from(i)]).collect();
        let point = |[u, v]: &[f64; 2]| {
            let at = surface.local(*u, *v);
            at.point + at.normal * 0.01
        };
        let points: Vec<Point> = places.iter().map(point).collect();
        let flat = by_its_lines(&surface, &points, |i| i != 7);
        for (i, (got, [u, v])) in flat.iter().zip(&places).enumerate() {
            if i == 7 {
                assert!(got[0].is_nan(), "not wanted");
                continue;
            }
            let rise = 1.0_f64.hypot(cui.twist * cui.distance.hypot(*u));
            let wanted = [u + cui.half_width, (v + cui.half_length) * rise];
            assert!((got[0] - wanted[0]).abs() < 1e-3 && (got[1] - wanted[1]).abs() < 2e-3, "{got:?} {wanted:?}");
        }
        // Closed round its section: one turn is the length of it.
        let surface = ClosedSurface::new(Lu::stand_in());
        let near_end = surface.local(TAU - 1e-6, 0.5);
        let flat = by_its_lines(&surface, &[near_end.point], |_| true);
        let round = (0..20_000).map(|k| {
            let at = |k: f64| surface.local(TAU * k / 20_000.0, 0.5).point;
            (at(f64::from(k) + 1.0) - at(f64::from(k))).norm()
        });
        let round: f64 = round.sum();
        assert!((flat[0][0] - round).abs() < 2e-3 * round || flat[0][0] < 1e-3, "{flat:?} {round}");
    }

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
