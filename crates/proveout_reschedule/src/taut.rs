//! Shortest path through a row of vertical gates (funnel algorithm).
//!
//! ```text
//!   hi  |      |         |
//!       |  U--*|----*    |
//!   apex*<     |     gap |
//!       |  L--*|----*    |
//!   lo  |      |         |
//! ```
//!
//! The funnel: from the apex the upper chain U is the shortest way to the top of the newest gate (convex:
//! slopes rise), the lower chain L the one to its bottom (concave: slopes fall). A new top takes points off
//! the upper chain while it lies below them; when it lies below the lower chain's first edge, the path must
//! bend there: that point becomes the apex. Bottoms are treated alike.
//!
//! Every point enters and leaves a chain once: linear time. D. T. Lee and F. P. Preparata (1984),
//! Euclidean shortest paths in the presence of rectilinear barriers, Networks 14; for gates at
//! given abscissas it is also the taut string of Davies and Kovac (2001). Where both limits are
//! non-decreasing and the ends are in order the path is non-decreasing: its slope falls only at
//! contacts with lower limits, and after such a contact nothing lies lower than the contact.

use std::collections::VecDeque;

/// A gate: abscissa and the closed interval that the path must pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TautGate {
    /// Abscissa; strictly rising from gate to gate.
    pub s: f64,
    /// Bottom.
    pub low: f64,
    /// Top.
    pub high: f64,
}

fn slope(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[1] - a[1]) / (b[0] - a[0])
}

/// Corners of the shortest path from `start` through the gates to `end`, both ends included. Gates lie
/// between the ends.
///
/// # Errors
/// Index of the first gate that is empty.
pub fn taut_string(start: [f64; 2], gates: &[TautGate], end: [f64; 2]) -> Result<Vec<[f64; 2]>, usize> {
    let mut path = vec![start];
    let mut apex = start;
    let mut upper: VecDeque<[f64; 2]> = VecDeque::new();
    let mut lower: VecDeque<[f64; 2]> = VecDeque::new();
    let last = TautGate { s: end[0], low: end[1], high: end[1] };
    for (i, gate) in gates.iter().chain(std::iter::once(&last)).enumerate() {
        if gate.low.is_nan() || gate.high.is_nan() || gate.low > gate.high {
            return Err(i);
        }
        extend(&mut path, &mut apex, &mut upper, &mut lower, [gate.s, gate.high], |new, old| new < old);
        extend(&mut path, &mut apex, &mut lower, &mut upper, [gate.s, gate.low], |new, old| new > old);
    }
    // Both chains end at the end; what is left of the lower one is the way there.
    path.extend(lower);
    path.dedup();
    Ok(path)
}

/// Corners of the shortest path through gates of which it may take any place of the first and the last: level
/// up to its first corner and from its last one. The sum of any convex function of its slopes is the least
/// there is.
///
/// # Errors
/// Index of the first gate that is empty.
pub fn free_taut_string(gates: &[TautGate]) -> Result<Vec<[f64; 2]>, usize> {
    if let Some(empty) = gates.iter().position(|g| g.low.is_nan() || g.high.is_nan() || g.low > g.high) {
        return Err(empty);
    }
    let (Some(begin), Some(end)) = (gates.first(), gates.last()) else { return Ok(Vec::new()) };
    let ends = (first_demand(gates.iter().enumerate()), first_demand(gates.iter().enumerate().rev()));
    let (Some(first), Some(last)) = ends else {
        let low = gates.iter().map(|g| g.low).fold(f64::MIN, f64::max);
        let high = gates.iter().map(|g| g.high).fold(f64::MAX, f64::min);
        let level = 0.5 * (low + high);
        return Ok(vec![[begin.s, level], [end.s, level]]);
    };
    let point = |(i, value): (usize, f64)| [gates[i].s, value];
    let mut path = vec![[begin.s, first.1]];
    if first.0 < last.0 {
        path.extend(taut_string(point(first), &gates[first.0 + 1..last.0], point(last))?);
    }
    path.push([end.s, last.1]);
    path.dedup();
    Ok(path)
}

/// The last gate, from one end on, with the limit that a later one contradicts; none where one level passes
/// all gates.
fn first_demand<'a>(gates: impl Iterator<Item = (usize, &'a TautGate)>) -> Option<(usize, f64)> {
    let (mut bottom, mut top) = ((0, f64::NEG_INFINITY), (0, f64::INFINITY));
    for (i, gate) in gates {
        if gate.low > top.1 {
            return Some(top);
        }
        if gate.high < bottom.1 {
            return Some(bottom);
        }
        if gate.low >= bottom.1 {
            bottom = (i, gate.low);
        }
        if gate.high <= top.1 {
            top = (i, gate.high);
        }
    }
    None
}

/// Adds a point to a chain; `inside` says that a slope lies on the inner side of another one.
fn extend(
    path: &mut Vec<[f64; 2]>,
    apex: &mut [f64; 2],
    chain: &mut VecDeque<[f64; 2]>,
    other: &mut VecDeque<[f64; 2]>,
    point: [f64; 2],
    inside: impl Fn(f64, f64) -> bool,
) {
    while let Some(&end) = chain.back() {
        let before = if chain.len() > 1 { chain[chain.len() - 2] } else { *apex };
        if !inside(slope(end, point), slope(before, end)) {
            break;
        }
        chain.pop_back();
    }
    if chain.is_empty() {
        while let Some(&bend) = other.front() {
            if bend[0] >= point[0] || !inside(slope(*apex, point), slope(*apex, bend)) {
                break;
            }
            other.pop_front();
            *apex = bend;
            path.push(bend);
        }
    }
    chain.push_back(point);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Length by dynamic programming over a fine grid of each gate: an independent upper bound that tends to
    /// the optimum.
    fn grid_length(start: [f64; 2], gates: &[TautGate], end: [f64; 2], n: usize) -> f64 {
        let mut front = vec![(start, 0.0)];
        for gate in gates.iter().chain(std::iter::once(&TautGate { s: end[0], low: end[1], high: end[1] })) {
            let count = if gate.low == gate.high { 1 } else { n };
            front = (0..count)
                .map(|k| {
                    let y = gate.low + (gate.high - gate.low) * k as f64 / (n - 1) as f64;
                    let p = [gate.s, y];
                    let best = front.iter().map(|(q, l)| l + (p[0] - q[0]).hypot(p[1] - q[1])).fold(f64::MAX, f64::min);
                    (p, best)
                })
                .collect();
        }
        front[0].1
    }

    fn length(path: &[[f64; 2]]) -> f64 {
        path.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum()
    }

    #[test]
    fn it_is_inside_and_as_short_as_a_grid_search() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..200 {
            let gates: Vec<TautGate> = (1..12)
                .map(|i| {
                    let (a, b) = (4.0 * random() - 2.0, 4.0 * random() - 2.0);
                    TautGate { s: f64::from(i) + 0.8 * random(), low: a.min(b), high: a.max(b) }
                })
                .collect();
            let (start, end) = ([0.0, 0.0], [13.0, 2.0 * random() - 1.0]);
            let path = taut_string(start, &gates, end).unwrap();
            assert_eq!((path[0], *path.last().unwrap()), (start, end));
            for gate in &gates {
                let k = path.partition_point(|p| p[0] <= gate.s);
                let (a, b) = (path[k - 1], path[k.min(path.len() - 1)]);
                let y = if b[0] > a[0] { a[1] + slope(a, b) * (gate.s - a[0]) } else { a[1] };
                assert!(y > gate.low - 1e-12 && y < gate.high + 1e-12, "{gate:?} {y}");
            }
            // A grid of 81 points a gate is at most half a grid step off at each of 11 gates; its excess is
            // of second order of the step 0.05 over distances of about one: 11 * 0.025^2 / 0.2.
            let grid = grid_length(start, &gates, end, 81);
            assert!(length(&path) <= grid + 1e-12 && grid - length(&path) < 0.035, "{} {grid}", length(&path));
        }
    }

    #[test]
    fn rising_limits_give_a_rising_path() {
        let mut state = 99_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..1000 {
            let (mut low, mut high) = (-1.0, 0.2);
            let gates: Vec<TautGate> = (1..60)
                .map(|i| {
                    low += 0.3 * random() * random();
                    high = (high + 0.3 * random() * random()).max(low + 0.01);
                    TautGate { s: f64::from(i), low, high }
                })
                .collect();
            let path = taut_string([0.0, 0.0], &gates, [60.0, high]).unwrap();
            assert!(path.windows(2).all(|w| w[1][1] >= w[0][1] - 1e-12), "{path:?}");
        }
    }

    #[test]
    fn a_closed_gate_is_named() {
        let gates = [TautGate { s: 1.0, low: 0.0, high: 1.0 }, TautGate { s: 2.0, low: 1.0, high: 0.0 }];
        assert_eq!(taut_string([0.0, 0.0], &gates, [3.0, 0.0]), Err(1));
        assert_eq!(taut_string([0.0, 0.0], &[], [3.0, 1.0]), Ok(vec![[0.0, 0.0], [3.0, 1.0]]));
    }
}
