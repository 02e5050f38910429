//! Thinning of motion and signals, so that a recording stays small and still correct.

use proveout_machine::JointValues;

/// Rows after which the spacing doubles: 5 minutes of uninterrupted motion at the first spacing.
const ROWS: usize = 15_000;
/// First spacing, s: 50 poses a second.
const FIRST_SPACING: f64 = 0.02;
/// A row may come before its time by this, s: rounding of sums of times.
const ROUNDING_S: f64 = 1e-9;
/// A value that jumps is written again this long before it, s: lines between rows stay level.
const JUST_BEFORE_S: f64 = 1e-6;

/// Spacings between the repeated values of a constant signal: a quarter of a second at first.
const REPEAT: f64 = 12.0;
/// Most of them in one stretch.
const MOST_REPEATS: f64 = 64.0;

/// Spacing that grows with the number of rows written: 50 a second in the first 15 000 rows, 25 in the next,
/// and so on, so that the number of rows grows with the logarithm of the length of the run.
#[derive(Clone, Debug)]
struct Spacing {
    rows: usize,
    seconds: f64,
}

impl Default for Spacing {
    fn default() -> Self {
        Self { rows: 0, seconds: FIRST_SPACING }
    }
}

impl Spacing {
    fn count(&mut self) {
        self.rows += 1;
        if self.rows.is_multiple_of(ROWS) {
            self.seconds *= 2.0;
        }
    }
}

/// Picks the samples whose joint positions are shown.
///
/// A sample is taken when the joints have moved since the one taken before and the spacing has passed. A
/// viewer shows the newest pose at or before its time, so that standstill needs no rows, and what it shows is
/// never older than one spacing.
#[derive(Clone, Debug, Default)]
pub(crate) struct MotionThinner {
    last: Option<(f64, JointValues)>,
    spacing: Spacing,
}

impl MotionThinner {
    pub(crate) fn take(&mut self, time: f64, joints: &JointValues) -> bool {
        let due = match &self.last {
            None => true,
            Some((before, shown)) => *shown != *joints && time >= before + self.spacing.seconds - ROUNDING_S,
        };
        if due {
            self.last = Some((time, *joints));
            self.spacing.count();
        }
        due
    }
}

/// Thins a signal to its smallest and largest sample in each stretch, at their own times: no peak is lost,
/// and every row is a sample of the run. Stretches without a change give few rows, which repeat their value
/// up to the next change.
#[derive(Clone, Debug, Default)]
pub(crate) struct SignalThinner {
    begin: f64,
    low: Option<(f64, f64)>,
    high: Option<(f64, f64)>,
    newest: Option<(f64, f64)>,
    written: Option<(f64, f64)>,
    spacing: Spacing,
}

impl SignalThinner {
    /// Adds a sample and appends the rows (time, value) that are complete.
    pub(crate) fn push(&mut self, time: f64, value: f64, rows: &mut Vec<(f64, f64)>) {
        if !value.is_finite() {
            return;
        }
        if let Some(newest) = self.newest
            && time - newest.0 > 4.0 * self.spacing.seconds
        {
            // A standstill has no samples between its first and its last: the signal holds its last value,
            // which need not be the smallest or largest of its stretch.
            self.flush(rows);
            self.keep(newest, rows);
            self.begin = time;
        }
        // Two rows a stretch: twice the spacing of poses keeps their number.
        if time >= self.begin + 2.0 * self.spacing.seconds {
            self.flush(rows);
            self.begin = time;
        }
        if self.low.is_none_or(|(_, v)| value < v) {
            self.low = Some((time, value));
        }
        if self.high.is_none_or(|(_, v)| value > v) {
            self.high = Some((time, value));
        }
        self.newest = Some((time, value));
    }

    /// Ends the stretch.
    pub(crate) fn flush(&mut self, rows: &mut Vec<(f64, f64)>) {
        let (Some(low), Some(high)) = (self.low.take(), self.high.take()) else { return };
        let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        let unchanged = self.written.is_some_and(|(_, v)| v == low.1 && v == high.1);
        if unchanged {
            return;
        }
        self.hold(first, rows);
        for row in std::iter::once(first).chain((first != second).then_some(second)) {
            rows.push(row);
            self.spacing.count();
            self.written = Some(row);
        }
    }

    /// Ends the signal with its last sample.
    pub(crate) fn finish(&mut self, rows: &mut Vec<(f64, f64)>) {
        self.flush(rows);
        if let Some(newest) = self.newest.take() {
            self.keep(newest, rows);
        }
    }

    /// Holds the value that was written last up to the next row, where that comes after a constant stretch.
    ///
    /// A viewer draws many rows as one pixel, smallest first, and so would slope over the whole stretch:
    /// repeated values bind the slope to their distance.
    fn hold(&mut self, next: (f64, f64), rows: &mut Vec<(f64, f64)>) {
        let Some((t, v)) = self.written else { return };
        let gap = next.0 - t;
        if gap <= 4.0 * self.spacing.seconds {
            return;
        }
        let repeats = (gap / (REPEAT * self.spacing.seconds)).min(MOST_REPEATS).floor();
        rows.extend((1..=repeats as usize).map(|k| (t + gap * k as f64 / (repeats + 1.0), v)));
        if next.1 != v {
            rows.push((next.0 - JUST_BEFORE_S, v));
            self.spacing.count();
        }
    }

    /// Writes a sample that comes after all that is written.
    fn keep(&mut self, sample: (f64, f64), rows: &mut Vec<(f64, f64)>) {
        if self.written.is_none_or(|w| w.0 < sample.0) {
            self.hold(sample, rows);
            rows.push(sample);
            self.spacing.count();
            self.written = Some(sample);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_spaced_and_standstill_gives_none() {
        let mut thinner = MotionThinner::default();
        let mut taken = Vec::new();
        for i in 0..5000 {
            let t = f64::from(i) * 0.002;
            let mut q = JointValues::ZERO;
            q[0] = if (2.0..6.0).contains(&t) { 7.0 } else { t };
            if thinner.take(t, &q) {
                taken.push(t);
            }
        }
        assert!(taken.windows(2).all(|w| w[1] - w[0] > FIRST_SPACING - 1e-6));
        assert_eq!(taken.iter().filter(|t| (2.1..5.9).contains(*t)).count(), 0);
        assert!((300..=303).contains(&taken.len()), "6 s at 50 a second, {}", taken.len());
    }

    #[test]
    fn long_runs_grow_slowly() {
        let mut thinner = MotionThinner::default();
        let mut q = JointValues::ZERO;
        let rows = (0..1_000_000)
            .filter(|&i| {
                let t = f64::from(i) * 0.01;
                q[0] = t;
                thinner.take(t, &q)
            })
            .count();
        // 10 000 s: 300 s at 50/s, 600 at 25, 1200, 2400, 4800 ...: five doublings and a part.
        assert!((75_000..90_000).contains(&rows), "{rows}");
    }

    #[test]
    fn signals_keep_their_peaks_and_every_row_is_a_sample() {
        let mut thinner = SignalThinner::default();
        let signal = |i: i32| if i == 3333 { 99.0 } else { (f64::from(i) * 0.01).sin() };
        let mut rows = Vec::new();
        for i in 0..10_000 {
            thinner.push(f64::from(i) * 0.001, signal(i), &mut rows);
        }
        thinner.finish(&mut rows);
        assert!(rows.len() < 520, "10 s at 25 stretches of two rows, {}", rows.len());
        assert!(rows.windows(2).all(|w| w[0].0 < w[1].0), "times rise");
        assert!(rows.iter().any(|r| r.1 == 99.0), "the peak of one sample is there");
        for (t, v) in &rows {
            assert_eq!(*v, signal((t * 1000.0).round() as i32));
        }
        assert_eq!(rows.last().map(|r| r.0), Some(9.999));
    }

    /// A jerk that ends at its lowest, drops to zero within the same stretch, and stays there for five
    /// seconds.
    #[test]
    fn a_standstill_holds_the_value_that_it_began_with() {
        let mut thinner = SignalThinner::default();
        let mut rows = Vec::new();
        let mut samples: Vec<(f64, f64)> =
            (0..50).map(|i| (f64::from(i) * 0.002, if i < 45 { -9.0 } else { 0.0 })).collect();
        samples.push((5.0, 0.0));
        samples.extend((1..50).map(|i| (5.0 + f64::from(i) * 0.002, 7.0)));
        for (t, v) in samples {
            thinner.push(t, v, &mut rows);
        }
        thinner.finish(&mut rows);
        for pair in rows.windows(2) {
            let across = pair[0].0 > 0.1 && pair[1].0 <= 5.0;
            assert!(!across || pair[0].1 == 0.0 && pair[1].1 == 0.0, "slopes over the standstill: {pair:?}");
            assert!(pair[1].0 - pair[0].0 < 0.3, "bare stretch {pair:?}");
        }
        assert!(rows.iter().any(|r| r.1 == -9.0) && rows.iter().any(|r| r.1 == 7.0));
        assert!(rows.windows(2).all(|w| w[0].0 < w[1].0), "times rise: {rows:?}");
    }

    #[test]
    fn a_constant_signal_is_a_few_rows() {
        let mut thinner = SignalThinner::default();
        let mut rows = Vec::new();
        for i in 0..1000 {
            thinner.push(f64::from(i) * 0.01, 4.0, &mut rows);
        }
        thinner.push(10.0, f64::NAN, &mut rows);
        thinner.finish(&mut rows);
        assert_eq!((rows[0], rows[rows.len() - 1]), ((0.0, 4.0), (9.99, 4.0)));
        assert!(rows.len() < 45 && rows.iter().all(|r| r.1 == 4.0), "four a second: {}", rows.len());
    }
}
