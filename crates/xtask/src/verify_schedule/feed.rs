//! Least times of blocks, from the ways of the tip.
//!
//! A way gives block i the vector `u_i` along it with the size time over length. On whatever way the tip is
//! within `off_mm` of the points it takes, for each window of blocks, no less than the times less `off_mm`
//! times the sizes of the changes of u inside, and times the sizes of u at both ends. So the claimed times
//! may be at most that: checked for every window of every way, by their two ends.

use serde_json::Value;

use super::{TaskError, list, number, numbers, wrong};

/// By how much sums of many blocks may differ, s.
const ROUNDED_S: f64 = 1e-9;

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Checks that least times and seams are proved by each way.
pub(super) fn check(run: &Value, least: &[f64], seams: &[f64]) -> Result<(), TaskError> {
    let (passed, off) = (1.0 + number(run, "feed_passed")?, number(run, "off_mm")?);
    if !(off >= 0.0 && passed >= 1.0) {
        return Err(wrong("off_mm or feed_passed is below zero"));
    }
    let ways = list(run, "ways")?;
    if ways.is_empty() {
        return Err(wrong("no path given to prove the feed from"));
    }
    for way in ways {
        let name = way["program"].as_str().unwrap_or("nameless");
        let times = numbers(way, "times_s")?;
        let points: Option<Vec<[f64; 3]>> =
            list(way, "points_mm")?.iter().map(|p| Some([p[0].as_f64()?, p[1].as_f64()?, p[2].as_f64()?])).collect();
        let points = points.ok_or_else(|| wrong(format!("a point of the {name} path is invalid")))?;
        if times.len() != least.len() || points.len() != least.len() + 1 {
            return Err(wrong(format!("the {name} path needs one time per block and one point per gate")));
        }
        let mut vectors = Vec::with_capacity(times.len());
        for (i, time) in times.iter().enumerate() {
            let step: [f64; 3] = std::array::from_fn(|k| points[i + 1][k] - points[i][k]);
            let length = norm(step);
            if length <= 0.0 || *time <= 0.0 {
                return Err(wrong(format!("block {i} of the {name} path does not move")));
            }
            vectors.push(step.map(|x| x * time / (length * length)));
        }
        // From gate a to gate b the way proves `S(b) - S(a) + k_a - begin(a) - end(b)` with S the times less
        // the bends k so far, and `L(b) - L(a) - seam_a - seam_b` is claimed.
        let bend = |g: usize| -> f64 {
            let turned = |g: usize| norm(std::array::from_fn(|k| vectors[g][k] - vectors[g - 1][k]));
            if g > 0 { off * turned(g) / passed } else { 0.0 }
        };
        let (mut proved, mut claimed, mut begun) = (0.0, 0.0, f64::NEG_INFINITY);
        for g in 0..points.len() {
            if g > 0 {
                let end = off * norm(vectors[g - 1]) / passed;
                if proved - claimed - end + seams[g] < begun - ROUNDED_S {
                    return Err(wrong(format!(
                        "a window of blocks up to gate {g} claims more feed time than the {name} path proves"
                    )));
                }
            }
            if g < vectors.len() {
                let begin = off * norm(vectors[g]) / passed;
                // A window that begins here has no bend here: S counts it after this gate.
                begun = f64::max(begun, proved - claimed - bend(g) - seams[g] + begin);
                proved += times[g] / passed - bend(g);
                claimed += least[g];
            }
        }
    }
    Ok(())
}

/// The first window of blocks that takes less than its least time, in the times of a program; none where
/// there is none.
pub(super) fn faster(own: &[f64], least: &[f64], seams: &[f64]) -> Option<[usize; 2]> {
    // Of what the times have more than the least: the most that a window brings along from its begin.
    let (mut more, mut most) = (0.0, (f64::NEG_INFINITY, 0));
    for g in 0..own.len() {
        if more - seams[g] > most.0 {
            most = (more - seams[g], g);
        }
        more += own[g] - least[g];
        if more + seams[g + 1] < most.0 - ROUNDED_S {
            return Some([most.1, g]);
        }
    }
    None
}
