//! Signals over time as few knots with straight lines between them, within a tolerance that is known.

use crate::page_encoding::DeltaWriter;

/// Most knots of a series: some 2 MB of page for six signals.
const MOST_KNOTS: usize = 150_000;
/// Most doublings of the tolerances at once: a million times the first.
const MOST_DOUBLINGS: usize = 20;
/// Steps of the time of a knot in a second.
pub(crate) const TIME_STEPS: f64 = 1e4;

/// A series of samples of several signals, thinned while it grows.
///
/// Between neighboring knots each signal is a straight line over time. A sample is left out as long as one
/// line from the last knot to the newest sample passes all samples between within the tolerance of each
/// signal (interval of slopes, Bristol 1990, "swinging door"): the bound holds at every sample that was
/// pushed. When there are too many knots the tolerances double, and the knots themselves are thinned in the
/// same way; the bound is then the sum of all tolerances, since two lines are farthest apart at one of their
/// knots.
#[derive(Clone, Debug)]
pub(crate) struct KnotSeries {
    tolerances: Vec<f64>,
    /// Tolerances in force and bound so far, as multiples of the first tolerances.
    factor: f64,
    bound: f64,
    times: Vec<f64>,
    /// One value a signal, knot by knot.
    values: Vec<f64>,
    /// Knots that thinning keeps as long as they are few.
    exact: Vec<bool>,
    /// Newest sample, not a knot yet.
    held: Option<(f64, Vec<f64>)>,
    /// Slopes of the lines from the last knot that pass all samples since within the tolerances.
    slopes: Vec<[f64; 2]>,
}

const ANY_SLOPE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl KnotSeries {
    /// A series of as many signals as there are tolerances.
    pub(crate) fn new(tolerances: Vec<f64>) -> Self {
        Self {
            slopes: vec![ANY_SLOPE; tolerances.len()],
            tolerances,
            factor: 1.0,
            bound: 1.0,
            times: Vec::new(),
            values: Vec::new(),
            exact: Vec::new(),
            held: None,
        }
    }

    fn signals(&self) -> usize {
        self.tolerances.len()
    }

    /// Knots so far.
    pub(crate) fn len(&self) -> usize {
        self.times.len()
    }

    /// Largest distance of each signal from its samples.
    pub(crate) fn bounds(&self) -> Vec<f64> {
        self.tolerances.iter().map(|t| t * self.bound).collect()
    }

    /// Adds a sample; one that is not finite, or earlier than the one before, is left out. `exact`: it
    /// becomes a knot itself.
    pub(crate) fn push(&mut self, time: f64, values: &[f64], exact: bool) {
        if self.signals() == 0 || values.len() != self.signals() {
            return;
        }
        self.add(time, values, exact);
        if self.times.len() > MOST_KNOTS {
            self.thin();
        }
    }

    fn add(&mut self, time: f64, values: &[f64], exact: bool) {
        if !time.is_finite() || !values.iter().all(|v| v.is_finite()) {
            return;
        }
        let newest = self.held.as_ref().map(|h| h.0).or_else(|| self.times.last().copied());
        match newest {
            None => return self.keep(time, values, exact),
            Some(last) if time < last => return,
            Some(last) if time == last => {
                // A jump: the line ends at the value before, and the next begins at this one.
                let same = match &self.held {
                    Some((_, held)) => held == values,
                    None => self.last_values() == values,
                };
                if same && !exact {
                    return;
                }
                self.close();
                if !same {
                    self.keep(time, values, exact);
                } else if let Some(last) = self.exact.last_mut() {
                    *last = true;
                }
                return;
            }
            Some(_) => {}
        }
        if !self.passes(time, values) {
            self.close();
        }
        self.narrow(time, values);
        self.held = Some((time, values.to_vec()));
        if exact {
            self.close();
            if let Some(last) = self.exact.last_mut() {
                *last = true;
            }
        }
    }

    fn last_values(&self) -> &[f64] {
        &self.values[self.values.len().saturating_sub(self.signals())..]
    }

    fn last_knot(&self) -> (f64, &[f64]) {
        (self.times.last().copied().unwrap_or(0.0), self.last_values())
    }

    /// True when the line from the last knot to a sample passes all since then.
    fn passes(&self, time: f64, values: &[f64]) -> bool {
        let (begin, from) = self.last_knot();
        let slope = |k: usize| (values[k] - from[k]) / (time - begin);
        time > begin && (0..self.signals()).all(|k| (self.slopes[k][0]..=self.slopes[k][1]).contains(&slope(k)))
    }

    fn narrow(&mut self, time: f64, values: &[f64]) {
        let (begin, from) = self.last_knot();
        if time <= begin {
            return;
        }
        let ends: Vec<[f64; 2]> = (0..self.signals())
            .map(|k| {
                let tolerance = self.tolerances[k] * self.factor;
                [values[k] - tolerance, values[k] + tolerance].map(|v| (v - from[k]) / (time - begin))
            })
            .collect();
        for (slope, [low, high]) in self.slopes.iter_mut().zip(ends) {
            *slope = [slope[0].max(low), slope[1].min(high)];
        }
    }

    /// Makes the newest sample a knot.
    fn close(&mut self) {
        if let Some((time, values)) = self.held.take() {
            self.keep(time, &values, false);
        }
    }

    fn keep(&mut self, time: f64, values: &[f64], exact: bool) {
        self.times.push(time);
        self.values.extend_from_slice(values);
        self.exact.push(exact);
        self.slopes.fill(ANY_SLOPE);
    }

    /// Doubles the tolerances until a quarter of the knots has gone.
    fn thin(&mut self) {
        for _ in 0..MOST_DOUBLINGS {
            self.double();
            if self.times.len() * 4 <= MOST_KNOTS * 3 {
                return;
            }
        }
        self.halve();
    }

    fn double(&mut self) {
        let width = self.signals();
        let keep_exact = self.exact.iter().filter(|e| **e).count() * 2 < MOST_KNOTS;
        let (times, values, exact) =
            (std::mem::take(&mut self.times), std::mem::take(&mut self.values), std::mem::take(&mut self.exact));
        let held = self.held.take();
        self.factor *= 2.0;
        self.bound += self.factor;
        self.slopes.fill(ANY_SLOPE);
        for ((time, row), exact) in times.iter().zip(values.chunks_exact(width)).zip(exact) {
            self.add(*time, row, exact && keep_exact);
        }
        if let Some((time, row)) = held {
            self.add(time, &row, false);
        }
    }

    /// Drops every other knot, where a signal jumps too far at too many of them; the bound is then not known.
    fn halve(&mut self) {
        let width = self.signals();
        let keep = |i: usize, last: usize| i.is_multiple_of(2) || i == last;
        let last = self.times.len().saturating_sub(1);
        self.values = self
            .values
            .chunks_exact(width)
            .enumerate()
            .filter(|(i, _)| keep(*i, last))
            .flat_map(|(_, v)| v.to_vec())
            .collect();
        self.times = self.times.iter().enumerate().filter(|(i, _)| keep(*i, last)).map(|(_, t)| *t).collect();
        self.exact = self.exact.iter().enumerate().filter(|(i, _)| keep(*i, last)).map(|(_, e)| *e).collect();
        self.slopes.fill(ANY_SLOPE);
        self.bound = f64::INFINITY;
    }

    /// Ends the series with its newest sample.
    pub(crate) fn finish(&mut self) {
        self.close();
    }

    /// The knots packed for the page, little endian:
    ///
    /// ```text
    /// u32       knots
    /// varint    time of all knots, 0.1 ms, zigzag of the differences
    /// varint    first signal of all knots in steps of its own, likewise; then the second, and so on
    /// ```
    pub(crate) fn pack(&self, steps: &[f64], out: &mut Vec<u8>) {
        out.extend((self.times.len() as u32).to_le_bytes());
        let mut deltas = DeltaWriter::default();
        for time in &self.times {
            deltas.put((time * TIME_STEPS).round() as i64, out);
        }
        for k in 0..self.signals() {
            let mut deltas = DeltaWriter::default();
            let step = steps.get(k).copied().unwrap_or(1.0);
            for row in self.values.chunks_exact(self.signals()) {
                deltas.put((row[k] / step).round() as i64, out);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of a signal at a time, as the page interpolates it.
    fn at(series: &KnotSeries, signal: usize, time: f64) -> f64 {
        let width = series.signals();
        let value = |i: usize| series.values[i * width + signal];
        let after = series.times.partition_point(|t| *t <= time);
        match after {
            0 => value(0),
            n if n == series.times.len() => value(n - 1),
            n => {
                let (a, b) = (series.times[n - 1], series.times[n]);
                value(n - 1) + (value(n) - value(n - 1)) * (time - a) / (b - a)
            }
        }
    }

    fn samples(count: usize) -> impl Iterator<Item = (f64, [f64; 2])> {
        (0..count).map(|i| {
            let t = i as f64 * 0.002;
            (t, [300.0 * (0.7 * t).sin(), if (5.0..9.0).contains(&t) { 40.0 } else { 10.0 * t }])
        })
    }

    #[test]
    fn every_sample_lies_within_the_bound_and_straight_lines_are_two_knots() {
        let mut series = KnotSeries::new(vec![0.05, 0.01]);
        for (t, v) in samples(20_000) {
            series.push(t, &v, false);
        }
        series.finish();
        for (t, v) in samples(20_000) {
            for (k, value) in v.into_iter().enumerate() {
                // At the jump two lines meet within one sample.
                assert!((at(&series, k, t) - value).abs() <= series.bounds()[k] * (1.0 + 1e-9), "signal {k} at {t}");
            }
        }
        assert!(series.len() > 100 && series.len() < 1200, "{} knots of 20,000 samples", series.len());
        let mut line = KnotSeries::new(vec![1e-3]);
        (0..1000).for_each(|i| line.push(f64::from(i), &[2.0 * f64::from(i)], false));
        line.finish();
        assert_eq!((line.times, line.values), (vec![0.0, 999.0], vec![0.0, 1998.0]));
    }

    #[test]
    fn exact_samples_are_knots_and_jumps_keep_both_values() {
        let mut series = KnotSeries::new(vec![10.0]);
        for i in 0..100 {
            series.push(f64::from(i), &[0.01 * f64::from(i)], i == 37);
        }
        series.push(99.0, &[500.0], false);
        series.push(98.0, &[7.0], false);
        series.push(100.0, &[f64::NAN], false);
        series.push(120.0, &[500.0], false);
        series.finish();
        assert_eq!(series.times, [0.0, 37.0, 99.0, 99.0, 120.0]);
        assert_eq!(series.values, [0.0, 0.37, 0.99, 500.0, 500.0]);
        assert_eq!((at(&series, 0, 99.0), at(&series, 0, 110.0)), (500.0, 500.0));
    }

    #[test]
    fn a_series_that_grows_too_long_doubles_its_tolerance_and_says_so() {
        let mut series = KnotSeries::new(vec![1e-3]);
        // A curve that needs a knot every few samples, and some samples of it to compare with.
        let signal = |i: u32| 100.0 * (f64::from(i) * 0.05).sin();
        for i in 0..600_000 {
            series.push(f64::from(i), &[signal(i)], false);
        }
        series.finish();
        assert!(series.len() <= MOST_KNOTS && series.len() > MOST_KNOTS / 8, "{}", series.len());
        let bound = series.bounds()[0];
        assert!(bound > 1e-3 && bound < 10.0, "{bound}");
        for i in (0..600_000).step_by(13) {
            let off = (at(&series, 0, f64::from(i)) - signal(i)).abs();
            assert!(off <= bound * (1.0 + 1e-9), "{off} at {i}");
        }
    }

    #[test]
    fn a_series_packs_its_counts_and_steps() {
        let mut series = KnotSeries::new(vec![1e-3]);
        series.push(0.0, &[1.0], false);
        series.push(0.5, &[1.5], false);
        series.finish();
        let mut out = Vec::new();
        series.pack(&[0.5], &mut out);
        // Two knots; times 0 and 5000 steps: zigzag 10,000 in two bytes; values 2 and 3.
        assert_eq!(out, [2, 0, 0, 0, 0, 0x90, 0x4e, 4, 2]);
    }
}
