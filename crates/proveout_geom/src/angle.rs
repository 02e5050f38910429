use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Converts degrees, as written in programs and files, to radians.
///
/// Multiples of 90 degrees give the double nearest to the multiple of pi/2, which [`sin_cos`] knows.
pub fn rad(degrees: f64) -> f64 {
    let quarters = degrees / 90.0;
    if quarters == quarters.round() { quarters * FRAC_PI_2 } else { degrees * (PI / 180.0) }
}

/// Converts radians to degrees; exact for multiples of a right angle.
pub fn deg(radians: f64) -> f64 {
    let quarters = (radians / FRAC_PI_2).round();
    if (radians - quarters * FRAC_PI_2).abs() <= 4.0 * f64::EPSILON * radians.abs() {
        quarters * 90.0
    } else {
        radians * (180.0 / PI)
    }
}

/// Sine and cosine; exact (0, 1 or -1) at multiples of a right angle.
///
/// An angle within four units in the last place of a multiple of pi/2 counts as that multiple: at 90 degrees
/// the cosine of the nearest double is 6e-17, which would tilt a face milled at B90 and break tests for
/// equality.
///
/// ```
/// use proveout_geom::{rad, sin_cos};
///
/// assert_eq!(sin_cos(rad(90.0)), (1.0, 0.0));
/// assert_eq!(sin_cos(rad(-180.0)), (0.0, -1.0));
/// assert_ne!(rad(90.0).cos(), 0.0); // the cosine of the nearest double
/// ```
pub fn sin_cos(radians: f64) -> (f64, f64) {
    let quarters = (radians / FRAC_PI_2).round();
    if (radians - quarters * FRAC_PI_2).abs() > 4.0 * f64::EPSILON * radians.abs() {
        return radians.sin_cos();
    }
    match quarters.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

/// The angle equal to `angle` modulo a full turn that lies nearest to `near` (radians).
pub fn wrap_near(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        for quarters in -9_i32..=9 {
            let degrees = 90.0 * f64::from(quarters);
            let (s, c) = sin_cos(rad(degrees));
            assert_eq!(s, [0.0, 1.0, 0.0, -1.0][quarters.rem_euclid(4) as usize]);
            assert_eq!(c, [1.0, 0.0, -1.0, 0.0][quarters.rem_euclid(4) as usize]);
            assert_eq!(deg(rad(degrees)), degrees);
        }
    }

    #[test]
    fn other_angles_are_those_of_the_library() {
        for i in 0..1000 {
            let a = -20.0 + 0.0413 * f64::from(i);
            assert_eq!(sin_cos(a), a.sin_cos());
            assert!((rad(deg(a)) - a).abs() < 1e-14);
        }
    }

    #[test]
    fn wrapping_keeps_the_direction_and_comes_near() {
        for (angle, near) in [(0.1, 12.0), (-3.0, 3.0), (7.0, -50.0)] {
            let w = wrap_near(angle, near);
            assert!((w - near).abs() <= PI + 1e-12);
            assert!(((w - angle) / TAU - ((w - angle) / TAU).round()).abs() < 1e-12);
        }
    }
}
