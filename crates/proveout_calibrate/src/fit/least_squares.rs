//! Bounded nonlinear least squares with standard errors: Gauss-Newton with the damping of Marquardt (1963),
//! and a rank test.
//!
//! Residuals come in blocks (one move each), already divided by their standard deviations, so that the sum of
//! squares has the expectation of its degrees of freedom. A block names the parameters that it depends on;
//! derivatives are central differences of those alone.
//!
//! *Covariance.* With H the sum of J'J, the covariance is f H^-1, where f is at least one and covers what the
//! standard deviations do not: the mean square of the residuals, times what their correlation along time
//! takes from the number of independent rows, `1 + 2 (r1 + r2 + ...)` (Bartlett 1946).
//!
//! *Rank.* H is scaled to a unit diagonal and split into its eigenvectors. A parameter that takes part in an
//! eigenvector without weight is not known, and no error is given for it.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Eigenvalues below this part of the largest one carry no knowledge: derivatives are differences, good to
/// about 1e-7 of themselves, and H is their square.
const RANK: f64 = 1e-11;
/// Part of a parameter that may lie in directions without weight.
const UNKNOWN_SHARE: f64 = 1e-6;
/// Damping at the begin, and what ends the search for a better step.
const FIRST_DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e12;
/// Steps after which the search ends in any case.
const MOST_STEPS: usize = 200;
/// Relative gain of a step below which the minimum is found; three such steps in a row end the search.
const FOUND: f64 = 1e-10;
/// Longest correlation of residuals, rows.
const MOST_LAGS: usize = 400;
/// Rows in a block below which no correlation is looked for.
const FEWEST_ROWS: usize = 20;

/// Residuals as a function of parameters.
pub(crate) trait Problem {
    /// Number of blocks of residuals.
    fn blocks(&self) -> usize;
    /// Parameters that a block depends on.
    fn depends(&self, block: usize) -> &[usize];
    /// Residuals of a block over their standard deviations, in the order of time; `None` where the
    /// parameters mean nothing.
    fn residuals(&self, block: usize, parameters: &[f64]) -> Option<Vec<f64>>;
    /// Step of the difference for a parameter.
    fn step(&self, parameter: usize) -> f64;
    /// Steps of the search may use differences to one side: half the work where a residual is a simulation.
    fn one_sided(&self) -> bool {
        false
    }
    /// Lowest and highest value of a parameter.
    fn bounds(&self, parameter: usize) -> [f64; 2];
}

/// The minimum.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub(crate) parameters: Vec<f64>,
    /// Sum of squares.
    pub(crate) cost: f64,
    /// Number of residuals.
    pub(crate) rows: usize,
    /// Standard error of each parameter; none where the data do not determine it.
    pub(crate) errors: Vec<Option<f64>>,
    /// Correlation of each pair; zero with a parameter that is not determined.
    pub(crate) correlations: DMatrix<f64>,
    /// Factor by which the variances were widened.
    pub(crate) inflation: f64,
    /// The search ended at a minimum.
    pub(crate) converged: bool,
}

struct Linear {
    h: DMatrix<f64>,
    g: DVector<f64>,
}

fn cost_of(problem: &dyn Problem, x: &[f64]) -> Option<f64> {
    let mut sum = 0.0;
    for block in 0..problem.blocks() {
        sum += problem.residuals(block, x)?.iter().map(|r| r * r).sum::<f64>();
    }
    sum.is_finite().then_some(sum)
}

/// H and gradient at a place.
fn linear(problem: &dyn Problem, x: &[f64], one_sided: bool) -> Option<Linear> {
    let n = x.len();
    let (mut h, mut g) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
    let mut moved = x.to_vec();
    for block in 0..problem.blocks() {
        let here = problem.residuals(block, x)?;
        let depends = problem.depends(block);
        let mut columns: Vec<Vec<f64>> = Vec::with_capacity(depends.len());
        for &p in depends {
            let step = problem.step(p);
            let [low, high] = problem.bounds(p);
            let (up, mut down) = ((x[p] + step).min(high), (x[p] - step).max(low));
            if one_sided && up > x[p] {
                down = x[p];
            }
            moved[p] = up;
            let above = problem.residuals(block, &moved)?;
            moved[p] = down;
            let below = if down == x[p] { here.clone() } else { problem.residuals(block, &moved)? };
            moved[p] = x[p];
            let width = up - down;
            let slope = |(a, b): (&f64, &f64)| if width > 0.0 { (a - b) / width } else { 0.0 };
            columns.push(above.iter().zip(&below).map(slope).collect());
        }
        for (i, &p) in depends.iter().enumerate() {
            g[p] += columns[i].iter().zip(&here).map(|(j, r)| j * r).sum::<f64>();
            for (k, &q) in depends.iter().enumerate().take(i + 1) {
                let sum = columns[i].iter().zip(&columns[k]).map(|(a, b)| a * b).sum::<f64>();
                h[(p, q)] += sum;
                if p != q {
                    h[(q, p)] += sum;
                }
            }
        }
    }
    (h.iter().all(|v| v.is_finite()) && g.iter().all(|v| v.is_finite())).then_some(Linear { h, g })
}

/// Searches from `start`; none where the problem cannot be evaluated there.
pub(crate) fn minimize(problem: &dyn Problem, start: &[f64]) -> Option<Minimum> {
    let n = start.len();
    let clamp = |p: usize, v: f64| {
        let [low, high] = problem.bounds(p);
        v.clamp(low, high)
    };
    let mut x: Vec<f64> = start.iter().enumerate().map(|(p, v)| clamp(p, *v)).collect();
    let mut cost = cost_of(problem, &x)?;
    let mut damping = FIRST_DAMPING;
    let (mut quiet, mut converged) = (0, false);
    for _ in 0..MOST_STEPS {
        let Linear { h, g } = linear(problem, &x, problem.one_sided())?;
        let mut better = None;
        // A parameter at a bound that would leave it is held there, so that the others find their own step.
        let held: Vec<bool> = (0..n)
            .map(|p| {
                let [low, high] = problem.bounds(p);
                x[p] <= low && g[p] > 0.0 || x[p] >= high && g[p] < 0.0
            })
            .collect();
        let (mut h, mut g) = (h, g);
        for p in (0..n).filter(|p| held[*p]) {
            for k in 0..n {
                (h[(p, k)], h[(k, p)]) = (0.0, 0.0);
            }
            (h[(p, p)], g[p]) = (1.0, 0.0);
        }
        while damping < MOST_DAMPING {
            let mut damped = h.clone();
            for p in 0..n {
                // A parameter without weight stays where it is.
                damped[(p, p)] += damping * h[(p, p)] + f64::MIN_POSITIVE.sqrt();
            }
            let step = damped.cholesky().map(|c| c.solve(&g));
            if let Some(step) = step {
                let next: Vec<f64> = (0..n).map(|p| clamp(p, x[p] - step[p])).collect();
                if let Some(new) = cost_of(problem, &next).filter(|c| *c <= cost) {
                    better = Some((next, new));
                    break;
                }
            }
            damping *= 5.0;
        }
        let Some((next, new)) = better else {
            converged = true;
            break;
        };
        let gain = cost - new;
        damping = (damping * 0.1).max(1e-12);
        (x, quiet) = (next, if gain <= FOUND * cost { quiet + 1 } else { 0 });
        cost = new;
        if quiet >= 3 || cost == 0.0 {
            converged = true;
            break;
        }
    }
    let Linear { h, .. } = linear(problem, &x, false)?;
    let mut rows = 0;
    let mut all: Vec<Vec<f64>> = Vec::with_capacity(problem.blocks());
    for block in 0..problem.blocks() {
        let r = problem.residuals(block, &x)?;
        rows += r.len();
        all.push(r);
    }
    let free = rows.saturating_sub(n).max(1) as f64;
    let inflation = (cost / free).max(1.0) * correlation_time(&all);
    let (errors, correlations) = covariance(&h, inflation);
    Some(Minimum { parameters: x, cost, rows, errors, correlations, inflation, converged })
}

/// What correlation of the residuals along time takes from their number: one for independent ones.
fn correlation_time(blocks: &[Vec<f64>]) -> f64 {
    let rows: usize = blocks.iter().map(Vec::len).filter(|n| *n >= FEWEST_ROWS).sum();
    let blocks = || blocks.iter().filter(|b| b.len() >= FEWEST_ROWS);
    let power: f64 = blocks().flatten().map(|r| r * r).sum();
    if rows == 0 || power == 0.0 {
        return 1.0;
    }
    // Two standard deviations of a correlation of independent numbers: less is not seen as one.
    let seen = 2.0 / (rows as f64).sqrt();
    let mut sum = 0.0;
    for lag in 1..MOST_LAGS {
        let product: f64 = blocks().flat_map(|b| b.iter().zip(b.iter().skip(lag))).map(|(a, b)| a * b).sum();
        let r = product / power;
        if r < seen {
            break;
        }
        sum += r;
    }
    1.0 + 2.0 * sum
}

/// Standard errors and correlations from J'J; parameters that it does not determine have none.
pub(crate) fn covariance(h: &DMatrix<f64>, inflation: f64) -> (Vec<Option<f64>>, DMatrix<f64>) {
    let n = h.nrows();
    let scale: Vec<f64> = (0..n).map(|p| h[(p, p)].max(0.0).sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, k| {
        let s = scale[i] * scale[k];
        if s > 0.0 { h[(i, k)] / s } else { 0.0 }
    });
    let eigen = SymmetricEigen::new(scaled);
    let largest = eigen.eigenvalues.iter().fold(0.0_f64, |m, v| m.max(*v));
    let carries = |k: usize| eigen.eigenvalues[k] > RANK * largest;
    let known: Vec<bool> = (0..n)
        .map(|p| {
            let lost: f64 = (0..n).filter(|k| !carries(*k)).map(|k| eigen.eigenvectors[(p, k)].powi(2)).sum();
            scale[p] > 0.0 && lost < UNKNOWN_SHARE
        })
        .collect();
    let entry = |i: usize, k: usize| -> f64 {
        (0..n)
            .filter(|m| carries(*m))
            .map(|m| eigen.eigenvectors[(i, m)] * eigen.eigenvectors[(k, m)] / eigen.eigenvalues[m])
            .sum()
    };
    let variance: Vec<f64> = (0..n).map(|p| entry(p, p)).collect();
    let errors = (0..n).map(|p| known[p].then(|| (inflation * variance[p]).sqrt() / scale[p])).collect();
    let correlations = DMatrix::from_fn(n, n, |i, k| {
        if i == k {
            1.0
        } else if known[i] && known[k] {
            entry(i, k) / (variance[i] * variance[k]).sqrt()
        } else {
            0.0
        }
    });
    (errors, correlations)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = a exp(-b x) + c, with c without effect where `idle`.
    struct Decay {
        y: Vec<f64>,
        depends: Vec<usize>,
        idle: bool,
    }

    impl Problem for Decay {
        fn blocks(&self) -> usize {
            1
        }

        fn depends(&self, _: usize) -> &[usize] {
            &self.depends
        }

        fn residuals(&self, _: usize, p: &[f64]) -> Option<Vec<f64>> {
            let c = if self.idle { 0.0 } else { p[2] };
            let at = |(i, y): (usize, &f64)| (p[0] * (-p[1] * 0.05 * i as f64).exp() + c - y) / 0.01;
            Some(self.y.iter().enumerate().map(at).collect())
        }

        fn step(&self, _: usize) -> f64 {
            1e-5
        }

        fn bounds(&self, parameter: usize) -> [f64; 2] {
            if parameter == 1 { [0.0, 2.5] } else { [-1e6, 1e6] }
        }
    }

    fn decay(b: f64, idle: bool) -> Decay {
        // A fixed pattern of errors of 0.01 with mean zero.
        let error = |i: usize| 0.01 * [1.2, -0.3, -1.4, 0.8, 0.2, -0.5][i % 6];
        let y = (0..60).map(|i| 3.0 * (-b * 0.05 * i as f64).exp() + if idle { 0.0 } else { 1.0 } + error(i));
        Decay { y: y.collect(), depends: vec![0, 1, 2], idle }
    }

    #[test]
    fn the_minimum_is_found_from_afar_with_its_error() {
        let found = minimize(&decay(1.3, false), &[1.0, 0.2, 0.0]).expect("evaluated");
        assert!(found.converged);
        for (p, truth) in [3.0, 1.3, 1.0].into_iter().enumerate() {
            let error = found.errors[p].expect("determined");
            assert!(error > 1e-4 && error < 0.1, "{error}");
            assert!((found.parameters[p] - truth).abs() < 4.0 * error, "{p}: {:?}", found.parameters);
        }
        assert!(found.correlations[(1, 2)].abs() > 0.5, "rate and floor of a decay go together");
    }

    #[test]
    fn a_bound_holds() {
        let found = minimize(&decay(4.0, false), &[1.0, 0.2, 0.0]).expect("evaluated");
        assert_eq!(found.parameters[1], 2.5);
    }

    #[test]
    fn what_has_no_effect_is_not_known_and_stays() {
        let found = minimize(&decay(1.3, true), &[1.0, 0.2, 0.7]).expect("evaluated");
        assert_eq!((found.errors[2], found.parameters[2]), (None, 0.7));
        assert!(found.errors[0].is_some() && found.errors[1].is_some());
    }

    /// Two parameters of which only the sum counts: neither is known, a third one is.
    #[test]
    fn the_parts_of_a_sum_are_not_known() {
        let h = DMatrix::from_row_slice(3, 3, &[4.0, 4.0, 0.0, 4.0, 4.0, 0.0, 0.0, 0.0, 25.0]);
        let (errors, _) = covariance(&h, 1.0);
        assert_eq!((errors[0], errors[1]), (None, None));
        assert!((errors[2].expect("its own") - 0.2).abs() < 1e-12);
    }

    #[test]
    fn residuals_in_pairs_count_once() {
        let mut state = 3_u64;
        let mut sign = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let pairs: Vec<f64> = (0..2000).flat_map(|_| [sign(); 2]).collect();
        // Neighbors agree in half of the cases fully, else by chance: r1 = 0.5, so that two rows count as
        // one.
        let found = correlation_time(&[pairs]);
        assert!((found - 2.0).abs() < 0.2, "{found}");
        let single: Vec<f64> = (0..4000).map(|_| sign()).collect();
        assert!(correlation_time(&[single]) < 1.1);
    }
}
