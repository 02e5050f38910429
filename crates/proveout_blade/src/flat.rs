//! Plane faces with any outline: triangles by cutting off ears (Meisters 1975; a hole is joined to the
//! outline by a bridge, Eberly 2008), and whether a point lies within.

/// Twice the area of a triangle, positive where it runs counter-clockwise.
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Twice the area of a polygon, positive where it runs counter-clockwise.
pub(super) fn polygon_area(polygon: &[[f64; 2]]) -> f64 {
    (0..polygon.len()).map(|k| area(polygon[0], polygon[k], polygon[(k + 1) % polygon.len()])).sum()
}

/// Whether a point lies within a polygon (odd count of crossings to the right).
pub(super) fn contains(polygon: &[[f64; 2]], p: [f64; 2]) -> bool {
    let sides = (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]));
    let crossed = |(a, b): ([f64; 2], [f64; 2])| {
        (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1])
    };
    sides.filter(|s| crossed(*s)).count() % 2 == 1
}

/// Two sides of a polygon that cross, if there are.
pub(super) fn crossing(polygon: &[[f64; 2]]) -> Option<(usize, usize)> {
    let n = polygon.len();
    let side = |k: usize| (polygon[k], polygon[(k + 1) % n]);
    (0..n).find_map(|i| {
        let (a, b) = side(i);
        let (low, high) = ([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]);
        (i + 2..n).filter(|j| i > 0 || *j + 1 < n).find_map(|j| {
            let (c, d) = side(j);
            let apart = (0..2).any(|k| c[k].min(d[k]) > high[k] || c[k].max(d[k]) < low[k]);
            let crosses = !apart && area(a, b, c) * area(a, b, d) < 0.0 && area(c, d, a) * area(c, d, b) < 0.0;
            crosses.then_some((i, j))
        })
    })
}

/// Triangles over a polygon of places, given as indices into `places`, counter-clockwise, with a hole in it,
/// clockwise. None where an ear is not found: the outline crosses itself.
pub(super) fn triangles(places: &[[f64; 2]], outline: &[u32], hole: &[u32]) -> Option<Vec<[u32; 3]>> {
    let at = |i: u32| places[i as usize];
    let mut ring = outline.to_vec();
    if let Some(bridge) = bridge(places, outline, hole) {
        let (from, to) = bridge;
        let tail = ring.split_off(from + 1);
        ring.extend((0..=hole.len()).map(|k| hole[(to + k) % hole.len()]));
        ring.push(ring[from]);
        ring.extend(tail);
    }
    let mut out = Vec::with_capacity(ring.len());
    // A list of who follows whom; bent inward ones are the only that can lie in an ear.
    let n = ring.len();
    let (mut next, mut last): (Vec<usize>, Vec<usize>) =
        ((0..n).map(|k| (k + 1) % n).collect(), (0..n).map(|k| (k + n - 1) % n).collect());
    let (mut left, mut here, mut misses) = (n, 0, 0);
    let mut inward: Vec<usize> =
        (0..n).filter(|&k| area(at(ring[last[k]]), at(ring[k]), at(ring[next[k]])) <= 0.0).collect();
    while left > 3 {
        let (a, b) = (last[here], next[here]);
        let corners = [ring[a], ring[here], ring[b]];
        let [p, q, r] = corners.map(at);
        let within = |k: &usize| {
            let (i, x) = (ring[*k], at(ring[*k]));
            next[*k] != usize::MAX
                && !corners.contains(&i)
                && area(p, q, x) >= 0.0
                && area(q, r, x) >= 0.0
                && area(r, p, x) >= 0.0
        };
        let size = area(p, q, r);
        // Flat ears go too where nothing else is left: a bridge leaves such.
        if (size > 0.0 || (size == 0.0 && misses > left)) && !inward.iter().any(within) {
            out.push(corners);
            (next[a], last[b]) = (b, a);
            (next[here], left, misses) = (usize::MAX, left - 1, 0);
            if left.is_multiple_of(64) {
                inward.retain(|&k| {
                    next[k] != usize::MAX && area(at(ring[last[k]]), at(ring[k]), at(ring[next[k]])) <= 0.0
                });
            }
            // Skipping one makes fewer slivers.
            here = next[b];
        } else {
            misses += 1;
            if misses > 2 * left + 2 {
                return None;
            }
            here = b;
        }
    }
    out.push([ring[last[here]], ring[here], ring[next[here]]]);
    Some(out)
}

/// The shortest way from the outline to the hole: it crosses neither.
fn bridge(places: &[[f64; 2]], outline: &[u32], hole: &[u32]) -> Option<(usize, usize)> {
    let far = |i: usize, j: usize| {
        let (a, b) = (places[outline[i] as usize], places[hole[j] as usize]);
        (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
    };
    let pairs = (0..outline.len()).flat_map(|i| (0..hole.len()).map(move |j| (i, j)));
    pairs.min_by(|x, y| far(x.0, x.1).total_cmp(&far(y.0, y.1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_cover_a_crooked_outline_and_leave_its_hole() {
        // A star of 40 points in a square.
        let star = |k: usize| {
            let (s, c) = (-std::f64::consts::TAU * k as f64 / 40.0).sin_cos();
            let r = if k.is_multiple_of(2) { 3.0 } else { 1.0 };
            [r * c, r * s]
        };
        let mut places = vec![[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]];
        places.extend((0..40).map(star));
        let hole: Vec<u32> = (4..44).collect();
        let all = triangles(&places, &[0, 1, 2, 3], &hole).expect("triangles");
        let sizes: Vec<f64> =
            all.iter().map(|t| area(places[t[0] as usize], places[t[1] as usize], places[t[2] as usize])).collect();
        let star_area = polygon_area(&places[4..]);
        assert!(star_area < 0.0 && sizes.iter().all(|s| *s >= 0.0));
        assert!((sizes.iter().sum::<f64>() - (200.0 + star_area)).abs() < 1e-9);
        assert_eq!(all.len(), 44, "n + 2 vertices of a ring with a bridge give n triangles");
        let turned: Vec<u32> = hole.iter().rev().copied().collect();
        let inner = triangles(&places, &turned, &[]).expect("triangles");
        assert_eq!(inner.len(), 38);
        assert!(contains(&places[4..], [2.5, 0.0]) && !contains(&places[4..], [2.5, 0.3]));
    }
}
