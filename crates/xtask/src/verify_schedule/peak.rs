//! The least peak of acceleration or jerk at programmed times, by the weights of its dual.
//!
//! A divided difference of order m is a mean of the m-th derivative. It is counted here by the recursion of
//! Newton, from the positions up; the product has closed weights. Pulling at the positions with the weights w
//! of the differences (`sum |w| <= 1`), and at the steps between them with pushes whose limits count against
//! it, proves what the gates leave of it.

use serde_json::Value;

use super::{TaskError, list, number, numbers, wrong};

/// By how much sums of many weights may differ, as part.
const ROUNDED: f64 = 1e-6;

/// What divided differences of an order do to positions, turned round: the pull on each position of one
/// weight.
fn pull(nodes: &[f64]) -> Vec<f64> {
    // The difference as a row of numbers on its positions, built order by order.
    let mut rows: Vec<Vec<f64>> =
        (0..nodes.len()).map(|k| (0..nodes.len()).map(|l| f64::from(u8::from(l == k))).collect()).collect();
    for order in 1..nodes.len() {
        rows = (0..nodes.len() - order)
            .map(|k| {
                let apart = nodes[k + order] - nodes[k];
                rows[k + 1].iter().zip(&rows[k]).map(|(b, a)| (b - a) / apart * order as f64).collect()
            })
            .collect();
    }
    rows.swap_remove(0)
}

pub(super) fn check(run: &Value, peak: &Value) -> Result<(), TaskError> {
    let order =
        peak["order"].as_u64().filter(|m| matches!(m, 2 | 3)).ok_or_else(|| wrong("a peak has an unknown order"))?
            as usize;
    let velocity = numbers(peak, "velocity_deg_s")?;
    let &[slowest, fastest] = velocity.as_slice() else { return Err(wrong("a least peak needs two velocities")) };
    if slowest > 0.0 || fastest < 0.0 {
        return Err(wrong("the velocity range of a least peak must include zero"));
    }
    let joint = list(run, "joints")?.iter().find(|j| j["name"] == peak["joint"]);
    let joint = joint.ok_or_else(|| wrong("the joint of a least peak is not in the certificate"))?;
    let limit = number(joint, "velocity_deg_s")? * (1.0 + number(run, "limit_passed")?);
    let reaches = |v: f64| v == 0.0 || v.abs() >= limit * (1.0 - ROUNDED);
    if !(reaches(slowest) && reaches(fastest)) || slowest == fastest {
        return Err(wrong("the velocities of a least peak must be zero or reach the joint's limit"));
    }
    let rounding = number(run, "rounding_deg")?;
    let gates: Option<Vec<[f64; 2]>> = list(joint, "gates_deg")?
        .iter()
        .map(|g| Some([g[0].as_f64()? + rounding, g[1].as_f64()? - rounding]))
        .collect();
    let gates = gates.ok_or_else(|| wrong("a gate is not a pair"))?;
    let mut times = vec![0.0];
    for t in numbers(run, "nominal_s")? {
        if t <= 0.0 {
            return Err(wrong("a block has no programmed time"));
        }
        times.push(times[times.len() - 1] + t);
    }
    let (weights, pushes) = (numbers(peak, "weights")?, numbers(peak, "pushes")?);
    if gates.len() != times.len() || weights.len() + order != times.len() || pushes.len() + 1 != times.len() {
        return Err(wrong("a least peak needs one weight per difference and one push per block"));
    }
    if weights.iter().map(|w| w.abs()).sum::<f64>() > 1.0 + ROUNDED {
        return Err(wrong("the weights of a least peak prove nothing: their sum is above one"));
    }
    let mut on = vec![0.0; times.len()];
    for (i, w) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
        for (k, p) in pull(&times[i..=i + order]).into_iter().enumerate() {
            on[i + k] += w * p;
        }
    }
    let mut against = 0.0;
    for (i, p) in pushes.iter().enumerate() {
        on[i] -= p;
        on[i + 1] += p;
        against += (p * fastest).max(p * slowest) * (times[i + 1] - times[i]);
    }
    let gained: f64 = on.iter().zip(&gates).map(|(p, [low, high])| (p * low).min(p * high)).sum();
    let proved = gained - against;
    let size: f64 = on.iter().zip(&gates).map(|(p, [low, high])| (p * low).abs().max((p * high).abs())).sum();
    let claimed = number(peak, "proved_deg")?;
    if claimed > proved + ROUNDED * proved.abs().max(1.0) + 1e-12 * size {
        return Err(wrong(format!("a least peak claims {claimed}, but its weights prove {proved}")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_of_powers_are_their_derivatives() {
        let nodes = [0.0, 0.3, 1.0, 1.1];
        let of =
            |nodes: &[f64], power: i32| -> f64 { pull(nodes).iter().zip(nodes).map(|(p, t)| p * t.powi(power)).sum() };
        assert!((of(&nodes[..3], 2) - 2.0).abs() < 1e-12 && of(&nodes[..3], 1).abs() < 1e-12);
        assert!((of(&nodes, 3) - 6.0).abs() < 1e-9 && of(&nodes, 2).abs() < 1e-9);
    }
}
