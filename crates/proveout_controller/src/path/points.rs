//! Where the points of a run of short blocks go before it is averaged, so that the average passes through
//! them.
//!
//! A moving average lies on the inner side of a curve: with the weights of `fit.rs`, `k d^2/10` for the
//! curvature k, on top of the chords' own distance. Blocks of a curve are its chords, and their borders are
//! its points; the fitted path shall pass through these. So each border is moved outward first, by what the
//! average will take it inward:
//!
//! ```text
//!                    o Q = P + D            the average of the moved points passes through P:
//!               o    :    o                   y = average of (x + D)
//!          o    x----x----x   o             with D the polygon of the shifts D_i over s
//!          x  /   points P    x
//! ```
//!
//! With `g_i` = what `fit.rs` would move border i by, `D_i = -(g_(i-1) + 2 g_i + g_(i+1))/4`. Where g hardly
//! changes from block to block, which is so on a smooth curve, `y(s_i) = P_i` up to the second differences of
//! g; the mean takes the zigzag of rounded coordinates out of g, which is no curvature. (This is twicing,
//! Tukey 1977, section 16: what a smoother leaves is smoothed and added.)
//!
//! *Kinks.* x + D has the kinks `m_i + n_i`, with n the jumps of the slope of D; all of `fit.rs` holds with
//! them, the half widths stay.
//!
//! *Where.* Only at borders that are *wide*, with wide neighbors: both blocks short, the kink small, and half
//! widths that reach over both blocks. So a moved block lies within supports throughout, blocks that are not
//! short stay where they are, the first and the last border of a run too, and a narrow corner gets no kink
//! that its width was not made for.
//!
//! *Tolerance.* |y - x| <= |D| + S + N, with S and N the sums of `fit.rs` over the sizes of m and n. All
//! three are convex on each block, so that their sum is highest at borders. With `|n_k| <= (|D_(k-1)| +
//! |D_k|)/L + (|D_k| + |D_(k+1)|)/L'`, the sum grows with each |D| alone: drafts of D are taken whole where
//! the sum keeps the tolerance, and in part otherwise, by the least part that any border in reach asks for.
//! Near a sharp corner, which takes all of the tolerance, nothing is moved.
//!
//! *Reversals.* y' is a mean of the slopes of the moved blocks. A block between two others whose slopes in a
//! coordinate have no other sign than its own keeps its sign: neither end moves by more than half of its way
//! in that coordinate. So a joint turns back only where the program turns it back, or a block away from
//! there.
//!
//! *Limits.* Chords that take the tolerance for themselves leave none for the points: the sums count sizes,
//! so that points are moved in full where the average would take them by less than a third of the tolerance.

use proveout_machine::{JointValues, MAX_JOINTS};

use super::{
    Tolerance,
    fit::{Fit, Kink, NEIGHBORS, lift},
};

/// Kinks to either side on which the part of a shift depends: a kink in reach, and its neighbor.
const IN_REACH: usize = NEIGHBORS + 1;
/// Slopes below this are none.
const NO_SLOPE: f64 = 1e-12;
/// Part by which a half width may miss the length of a block that it is to reach over.
const ROUNDING: f64 = 1e-9;

/// What is done with the border of two blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// What the average alone moves it by, g, and S.
    moved: JointValues,
    used: Tolerance,
    /// D before and after the tolerance has been looked at, and the part of drafts in reach that it allows.
    draft: JointValues,
    allowed: f64,
    pub(super) shift: JointValues,
    /// Slope of D over the block before, and its jump n.
    pub(super) lean: JointValues,
    pub(super) bend: JointValues,
}

impl Default for Point {
    fn default() -> Self {
        let zero = JointValues::ZERO;
        let used = Tolerance { tip: 0.0, angle: 0.0 };
        Self { moved: zero, used, draft: zero, allowed: 1.0, shift: zero, lean: zero, bend: zero }
    }
}

impl Fit {
    /// Decides the points as far as half widths are decided; all of them where the run ends.
    pub(super) fn place_points(&mut self, ended: bool, size: &dyn Fn(&JointValues) -> Tolerance) {
        // How far each step looks ahead in what the step before gives.
        for (step, ahead) in [NEIGHBORS, 2, IN_REACH, IN_REACH, 1].into_iter().enumerate() {
            loop {
                let i = self.points[step];
                let known = if step == 0 { self.settled } else { self.points[step - 1] };
                let idle = self.is_idle(i, ended);
                if i >= known || !(ended || idle || i + ahead < known) {
                    break;
                }
                if !idle {
                    self.step(step, i, size);
                }
                self.points[step] += 1;
            }
        }
    }

    /// True if no step would change the present values, since no block in reach is short.
    fn is_idle(&self, i: usize, ended: bool) -> bool {
        let end = i + 2 * IN_REACH + 3;
        let range = i.saturating_sub(2 * IN_REACH + 2)..end.min(self.kinks.len());
        (ended || end <= self.kinks.len()) && self.kinks.range(range).all(|k| !k.short)
    }

    fn step(&mut self, step: usize, i: usize, size: &dyn Fn(&JointValues) -> Tolerance) {
        match step {
            0 => (self.kinks[i].point.moved, self.kinks[i].point.used) = self.moved(i),
            1 => self.kinks[i].point.draft = self.draft(i),
            2 => self.kinks[i].point.allowed = self.allowed(i, size),
            3 => {
                let reach = i.saturating_sub(IN_REACH)..(i + IN_REACH + 1).min(self.kinks.len());
                let part = self.kinks.range(reach).map(|k| k.point.allowed).fold(1.0, f64::min);
                self.kinks[i].point.shift = self.kinks[i].point.draft * part;
            }
            _ => {
                let zero = JointValues::ZERO;
                let shift = |k: Option<usize>| k.and_then(|k| self.kinks.get(k)).map_or(zero, |k| k.point.shift);
                let [before, here, behind] = [shift(i.checked_sub(1)), shift(Some(i)), shift(Some(i + 1))];
                let [left, right] = self.lengths(i);
                let slope = |way: JointValues, length: f64| if way == zero { zero } else { way * (1.0 / length) };
                let lean = slope(here - before, left);
                let bend = slope(behind - here, right) - lean;
                (self.kinks[i].point.lean, self.kinks[i].point.bend) = (lean, bend);
            }
        }
    }

    /// Lengths of the blocks on both sides; zero where it is not known, at the ends of a run.
    fn lengths(&self, i: usize) -> [f64; 2] {
        let s = self.kinks[i].s;
        let left = i.checked_sub(1).map_or(0.0, |k| s - self.kinks[k].s);
        [left, self.kinks.get(i + 1).map_or(0.0, |k| k.s - s)]
    }

    /// g and S at a border.
    fn moved(&self, i: usize) -> (JointValues, Tolerance) {
        let here = self.kinks[i].s;
        let (mut moved, mut used) = (JointValues::ZERO, Tolerance { tip: 0.0, angle: 0.0 });
        for k in self.near(i).map(|k| &self.kinks[k]).filter(|k| k.half_width > 0.0) {
            let lift = lift(here - k.s, k.half_width);
            if lift > 0.0 {
                moved = moved + k.slope * lift;
                used.tip += k.size.tip * lift;
                used.angle += k.size.angle * lift;
            }
        }
        (moved, used)
    }

    fn is_wide(&self, i: usize) -> bool {
        let kink = &self.kinks[i];
        let [left, right] = self.lengths(i);
        kink.short && kink.half_width >= left.max(right) * (1.0 - ROUNDING)
    }

    /// D before the tolerance is looked at.
    fn draft(&self, i: usize) -> JointValues {
        let inner = i > 0 && i + 1 < self.kinks.len();
        if !inner || !(i - 1..=i + 1).all(|k| self.is_wide(k)) {
            return JointValues::ZERO;
        }
        let [left, right] = self.lengths(i);
        let [a, b, c] = [i - 1, i, i + 1].map(|k| &self.kinks[k]);
        let after = |k: &Kink| k.before + k.slope;
        let before = keeps_sign([a.before, b.before, after(b)], left);
        let behind = keeps_sign([b.before, after(b), after(c)], right);
        let mean = (a.point.moved + b.point.moved * 2.0 + c.point.moved) * 0.25;
        JointValues(std::array::from_fn(|j| {
            let most = before[j].min(behind[j]);
            (-mean[j]).clamp(-most, most)
        }))
    }

    /// The part of all drafts in reach that keeps the tolerance at a border.
    fn allowed(&self, i: usize, size: &dyn Fn(&JointValues) -> Tolerance) -> f64 {
        let here = &self.kinks[i];
        let own = size(&here.point.draft);
        let (mut tip, mut angle) = (own.tip, own.angle);
        for k in self.near(i) {
            let kink = &self.kinks[k];
            let lift = if kink.half_width > 0.0 { lift(here.s - kink.s, kink.half_width) } else { 0.0 };
            if lift <= 0.0 {
                continue;
            }
            let [left, right] = self.lengths(k);
            let draft =
                |k: Option<usize>| k.and_then(|k| self.kinks.get(k)).map_or(JointValues::ZERO, |k| k.point.draft);
            for (other, length) in [(k.checked_sub(1), left), (Some(k + 1), right)] {
                let pair = [draft(other), draft(Some(k))].map(|d| size(&d));
                let per = if length > 0.0 { lift / length } else { 0.0 };
                tip += (pair[0].tip + pair[1].tip) * per;
                angle += (pair[0].angle + pair[1].angle) * per;
            }
        }
        let left = |tolerance: f64, used: f64, more: f64| if more > 0.0 { (tolerance - used) / more } else { 1.0 };
        let (tolerance, used) = (here.tolerance, here.point.used);
        left(tolerance.tip, used.tip, tip).min(left(tolerance.angle, used.angle, angle)).clamp(0.0, 1.0)
    }

    /// Bounds of the deviation of the tip at a border: the sum of sizes, and what it is.
    pub(super) fn bounds_at(&self, i: usize, size: &dyn Fn(&JointValues) -> Tolerance) -> [f64; 2] {
        let here = &self.kinks[i];
        let mut sum = size(&here.point.shift).tip;
        let mut off = here.point.shift;
        for k in self.near(i).map(|k| &self.kinks[k]).filter(|k| k.half_width > 0.0) {
            let lift = lift(here.s - k.s, k.half_width);
            if lift > 0.0 {
                sum += (k.size.tip + size(&k.point.bend).tip) * lift;
                off = off + k.kink() * lift;
            }
        }
        [sum, size(&off).tip]
    }

    /// By how much the deviation of the tip may rise on the block before a border above that at its ends: x
    /// is straight there, so that the deviation bends with y'', and L^2/8 of it lies between. Each kink adds
    /// |m + n| k(..)/d, which falls with the distance.
    pub(super) fn between(&self, i: usize, size: &dyn Fn(&JointValues) -> Tolerance) -> f64 {
        let here = self.kinks[i].s;
        let [length, _] = self.lengths(i);
        let bend = |k: &Kink| {
            let away = (k.s - here).max(here - length - k.s).max(0.0);
            let part = 1.0 - (away / k.half_width).powi(2);
            if k.half_width > 0.0 && part > 0.0 { 0.75 * part * size(&k.kink()).tip / k.half_width } else { 0.0 }
        };
        // Those before the block may reach over it from one border more.
        let range = i.saturating_sub(IN_REACH)..(i + IN_REACH).min(self.kinks.len());
        length * length / 8.0 * self.kinks.range(range).map(bend).sum::<f64>()
    }
}

/// How far both ends of the middle one of three blocks may move so that no coordinate gets a sign that none
/// of the three has.
fn keeps_sign([a, b, c]: [JointValues; 3], length: f64) -> [f64; MAX_JOINTS] {
    std::array::from_fn(|j| {
        let slopes = [a[j], b[j], c[j]];
        let both = slopes.iter().any(|x| *x > NO_SLOPE) && slopes.iter().any(|x| *x < -NO_SLOPE);
        if both { f64::INFINITY } else { 0.5 * length * b[j].abs() }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn planar(v: &JointValues) -> Tolerance {
        Tolerance { tip: v[0].hypot(v[1]), angle: 0.0 }
    }

    fn values(v: [f64; 2]) -> JointValues {
        let mut out = JointValues::ZERO;
        (out[0], out[1]) = (v[0], v[1]);
        out
    }

    /// A polygon with its slopes over its length.
    struct Polygon {
        points: Vec<[f64; 2]>,
        s: Vec<f64>,
    }

    impl Polygon {
        fn new(points: Vec<[f64; 2]>) -> Self {
            let mut s = vec![0.0];
            for w in points.windows(2) {
                s.push(s[s.len() - 1] + (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]));
            }
            Self { points, s }
        }

        fn slope(&self, block: usize) -> JointValues {
            let length = self.s[block + 1] - self.s[block];
            values([0, 1].map(|c| (self.points[block + 1][c] - self.points[block][c]) / length))
        }

        /// Its fit with widths of 1.23 blocks, decided at once or point by point.
        fn fit(&self, tolerance: f64, short: impl Fn(usize) -> bool, stream: bool) -> Fit {
            let mut fit = Fit::from(0.0);
            for k in 1..self.points.len() - 1 {
                let (before, after) = (self.slope(k - 1), self.slope(k));
                let longest = (self.s[k] - self.s[k - 1]).max(self.s[k + 1] - self.s[k]);
                let slope = after - before;
                let tolerance = Tolerance { tip: tolerance, angle: 1.0 };
                let wanted = if short(k) { 1.23 * longest } else { 0.2 * longest };
                let kink = Kink::new(
                    (k as u64 - 1, self.s[k]),
                    [before, slope],
                    planar(&slope),
                    wanted,
                    (tolerance, short(k)),
                );
                fit.push(kink);
                if stream {
                    fit.settle(None, &planar);
                }
            }
            fit.settle(self.s.last().copied(), &planar);
            fit
        }

        /// x and y at s, and the slope of y by differences.
        fn at(&self, fit: &Fit, s: f64) -> [JointValues; 3] {
            let y = |s: f64| {
                let block = (self.s.partition_point(|x| *x < s).max(1) - 1).min(self.points.len() - 2);
                let x = values(self.points[block]) + self.slope(block) * (s - self.s[block]);
                let shift = |k: Option<u64>| fit.numbered(k).map_or(JointValues::ZERO, |k| k.point.shift);
                let [a, b] = [(block as u64).checked_sub(1), Some(block as u64)].map(shift);
                let part = (s - self.s[block]) / (self.s[block + 1] - self.s[block]);
                let lifts = fit.kinks.iter().filter(|k| k.half_width > 0.0);
                let sum = lifts.fold(JointValues::ZERO, |sum, k| sum + k.kink() * lift(s - k.s, k.half_width));
                [x, x + a * (1.0 - part) + b * part + sum]
            };
            let h = 1e-6;
            let [x, here] = y(s);
            [x, here, (y(s + h)[1] - y(s - h)[1]) * (0.5 / h)]
        }
    }

    #[test]
    fn chords_of_an_arc_are_averaged_onto_the_arc() {
        let (radius, step) = (40.0, 0.008);
        let arc: Vec<[f64; 2]> =
            (0..200).map(|k| step * f64::from(k)).map(|a| [radius * a.cos(), radius * a.sin()]).collect();
        let polygon = Polygon::new(arc);
        let fit = polygon.fit(0.01, |_| true, false);
        let sagitta = radius * (1.0 - (0.5 * step).cos());
        let end = polygon.s[polygon.s.len() - 1];
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 100..900 {
            let [_, y, slope] = polygon.at(&fit, end * f64::from(k) / 1000.0);
            let off = y[0].hypot(y[1]) - radius;
            (least, most) = (least.min(off), most.max(off));
            // The tip is faster than the parameter by what the arc is longer than its chords.
            let rate = slope[0].hypot(slope[1]);
            assert!((rate - 1.0).abs() < 2e-5, "{rate}");
        }
        // Without the points moved: 0.23 k L^2 inside, nearly twice the sagitta.
        assert!(least > -0.05 * sagitta && most < 0.05 * sagitta, "{least} {most} of {sagitta}");
        // Bounds of the deviation from the chords: their sagitta, and not the sum of the sizes of all that
        // was done.
        let mut fit = fit;
        let begin = fit.rounding(0.1 * end, &planar);
        let rounding = fit.rounding(0.9 * end, &planar);
        assert!(begin > rounding, "the first point stays, and what is behind it is averaged all the same");
        assert!(rounding > 0.98 * sagitta && rounding < 1.8 * sagitta, "{rounding} of {sagitta}");
    }

    /// Polygons with corners, steps of all sizes, long blocks, rounded coordinates and straight stretches.
    #[test]
    fn the_tolerance_and_the_signs_of_slopes_hold_and_nothing_hangs_on_what_is_known_when() {
        let mut moved_points = 0;
        for case in 0..200 {
            let mut seed = 9_000 + case;
            let (mut at, mut heading) = ([0.0, 0.0], 0.0_f64);
            let tolerance = 10_f64.powf(-1.0 - 2.0 * random(&mut seed));
            let size = 10_f64.powf(-1.0 + 1.3 * random(&mut seed));
            let grid = if case % 3 == 0 { 0.001 } else { 0.0 };
            let bend = 0.2 * random(&mut seed);
            let mut points = vec![at];
            for k in 0..160 {
                if k % 40 < 25 {
                    heading += bend * random(&mut seed).powi(if case % 2 == 0 { 0 } else { 1 });
                }
                if random(&mut seed) < 0.02 {
                    heading += 3.0 * random(&mut seed) - 1.5;
                }
                let step = size * if case % 5 == 0 { 10_f64.powf(random(&mut seed) - 0.5) } else { 1.0 };
                at = [at[0] + step * heading.cos(), at[1] + step * heading.sin()];
                points.push(at.map(|x| if grid > 0.0 { (x / grid).round() * grid } else { x }));
            }
            let long = case.is_multiple_of(7);
            let short = |k: usize| !(long && k.is_multiple_of(30));
            let polygon = Polygon::new(points);
            let (fit, stream) = (polygon.fit(tolerance, short, false), polygon.fit(tolerance, short, true));
            for (a, b) in fit.kinks.iter().zip(&stream.kinks) {
                assert_eq!((a.point.shift, a.point.bend), (b.point.shift, b.point.bend));
                moved_points += usize::from(a.point.shift != JointValues::ZERO);
                assert!(a.point.shift == JointValues::ZERO || a.short);
            }
            let mut looked = polygon.fit(tolerance, short, false);
            let end = polygon.s[polygon.s.len() - 1];
            let rounding = looked.rounding(end, &planar);
            let blocks = polygon.points.len() - 1;
            for k in 1..2400 {
                let s = end * f64::from(k) / 2400.0;
                let [x, y, slope] = polygon.at(&fit, s);
                let off = planar(&(y - x)).tip;
                assert!(off <= tolerance * (1.0 + 1e-9), "case {case} at {s}: {off} of {tolerance}");
                assert!(off <= rounding * (1.0 + 1e-9) + 1e-12, "case {case} at {s}: {off}, said to be {rounding}");
                // Blocks that act here, and one more on either side.
                let acts = |k: &&Kink| k.half_width > 0.0 && k.begin() < s && k.end() > s;
                let own = (polygon.s.partition_point(|x| *x < s).max(1) - 1).min(blocks - 1);
                let numbers = fit.kinks.iter().filter(acts).map(|k| k.number as usize);
                let (low, high) = numbers.fold((own, own), |(low, high), n| (low.min(n), high.max(n + 1)));
                let slopes: Vec<JointValues> =
                    (low.saturating_sub(1)..(high + 2).min(blocks)).map(|b| polygon.slope(b)).collect();
                for c in 0..2 {
                    let both = slopes.iter().any(|p| p[c] > 1e-9) && slopes.iter().any(|p| p[c] < -1e-9);
                    let sign = slopes.iter().fold(0.0, |sum, p| sum + p[c]);
                    assert!(both || slope[c] * sign >= -1e-7, "case {case} at {s}: {} among {slopes:?}", slope[c]);
                }
            }
        }
        assert!(moved_points > 5_000, "{moved_points}");
    }
}
