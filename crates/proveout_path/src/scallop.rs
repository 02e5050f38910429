//! Side step and scallop height of two adjacent circular cuts on a circle, with the exact formulas
//! of Ma et al. 2020, equations (6), (7) and the concave counterpart, for a cut of radius R on a
//! section of radius rho:
//!
//! ```text
//!              h: from the surface to where the two cuts meet
//!    plane     h = R - sqrt(R^2 - L^2/4)
//!    convex    h = (rho+R)/rho sqrt(rho^2 - L^2/4) - sqrt(R^2 - ((rho+R) L / (2 rho))^2) - rho
//!    concave   h = rho - (rho-R)/rho sqrt(rho^2 - L^2/4) - sqrt(R^2 - ((rho-R) L / (2 rho))^2)
//! ```
//!
//! L is the chord between the two contacts. All three are one: with a = half of the angle between the
//! contacts seen from the center of the section, the centers of the cuts lie at `d = rho + R` from it, and
//! the two cuts meet at `d cos a - sqrt(R^2 - d^2 sin^2 a)` from it. For a concave side rho and d are
//! negative. In the form
//!
//! ```text
//!    k = 1/rho,  s = L/2,  c = sqrt(1 - k^2 s^2) = cos a,   1 - c = k^2 s^2 / (1 + c)
//!    w = (1 + k R) s          distance of a center from the line in the middle
//!    h = R w^2/R^2 / (1 + sqrt(1 - w^2/R^2)) - (1 + k R) k s^2 / (1 + c)
//! ```
//!
//! nothing is lost to differences of large numbers, and a plane is k = 0.

/// By how much the widest step is taken smaller, part of it: rounding.
const BELOW_WIDEST: f64 = 1e-12;
/// Difference of height at which the search ends, part of it.
const SAME_HEIGHT: f64 = 1e-14;
/// Width of the bracket at which the search ends, part of the step.
const NARROW: f64 = 1e-15;

/// Height of the ridge between two contacts a chord `step` (mm) apart, mm: cut of `cutter_curvature`, surface
/// of `curvature` (1/mm, positive where convex). None where the two cuts do not meet.
///
/// ```
/// use proveout_path::scallop_height;
///
/// // A ball of 3 mm radius, contacts 1 mm apart: R - sqrt(R^2 - L^2 / 4) on a plane.
/// let plane = scallop_height(1.0 / 3.0, 0.0, 1.0).expect("the cuts meet");
/// assert!((plane - (3.0 - 8.75_f64.sqrt())).abs() < 1e-12); // mm
/// // The ridge is lower in a hollow and higher on a bulge of 20 mm.
/// let [hollow, bulge] = [-0.05, 0.05].map(|k| scallop_height(1.0 / 3.0, k, 1.0));
/// assert!(hollow < Some(plane) && Some(plane) < bulge);
/// ```
pub fn scallop_height(cutter_curvature: f64, curvature: f64, step: f64) -> Option<f64> {
    let s = 0.5 * step;
    let opened = 1.0 + curvature / cutter_curvature;
    let reach = opened * s * cutter_curvature;
    let chord = curvature * s;
    if cutter_curvature.is_nan() || cutter_curvature <= 0.0 || reach.abs() > 1.0 || chord.abs() > 1.0 {
        return None;
    }
    let rise = opened * opened * s * s * cutter_curvature / (1.0 + (1.0 - reach * reach).sqrt());
    let sag = opened * curvature * s * s / (1.0 + (1.0 - chord * chord).sqrt());
    Some(rise - sag)
}

/// The chord between two contacts that leaves ridges of this height, mm. None where the cutter does not fit
/// the surface, or no step leaves so high a ridge.
///
/// ```
/// use proveout_path::side_step;
///
/// // A ball of 3 mm radius, ridges of 0.02 mm: L = 2 sqrt(2 R h - h^2) on a plane.
/// let step = side_step(1.0 / 3.0, 0.0, 0.02).expect("the cuts meet");
/// assert!((step - 2.0 * (0.12_f64 - 0.0004).sqrt()).abs() < 1e-9); // mm
/// assert_eq!(side_step(0.1, -0.2, 0.02), None); // a ball of 10 mm in a hollow of 5 mm
/// ```
pub fn side_step(cutter_curvature: f64, curvature: f64, height: f64) -> Option<f64> {
    let opened = 1.0 + curvature / cutter_curvature;
    if !(cutter_curvature > 0.0 && height > 0.0 && opened > 0.0) {
        return None;
    }
    let mut low = 0.0;
    let mut high = 2.0 / (opened * cutter_curvature);
    if curvature.abs() > 0.0 {
        high = high.min(2.0 / curvature.abs());
    }
    if scallop_height(cutter_curvature, curvature, high).is_none_or(|most| most < height) {
        // The rounding of the last place must not decide whether the widest step counts.
        high *= 1.0 - BELOW_WIDEST;
        if scallop_height(cutter_curvature, curvature, high).is_none_or(|most| most < height) {
            return None;
        }
    }
    // Parabolas give h = L^2 (k + 1/R) / 8; from there the secant of sqrt(h) is nearly straight.
    let mut step = (8.0 * height / (cutter_curvature + curvature)).sqrt().min(high);
    for round in 0..120 {
        let is = scallop_height(cutter_curvature, curvature, step)?;
        if is > height {
            high = step;
        } else {
            low = step;
        }
        if (is - height).abs() <= SAME_HEIGHT * height || high - low <= NARROW * high {
            break;
        }
        // Near the widest step the height rises ever faster: halves help where the root of the ratio does
        // not.
        let next = step * (height / is).sqrt();
        step = if round % 4 < 3 && next > low && next < high { next } else { 0.5 * (low + high) };
    }
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_golden_side_steps() {
        // R mm, h mm, rho mm, plane, convex, concave: exact columns of the golden file; its printed ones must
        // fail.
        let rows = [
            [3.0, 0.02, 5.0, 0.691_664_658_6, 0.545_515_389_1, 1.094_165_615, 0.433_012_701_9, 1.732_050_808],
            [3.0, 0.02, 8.0, 0.691_664_658_6, 0.589_017_823_4, 0.875_661_668_7, 0.503_869_325_8, 1.108_512_517],
            [3.0, 0.02, 10.0, 0.691_664_658_6, 0.605_954_756_2, 0.827_348_218_7, 0.532_938_71, 0.989_743_318_6],
            [3.0, 0.02, 15.0, 0.691_664_658_6, 0.630_945_154_3, 0.773_756_291_1, 0.577_350_269_2, 0.866_025_403_8],
            [3.0, 0.02, 20.0, 0.691_664_658_6, 0.644_637_440_4, 0.750_558_007, 0.602_452_464_8, 0.815_082_733],
            [3.0, 0.02, 30.0, 0.691_664_658_6, 0.659_246_711_8, 0.729_308_243_8, 0.629_836_657_3, 0.769_800_358_9],
            [3.0, 0.02, 50.0, 0.691_664_658_6, 0.671_665_996_2, 0.713_535_805_4, 0.653_604_078_3, 0.737_042_896_8],
            [3.0, 0.02, 100.0, 0.691_664_658_6, 0.681_448_308_4, 0.702_348_214_4, 0.672_641_090_3, 0.714_247_755_7],
        ];
        for [r, h, rho, plane, convex, concave, printed_convex, printed_concave] in rows {
            let step = |k: f64| side_step(1.0 / r, k, h).unwrap();
            assert!((step(0.0) - plane).abs() < 1e-9, "{rho}");
            assert!((step(1.0 / rho) - convex).abs() < 1e-9, "{rho}");
            assert!((step(-1.0 / rho) - concave).abs() < 1e-9, "{rho}");
            assert!(
                (step(1.0 / rho) - printed_convex).abs() > 1e-3 && (step(-1.0 / rho) - printed_concave).abs() > 1e-3
            );
        }
    }

    #[test]
    fn the_formulas_as_they_stand_and_the_way_back() {
        let convex = |r: f64, rho: f64, l: f64| {
            (rho + r) / rho * (rho * rho - l * l / 4.0).sqrt()
                - (r * r - ((rho + r) * l / (2.0 * rho)).powi(2)).sqrt()
                - rho
        };
        let concave = |r: f64, rho: f64, l: f64| {
            rho - (rho - r) / rho * (rho * rho - l * l / 4.0).sqrt()
                - (r * r - ((rho - r) * l / (2.0 * rho)).powi(2)).sqrt()
        };
        // Corners: sharp and blunt cutters, nearly flat and nearly fitting surfaces, low and high ridges.
        for r in [0.2, 3.0, 40.0] {
            for factor in [1.05, 2.0, 30.0, 1e4] {
                for part in [0.01, 0.3, 0.9] {
                    let rho = r * factor;
                    let l = part * 2.0 * r / (1.0 + r / rho);
                    let h = scallop_height(1.0 / r, 1.0 / rho, l).unwrap();
                    assert!((h - convex(r, rho, l)).abs() < 1e-11 * rho, "{r} {rho} {l}");
                    assert!((side_step(1.0 / r, 1.0 / rho, h).unwrap() - l).abs() < 1e-9 * l, "{r} {rho} {l}");
                    let h = scallop_height(1.0 / r, -1.0 / rho, l).unwrap();
                    assert!((h - concave(r, rho, l)).abs() < 1e-11 * rho, "{r} {rho} {l}");
                }
            }
        }
    }

    #[test]
    fn what_has_no_step() {
        assert_eq!(side_step(0.1, -0.2, 0.01), None, "the cutter is larger than the hollow");
        assert_eq!(side_step(1.0, 0.0, 2.0), None, "higher than the cut is deep");
        assert_eq!(scallop_height(1.0, 0.0, 2.1), None);
        assert_eq!(side_step(f64::NAN, 0.0, 0.1), None);
    }
}
