//! Points, lines and arcs of the tests, and distances by search. Shares nothing with the crate.

use std::f64::consts::TAU;

pub(crate) type Point = [f64; 2];

pub(crate) fn far(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A straight or circular piece of a path, as a function from 0..1 to points.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    Line(Point, Point),
    /// Center, radius, start angle, signed sweep.
    Arc(Point, f64, f64, f64),
}

impl Shape {
    pub(crate) fn at(&self, s: f64) -> Point {
        match self {
            Self::Line(a, b) => [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])],
            Self::Arc(c, r, from, sweep) => [c[0] + r * (from + s * sweep).cos(), c[1] + r * (from + s * sweep).sin()],
        }
    }

    pub(crate) fn length(&self) -> f64 {
        match self {
            Self::Line(a, b) => far(*a, *b),
            Self::Arc(_, r, _, sweep) => r * sweep.abs(),
        }
    }

    /// Direction of motion at a parameter.
    pub(crate) fn heading(&self, s: f64) -> Point {
        match self {
            Self::Line(a, b) => {
                let l = far(*a, *b).max(1e-300);
                [(b[0] - a[0]) / l, (b[1] - a[1]) / l]
            }
            Self::Arc(_, _, from, sweep) => {
                let (sine, cosine) = (from + s * sweep).sin_cos();
                [-sine * sweep.signum(), cosine * sweep.signum()]
            }
        }
    }

    /// Nearest parameter of a point, and its distance.
    pub(crate) fn nearest(&self, p: Point) -> (f64, f64) {
        let s = match self {
            Self::Line(a, b) => {
                let (d, e) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
                ((d[0] * e[0] + d[1] * e[1]) / (d[0] * d[0] + d[1] * d[1]).max(1e-300)).clamp(0.0, 1.0)
            }
            Self::Arc(c, _, from, sweep) => {
                let angle = (p[1] - c[1]).atan2(p[0] - c[0]);
                let along = (if *sweep > 0.0 { angle - from } else { from - angle }).rem_euclid(TAU);
                if along <= sweep.abs() {
                    along / sweep.abs()
                } else {
                    f64::from(far(p, self.at(1.0)) < far(p, self.at(0.0)))
                }
            }
        };
        (s, far(p, self.at(s)))
    }
}

/// Least distance of two pieces, and the parameter on the first where it is: points not farther apart than
/// `step`, and a golden section about each local minimum that lies below `limit`.
pub(crate) fn distance(a: &Shape, b: &Shape, step: f64, limit: f64) -> (f64, f64) {
    let n = ((a.length() / step).ceil() as usize).clamp(8, 20_000);
    let of = |s: f64| b.nearest(a.at(s)).1;
    let values: Vec<f64> = (0..=n).map(|k| of(k as f64 / n as f64)).collect();
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..=n {
        if values[k] < best.0 {
            best = (values[k], k as f64 / n as f64);
        }
        let lower = (k == 0 || values[k] <= values[k - 1]) && (k == n || values[k] <= values[k + 1]);
        if !lower || values[k] > limit + step {
            continue;
        }
        let (mut low, mut high) = (k.saturating_sub(1) as f64 / n as f64, (k + 1).min(n) as f64 / n as f64);
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..40 {
            let (x, y) = (high - golden * (high - low), low + golden * (high - low));
            if of(x) < of(y) { high = y } else { low = x }
        }
        let s = 0.5 * (low + high);
        if of(s) < best.0 {
            best = (of(s), s);
        }
    }
    best
}
