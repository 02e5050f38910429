//! Which findings of two runs are the same one: pairs, each finding in one of them or in none.
//!
//! Code, bodies, file and line agree. Of several the two pair whose places are nearest to each other, then
//! the next two. Places that are farther apart than the area of the fault is wide are two faults: one is
//! gone, and one is new.

use std::collections::BTreeMap;

use proveout_sim::finding::Finding;

/// Places so near are the same, however small the fault, mm.
const SAME_PLACE_MM: f64 = 1.0;
/// Most distances that are looked at for one kind; more findings of a kind than that pair in their order.
const MOST_DISTANCES: usize = 4_000_000;

type Kind<'a> = (&'a str, &'a [String], Option<&'a str>, Option<u32>, bool);

/// What must agree. A finding that covers several areas never pairs with one of a single area.
fn kind(f: &Finding) -> Kind<'_> {
    (&f.code, &f.bodies, f.file.as_deref(), f.line, f.areas.is_some_and(|n| n > 1))
}

/// Distance of two findings, mm, where they may be the same; none where they are two.
fn apart(a: &Finding, b: &Finding) -> Option<f64> {
    let (Some(p), Some(q)) = (a.point_mm, b.point_mm) else { return Some(0.0) };
    let distance = (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
    let wide = [a.area_mm2, b.area_mm2].into_iter().flatten().fold(0.0_f64, f64::max).sqrt();
    (distance <= wide.max(SAME_PLACE_MM)).then_some(distance)
}

/// Pairs of findings of two runs: number of the first run, number of the second.
pub(super) fn pairs(a: &[Finding], b: &[Finding]) -> BTreeMap<usize, usize> {
    let mut kinds: BTreeMap<Kind<'_>, [Vec<usize>; 2]> = BTreeMap::new();
    for (side, findings) in [a, b].into_iter().enumerate() {
        for (i, finding) in findings.iter().enumerate() {
            kinds.entry(kind(finding)).or_default()[side].push(i);
        }
    }
    let mut all = BTreeMap::new();
    for [first, second] in kinds.into_values() {
        if first.len().saturating_mul(second.len()) > MOST_DISTANCES {
            all.extend(first.into_iter().zip(second));
            continue;
        }
        let mut near: Vec<(f64, usize, usize)> = first
            .iter()
            .flat_map(|i| second.iter().filter_map(move |k| Some((apart(a.get(*i)?, b.get(*k)?)?, *i, *k))))
            .collect();
        near.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let mut taken = std::collections::BTreeSet::new();
        for (_, i, k) in near {
            if !all.contains_key(&i) && taken.insert(k) {
                all.insert(i, k);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gouge(line: u32, x: f64) -> Finding {
        let json = format!(
            "{{\"code\": \"geometry-gouge\", \"family\": \"geometry\", \"severity\": \"error\", \"message\": \"m\", \"file\": \"a.nc\", \
             \"line\": {line}, \"axes\": {{}}, \"bodies\": [], \"repeats\": 0, \"point_mm\": [{x}, 0.0, 0.0], \"area_mm2\": 4.0}}"
        );
        serde_json::from_str(&json).expect("a finding")
    }

    #[test]
    fn every_finding_is_in_one_pair_at_most_and_the_nearest_are_one() {
        let all = |places: &[f64]| places.iter().map(|x| gouge(8, *x)).collect::<Vec<_>>();
        // Before, after, pairs by place; the rest is gone or new.
        type Case<'a> = (&'a [f64], &'a [f64], &'a [(f64, f64)]);
        let cases: [Case<'_>; 6] = [
            (&[-26.0, 26.0], &[-26.0], &[(-26.0, -26.0)]),
            (&[-26.0], &[26.0, -26.0], &[(-26.0, -26.0)]),
            (&[0.0, 1.0], &[0.9, 0.1], &[(0.0, 0.1), (1.0, 0.9)]),
            (&[0.0], &[30.0], &[]),
            (&[0.0, 0.0, 0.0], &[0.0, 0.0], &[(0.0, 0.0), (0.0, 0.0)]),
            (&[], &[5.0], &[]),
        ];
        for (before, after, wanted) in cases {
            let found = pairs(&all(before), &all(after));
            let mut named: Vec<(f64, f64)> = found.iter().map(|(i, k)| (before[*i], after[*k])).collect();
            named.sort_by(|x, y| x.0.total_cmp(&y.0));
            assert_eq!(named, wanted, "{before:?} {after:?}");
        }
        assert!(pairs(&[gouge(8, 0.0)], &[gouge(9, 0.0)]).is_empty(), "another line");
    }
}
