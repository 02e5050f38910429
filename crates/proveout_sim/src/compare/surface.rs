//! Scallop of a cut part, and cut parts compared with each other.

use super::result::Difference;
use crate::{SurfaceMap, units::UM_PER_MM, verdict::verdict_file::Surface};

/// The rule of [`scallop`], in words.
pub(crate) const SCALLOP_RULE: &str = "Where the scene sets `scallop_um`: heights of the ridges between passes above the design, found on the swept surfaces and weighed with \
     their length; each has its error bound, and a criterion whose limit lies within the bound is unchecked. Otherwise the largest and mean material left over the design at the exact points in the judged box (gouged points count \
     as zero): between the turns of a finishing pass this is the kinematic scallop with the path's deviation and the design's own error \
     on it. Unchecked where the scene has no judged box, or where a judged point is skin of the stock";

/// Fills in the scallop where the run has not evaluated it.
///
/// The material left over the design is the scallop only where the whole judged area was cut: a point that is
/// still skin of the stock was not reached, and its height is an allowance. Then nothing is filled in.
pub(crate) fn scallop(surface: &Surface, map: &SurfaceMap, judged: bool) -> Surface {
    let mut out = surface.clone();
    if out.scallop_max_um.is_some() || !judged {
        return out;
    }
    let (mut sum, mut count, mut largest) = (0.0, 0.0, 0.0_f64);
    for (point, weight) in map.weighted_points() {
        let Some(deviation) = point.deviation else { continue };
        if point.made_by.is_none() {
            return out;
        }
        sum += weight * deviation.max(0.0);
        count += weight;
        largest = largest.max(deviation);
    }
    if count > 0.0 {
        out.scallop_max_um = Some(UM_PER_MM * largest);
        out.scallop_mean_um = Some(UM_PER_MM * sum / count);
    }
    out
}

/// Statistics of a deviation less another one at the same places, mm; places where one of them is not a
/// number do not count.
pub(crate) fn difference(values: &[f64]) -> Difference {
    let (mut count, mut sum, mut squares) = (0_u64, 0.0, 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.iter().filter(|v| v.is_finite()) {
        count += 1;
        sum += v;
        squares += v * v;
        (low, high) = (low.min(*v), high.max(*v));
    }
    let known = |v: f64| (count > 0).then_some(v);
    Difference {
        samples: count,
        mean_mm: known(sum / count as f64),
        rms_mm: known((squares / count as f64).sqrt()),
        min_mm: known(low),
        max_mm: known(high),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MapPoint;

    fn map(points: &[MapPoint]) -> SurfaceMap {
        SurfaceMap { points: points.to_vec(), ..SurfaceMap::default() }
    }

    fn point(deviation: Option<f64>, made_by: Option<u32>) -> MapPoint {
        MapPoint {
            position: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            deviation,
            scallop: None,
            scallop_geometric: None,
            made_by,
        }
    }

    #[test]
    fn turns_of_a_ball_leave_their_closed_form() {
        // A ball of 8 mm at 1 mm pitch over a plane: h(x) = 8 - sqrt(64 - x^2), |x| <= 0.5; mean of x^2 / 16
        // is 1 / 192 mm but for the fourth order, which adds less than 0.1 percent.
        let n = 20_000;
        let points: Vec<MapPoint> = (0..=n)
            .map(|i| {
                let x = f64::from(i) / f64::from(n) - 0.5;
                point(Some(8.0 - (64.0 - x * x).sqrt()), Some(1))
            })
            .collect();
        let s = scallop(&Surface::default(), &map(&points), true);
        assert!((s.scallop_max_um.expect("cut") - 1e3 * (8.0 - 63.75_f64.sqrt())).abs() < 1e-9);
        assert!((s.scallop_mean_um.expect("cut") * 192e-3 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn skin_of_the_stock_is_no_scallop() {
        let cut = [point(Some(0.01), Some(3)), point(None, None), point(Some(-0.5), Some(4))];
        let s = scallop(&Surface::default(), &map(&cut), true);
        assert_eq!((s.scallop_max_um, s.scallop_mean_um), (Some(10.0), Some(5.0)));
        assert_eq!(scallop(&Surface::default(), &map(&cut), false), Surface::default(), "nothing says where to look");
        let skin = [cut[0], point(Some(0.5), None)];
        assert_eq!(scallop(&Surface::default(), &map(&skin), true), Surface::default());
        let known = Surface { scallop_max_um: Some(7.0), ..Surface::default() };
        assert_eq!(scallop(&known, &map(&cut), true), known, "what the run has evaluated stays");
    }

    #[test]
    fn differences_are_taken_where_both_parts_are_measured() {
        let d = difference(&[f64::NAN, 0.003, -0.001, f64::NAN, 0.001]);
        assert_eq!((d.samples, d.min_mm, d.max_mm), (3, Some(-0.001), Some(0.003)));
        assert!((d.mean_mm.expect("three") - 0.001).abs() < 1e-15);
        assert!((d.rms_mm.expect("three") - (11e-6_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(difference(&[f64::NAN]), Difference::default());
    }
}
