//! Tool axes before and after on the Gauss sphere, seen along an axis of the table frame.
//!
//! Every axis is drawn at its angle from the middle and in its direction about it (equidistant azimuthal
//! projection), in degrees, so that ways from the middle have their true length. The middle is that of the
//! six directions of the frame from which all axes are least far.

use std::f64::consts::TAU;

use proveout_controller::ReprogrammedRun;
use proveout_geom::{ToolPose, Vector};

use crate::observe::study::{Role, StudyCurve};

/// How the abscissa of curves on the Gauss sphere begins: they are drawn in a square.
const GAUSS_SPHERE: &str = "Gauss sphere";
/// Circles of equal angle from the middle, degrees apart: the first of these that needs no more than five.
const CIRCLES: [f64; 5] = [1.0, 2.0, 5.0, 10.0, 30.0];
/// Points of a circle.
const POINTS: usize = 72;
/// A middle is better from this angle on, radian: rounding does not choose between equal ones.
const NEARER: f64 = 1e-9;
/// Keeps the direction of an axis in the middle a number: zero over it is zero.
const SMALLEST: f64 = 1e-300;

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Curves of a run: circles of equal angle, axes before, axes after.
pub(super) fn gauss_sphere(run: &ReprogrammedRun) -> Vec<StudyCurve> {
    let all = || run.before.iter().chain(&run.after).map(|p| &p.axis);
    let far = |middle: &Vector| all().map(|a| angle(middle, a)).fold(0.0, f64::max);
    let unit = [Vector::x(), Vector::y(), Vector::z()];
    let mut best: Option<(f64, usize, f64)> = None;
    for k in [2, 0, 1] {
        for sign in [1.0, -1.0] {
            let most = far(&(unit[k] * sign));
            if best.is_none_or(|(least, ..)| most < least - NEARER) {
                best = Some((most, k, sign));
            }
        }
    }
    let Some((most, k, sign)) = best.filter(|(most, ..)| most.is_finite()) else { return Vec::new() };
    let middle = unit[k] * sign;
    let (u, v) = (unit[(k + 1) % 3], middle.cross(&unit[(k + 1) % 3]));
    let letter = ["X", "Y", "Z"];
    let of = |d: &Vector| {
        let at = (0..3).max_by(|&a, &b| d[a].abs().total_cmp(&d[b].abs())).unwrap_or(0);
        format!("{}{}", if d[at] < 0.0 { "-" } else { "" }, letter[at])
    };
    let axes = [
        format!("{GAUSS_SPHERE} about {}, angle towards {}", of(&middle), of(&u)),
        format!("angle towards {}", of(&v)),
    ];
    let curve = |name: &str, role, points| StudyCurve {
        name: name.to_owned(),
        role,
        axes: axes.clone(),
        units: ["deg".to_owned(), "deg".to_owned()],
        equal_scales: true,
        points,
    };
    let place = |pose: &ToolPose| {
        let lean = angle(&middle, &pose.axis).to_degrees();
        let [x, y] = [pose.axis.dot(&u), pose.axis.dot(&v)];
        let size = x.hypot(y).max(SMALLEST);
        [lean * x / size, lean * y / size]
    };
    let most = most.to_degrees().max(1.0);
    let step = CIRCLES.into_iter().find(|s| most <= 5.0 * s).unwrap_or(60.0);
    let mut circles = Vec::new();
    for circle in 1..=(most / step).ceil() as usize {
        let radius = step * circle as f64;
        circles.extend((0..=POINTS).map(|i| {
            let (s, c) = (TAU * i as f64 / POINTS as f64).sin_cos();
            [radius * c, radius * s]
        }));
        circles.push([f64::NAN; 2]);
    }
    let name = format!("{step} degrees apart");
    vec![
        curve(&name, Role::Polyline, circles),
        curve("original", Role::Original, run.before.iter().map(place).collect()),
        curve("new", Role::Result, run.after.iter().map(place).collect()),
    ]
}

#[cfg(test)]
mod tests {
    use proveout_geom::Point;
    use proveout_reschedule::Study;

    use super::*;

    #[test]
    fn axes_stand_at_their_angles_from_the_direction_that_is_nearest_to_all() {
        let pose = |axis: Vector| ToolPose { tip: Point::origin(), axis: axis.normalize() };
        // Round X at 80 degrees, as the axes of a blade are.
        let before: Vec<ToolPose> = (0..24)
            .map(|i| {
                let (s, c) = (TAU * f64::from(i) / 24.0).sin_cos();
                let lean = 80.0_f64.to_radians();
                pose(Vector::new(lean.cos(), lean.sin() * c, lean.sin() * s))
            })
            .collect();
        let run = ReprogrammedRun {
            commands: vec![0; 24],
            after: before.clone(),
            before,
            stretch: 0..24,
            study: Study::default(),
            alternatives: Err("none"),
        };
        let curves = gauss_sphere(&run);
        assert_eq!(curves.len(), 3);
        assert!(
            curves
                .iter()
                .all(|c| c.axes[0] == "Gauss sphere about X, angle towards Y" && c.axes[1] == "angle towards Z")
        );
        for (i, p) in curves[2].points.iter().enumerate() {
            let (s, c) = (TAU * i as f64 / 24.0).sin_cos();
            assert!((p[0] - 80.0 * c).abs() < 1e-9 && (p[1] - 80.0 * s).abs() < 1e-9);
        }
        // Circles reach as far as the axes.
        let most = curves[0].points.iter().filter(|p| p[0].is_finite()).map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
        assert!((most - 90.0).abs() < 1e-9, "{most}");
    }
}
