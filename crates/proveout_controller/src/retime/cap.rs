//! Limits of the square of the tempo by feed and joint velocities, which change over an interval.
//!
//! A speed `V` allows b up to `U(p) = 1/w(p)` with `w = (v/V)^2`, v the speed at b = 1. On the path that is
//! run the tip's way by the parameter changes through a corner, and with it U. The cubic H with value and
//! slope of U at both ends of an interval differs from U by the fourth power of the interval's length:
//!
//! ```text
//!        U0 + h/3 U0'    U1 - h/3 U1'        control points of H and, below them, of b: b <= H
//!           o- - - - - - -o
//!        ./                 \.
//!   U0 o'     b <= H = U      'o U1          over both ends the slope of b goes on, and so does that of U
//!      |<--------- h -------->|
//! ```
//!
//! H is checked in all nodes of the interval and lowered as a whole by the amount it exceeds U
//! there. Where a limit more than doubles over an interval, or its ends do not describe the inside,
//! the lowest U of the nodes holds throughout.

use proveout_machine::MAX_JOINTS;

use super::problem::TempoNode;

/// Square of a speed over its limit, and its slope by the time of the first law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cap {
    value: f64,
    slope: f64,
}

/// Caps of the joints, followed by that of the feed.
pub(super) type Caps = [Cap; MAX_JOINTS + 1];

impl Cap {
    /// Of a speed with its slope.
    pub(super) fn of([speed, slope]: [f64; 2], limit: f64) -> Self {
        let part = speed / limit;
        Self { value: part * part, slope: 2.0 * part * slope / limit }
    }

    pub(super) fn tightened(self, factor: f64) -> Self {
        Self { value: self.value * factor, slope: self.slope * factor }
    }
}

/// One over the highest values of the two inner control points of b in an interval with these nodes.
pub(super) fn inner_points(nodes: &[TempoNode], caps: &[Caps], length: f64) -> [f64; 2] {
    let mut rows = [0.0_f64; 2];
    let last = caps.len().saturating_sub(1);
    for k in 0..=MAX_JOINTS {
        let highest = caps.iter().map(|c| c[k].value).fold(0.0, f64::max);
        if highest <= 0.0 {
            continue;
        }
        let even = 1.0 / highest;
        let ends = [caps[0][k], caps[last][k]];
        let mut points = [even; 2];
        if ends.iter().all(|end| 2.0 * end.value > highest) {
            let u = ends.map(|end| 1.0 / end.value);
            // U' = -w'/w^2.
            let [begin, behind] = [0, 1].map(|i| -ends[i].slope * u[i] * u[i] * length / 3.0);
            let inner = [u[0] + begin, u[1] - behind];
            let over = nodes.iter().zip(caps).map(|(node, cap)| {
                let (t, r) = (node.tau, 1.0 - node.tau);
                let h = r * r * r * u[0] + 3.0 * t * r * (r * inner[0] + t * inner[1]) + t * t * t * u[1];
                h * cap[k].value
            });
            let over = over.fold(1.0, f64::max);
            let lowered = inner.map(|c| c / over);
            if lowered.iter().all(|c| *c >= even) {
                points = lowered;
            }
        }
        for (row, point) in rows.iter_mut().zip(points) {
            *row = row.max(1.0 / point);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(tau: f64) -> TempoNode {
        TempoNode { k: 0, tau, cell: 0, smooth: 0, twin: false, weight: 0.0, speed: 0.0, lead: 0.0 }
    }

    /// A cubic with control points at the limits of the inner ones and at U itself at the ends stays below U,
    /// up to the fourth power of the interval, and comes near it.
    #[test]
    fn b_below_the_inner_points_passes_no_speed() {
        let taus = [0.0, 0.25, 0.5, 0.75, 1.0];
        let nodes: Vec<TempoNode> = taus.iter().map(|t| node(*t)).collect();
        // The speed of the tip in the middle of a corner, and a joint that turns meanwhile.
        for (h, close) in [(0.4, 2e-3), (0.2, 2e-4), (0.1, 2e-5)] {
            let tip = |p: f64| [(0.5 + 0.5 * p * p).sqrt(), 0.5 * p / (0.5 + 0.5 * p * p).sqrt()];
            let joint = |p: f64| [0.9 - 0.4 * p, -0.4];
            let begin = -0.15;
            let caps: Vec<Caps> = taus
                .iter()
                .map(|t| {
                    let mut caps = [Cap::default(); MAX_JOINTS + 1];
                    caps[MAX_JOINTS] = Cap::of(tip(begin + h * t), 1.0);
                    caps[2] = Cap::of(joint(begin + h * t), 1.1);
                    caps
                })
                .collect();
            let inner = inner_points(&nodes, &caps, h).map(|row| 1.0 / row);
            let limit = |p: f64| tip(p)[0].powi(-2).min((joint(p)[0] / 1.1).powi(-2));
            let ends = [limit(begin), limit(begin + h)];
            let mut nearest = f64::INFINITY;
            for k in 0..=200 {
                let t = f64::from(k) / 200.0;
                let r = 1.0 - t;
                let b = r * r * r * ends[0] + 3.0 * t * r * (r * inner[0] + t * inner[1]) + t * t * t * ends[1];
                let over = b / limit(begin + h * t);
                assert!(over < 1.0 + close, "{h} {t}: {over}");
                nearest = nearest.min(over);
            }
            assert!(nearest > 0.98, "{h}: the limit is not used: {nearest}");
        }
    }

    /// A limit that jumps within the interval, and a joint that turns round in it.
    #[test]
    fn jumps_and_reversals_take_the_lowest_limit() {
        let nodes = [node(0.0), node(0.5), node(0.5), node(1.0)];
        let caps = [1.0, 1.0, 1.5, 1.5].map(|value| {
            let mut caps = [Cap::default(); MAX_JOINTS + 1];
            caps[0] = Cap { value, slope: 0.0 };
            caps
        });
        let rows = inner_points(&nodes, &caps, 0.1);
        assert!(rows.iter().all(|r| *r >= 1.25), "{rows:?}");
        let turning = [0.8, 0.2, 0.0, 0.3].map(|value| {
            let mut caps = [Cap::default(); MAX_JOINTS + 1];
            caps[3] = Cap { value, slope: -3.0 };
            caps
        });
        assert_eq!(inner_points(&nodes, &turning, 0.1), [0.8, 0.8]);
    }
}
