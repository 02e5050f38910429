//! A signal of unknown length in a bounded number of stretches, each with its smallest and largest value.

/// Smallest and largest value of a signal over equal stretches of time.
///
/// The stretch doubles (pairs of stretches are joined) whenever the signal outgrows the buckets, so that
/// memory stays fixed and every peak stays visible: the envelope always contains the signal. The number of
/// stretches in use lies between half and all of [`BUCKETS`] once the signal is longer than the first stretch
/// times that number.
#[derive(Clone, Debug)]
pub(crate) struct Envelope {
    width: f64,
    /// Smallest, largest, last value; none in a stretch without a sample.
    buckets: Vec<Option<[f64; 3]>>,
}

/// Most stretches that are kept: a plot has about as many pixels.
pub(crate) const BUCKETS: usize = 640;
/// First length of a stretch, s.
const FIRST_WIDTH: f64 = 1.0 / 256.0;

impl Default for Envelope {
    fn default() -> Self {
        Self { width: FIRST_WIDTH, buckets: Vec::new() }
    }
}

impl Envelope {
    /// Adds a sample at `time` (s, not negative); values that are not finite are left out.
    pub(crate) fn push(&mut self, time: f64, value: f64) {
        if !value.is_finite() || !(0.0..1e12).contains(&time) {
            return;
        }
        while time / self.width >= BUCKETS as f64 {
            self.join_pairs();
        }
        let index = (time / self.width) as usize;
        if self.buckets.len() <= index {
            self.buckets.resize(index + 1, None);
        }
        let bucket = &mut self.buckets[index];
        *bucket = Some(bucket.map_or([value; 3], |[low, high, _]| [low.min(value), high.max(value), value]));
    }

    fn join_pairs(&mut self) {
        let join = |pair: &[Option<[f64; 3]>]| match *pair {
            [Some(a), Some(b)] => Some([a[0].min(b[0]), a[1].max(b[1]), b[2]]),
            [a, b] => a.or(b),
            [a] => a,
            _ => None,
        };
        self.buckets = self.buckets.chunks(2).map(join).collect();
        self.width *= 2.0;
    }

    /// Middle of each stretch (s), smallest and largest value, in order of time.
    ///
    /// Where no sample falls, at a standstill, the signal holds its last value: the first and the last of
    /// such stretches carry it, those between are left out.
    pub(crate) fn stretches(&self) -> Vec<(f64, f64, f64)> {
        let at = |i: usize| (i as f64 + 0.5) * self.width;
        let mut out = Vec::with_capacity(self.buckets.len());
        let mut before: Option<(usize, f64)> = None;
        for (i, bucket) in self.buckets.iter().enumerate() {
            let Some([low, high, last]) = *bucket else { continue };
            if let Some((index, held)) = before {
                let hold = |k: usize| (at(k), held, held);
                match i - index {
                    0 | 1 => {}
                    2 => out.push(hold(index + 1)),
                    _ => out.extend([hold(index + 1), hold(i - 1)]),
                }
            }
            out.push((at(i), low, high));
            before = Some((i, last));
        }
        out
    }

    /// Begin and end (s) of the times that have samples; neighboring stretches are joined.
    pub(crate) fn marked(&self) -> Vec<[f64; 2]> {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for (i, _) in self.buckets.iter().enumerate().filter(|(_, b)| b.is_some()) {
            let (begin, end) = (i as f64 * self.width, (i + 1) as f64 * self.width);
            match out.last_mut() {
                Some(last) if last[1] == begin => last[1] = end,
                _ => out.push([begin, end]),
            }
        }
        out
    }

    /// Length of a stretch, s.
    pub(crate) fn width(&self) -> f64 {
        self.width
    }

    /// Smallest and largest value of all; none without a sample.
    pub(crate) fn range(&self) -> Option<[f64; 2]> {
        self.buckets.iter().flatten().fold(None, |all, b| {
            Some(all.map_or([b[0], b[1]], |[low, high]: [f64; 2]| [low.min(b[0]), high.max(b[1])]))
        })
    }

    /// True when no sample was added.
    pub(crate) fn is_empty(&self) -> bool {
        self.buckets.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_contains_the_signal_in_bounded_memory() {
        let mut envelope = Envelope::default();
        let signal = |i: u32| (f64::from(i) * 0.37).sin() * f64::from(i % 1000);
        let samples = 200_000;
        for i in 0..samples {
            envelope.push(f64::from(i) * 0.004, signal(i));
        }
        let stretches = envelope.stretches();
        assert!((BUCKETS / 2..=BUCKETS).contains(&stretches.len()), "{}", stretches.len());
        for i in 0..samples {
            let k = (f64::from(i) * 0.004 / envelope.width()) as usize;
            let (_, low, high) = stretches[k];
            assert!(low <= signal(i) && signal(i) <= high);
        }
        let peak = (0..samples).map(signal).fold(f64::MIN, f64::max);
        assert_eq!(envelope.range().map(|r| r[1]), Some(peak));
    }

    #[test]
    fn a_standstill_holds_the_last_value() {
        let mut envelope = Envelope::default();
        envelope.push(0.0, 5.0);
        envelope.push(0.001, 2.0);
        envelope.push(1.0, 9.0);
        let w = FIRST_WIDTH;
        let last = (1.0 / w) as usize;
        let middle = |k: usize| (k as f64 + 0.5) * w;
        assert_eq!(
            envelope.stretches(),
            [(middle(0), 2.0, 5.0), (middle(1), 2.0, 2.0), (middle(last - 1), 2.0, 2.0), (middle(last), 9.0, 9.0)]
        );
    }

    #[test]
    fn marked_times_are_joined_stretches() {
        let mut envelope = Envelope::default();
        for time in [1.0, 1.004, 1.008, 2.0] {
            envelope.push(time, 1.0);
        }
        let w = FIRST_WIDTH;
        assert_eq!(envelope.marked(), [[1.0, 1.0 + 3.0 * w], [2.0, 2.0 + w]]);
        assert!(Envelope::default().marked().is_empty());
    }

    #[test]
    fn bad_numbers_are_left_out() {
        let mut envelope = Envelope::default();
        envelope.push(f64::NAN, 1.0);
        envelope.push(-1.0, 1.0);
        envelope.push(1.0, f64::INFINITY);
        assert!(envelope.is_empty() && envelope.range().is_none());
    }
}
