//! Ridges between two equal passes of a ball end, in closed form.
//!
//! ```text
//!         centers of the ball          the triangle of one center, the axis of the cylinder and the
//!           o--------.--------o        ridge has the sides rho + R, rho + h and R; its angle at the
//!            \   R  /|                 axis is a, and the contacts lie rho sin a to either side of the
//!             \    / | h               ridge:
//!    rho + R   \  /__|______             R^2 = (rho + R)^2 + (rho + h)^2 - 2 (rho + R) (rho + h) cos a
//!               \ |  |                   L   = 2 rho sin a
//!                \a  | rho
//!                 \  |
//! ```
//!
//! Ma et al. 2020, equation (7), is this solved for h. On a concave cylinder rho < 0 stands for their third
//! form, and rho to infinity for (6).

/// A ridge of this height (mm) lies between two passes of a ball with these contacts.
///
/// `radius` of the ball and `step` between the contacts (their chord) in mm; `curvature` of the surface
/// across the feed in 1/mm, positive where it is convex. None where the balls do not meet, or do not fit into
/// a hollow.
///
/// ```
/// use proveout_surface::scallop::{ball_scallop, ball_step};
///
/// // A ball of 4 mm radius, contacts 2 mm apart on a plane: R - sqrt(R^2 - L^2 / 4).
/// let height = ball_scallop(4.0, 2.0, 0.0).expect("the cuts meet");
/// assert!((height - (4.0 - 15_f64.sqrt())).abs() < 1e-12); // mm
/// let step = ball_step(4.0, height, 0.0).expect("below the radius");
/// assert!((step - 2.0).abs() < 1e-9);
/// assert_eq!(ball_scallop(4.0, 2.0, -0.5), None); // no ball of 4 mm fits a hollow of 2 mm
/// ```
pub fn ball_scallop(radius: f64, step: f64, curvature: f64) -> Option<f64> {
    let half = 0.5 * step;
    let grown = 1.0 + curvature * radius;
    let (inside, below) = (1.0 - (half * curvature).powi(2), radius * radius - (grown * half).powi(2));
    if !(radius > 0.0 && grown > 0.0 && inside >= 0.0 && below >= 0.0) {
        return None;
    }
    // (rho + R)/rho sqrt(rho^2 - L^2/4) - rho, without the loss of figures where rho is large.
    let root = inside.sqrt();
    let lifted = radius * root - curvature * half * half / (1.0 + root);
    Some(lifted - below.sqrt())
}

/// The step between the contacts of two passes of a ball that leave a ridge of this height, mm: inverse of
/// [`ball_scallop`].
pub fn ball_step(radius: f64, scallop: f64, curvature: f64) -> Option<f64> {
    let grown = 1.0 + curvature * radius;
    if !(radius > 0.0 && grown > 0.0 && scallop >= 0.0 && scallop <= radius) {
        return None;
    }
    // 1 - cos a = (R^2 - (R - h)^2) rho^-2 / (2 (1 + R/rho) (1 + h/rho)), written with curvatures; then L = 2
    // rho sin a.
    let versed = (2.0 * radius * scallop - scallop * scallop) / (2.0 * grown * (1.0 + curvature * scallop));
    let squared = versed * (2.0 - versed * curvature * curvature);
    (squared >= 0.0).then(|| 2.0 * squared.sqrt())
}
