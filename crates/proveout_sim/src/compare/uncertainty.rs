//! The error of a gain.
//!
//! A gain is the difference of two predicted times on the same twin, so that most of what is wrong with the
//! twin is wrong with both times and falls out. What is left is found by changing one parameter of the twin
//! at a time and taking the gain again; `d` is the largest change of the gain over the values that a
//! parameter was given.
//!
//! *Numerical parameters* (tolerances of the computation, window, cycle) have a true answer that their
//! refinement tends to. Their errors have unknown but fixed signs and need not be independent: they add up,
//! `n = sum of |d|`.
//!
//! *Model parameters* (joint limits, path tolerance, dynamics) are known only to lie in a range; `d` is the
//! half width of what that range makes of the gain. For a quantity of which only bounds are known the
//! standard uncertainty is `d / sqrt 3` (rectangular distribution: JCGM 100:2008, GUM, 4.3.7), independent
//! parameters combine as the root of the sum of squares (GUM 5.1.2, eq. 10), and coverage factor 2 (about 95
//! percent, GUM 6.3.3) gives `m = 2 sqrt(sum of d^2 / 3)`.
//!
//! The error is `n + m`. It says how far the gain on this twin can be trusted when the machine is
//! of the modeled kind with limits in the stated ranges. What no parameter represents (the cut,
//! another control's strategy) is not in it.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a variation represents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum VariationKind {
    /// Precision of the computation: its effect should vanish.
    Numerical,
    /// A parameter of the machine or its control that is not known exactly: its effect is real.
    Model,
}

/// A gain in time with its error, percent of the baseline's time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TimeGain {
    /// Time saved: `100 (1 - time / time of the baseline)`; null where the baseline takes no time.
    pub percent: Option<f64>,
    /// The same as gain in rate: `100 (time of the baseline / time - 1)`.
    pub rate_percent: Option<f64>,
    /// Error of `percent`: numerical and model part together; null without a variation.
    pub error_percent: Option<f64>,
    /// Part of the error that comes from the computation.
    pub numerical_percent: Option<f64>,
    /// Part of the error that comes from the model.
    pub model_percent: Option<f64>,
    /// Smallest gain of the nominal twin and all variations.
    pub smallest_percent: Option<f64>,
    /// Largest of them.
    pub largest_percent: Option<f64>,
    /// The gain has the sign of the nominal one under every variation that was made.
    pub sign_holds: bool,
    /// The gain is larger than its error.
    pub exceeds_error: bool,
}

/// The gain under one variation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VariedGain<'a> {
    pub(crate) parameter: &'a str,
    pub(crate) kind: VariationKind,
    /// Gain, percent.
    pub(crate) percent: f64,
}

/// Time saved, percent of the baseline's time; none where the baseline takes no time.
pub(crate) fn saved(baseline: f64, time: f64) -> Option<f64> {
    Some(100.0 * (1.0 - time / baseline)).filter(|p| p.is_finite())
}

/// The gain of a time against that of the baseline, with its error from the variations.
pub(crate) fn time_gain(baseline: f64, time: f64, varied: &[VariedGain<'_>]) -> TimeGain {
    let Some(nominal) = saved(baseline, time) else { return TimeGain::default() };
    let mut largest: BTreeMap<(VariationKind, &str), f64> = BTreeMap::new();
    for v in varied {
        let change = (v.percent - nominal).abs();
        let worst = largest.entry((v.kind, v.parameter)).or_default();
        *worst = worst.max(change);
    }
    let of = |kind| largest.iter().filter(move |((k, _), _)| *k == kind).map(|(_, d)| *d);
    let numerical: f64 = of(VariationKind::Numerical).sum();
    let model = 2.0 * (of(VariationKind::Model).map(|d| d * d).sum::<f64>() / 3.0).sqrt();
    let all = || varied.iter().map(|v| v.percent).chain([nominal]);
    let made = !varied.is_empty();
    TimeGain {
        percent: Some(nominal),
        rate_percent: Some(100.0 * (baseline / time - 1.0)).filter(|p| p.is_finite()),
        error_percent: made.then_some(numerical + model),
        numerical_percent: made.then_some(numerical),
        model_percent: made.then_some(model),
        smallest_percent: Some(all().fold(f64::INFINITY, f64::min)),
        largest_percent: Some(all().fold(f64::NEG_INFINITY, f64::max)),
        sign_holds: made && nominal != 0.0 && all().all(|p| p * nominal > 0.0),
        exceeds_error: made && nominal.abs() > numerical + model,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn varied<'a>(parameter: &'a str, kind: VariationKind, percent: f64) -> VariedGain<'a> {
        VariedGain { parameter, kind, percent }
    }

    #[test]
    fn saved_time_and_rate_are_the_two_readings_of_one_gain() {
        // The paper's example: 24.5 percent less time is 32.45 percent more rate.
        let gain = time_gain(100.0, 75.5, &[]);
        assert!((gain.percent.expect("a time") - 24.5).abs() < 1e-12);
        assert!((gain.rate_percent.expect("a time") - 100.0 * 24.5 / 75.5).abs() < 1e-12);
        assert_eq!(gain.error_percent, None, "nothing was varied");
        assert!(!gain.sign_holds && !gain.exceeds_error, "nothing was varied, nothing is proved");
    }

    #[test]
    fn numerical_errors_add_up_and_model_errors_combine_as_squares() {
        use VariationKind::{Model, Numerical};
        let all = [
            varied("cycle", Numerical, 10.01),
            varied("cycle", Numerical, 9.97),
            varied("window", Numerical, 10.02),
            varied("acceleration", Model, 13.0),
            varied("acceleration", Model, 9.0),
            varied("jerk", Model, 6.0),
        ];
        let gain = time_gain(100.0, 90.0, &all);
        // Largest change of each parameter: 0.03 and 0.02; 3 and 4.
        assert!((gain.numerical_percent.expect("varied") - 0.05).abs() < 1e-9);
        assert!((gain.model_percent.expect("varied") - 2.0 * 5.0 / 3.0_f64.sqrt()).abs() < 1e-9);
        let sum = 0.05 + 10.0 / 3.0_f64.sqrt();
        assert!((gain.error_percent.expect("varied") - sum).abs() < 1e-9);
        assert!(gain.sign_holds && gain.exceeds_error);
        assert_eq!((gain.smallest_percent, gain.largest_percent), (Some(6.0), Some(13.0)));
    }

    #[test]
    fn one_variation_of_the_other_sign_breaks_the_sign() {
        let all = [varied("jerk", VariationKind::Model, -0.1), varied("cycle", VariationKind::Numerical, 1.0)];
        let gain = time_gain(100.0, 99.0, &all);
        assert!(!gain.sign_holds && !gain.exceeds_error);
        let loss = time_gain(100.0, 104.0, &[varied("jerk", VariationKind::Model, -3.0)]);
        assert!(loss.sign_holds, "a loss that stays a loss holds its sign: {loss:?}");
    }

    #[test]
    fn the_order_of_variations_does_not_change_a_bit() {
        let mut all: Vec<VariedGain<'_>> = (0..12)
            .map(|i| {
                let kind = if i % 3 == 0 { VariationKind::Numerical } else { VariationKind::Model };
                varied(["a", "b", "c", "d", "e", "f"][i % 6], kind, 10.0 + (i as f64 * 0.7).sin())
            })
            .collect();
        let forward = time_gain(7.0, 6.3, &all);
        all.reverse();
        assert_eq!(time_gain(7.0, 6.3, &all), forward);
    }

    #[test]
    fn a_baseline_without_time_has_no_gain() {
        assert_eq!(time_gain(0.0, 0.0, &[]), TimeGain::default());
    }
}
