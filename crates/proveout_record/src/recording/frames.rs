//! Pictures of a changing thing at a bounded number of times.

use std::collections::BTreeMap;

/// Frames that may be joined: when twice as many are held, every second one is joined with its successor.
const FRAMES: usize = 32;
/// First spacing, s.
const FIRST_SPACING: f64 = 0.5;

/// The parts that changed up to a time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frame<T> {
    pub(crate) time: f64,
    /// A frame at a tool change is never joined.
    pub(crate) keep: bool,
    /// Part by its number, as it stands at `time`.
    pub(crate) parts: BTreeMap<u32, T>,
}

/// Collects frames of a run whose length is not known: between 32 and 64 of them at equal spacing, plus the kept ones.
///
/// Joining loses no state: a part that changed in the joined frame and not in its successor looks the same at both times.
#[derive(Clone, Debug)]
pub(crate) struct Frames<T> {
    spacing: f64,
    next: f64,
    list: Vec<Frame<T>>,
}

impl<T> Default for Frames<T> {
    fn default() -> Self {
        Self { spacing: FIRST_SPACING, next: 0.0, list: Vec::new() }
    }
}

impl<T> Frames<T> {
    /// True when the next frame is due.
    pub(crate) fn due(&self, time: f64) -> bool {
        time >= self.next
    }

    /// Adds a frame; times must not fall.
    pub(crate) fn push(&mut self, frame: Frame<T>) {
        self.next = frame.time + self.spacing;
        self.list.push(frame);
        if self.list.iter().filter(|f| !f.keep).count() > 2 * FRAMES {
            self.join();
        }
    }

    fn join(&mut self) {
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

    /// The frames in order of time; the collection is then empty.
    pub(crate) fn drain(&mut self) -> impl Iterator<Item = Frame<T>> + '_ {
        self.list.drain(..)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// State at a time: what a viewer shows that applies all frames up to it.
    fn state(frames: &[Frame<u32>], time: f64) -> BTreeMap<u32, u32> {
        let mut all = BTreeMap::new();
        for f in frames.iter().filter(|f| f.time <= time) {
            all.extend(f.parts.iter().map(|(k, v)| (*k, *v)));
        }
        all
    }

    #[test]
    fn long_runs_keep_a_bounded_number_of_true_frames() {
        let mut frames = Frames::default();
        let mut truth = Vec::new();
        for i in 0..40_000_u32 {
            let time = f64::from(i) * 0.1;
            let keep = i % 5000 == 77;
            truth.push(Frame { time, keep, parts: BTreeMap::from([(i * 7919 % 13, i)]) });
        }
        // As the observer does it: changes gather until a frame is due.
        let mut gathered = BTreeMap::new();
        for f in &truth {
            gathered.extend(f.parts.clone());
            if f.keep || frames.due(f.time) {
                frames.push(Frame { time: f.time, keep: f.keep, parts: std::mem::take(&mut gathered) });
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

    #[test]
    fn the_first_frame_is_due_at_once() {
        let mut frames = Frames::default();
        assert!(frames.due(0.0));
        frames.push(Frame { time: 0.0, keep: false, parts: BTreeMap::from([(0, 1)]) });
        assert!(!frames.due(0.9 * FIRST_SPACING) && frames.due(FIRST_SPACING));
    }
}
