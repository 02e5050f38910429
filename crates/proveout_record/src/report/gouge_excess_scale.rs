//! Scales of the deviation colors on the page: one for gouge and one for excess, so that neither drowns the
//! other.

use crate::{color::LEAST_FLOOR_MM, deviation_classes::Classes};

/// Share of the points of a side that its scale holds; above it are outliers.
const SHARE: f64 = 0.99;
/// Tolerances up to which the scale of a side reaches at first: what is far out of tolerance has one color,
/// so that a clamping stub or a design in another unit does not make everything else look alike.
const TOLERANCES: f64 = 20.0;
/// A value may be above a number of two digits by this part of the second and still be rounded to it:
/// rounding.
const ROUNDING: f64 = 1e-9;

/// Lengths that one side may be scaled to, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Scale {
    /// With which the page begins.
    pub(crate) shown: f64,
    /// 99 percent of the points of this side are below it.
    pub(crate) most_points: f64,
    /// The largest deviation of this side.
    pub(crate) largest: f64,
    /// The tolerance of the scene.
    pub(crate) tolerance: f64,
}

/// Scales of both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Scales {
    pub(crate) gouge: Scale,
    pub(crate) excess: Scale,
}

impl Scales {
    /// The scales of counted deviations; none without any. `tolerance` is that of gouge and of excess, mm.
    pub(crate) fn of(classes: &Classes, tolerance: [f64; 2], floor: f64) -> Option<Self> {
        let all: Vec<(f64, f64)> = classes.weights().filter(|(v, w)| v.is_finite() && *w > 0.0).collect();
        if all.is_empty() {
            return None;
        }
        let floor = if floor.is_finite() { floor.max(LEAST_FLOOR_MM) } else { LEAST_FLOOR_MM };
        let side = |sign: f64, tolerance: f64| {
            let mut of: Vec<(f64, f64)> =
                all.iter().filter(|(v, _)| v * sign > 0.0).map(|(v, w)| (v.abs(), *w)).collect();
            of.sort_by(|a, b| a.0.total_cmp(&b.0));
            let sum: f64 = of.iter().map(|c| c.1).sum();
            let mut before = 0.0;
            let most = of.iter().find(|(_, w)| {
                before += w;
                before >= SHARE * sum
            });
            let most_points = most.map_or(0.0, |c| c.0).max(floor);
            let tolerance = if tolerance.is_finite() && tolerance > 0.0 { tolerance } else { floor };
            Scale {
                shown: rounded(most_points.min((TOLERANCES * tolerance).max(floor))),
                most_points,
                largest: of.last().map_or(0.0, |c| c.0).max(floor),
                tolerance,
            }
        };
        Some(Self { gouge: side(-1.0, tolerance[0]), excess: side(1.0, tolerance[1]) })
    }

    /// Place of a deviation between the ends of both scales, below 0 and above 1 past them; 0.5 on the
    /// design.
    pub(crate) fn position(&self, deviation: f64) -> f64 {
        let range = if deviation < 0.0 { self.gouge.shown } else { self.excess.shown };
        0.5 + 0.5 * deviation / range
    }
}

/// Two significant digits, not below the value.
fn rounded(value: f64) -> f64 {
    let power = value.log10().floor() as i32 - 1;
    let tens = (value / 10_f64.powi(power) - ROUNDING).ceil();
    // Divided by a whole number where it can be: 13 / 1000 prints well, 13 * 0.001 does not.
    if power < 0 { tens / 10_f64.powi(-power) } else { tens * 10_f64.powi(power) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn classes(values: impl IntoIterator<Item = f64>) -> Classes {
        let mut all = Classes::default();
        values.into_iter().for_each(|v| all.add(v, 1.0));
        all
    }

    #[test]
    fn each_side_has_its_own_and_a_stub_does_not_drown_the_rest() {
        // Half of the points lie 146 mm above the design.
        let values = (0..1000).map(|i| if i % 2 == 0 { 146.0 } else { -0.001 - 1e-5 * f64::from(i) });
        let s = Scales::of(&classes(values), [0.02, 0.05], 0.002).expect("points");
        assert!((s.excess.shown - 1.0).abs() < 1e-12, "twenty tolerances: {s:?}");
        assert!((s.excess.largest - 146.0).abs() < 0.1 && (s.excess.most_points - 146.0).abs() < 0.1);
        assert!((s.gouge.shown - 0.011).abs() < 1e-9, "{s:?}");
        assert_eq!((s.position(0.0), s.position(-s.gouge.shown), s.position(s.excess.shown)), (0.5, 0.0, 1.0));
    }

    #[test]
    fn sides_without_points_keep_the_floor_and_no_points_have_no_scale() {
        assert_eq!(Scales::of(&Classes::default(), [0.01, 0.01], 0.001), None);
        let s = Scales::of(&classes([0.004; 30]), [0.01, f64::NAN], 0.001).expect("points");
        assert_eq!(s.gouge, Scale { shown: 0.001, most_points: 0.001, largest: 0.001, tolerance: 0.01 });
        assert!((s.excess.shown - 0.004).abs() < 2e-4 && s.excess.tolerance == 0.001);
    }

    #[test]
    fn two_digits_and_never_below() {
        for (value, wanted) in [(0.0123, 0.013), (1.0, 1.0), (146.2, 150.0), (0.5, 0.5), (9.99, 10.0), (2e-6, 2e-6)] {
            assert!((rounded(value) - wanted).abs() < 1e-9 * wanted.max(1.0), "{value}: {}", rounded(value));
        }
    }
}
