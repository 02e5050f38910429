//! Where a search for a tempo begins: at a tempo that is quicker than the law, and comes to it from what is
//! given without a step.

use super::problem::Problem;

/// b where a search begins: of the searches that begin at the law itself more fail (12 against 1 on 20
/// curves).
const QUICK: f64 = 2.0;
/// Intervals of the longest kind over which the begin of a search comes from what is given to that: a step of
/// b within one interval takes a hundred times the jerk, and the search half of its iterations to get rid of
/// it.
const RAMP: f64 = 24.0;

/// A step from zero to one that begins and ends without slope: at a part of its length, to either side, and
/// its slope.
fn smooth(part: f64, length: f64) -> [f64; 2] {
    let x = part.abs();
    if x < 1.0 { [x * x * (3.0 - 2.0 * x), part.signum() * 6.0 * x * (1.0 - x) / length] } else { [1.0, 0.0] }
}

impl Problem {
    /// Begins with a quicker tempo where that of the law was not changed yet; what is given stays, and so
    /// does what was found before.
    ///
    /// ```text
    ///   QUICK |      ____________          b = base + u (QUICK - base)
    ///         |    /              \        base runs from the known value on the left to that on the right,
    ///     b_l o--'                 \       u from 0 to 1 over the ramp from either of them
    ///     b_r |                     '--o
    /// ```
    pub(super) fn seed_tempo(&self, c: &mut [f64]) {
        let n = self.lengths.len();
        let given = |k: usize| k == 0 && self.fixed[0] || k == n && self.fixed[1];
        let known: Vec<usize> = (0..=n).filter(|k| given(*k) || c[2 * k..2 * k + 2] != [1.0, 0.0]).collect();
        let end = self.begins.last().zip(self.lengths.last()).map_or(0.0, |(begin, length)| begin + length);
        let at = |k: usize| self.begins.get(k).copied().unwrap_or(end);
        let borders = std::iter::once(None).chain(known.iter().copied().map(Some));
        for (left, right) in borders.zip(known.iter().copied().map(Some).chain(std::iter::once(None))) {
            let [low, high] = [left, right].map(|k| k.map_or(QUICK, |k| c[2 * k]));
            for k in left.map_or(0, |k| k + 1)..right.unwrap_or(n + 1) {
                let ramp = |from: Option<usize>| {
                    from.map_or([1.0, 0.0], |from| smooth((at(k) - at(from)) / (RAMP * self.scale), RAMP * self.scale))
                };
                let ([begun, begins], [left_over, ends]) = (ramp(left), ramp(right));
                let [part, grows] = match (left, right) {
                    (Some(l), Some(r)) => smooth((at(k) - at(l)) / (at(r) - at(l)), at(r) - at(l)),
                    (Some(_), None) => [0.0, 0.0],
                    _ => [1.0, 0.0],
                };
                let (base, slope) = (low + (high - low) * part, (high - low) * grows);
                let (lifted, lifts) = (begun * left_over, begins * left_over + begun * ends);
                c[2 * k] = base + lifted * (QUICK - base);
                c[2 * k + 1] = (slope * (1.0 - lifted) + lifts * (QUICK - base)) * self.scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Intervals of several lengths, some of them known from an earlier search: what is known stays,
    /// elsewhere b comes to the quick tempo without a step and without a kink, also where it is known at one
    /// end alone or nowhere.
    #[test]
    fn a_search_begins_without_a_step() {
        let n = 200;
        let lengths: Vec<f64> = (0..n).map(|k| 0.004 * (0.4 + 0.6 * f64::from(k % 7) / 6.0)).collect();
        let begins: Vec<f64> = (0..n as usize).map(|k| lengths[..k].iter().sum()).collect();
        for fixed in [[true, true], [true, false], [false, true], [false, false]] {
            for found in [0..0, 60..90, 130..161] {
                let problem = Problem {
                    scale: 0.004,
                    lengths: lengths.clone(),
                    begins: begins.clone(),
                    fixed,
                    ..Problem::default()
                };
                let mut c = problem.even();
                found.clone().for_each(|k| (c[2 * k], c[2 * k + 1]) = (3.0, 0.0));
                let before = c.clone();
                problem.seed_tempo(&mut c);
                let known = |k: usize| found.contains(&k) || k == 0 && fixed[0] || k == n as usize && fixed[1];
                for k in 0..=n as usize {
                    let (b, slope) = (c[2 * k], c[2 * k + 1] / 0.004);
                    if known(k) {
                        assert_eq!((b, slope), (before[2 * k], before[2 * k + 1] / 0.004));
                        continue;
                    }
                    assert!((1.0..=3.0).contains(&b), "{fixed:?} {found:?} {k}: {b}");
                    if let (Some(i), true) = (k.checked_sub(1), k < n as usize) {
                        let [back, ahead] = [lengths[i], lengths[k]];
                        let rise = [b - c[2 * i], c[2 * k + 2] - b];
                        assert!(rise.iter().all(|r| r.abs() < 0.15), "{fixed:?} {found:?} {k}: {rise:?}");
                        let difference = (rise[0] / back * ahead + rise[1] / ahead * back) / (back + ahead);
                        // A step of one over 24 intervals bends by no more than 6 / (24 h)^2.
                        assert!((difference - slope).abs() < 1.5, "{fixed:?} {found:?} {k}: {difference} {slope}");
                    }
                }
            }
        }
    }
}
