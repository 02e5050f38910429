//! Steps of time, rounding and noise of a trace, as they are found in the numbers.

/// Steps of time that differ by less than this part count as equal.
const EVEN: f64 = 0.02;
/// A difference is a multiple of a step when it is within this part of it.
const ON_GRID: f64 = 0.02;
/// Differences of more steps than this are not looked at: rounding of the numbers themselves would decide.
const MOST_STEPS: f64 = 1e6;
/// Differences that the step is made from.
const SMALLEST: usize = 400;
/// Smallest step that is looked for, in the unit of the column: below it, digits of the format remain.
const FINEST: f64 = 1e-10;
/// Standard deviation over median of the absolute value, of a normal distribution.
const DEVIATION_BY_MEDIAN: f64 = 1.482_602_218_505_602;

/// Median of some numbers; zero of none. The order of the slice changes.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Median step, and whether all steps are equal.
pub(crate) fn steps_of_time(time: &[f64]) -> (f64, bool) {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let step = median(&mut steps);
    let even = steps.iter().all(|s| (s - step).abs() <= EVEN * step);
    (step, even)
}

/// The step of which all differences of a column are multiples; zero where there is none.
///
/// Euclid's algorithm on the smallest differences, with a remainder below [`ON_GRID`] of the step as none: on
/// numbers that are not rounded it falls below the digits of the format.
pub(crate) fn quantum(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let least = FINEST.max(largest * 1e-13);
    let mut steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > least).collect();
    steps.sort_by(f64::total_cmp);
    let Some(mut q) = steps.first().copied() else { return 0.0 };
    for d in steps.iter().take(SMALLEST) {
        loop {
            let rest = (d - (d / q).round() * q).abs();
            if rest <= ON_GRID * q || d / q > MOST_STEPS {
                break;
            }
            q = rest;
            if q < least {
                return 0.0;
            }
        }
        // Remainders lose digits; the longer way has them.
        let whole = (d / q).round();
        if (1.0..MOST_STEPS).contains(&whole) {
            q = d / whole;
        }
    }
    // A longer way gives the step with more digits.
    if let Some(d) = steps.iter().rev().find(|d| **d / q < 1e3) {
        q = d / (d / q).round();
    }
    let near = || steps.iter().map(|d| d / q).filter(|n| *n < MOST_STEPS);
    let on_grid = near().filter(|n| (n - n.round()).abs() < ON_GRID).count();
    let all = near().count();
    if all >= 3 && 2 * all >= steps.len() && on_grid as f64 >= 0.999 * all as f64 { q } else { 0.0 }
}

/// Standard deviation of the noise, from the differences of neighbors at rest: the part of the rows in
/// which a joint moves least. Zero where it is less than the rounding shows.
pub(crate) fn noise(values: &[f64]) -> f64 {
    // Spread of the change over pieces of a few rows: rest is where it is small.
    const PIECE: usize = 16;
    let mut pieces: Vec<(f64, usize)> = Vec::new();
    for (k, piece) in values.chunks_exact(PIECE).enumerate() {
        let (first, last) = piece.split_at(PIECE / 2);
        let mean = |p: &[f64]| p.iter().sum::<f64>() / p.len() as f64;
        pieces.push(((mean(last) - mean(first)).abs(), k * PIECE));
    }
    pieces.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    pieces.truncate((pieces.len() / 8).max(1));
    let mut differences: Vec<f64> = pieces
        .iter()
        .filter_map(|(_, at)| values.get(*at..at + PIECE))
        .flat_map(|piece| piece.windows(2).map(|w| (w[1] - w[0]).abs()))
        .collect();
    let robust = DEVIATION_BY_MEDIAN * median(&mut differences) / std::f64::consts::SQRT_2;
    let rms = (differences.iter().map(|d| d * d).sum::<f64>() / differences.len().max(1) as f64 / 2.0).sqrt();
    // Rounded columns have a median of zero or of one step; their spread is the better measure then.
    if robust > 0.0 { robust.min(rms) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> impl Iterator<Item = f64> {
        (0..n).map(|i| 40.0 * (0.01 * i as f64).sin() + 3.0)
    }

    #[test]
    fn rounding_is_found_and_full_numbers_have_none() {
        for q in [1.0, 0.01, 1e-3, 1e-6, 0.000_5] {
            let rounded: Vec<f64> = wave(4000).map(|v| (v / q).round() * q).collect();
            assert!((quantum(&rounded) / q - 1.0).abs() < 1e-6, "{q}: {}", quantum(&rounded));
        }
        let full: Vec<f64> = wave(4000).collect();
        assert_eq!(quantum(&full), 0.0);
        assert_eq!(quantum(&[5.0; 100]), 0.0, "a joint that never moves shows no step");
        assert_eq!(quantum(&[]), 0.0);
    }

    #[test]
    fn noise_is_that_of_the_rests() {
        // A sum of twelve even numbers has the variance one.
        let mut state = 7_u64;
        let mut even = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| even()).sum::<f64>() - 6.0;
        let values: Vec<f64> =
            (0..4000).map(|i| if i < 2500 { 0.0 } else { 0.4 * f64::from(i - 2500) } + 0.001 * normal()).collect();
        let found = noise(&values);
        // 310 pieces of 16 rows are looked at an eighth of: 600 differences, 5 percent of their spread; the
        // pieces with the least change are a little quieter than the others.
        assert!((found / 0.001 - 1.0).abs() < 0.15, "{found}");
        assert_eq!(noise(&[1.0; 200]), 0.0);
        assert_eq!(noise(&[]), 0.0);
    }

    #[test]
    fn steps_of_time_are_even_or_not() {
        let even: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.001).collect();
        assert!(steps_of_time(&even).1);
        let mut shaken = even.clone();
        shaken[50] += 0.0003;
        let (step, is_even) = steps_of_time(&shaken);
        assert!((step - 0.001).abs() < 1e-9 && !is_even);
        assert_eq!(steps_of_time(&[]), (0.0, true));
    }
}
