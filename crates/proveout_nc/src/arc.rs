//! Circles in a plane from the words of a program.
//!
//! ```text
//!            end                 chord = end - start, middle between them
//!           /  \                 a center that is as far from the start as from the end
//!     chord/    \ r              lies on the bisector: middle + h * left(chord) / |chord|
//!         /      \
//!     start --r-- center
//! ```
//!
//! Programs round their words, so the two radii differ a little. Within the tolerance the center is moved to
//! the nearest point of the bisector. For an arc of more than half a turn with a short chord that would move
//! the whole circle by more than the rounding (the shift is `r * (r1 - r2) / chord`); there the center stays
//! as programmed.

use std::f64::consts::TAU;

use crate::control::ArcTolerance;

/// Two points nearer than this are one point, mm: below the resolution of every program, above rounding of
/// coordinates.
pub(crate) const SAME_POINT_MM: f64 = 1e-6;
/// Sine of the angle between tangent and chord below which the end lies on the tangent line.
const ON_TANGENT: f64 = 1e-9;

/// An arc in its plane: first and second axis of the plane, counter-clockwise positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneArc {
    pub(crate) center: [f64; 2],
    /// Distance of the start from the center, mm.
    pub(crate) radius: f64,
    /// Angle run through, radian, above zero.
    pub(crate) sweep: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ArcFault {
    /// Start or end lies on the center.
    NoRadius,
    /// Radius at the start and at the end, mm.
    Radii(f64, f64),
    /// The radius is too small for the chord: radius and half the chord, mm.
    TooSmall(f64, f64),
    /// Start and end are the same point, and the words define no circle.
    SamePoint,
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Angle from the start to the end about the center in the given direction, in (0, 2 pi].
pub(crate) fn sweep(start: [f64; 2], end: [f64; 2], center: [f64; 2], clockwise: bool) -> f64 {
    if distance(start, end) < SAME_POINT_MM {
        return TAU;
    }
    let (a, b) = ([start[0] - center[0], start[1] - center[1]], [end[0] - center[0], end[1] - center[1]]);
    let angle = (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]);
    let angle = if clockwise { -angle } else { angle };
    if angle > 0.0 { angle } else { angle + TAU }
}

/// Arc from its center; start and end at one point are a full circle.
pub(crate) fn from_center(
    start: [f64; 2],
    end: [f64; 2],
    center: [f64; 2],
    clockwise: bool,
    tolerance: ArcTolerance,
) -> Result<PlaneArc, ArcFault> {
    let (r1, r2) = (distance(start, center), distance(end, center));
    if r1 < SAME_POINT_MM || r2 < SAME_POINT_MM {
        return Err(ArcFault::NoRadius);
    }
    let tolerance = tolerance.of(r1.max(r2));
    if (r1 - r2).abs() > tolerance || !r1.is_finite() || !r2.is_finite() {
        return Err(ArcFault::Radii(r1, r2));
    }
    let angle = sweep(start, end, center, clockwise);
    let chord = distance(start, end);
    if chord < SAME_POINT_MM {
        return Ok(PlaneArc { center, radius: r1, sweep: TAU });
    }
    let along = [(end[0] - start[0]) / chord, (end[1] - start[1]) / chord];
    let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
    let shift = (middle[0] - center[0]) * along[0] + (middle[1] - center[1]) * along[1];
    if angle > TAU / 2.0 && shift.abs() > tolerance {
        return Ok(PlaneArc { center, radius: r1, sweep: angle });
    }
    let moved = [center[0] + shift * along[0], center[1] + shift * along[1]];
    Ok(PlaneArc { center: moved, radius: distance(start, moved), sweep: sweep(start, end, moved, clockwise) })
}

/// Arc of at most a quarter of a turn whose center lies at distances without signs from the start: the one
/// center that fits, or how many do.
pub(crate) fn in_quadrant(
    start: [f64; 2],
    end: [f64; 2],
    to_center: [f64; 2],
    clockwise: bool,
    tolerance: ArcTolerance,
) -> Result<PlaneArc, usize> {
    let mut found: Vec<PlaneArc> = Vec::new();
    for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let center = [start[0] + signs[0] * to_center[0], start[1] + signs[1] * to_center[1]];
        let Ok(arc) = from_center(start, end, center, clockwise, tolerance) else { continue };
        // Words of the ends are rounded: the quarter may be passed by as much.
        let quarter = arc.sweep <= TAU / 4.0 + 2.0 * tolerance.of(arc.radius) / arc.radius;
        if quarter && !found.iter().any(|other| distance(other.center, arc.center) < SAME_POINT_MM) {
            found.push(arc);
        }
    }
    match found[..] {
        [arc] => Ok(arc),
        _ => Err(found.len()),
    }
}

/// Arc from its radius: positive for at most half a turn, negative for more.
pub(crate) fn from_radius(
    start: [f64; 2],
    end: [f64; 2],
    radius: f64,
    clockwise: bool,
    tolerance: ArcTolerance,
) -> Result<PlaneArc, ArcFault> {
    let chord = distance(start, end);
    if chord < SAME_POINT_MM {
        return Err(ArcFault::SamePoint);
    }
    let (r, half) = (radius.abs(), 0.5 * chord);
    if r < SAME_POINT_MM {
        return Err(ArcFault::NoRadius);
    }
    if r < half - tolerance.absolute_mm {
        return Err(ArcFault::TooSmall(r, half));
    }
    // Height of the center over the chord; zero where rounding made the radius shorter than half the chord.
    let height = (r * r - half * half).max(0.0).sqrt();
    // Counter-clockwise with at most half a turn, the center lies left of the chord.
    let side = if clockwise == (radius < 0.0) { 1.0 } else { -1.0 };
    let left = [-(end[1] - start[1]) / chord, (end[0] - start[0]) / chord];
    let center = std::array::from_fn(|i| 0.5 * (start[i] + end[i]) + side * height * left[i]);
    Ok(PlaneArc { center, radius: distance(start, center), sweep: sweep(start, end, center, clockwise) })
}

/// Arc from its end and its angle in radian, above zero and below a full turn.
pub(crate) fn from_angle(start: [f64; 2], end: [f64; 2], angle: f64, clockwise: bool) -> Result<PlaneArc, ArcFault> {
    let chord = distance(start, end);
    if chord < SAME_POINT_MM {
        return Err(ArcFault::SamePoint);
    }
    // Half the chord is r sin(angle/2), the center lies r cos(angle/2) left of a counter-clockwise chord.
    let height = 0.5 * chord / (0.5 * angle).tan() * if clockwise { -1.0 } else { 1.0 };
    let left = [-(end[1] - start[1]) / chord, (end[0] - start[0]) / chord];
    let center: [f64; 2] = std::array::from_fn(|i| 0.5 * (start[i] + end[i]) + height * left[i]);
    Ok(PlaneArc { center, radius: distance(start, center), sweep: angle })
}

/// End of an arc about a center after an angle in radian.
pub(crate) fn end_after(start: [f64; 2], center: [f64; 2], angle: f64, clockwise: bool) -> [f64; 2] {
    let (s, c) = if clockwise { (-angle).sin_cos() } else { angle.sin_cos() };
    let d = [start[0] - center[0], start[1] - center[1]];
    [center[0] + c * d[0] - s * d[1], center[1] + s * d[0] + c * d[1]]
}

/// Arc that leaves the start along a tangent; none when the end lies on the tangent line. The flag says
/// clockwise.
pub(crate) fn from_tangent(start: [f64; 2], end: [f64; 2], tangent: [f64; 2]) -> Option<(PlaneArc, bool)> {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let side = tangent[0] * chord[1] - tangent[1] * chord[0];
    let length = chord[0].hypot(chord[1]);
    let tangent_length = tangent[0].hypot(tangent[1]);
    if length < SAME_POINT_MM || side.abs() <= ON_TANGENT * length * tangent_length {
        return None;
    }
    // The center lies on the normal of the tangent, as far from the start as from the end.
    let radius = length * length * tangent_length / (2.0 * side);
    let normal = [-tangent[1] / tangent_length, tangent[0] / tangent_length];
    let center = [start[0] + radius * normal[0], start[1] + radius * normal[1]];
    let clockwise = side < 0.0;
    Some((PlaneArc { center, radius: radius.abs(), sweep: sweep(start, end, center, clockwise) }, clockwise))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_words_are_put_on_the_bisector() {
        let arc = from_center(
            [3.859, 60.241],
            [3.96, 56.0],
            [3.859 + 2.171, 60.241 - 2.07],
            false,
            ArcTolerance::absolute(0.01),
        )
        .unwrap();
        let other = distance([3.96, 56.0], arc.center);
        assert!((arc.radius - other).abs() < 1e-12, "{} {other}", arc.radius);
        assert!(arc.sweep < TAU / 2.0);
    }

    #[test]
    fn radii_beyond_the_tolerance_are_refused() {
        let fault =
            from_center([10.0, 0.0], [0.0, 10.02], [0.0, 0.0], false, ArcTolerance::absolute(0.01)).unwrap_err();
        assert_eq!(fault, ArcFault::Radii(10.0, 10.02));
    }

    #[test]
    fn a_part_of_the_radius_is_taken_up_to_its_largest_difference() {
        let tolerance = ArcTolerance { absolute_mm: 0.005, relative: 0.001, largest_mm: 0.5 };
        for (radius, off, taken) in
            [(1.0, 0.004, true), (1.0, 0.006, false), (100.0, 0.09, true), (100.0, 0.11, false), (2000.0, 0.6, false)]
        {
            let arc = from_center([radius, 0.0], [0.0, radius + off], [0.0, 0.0], false, tolerance);
            assert_eq!(arc.is_ok(), taken, "{radius} {off}");
        }
    }

    #[test]
    fn nearly_full_circle_keeps_its_center() {
        let end = [10.0 * 0.001f64.cos() + 0.003, -10.0 * 0.001f64.sin()];
        let arc = from_center([10.0, 0.0], end, [0.0, 0.0], false, ArcTolerance::absolute(0.01)).unwrap();
        assert_eq!(arc.center, [0.0, 0.0]);
        assert!((arc.sweep - (TAU - 0.001)).abs() < 1e-6);
    }

    #[test]
    fn radius_sign_chooses_the_long_way() {
        for (radius, clockwise, center, quarter) in [
            (10.0, false, [0.0, 0.0], 1.0),
            (-10.0, false, [10.0, 10.0], 3.0),
            (10.0, true, [10.0, 10.0], 1.0),
            (-10.0, true, [0.0, 0.0], 3.0),
        ] {
            let arc = from_radius([10.0, 0.0], [0.0, 10.0], radius, clockwise, ArcTolerance::absolute(0.01)).unwrap();
            assert!(distance(arc.center, center) < 1e-12, "{radius} {clockwise} {:?}", arc.center);
            assert!((arc.sweep - quarter * TAU / 4.0).abs() < 1e-12);
        }
    }

    #[test]
    fn angle_and_tangent_agree_with_center() {
        let by_center = from_center([10.0, 0.0], [0.0, 10.0], [0.0, 0.0], false, ArcTolerance::absolute(0.01)).unwrap();
        let by_angle = from_angle([10.0, 0.0], [0.0, 10.0], TAU / 4.0, false).unwrap();
        let (by_tangent, clockwise) = from_tangent([10.0, 0.0], [0.0, 10.0], [0.0, 5.0]).unwrap();
        assert!(!clockwise);
        for arc in [by_angle, by_tangent] {
            assert!(distance(arc.center, by_center.center) < 1e-12);
            assert!((arc.sweep - by_center.sweep).abs() < 1e-12);
        }
        let end = end_after([10.0, 0.0], [0.0, 0.0], TAU / 4.0, true);
        assert!(distance(end, [0.0, -10.0]) < 1e-12);
    }
}
