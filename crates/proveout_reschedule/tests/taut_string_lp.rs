//! The taut string against the linear program of feed and velocity, solved by a simplex method that shares
//! nothing with it.
//!
//! ```text
//!   minimize  sum e_i     low_i <= q_i <= high_i,   |q_i+1 - q_i| <= V (least_i + e_i),   e_i >= 0
//! ```
//!
//! With `q = low + x` all costs are zero or one and all unknowns at least zero, so that the slack basis has a
//! sound dual: the dual simplex method (C. E. Lemke 1954), rows and columns by the smallest index as R. G.
//! Bland (1977) takes them, so that it ends.

#![expect(clippy::print_stdout, reason = "figures for people who run with --nocapture")]

#[path = "../src/certificate/random_schedules.rs"]
mod random_schedules;

use proveout_reschedule::{JointGates, Schedules, SwingLimits, TautGate, free_taut_string};
use random_schedules::{Random, random_schedules};

/// What is below this is rounding, in units of costs and limits of about one.
const ROUNDED: f64 = 1e-11;

/// Least of `c x` with `a x <= b`, `x >= 0` and no cost below zero. None where nothing keeps all rows.
fn least(a: &[Vec<f64>], b: &[f64], c: &[f64]) -> Option<f64> {
    let (rows, columns) = (a.len(), c.len());
    // Slacks begin as the basis; a column of the tableau is one unknown outside of it.
    let mut tableau: Vec<Vec<f64>> = a.iter().zip(b).map(|(a, b)| a.iter().copied().chain([*b]).collect()).collect();
    let mut costs: Vec<f64> = c.iter().copied().chain([0.0]).collect();
    let mut outside: Vec<usize> = (0..columns).collect();
    let mut basis: Vec<usize> = (columns..columns + rows).collect();
    for _ in 0..100_000 {
        let short = (0..rows).filter(|&r| tableau[r][columns] < -ROUNDED).min_by_key(|&r| basis[r]);
        let Some(row) = short else { return Some(-costs[columns]) };
        let ratio = |k: usize| costs[k].max(0.0) / -tableau[row][k];
        let lowest = (0..columns).filter(|&k| tableau[row][k] < -ROUNDED).map(ratio).fold(f64::INFINITY, f64::min);
        let ties = (0..columns).filter(|&k| tableau[row][k] < -ROUNDED && ratio(k) <= lowest + ROUNDED);
        let column = ties.min_by_key(|&k| outside[k])?;
        let pivot = tableau[row][column];
        let mut own: Vec<f64> = tableau[row].iter().map(|v| v / pivot).collect();
        own[column] = 1.0 / pivot;
        let takes = |line: &mut Vec<f64>| {
            let factor = line[column];
            if factor != 0.0 {
                line[column] = 0.0;
                line.iter_mut().zip(&own).for_each(|(v, o)| *v -= factor * o);
            }
        };
        tableau.iter_mut().enumerate().filter(|(r, _)| *r != row).for_each(|(_, line)| takes(line));
        takes(&mut costs);
        tableau[row] = own;
        std::mem::swap(&mut basis[row], &mut outside[column]);
    }
    panic!("the simplex method goes round");
}

/// Time above the feed that gates of one joint cost at a velocity, by the linear program.
fn excess(row: &[[f64; 2]], times: &[f64], velocity: f64) -> Option<f64> {
    let steps = times.len();
    let columns = row.len() + steps;
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for (i, [low, high]) in row.iter().enumerate() {
        let mut line = vec![0.0; columns];
        line[i] = 1.0;
        a.push(line);
        b.push(high - low);
    }
    for (i, time) in times.iter().enumerate() {
        for sign in [1.0, -1.0] {
            let mut line = vec![0.0; columns];
            (line[i + 1], line[i], line[row.len() + i]) = (sign, -sign, -velocity);
            a.push(line);
            b.push(velocity * time - sign * (row[i + 1][0] - row[i][0]));
        }
    }
    let costs: Vec<f64> = (0..columns).map(|k| f64::from(u8::from(k >= row.len()))).collect();
    least(&a, &b, &costs)
}

#[test]
fn the_simplex_method_solves_what_is_known() {
    // From below 1 to above 4 in two steps of a second at one a second: one second is missing. Turned round
    // it is the same.
    for gates in [[[0.0, 1.0], [-9.0, 9.0], [4.0, 5.0]], [[4.0, 5.0], [-9.0, 9.0], [0.0, 1.0]]] {
        let found = excess(&gates, &[1.0, 1.0], 1.0).expect("all rows can be kept");
        assert!((found - 1.0).abs() < 1e-12, "{found}");
    }
    // x >= 1 and x <= 0.
    assert_eq!(least(&[vec![-1.0], vec![1.0]], &[-1.0, 0.0], &[1.0]), None);
}

/// On the channels that the windows are tried on. A hundred; `PROVEOUT_LP_CHANNELS` for more.
#[test]
fn the_taut_string_takes_just_what_the_linear_program_takes() {
    let count = std::env::var("PROVEOUT_LP_CHANNELS").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    let mut random = Random(83);
    let mut forced = 0;
    let mut most = 0.0_f64;
    for channel in 0..count {
        let schedules = random_schedules(&mut random);
        let JointGates { gates, limits, .. } = &schedules.joints[0];
        // No gate that is open is needed beyond this: all others are within 40.
        let row: Vec<[f64; 2]> = gates.iter().map(|[low, high]| [low.max(-1e3), high.min(1e3)]).collect();
        let mut time = 0.0;
        let mut times = vec![0.0];
        times.extend(schedules.least.iter().map(|t| {
            time += t;
            time
        }));
        let placed: Vec<TautGate> =
            row.iter().zip(&times).map(|([low, high], s)| TautGate { s: *s, low: *low, high: *high }).collect();
        let string = free_taut_string(&placed).expect("gates that are open");
        let at = |s: f64| {
            let k = string.partition_point(|p| p[0] < s).clamp(1, string.len() - 1);
            let (a, b) = (string[k - 1], string[k]);
            if b[0] > a[0] { a[1] + (b[1] - a[1]) * (s - a[0]) / (b[0] - a[0]) } else { b[1] }
        };
        let own: f64 = times
            .windows(2)
            .zip(&schedules.least)
            .map(|(s, least)| least.max((at(s[1]) - at(s[0])).abs() / limits.velocity) - least)
            .sum();
        let program = excess(&row, &schedules.least, limits.velocity).expect("the string keeps all rows");
        // Rounding of a thousand eliminations of numbers up to 1e3 / V.
        assert!((own - program).abs() < 1e-7 * (time + own), "channel {channel}: {own} {program} {schedules:?}");
        most = most.max((own - program).abs() / (time + own));
        forced += usize::from(program > 0.001 * time);
    }
    println!("{count} channels, {forced} of them forced, largest difference {most:e} of the time");
    assert!(4 * forced > count, "{forced} of {count}");
}
