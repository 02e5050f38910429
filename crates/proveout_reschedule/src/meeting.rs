//! Whether a new tool axis brings shank or holder into what they must not touch, and how deep.
//!
//! The distance of two bodies that overlap is zero, however deep they overlap. The depth given here
//! is how far the tool must be drawn back along its axis to come free. Bodies that come free within
//! [`TOUCH_MM`] touch and do not overlap: ends of blocks are rounded to that.

use proveout_geom::ToolPose;

use super::FeasibleRegion;

/// Distance below which bodies meet, mm.
const MEETS: f64 = 1e-6;
/// A tool that is free when it is drawn back by so much touches, mm: the last digit of a program.
const TOUCH_MM: f64 = 1e-3;
/// Farthest way back that is looked at, mm.
const FARTHEST_MM: f64 = 1000.0;
/// Halvings of the way back.
const HALVINGS: usize = 40;

/// How deep a new pose is in what the old one is free of, in words; none where it is free or touches.
pub(super) fn newly_met(region: &(impl FeasibleRegion + ?Sized), new: &ToolPose, old: &ToolPose) -> Option<String> {
    let met = |pose: &ToolPose| region.clearance_up_to(pose, MEETS) <= 0.0;
    if !met(new) || met(old) {
        return None;
    }
    let back = |by: f64| ToolPose { tip: new.tip + new.axis * by, axis: new.axis };
    let (mut low, mut high) = (0.0, TOUCH_MM);
    if !met(&back(high)) {
        return None;
    }
    while met(&back(high)) {
        (low, high) = (high, 2.0 * high);
        if high > FARTHEST_MM {
            return Some(format!("more than {FARTHEST_MM} mm"));
        }
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if met(&back(middle)) { low = middle } else { high = middle }
    }
    Some(format!("{high:.3} mm"))
}

#[cfg(test)]
mod tests {
    use proveout_geom::{Point, Vector};

    use super::*;

    /// Everything below a height is solid; the end of the shank is 10 mm above the tip.
    struct Floor(f64);

    impl FeasibleRegion for Floor {
        fn clearance(&self, pose: &ToolPose) -> f64 {
            ((pose.tip + pose.axis * 10.0).z - self.0).max(0.0)
        }
    }

    #[test]
    fn a_depth_is_reported_and_a_touch_is_none() {
        let at = |z: f64| ToolPose { tip: Point::new(0.0, 0.0, z), axis: Vector::z() };
        let old = at(5.0);
        for (z, wanted) in [
            (0.1, None),
            (0.0, None),
            (-0.0005, None),
            (-0.0021, Some("0.002 mm")),
            (-1.25, Some("1.250 mm")),
            (-5000.0, Some("more than 1000 mm")),
        ] {
            assert_eq!(newly_met(&Floor(10.0), &at(z), &old).as_deref(), wanted, "{z}");
        }
        assert_eq!(newly_met(&Floor(10.0), &at(-1.0), &at(-1.0)), None, "the program before was in it too");
    }
}
