//! Local gouging: the normal curvatures of the cutter at the contact against those of the surface.
//!
//! At the contact a cutter of corner radius r, whose corner centers lie on a circle of radius m, has the
//! principal curvatures 1/r in the direction in which the axis leans and `k = sin t / (m + r sin t)` across
//! it (t the tilt): the distance of the contact from the axis is m + r sin t, and the normal there makes the
//! angle t with the axis (theorem of Meusnier). A ball has m = 0 and 1/r both ways. With the second
//! fundamental form S of the surface, positive where it is convex, both lie on different sides of the tangent
//! plane up to the second order when
//!
//! ```text
//!   M(t, y) = (1/r) d d' + k(t) c c' + S      d = (cos y, sin y),  c = (-sin y, cos y) in (T, K)
//! ```
//!
//! has no eigenvalue below zero: in every direction the cutter is at least as round as the surface is hollow.
//! k grows with the tilt, so that M grows with it. A yaw turns the first two terms against S; the eigenvalues
//! are the same whichever of the two is turned, and a rotation by a small angle changes a form by at most
//! that angle times the difference of its curvatures: the smaller of 1/r - k and of the difference of the
//! surface's curvatures is the rate for each radian of yaw.

use super::search::Verdict;

/// Rounding of the curvatures as a part of the largest: a ball in a cylinder of its own radius fits.
const GRAIN: f64 = 1e-9;

/// Smallest eigenvalue of `[xx, xy, yy]`.
fn least(m: [f64; 3]) -> f64 {
    let (mean, half) = (0.5 * (m[0] + m[2]), 0.5 * (m[0] - m[2]));
    mean - half.hypot(m[1])
}

/// Curvature across the lean at a tilt with the sine `s`, 1/mm.
fn across(circle: f64, round: f64, s: f64) -> f64 {
    if circle <= 0.0 { 1.0 / round } else { s / (circle + round * s) }
}

/// Smallest difference of the normal curvatures, cutter less hollow of the surface, at a tilt (its sine) and
/// a yaw, 1/mm.
pub(crate) fn least_difference(circle: f64, round: f64, form: [f64; 3], tilt_sine: f64, yaw: f64) -> f64 {
    let (s, c) = yaw.sin_cos();
    let k = across(circle, round, tilt_sine);
    if round <= 0.0 {
        // A sharp corner is rounder than anything along the lean: what counts is the direction across.
        return k + form[0] * s * s - 2.0 * form[1] * s * c + form[2] * c * c;
    }
    let d = 1.0 / round;
    least([d * c * c + k * s * s + form[0], (d - k) * s * c + form[1], d * s * s + k * c * c + form[2]])
}

/// Whether the cutter is round enough over all of a cell: tilts from `low` to `high`, yaws `half` about
/// `yaw`.
pub(crate) fn judge(
    circle: f64,
    round: f64,
    form: Option<[f64; 3]>,
    low: f64,
    high: f64,
    yaw: f64,
    half: f64,
) -> Verdict {
    let Some(form) = form else { return Verdict::Free };
    let at = |tilt: f64| {
        let sine = tilt.sin();
        let k = across(circle, round, sine);
        // Two ways to turn one form against the other: the smaller spread of curvatures counts.
        let spread = 2.0 * (0.5 * (form[0] - form[2])).hypot(form[1]);
        let rate = if round > 0.0 { spread.min(1.0 / round - k) } else { spread };
        (least_difference(circle, round, form, sine, yaw), rate.max(0.0) * half)
    };
    let grain = GRAIN * form.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (worst, turn) = at(low);
    if worst - turn >= -grain {
        return Verdict::Free;
    }
    let (best, turn) = at(high);
    if best + turn < -grain { Verdict::Blocked } else { Verdict::Open }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curvature of a torus section by a plane through the contact normal, from its implicit equation by
    /// finite differences: shares nothing with the closed form.
    fn section_curvature(circle: f64, round: f64, tilt: f64, phi: f64) -> f64 {
        let (st, ct) = tilt.sin_cos();
        // Tool frame: axis z, contact in the +x half plane; outward normal there is (sin t, 0, -cos t) turned
        // to point down.
        let normal = [st, 0.0, -ct];
        let p = [circle + round * normal[0], 0.0, round * normal[2]];
        let (u, v) = ([ct, 0.0, st], [0.0, 1.0, 0.0]);
        let d: Vec<f64> = (0..3).map(|i| u[i] * phi.cos() + v[i] * phi.sin()).collect();
        let inside = |h: f64, t: f64| {
            let q: Vec<f64> = (0..3).map(|i| p[i] + d[i] * t - normal[i] * h).collect();
            (q[0].hypot(q[1]) - circle).hypot(q[2]) - round
        };
        let t = 1e-3;
        let (mut low, mut high) = (0.0, 0.1 * round);
        for _ in 0..80 {
            let mid = 0.5 * (low + high);
            if inside(mid, t) > 0.0 { low = mid } else { high = mid }
        }
        2.0 * low / (t * t)
    }

    #[test]
    fn normal_curvatures_of_a_torus_are_those_of_its_sections() {
        for (circle, round) in [(4.0, 1.0), (2.0, 3.0), (9.5, 0.5)] {
            for tilt in [0.1_f64, 0.4, 1.0, 1.5] {
                for phi in [0.0_f64, 0.5, 1.1, std::f64::consts::FRAC_PI_2] {
                    // A surface hollow by k in every direction leaves the least difference where the torus is
                    // flattest; one direction is picked by a surface that is convex by far across it.
                    let exact = section_curvature(circle, round, tilt, phi);
                    let k = tilt.sin() / (circle + round * tilt.sin());
                    let formula = phi.cos().powi(2) / round + phi.sin().powi(2) * k;
                    assert!(
                        (exact - formula).abs() < 1e-4 * formula.max(1.0),
                        "{circle} {round} {tilt} {phi}: {exact} {formula}"
                    );
                }
                let k = tilt.sin() / (circle + round * tilt.sin());
                let flattest = k.min(1.0 / round);
                let hollow = [-flattest, 0.0, -flattest];
                assert!(least_difference(circle, round, hollow, tilt.sin(), 0.7).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn cells_are_judged_as_all_of_their_poses() {
        let mut state = 5_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut free, mut blocked) = (0, 0);
        for n in 0..20_000 {
            let circle = if n % 4 == 0 { 0.0 } else { 10.0 * random() };
            let round = if n % 5 == 1 && circle > 0.0 { 0.0 } else { 0.1 + 4.0 * random() };
            let form = [random() - 0.6, 0.4 * random() - 0.2, random() - 0.6];
            let low = 1.5 * random();
            let high = (low + 0.3 * random()).min(1.57);
            let (yaw, half) = (6.0 * random() - 3.0, 0.3 * random());
            let verdict = judge(circle, round, Some(form), low, high, yaw, half);
            free += u32::from(verdict == Verdict::Free);
            blocked += u32::from(verdict == Verdict::Blocked);
            for _ in 0..20 {
                let t = low + (high - low) * random();
                let y = yaw + half * (2.0 * random() - 1.0);
                let value = least_difference(circle, round, form, t.sin(), y);
                assert!(!(verdict == Verdict::Free && value < -1e-8), "free, but {value}");
                assert!(!(verdict == Verdict::Blocked && value > 1e-8), "blocked, but {value}");
            }
        }
        assert!(free > 2000 && blocked > 2000, "{free} {blocked}");
    }
}
