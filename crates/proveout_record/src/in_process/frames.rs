//! Pictures of a changing thing at a bounded number of times.

use std::collections::BTreeMap;

/// Frames that may be joined: when twice as many are held, every second one is joined with its successor.
const FRAMES: usize = 32;
/// First spacing, s.
const FIRST_SPACING: f64 = 0.5;
/// Frames at equal spacing up to the end that is expected.
const TO_THE_END: f64 = 24.0;
/// Part of the time that has passed which the spacing never exceeds: an end that is expected far too late
/// costs frames of the first seconds alone.
const OF_THE_PAST: f64 = 0.25;

/// The parts that changed up to a time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecordingFrame<T> {
    pub(crate) time: f64,
    /// A frame at a tool change is never joined.
    pub(crate) keep: bool,
    /// Part by its number, in its state at `time`.
    pub(crate) parts: BTreeMap<u32, T>,
}

/// Collects frames of a run whose length is not known: thirty to fifty of them, plus the kept ones. A frame
/// that is left out is never made, as far as the end is foreseen ([`FrameCollector::expect`]); where it comes
/// later, frames are joined, and no more than 64 stay.
///
/// Joining loses no state: a part that changed in the joined frame and not in its successor looks the same at
/// both times.
#[derive(Clone, Debug)]
pub(crate) struct FrameCollector<T> {
    spacing: f64,
    next: f64,
    /// The end came later than foreseen.
    joined: bool,
    list: Vec<RecordingFrame<T>>,
}

impl<T> Default for FrameCollector<T> {
    fn default() -> Self {
        Self { spacing: FIRST_SPACING, next: 0.0, joined: false, list: Vec::new() }
    }
}

impl<T> FrameCollector<T> {
    /// True when the next frame is due.
    pub(crate) fn due(&self, time: f64) -> bool {
        time >= self.next
    }

    /// Takes a time and the end of the run, as estimated from the part already done.
    pub(crate) fn expect(&mut self, time: f64, end: f64) {
        if end.is_finite() && !self.joined {
            self.spacing = (end / TO_THE_END).min(time * OF_THE_PAST).max(FIRST_SPACING);
        }
    }

    /// Adds a frame; times must not fall.
    pub(crate) fn push(&mut self, frame: RecordingFrame<T>) {
        self.next = frame.time + self.spacing;
        self.list.push(frame);
        if self.list.iter().filter(|f| !f.keep).count() > 2 * FRAMES {
            self.join();
        }
    }

    fn join(&mut self) {
        self.joined = true;
        self.spacing *= 2.0;
        let old = std::mem::take(&mut self.list);
        let last = old.len().saturating_sub(1);
        let mut drop_next = false;
        let mut carried: BTreeMap<u32, T> = BTreeMap::new();
        for (i, mut frame) in old.into_iter().enumerate() {
            for (part, value) in std::mem::take(&mut carried) {
                frame.parts.entry(part).or_insert(value);
            }
            if !frame.keep && i > 0 && i < last {
                drop_next = !drop_next;
                if drop_next {
                    carried = frame.parts;
                    continue;
                }
            }
            self.list.push(frame);
        }
        self.next = self.list.last().map_or(0.0, |f| f.time + self.spacing);
    }

    /// Sum over all parts that are held.
    pub(crate) fn sum(&self, of: impl Fn(&T) -> usize) -> usize {
        self.list.iter().flat_map(|f| f.parts.values()).map(of).sum()
    }

    /// Joins frames where there is too much in them; kept ones lose their mark when no other is left. False
    /// when nothing can be joined.
    pub(crate) fn thin(&mut self) -> bool {
        let before = self.list.len();
        if self.list.iter().filter(|f| !f.keep).count() < 4 {
            self.list.iter_mut().for_each(|f| f.keep = false);
        }
        self.join();
        self.list.len() < before
    }

    /// The frames in order of time; the collection is then empty.
    pub(crate) fn drain(&mut self) -> impl Iterator<Item = RecordingFrame<T>> + '_ {
        self.list.drain(..)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// State at a time: what a viewer shows that applies all frames up to it.
    fn state(frames: &[RecordingFrame<u32>], time: f64) -> BTreeMap<u32, u32> {
        let mut all = BTreeMap::new();
        for f in frames.iter().filter(|f| f.time <= time) {
            all.extend(f.parts.iter().map(|(k, v)| (*k, *v)));
        }
        all
    }

    #[test]
    fn long_runs_keep_a_bounded_number_of_true_frames() {
        let mut frames = FrameCollector::default();
        let mut truth = Vec::new();
        for i in 0..40_000_u32 {
            let time = f64::from(i) * 0.1;
            let keep = i % 5000 == 77;
            truth.push(RecordingFrame { time, keep, parts: BTreeMap::from([(i * 7919 % 13, i)]) });
        }
        // As the observer does it: changes gather until a frame is due.
        let mut gathered = BTreeMap::new();
        for f in &truth {
            gathered.extend(f.parts.clone());
            if f.keep || frames.due(f.time) {
                frames.push(RecordingFrame { time: f.time, keep: f.keep, parts: std::mem::take(&mut gathered) });
            }
        }
        let list: Vec<_> = frames.drain().collect();
        let kept = list.iter().filter(|f| f.keep).count();
        assert_eq!(kept, 8);
        assert!((FRAMES..=2 * FRAMES + kept).contains(&list.len()), "{}", list.len());
        for f in &list {
            assert_eq!(state(&list, f.time), state(&truth, f.time), "at {}", f.time);
        }
    }

    /// Frames that are made, and those that stay, of a run of so many seconds whose end is foreseen with an
    /// error.
    fn made(end: f64, foreseen: impl Fn(f64) -> f64) -> (usize, Vec<f64>) {
        let mut frames = FrameCollector::default();
        let mut count = 0;
        for i in 0..=(end * 10.0) as u32 {
            let time = f64::from(i) * 0.1;
            if frames.due(time) {
                frames.expect(time, foreseen(time));
                frames.push(RecordingFrame { time, keep: false, parts: BTreeMap::from([(0, i)]) });
                count += 1;
            }
        }
        (count, frames.drain().map(|f| f.time).collect())
    }

    #[test]
    fn thinning_keeps_the_states_of_the_frames_that_stay() {
        let mut frames = FrameCollector::default();
        let truth: Vec<_> = (0..40_u32)
            .map(|i| RecordingFrame { time: f64::from(i), keep: i % 9 == 4, parts: BTreeMap::from([(i % 5, i)]) })
            .collect();
        truth.iter().for_each(|f| frames.push(f.clone()));
        assert_eq!(frames.sum(|v| *v as usize), 39 * 40 / 2);
        while frames.list.len() > 6 {
            assert!(frames.thin());
            for f in &frames.list {
                assert_eq!(state(&frames.list, f.time), state(&truth, f.time), "at {}", f.time);
            }
        }
        while frames.thin() {}
        assert!(frames.list.len() <= 3, "{}", frames.list.len());
    }

    #[test]
    fn a_foreseen_end_makes_no_frame_in_vain() {
        for end in [15.0, 60.0, 1200.0, 3600.0] {
            let (count, times) = made(end, |_| end);
            assert!(count == times.len() && (20..=2 * FRAMES).contains(&count), "{end} s: {count}");
            let widest = times.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
            assert!(widest <= (end / TO_THE_END).max(FIRST_SPACING) + 0.11, "{end} s: {widest}");
        }
        // Foreseen a hundred times too late in its first tenth, and ten times too soon all the time.
        let (count, times) = made(1200.0, |t| if t < 120.0 { 120_000.0 } else { 1200.0 });
        assert!(count <= 2 * FRAMES && times.iter().filter(|t| **t < 120.0).count() > 15, "{count} {times:?}");
        let (count, times) = made(36_000.0, |_| 36_000.0);
        assert!(count < 80 && times.len() <= 2 * FRAMES, "ten hours: {count}");
        let (_, times) = made(1200.0, |_| 120.0);
        assert!((FRAMES..=2 * FRAMES).contains(&times.len()), "{times:?}");
    }

    #[test]
    fn the_first_frame_is_due_at_once() {
        let mut frames = FrameCollector::default();
        assert!(frames.due(0.0));
        frames.push(RecordingFrame { time: 0.0, keep: false, parts: BTreeMap::from([(0, 1)]) });
        assert!(!frames.due(0.9 * FIRST_SPACING) && frames.due(FIRST_SPACING));
    }
}
