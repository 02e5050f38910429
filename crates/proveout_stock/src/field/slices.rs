//! Where the cutter was engaged, by slices across its axis and by steps of its path.
//!
//! Every removed interval of a ray is a line of points that a motion took. Each of them was touched first at
//! one time, at one height of the cutter and under one angle ([`PassMotions::touch`]), so that the removed
//! material is sorted by time and height without a second stock:
//!
//! ```text
//!    height
//!      |  +-----+-----+-----+      a cell of time and height: range of angles of all touches in it,
//!      3  |     |  x  | x x |      and the material that was taken there
//!      2  |  x  | x x | x x |
//!      1  | x x | x x | x x |      both ends of an interval count, and points of it in equal steps: the
//!      0  +-----+-----+-----+--    ends lie on the old skin or at the side of the way, where the range
//!         0     1     2     step   of angles begins and ends
//! ```
//!
//! **Bounds.** A range of angles is never wider than the true one. It is short of it by less than
//! asin(cell / radius) at each end, where each slice has a ray in each step: slices of two cells or more, and
//! steps that are joined over a cell of path. The volumes of a motion add up to that of its rays; sorted into
//! steps they are off by what one row of rays holds.

use crate::{
    field::engagement::FirstTouch,
    sweep_item::{Action, SweepItem, SweepMotion},
};

/// Steps of one motion at most: bounds the memory of a motion that is too long for any part.
const MOST_STEPS: f64 = 1e5;
/// Points of one removed interval at most.
const MOST_POINTS: f64 = 4096.0;

/// Into what parts engagement is sorted; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlan {
    step: f64,
    slice: f64,
}

impl SlicePlan {
    /// Steps of the path no longer than `step`, slices of the height `slice`, mm; none where one of them is
    /// not finite and above zero.
    pub fn new(step: f64, slice: f64) -> Option<Self> {
        let usable = |x: f64| x.is_finite() && x > 0.0;
        (usable(step) && usable(slice)).then_some(Self { step, slice })
    }

    /// Height of a slice, mm.
    pub fn slice_mm(&self) -> f64 {
        self.slice
    }

    /// Equal parts of the duration of a motion: no point of the axis between two heights above the tip runs
    /// more than a step in one of them.
    pub fn steps(&self, motion: &SweepMotion, heights: [f64; 2]) -> u32 {
        let travel = motion.to.tip - motion.from.tip;
        let turn = motion.to.axis - motion.from.axis;
        let way = heights.map(|z| (travel + turn * z).norm()).into_iter().fold(0.0, f64::max);
        let steps = (way / self.step).ceil();
        if steps.is_finite() { steps.clamp(1.0, MOST_STEPS) as u32 } else { 1 }
    }

    /// The slice of a height; none where it is not finite.
    fn slice_of(&self, height: f64) -> Option<u32> {
        height.is_finite().then(|| (height / self.slice).floor().clamp(0.0, f64::from(u32::MAX)) as u32)
    }

    /// Points of a removed interval of this length.
    pub(crate) fn points(&self, length: f64) -> usize {
        (length / self.step).ceil().clamp(1.0, MOST_POINTS) as usize
    }
}

/// Engagement in one step of a motion and one slice of the cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceContact {
    /// Number of the sweep item.
    pub id: u32,
    /// Step of its motion, from 0.
    pub step: u32,
    /// Steps that its motion has, equal parts of its duration.
    pub steps: u32,
    /// Slice, from 0 at the tip.
    pub slice: u32,
    /// Lowest and highest touch above the tip, mm.
    pub height: [f64; 2],
    /// Touches across feed and axis, as [`Contact::across`](crate::Contact::across), mm.
    pub across: [f64; 2],
    /// First and last angle of a touch in front, as [`Contact::angle`](crate::Contact::angle), radian; low
    /// above high where there is none.
    pub angle: [f64; 2],
    /// Material was also met at the rear, or by a motion along the axis: the cutter goes down.
    pub around: bool,
    /// Material that was taken, mm³.
    pub volume_mm3: f64,
}

impl SliceContact {
    /// Both as one; of the same item, step and slice.
    fn join(&mut self, other: &Self) {
        let join = |a: &mut [f64; 2], b: [f64; 2]| *a = [a[0].min(b[0]), a[1].max(b[1])];
        join(&mut self.height, other.height);
        join(&mut self.across, other.across);
        join(&mut self.angle, other.angle);
        self.around |= other.around;
        self.volume_mm3 += other.volume_mm3;
    }

    /// Range of the touches in front, and the angles as the teeth of a spindle that turns clockwise or
    /// counter-clockwise meet them; none where no touch has an angle.
    pub fn entry_and_exit(&self, clockwise: bool) -> Option<[f64; 2]> {
        let [first, last] = self.angle;
        let mirrored = [std::f64::consts::PI - last, std::f64::consts::PI - first];
        (first <= last).then_some(if clockwise { [first, last] } else { mirrored })
    }
}

/// Takes touches of one item on one tile; what is not finite is left out.
#[derive(Clone, Debug, Default)]
pub(crate) struct SliceTouches {
    contacts: Vec<SliceContact>,
}

impl SliceTouches {
    /// A point that the item took, with the length of ray that it is for, mm.
    pub(crate) fn add(&mut self, plan: &SlicePlan, [id, steps]: [u32; 2], touch: &FirstTouch, length: f64) {
        let Some(slice) = plan.slice_of(touch.height) else { return };
        if !touch.tau.is_finite() {
            return;
        }
        let step = ((touch.tau * f64::from(steps)).floor().max(0.0) as u32).min(steps.saturating_sub(1));
        const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        let angle = touch.across.and_then(|(_, angle)| angle);
        let contact = SliceContact {
            id,
            step,
            steps,
            slice,
            height: [touch.height; 2],
            across: touch.across.map_or(NONE, |(across, _)| [across; 2]),
            angle: angle.map_or(NONE, |angle| [angle; 2]),
            around: touch.is_around(),
            volume_mm3: length,
        };
        // Points come ray by ray: the cell of the last one is the likely cell of the next.
        let same = |c: &&mut SliceContact| (c.step, c.slice) == (step, slice);
        match self.contacts.iter_mut().rev().take(NEAR).find(same) {
            Some(known) => known.join(&contact),
            None => self.contacts.push(contact),
        }
    }

    /// What was touched, each step and slice once; empties the list. `area` is that of a ray, mm².
    pub(crate) fn take(&mut self, area: f64) -> Vec<SliceContact> {
        let mut all = joined(std::mem::take(&mut self.contacts));
        all.iter_mut().for_each(|c| c.volume_mm3 *= area);
        all
    }
}

/// Cells that are looked through before a new one is made; doubles are joined at the end.
const NEAR: usize = 24;

/// Bodies of one item may differ in their steps where a pass ends between them.
fn key(c: &SliceContact) -> (u32, u32, u32, u32) {
    (c.id, c.steps, c.step, c.slice)
}

/// Sorted by item, step and slice, each once; sums run in the order in which they were given.
pub(crate) fn joined(mut all: Vec<SliceContact>) -> Vec<SliceContact> {
    all.sort_by_key(key);
    all.dedup_by(|next, kept| {
        let same = key(next) == key(kept);
        if same {
            kept.join(next);
        }
        same
    });
    all
}

/// The steps of removing items, the same for all bodies of one; zero for those that only probe.
pub(crate) fn steps_of(plan: &SlicePlan, items: &[SweepItem<'_>]) -> Vec<u32> {
    let of = |item: &SweepItem<'_>| match item.action {
        Action::Remove => plan.steps(&item.motion, [item.body.z_min(), item.body.z_max()]),
        Action::Probe => 0,
    };
    let mut steps = Vec::with_capacity(items.len());
    for same in items.chunk_by(|a, b| a.id == b.id) {
        let most = same.iter().map(of).max().unwrap_or(0);
        steps.extend(same.iter().map(|item| if item.action == Action::Remove { most } else { 0 }));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(tau: f64, height: f64) -> FirstTouch {
        FirstTouch { tau, height, across: Some((1.0, Some(1.5))), advance: 0.0 }
    }

    #[test]
    fn heights_and_times_that_are_no_numbers_are_left_out() {
        let plan = SlicePlan::new(0.5, 1.0).unwrap_or_else(|| panic!("usable"));
        let mut touches = SliceTouches::default();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            touches.add(&plan, [1, 4], &touch(0.5, bad), 1.0);
            touches.add(&plan, [1, 4], &touch(bad, 0.5), 1.0);
        }
        assert!(touches.take(1.0).is_empty());
        touches.add(&plan, [1, 4], &touch(1.0, -1e-6), 2.0);
        let all = touches.take(0.5);
        assert_eq!(all.len(), 1);
        assert_eq!((all[0].step, all[0].slice, all[0].volume_mm3), (3, 0, 1.0));
        for (step, slice) in [(0.0, 1.0), (f64::NAN, 1.0), (1.0, -1.0), (1.0, f64::INFINITY)] {
            assert!(SlicePlan::new(step, slice).is_none());
        }
    }

    #[test]
    fn each_step_and_slice_comes_once_and_holds_all_of_its_touches() {
        let plan = SlicePlan::new(0.5, 1.0).unwrap_or_else(|| panic!("usable"));
        let mut touches = SliceTouches::default();
        // More cells than are looked through, twice over.
        for k in 0..200 {
            let height = f64::from(k % 100) + 0.25 + 0.5 * f64::from(k / 100);
            touches.add(&plan, [7, 1], &touch(0.0, height), 1.0);
        }
        let all = touches.take(1.0);
        assert_eq!(all.len(), 100);
        assert!(all.iter().all(|c| c.volume_mm3 == 2.0 && (c.height[1] - c.height[0] - 0.5).abs() < 1e-12));
    }
}
