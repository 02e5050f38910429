//! The inset of s-theta by a search over the peak of acceleration.
//!
//! Li et al. 2022 leave open how far key points stay from the limits of the channel, yet the peak
//! of acceleration varies by a third with this inset. The peak has several minima and is cheap to
//! compute: insets a quarter of a degree apart are tried as far as the channel leaves room for
//! them, then the neighborhood of the best one by the golden section (J. Kiefer 1953, Sequential
//! minimax search for a maximum). The result is the best of all insets tried; all of them are
//! shown.

use super::smooth::peaks;
use super::{
    Channel, Curve, CurveKind, CuttingRun, Figure, Method, Quantity, RescheduleError, Rescheduled, STheta, SectionPath,
    Surroundings,
};

/// Steps and end of the search, radian.
const STEP: f64 = 0.25 * std::f64::consts::PI / 180.0;
const MOST: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Part of a bracket that the golden section keeps, and how often.
const GOLDEN: f64 = 0.618_033_988_749_894_8;
const SECTIONS: usize = 12;

/// S-theta with the inset of the least peak of acceleration at the programmed feed; what the method itself
/// says of its inset is not looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchedInset(pub STheta);

impl SearchedInset {
    /// Peaks of acceleration over insets that can be planned, rad/s2 and radian, in the order in which they
    /// were looked at.
    fn tried(&self, path: &SectionPath, channel: &Channel, least: &[f64]) -> Vec<[f64; 2]> {
        let narrowest = (0..path.len()).map(|i| channel.width(i)).fold(f64::MAX, f64::min);
        let end = MOST.min(0.5 * narrowest);
        let peak = |inset: f64| {
            let plan = STheta { inset, ..self.0 }.plan(path, channel).ok()?;
            Some([inset, peaks(&plan.angles, least)[1]])
        };
        let count = (end / STEP).floor() as usize;
        let mut tried: Vec<[f64; 2]> = (1..=count).filter_map(|k| peak(STEP * k as f64)).collect();
        let Some([best, _]) = best(&tried) else { return tried };
        let (mut low, mut high) = ((best - STEP).max(0.1 * STEP), (best + STEP).min(end));
        let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
        for _ in 0..SECTIONS {
            let found = inner(low, high).map(peak);
            let of = |found: Option<[f64; 2]>| found.map_or(f64::INFINITY, |f| f[1]);
            let [a, b] = inner(low, high);
            if of(found[0]) <= of(found[1]) {
                high = b
            } else {
                low = a
            }
            tried.extend(found.into_iter().flatten());
        }
        tried
    }
}

fn best(tried: &[[f64; 2]]) -> Option<[f64; 2]> {
    tried.iter().copied().min_by(|a, b| a[1].total_cmp(&b[1]))
}

impl Method for SearchedInset {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn source(&self) -> &'static str {
        self.0.source()
    }

    fn reschedule(&self, run: &CuttingRun, around: &Surroundings<'_>) -> Result<Rescheduled, RescheduleError> {
        let path = SectionPath::new(run, around)?;
        let own = run.blocks.get(path.stretch()).unwrap_or_default();
        let untimed = own.iter().skip(1).find(|b| b.time.is_none_or(|t| !(t.is_finite() && t > 0.0)));
        if let Some(block) = untimed {
            let message = "the program gives this block no feed, so its acceleration is not known";
            let help = "program a feed before it, or give inset_deg in degrees";
            return Err(RescheduleError::new("reschedule-path", block.line, message, help));
        }
        let least: Vec<f64> = own.iter().skip(1).filter_map(|b| b.time).collect();
        let channel = Channel::tabulated(&path, self.0.clearance, 2.0 * STEP)?;
        let tried = self.tried(&path, &channel, &least);
        // Where none can be planned the method says why.
        let [inset, peak] = best(&tried).unwrap_or([STEP, f64::NAN]);
        let mut made = STheta { inset, ..self.0 }.reschedule(run, around)?;
        let figure = |name, unit, value| Figure { name, unit, value };
        made.study.figures.extend([
            figure("inset that was found", "deg", inset.to_degrees()),
            figure("peak acceleration at the programmed feed", "deg/s2", peak.to_degrees()),
            figure("insets that were looked at", "", tried.len() as f64),
        ]);
        let mut points: Vec<[f64; 2]> = tried.iter().map(|t| t.map(f64::to_degrees)).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let axes = [
            Quantity { name: "inset of the key points", unit: "deg" },
            Quantity { name: "peak acceleration at the programmed feed", unit: "deg/s2" },
        ];
        made.study.curves.push(Curve { name: "peak over the inset", kind: CurveKind::Result, axes, points });
        Ok(made)
    }
}
