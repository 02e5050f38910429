//! Curves in the parameter plane of a surface: cubic splines u(t), v(t) through nodes, straight where there
//! are two.

use super::{PathError, Ruling};

/// A cubic spline through nodes with continuous second derivative. The ends are free of a condition of their
/// own: the first and the last two pieces are one cubic each (de Boor 1978, chapter IV, "not-a-knot"), so
/// that smooth data are met to fourth order up to the ends. Two nodes give a straight line, three a parabola.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the nodes.
    bend: Vec<f64>,
}

impl Spline {
    /// Through `y` at strictly ascending `x`; none where they are not, or fewer than two.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Option<Self> {
        let n = x.len();
        let ascending = x.windows(2).all(|w| w[0] < w[1]) && x.iter().chain(&y).all(|v| v.is_finite());
        if n < 2 || y.len() != n || !ascending {
            return None;
        }
        let h: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
        let slope: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
        let mut bend = vec![0.0; n];
        if n == 3 {
            bend.fill(2.0 * (slope[1] - slope[0]) / (h[0] + h[1]));
        } else if n > 3 {
            // h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (s_i - s_{i-1}) for the inner nodes;
            // the third derivative is continuous at the second and the last but one node, which eliminates
            // M_0 and M_{n-1}.
            let m = n - 2;
            let mut low: Vec<f64> = (0..m).map(|i| h[i]).collect();
            let mut mid: Vec<f64> = (0..m).map(|i| 2.0 * (h[i] + h[i + 1])).collect();
            let mut high: Vec<f64> = (0..m).map(|i| h[i + 1]).collect();
            let mut right: Vec<f64> = (0..m).map(|i| 6.0 * (slope[i + 1] - slope[i])).collect();
            mid[0] += h[0] * (1.0 + h[0] / h[1]);
            high[0] -= h[0] * h[0] / h[1];
            let (a, b) = (h[n - 2], h[n - 3]);
            mid[m - 1] += a * (1.0 + a / b);
            low[m - 1] -= a * a / b;
            for i in 1..m {
                let f = low[i] / mid[i - 1];
                mid[i] -= f * high[i - 1];
                right[i] -= f * right[i - 1];
            }
            bend[m] = right[m - 1] / mid[m - 1];
            for i in (1..m).rev() {
                bend[i] = (right[i - 1] - high[i - 1] * bend[i + 1]) / mid[i - 1];
            }
            bend[0] = bend[1] - (bend[2] - bend[1]) * h[0] / h[1];
            bend[n - 1] = bend[n - 2] + (bend[n - 2] - bend[n - 3]) * a / b;
        }
        Some(Self { x, y, bend })
    }

    /// First and last node.
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// The nodes.
    pub fn nodes(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.x.iter().copied().zip(self.y.iter().copied())
    }

    /// Value, first and second derivative; the end pieces go on outside.
    pub fn at(&self, x: f64) -> [f64; 3] {
        let last = self.x.len() - 2;
        let i = self.x.partition_point(|&k| k <= x).saturating_sub(1).min(last);
        let h = self.x[i + 1] - self.x[i];
        let (b, a) = ((x - self.x[i]) / h, (self.x[i + 1] - x) / h);
        let (m, n) = (self.bend[i], self.bend[i + 1]);
        [
            a * self.y[i] + b * self.y[i + 1] + ((a * a * a - a) * m + (b * b * b - b) * n) * h * h / 6.0,
            (self.y[i + 1] - self.y[i]) / h + ((1.0 - 3.0 * a * a) * m + (3.0 * b * b - 1.0) * n) * h / 6.0,
            a * m + b * n,
        ]
    }
}

/// A curve (u(t), v(t)) in the parameter plane of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterCurve {
    u: Spline,
    v: Spline,
}

/// A point of a [`ParameterCurve`]: each of u and v with its first and second derivative by t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// u, u', u''.
    pub u: [f64; 3],
    /// v, v', v''.
    pub v: [f64; 3],
}

impl ParameterCurve {
    /// Straight from one point to another, t from 0 to 1.
    pub fn straight(from: [f64; 2], to: [f64; 2]) -> Option<Self> {
        let line = |k: usize| Spline::new(vec![0.0, 1.0], vec![from[k], to[k]]);
        Some(Self { u: line(0)?, v: line(1)? })
    }

    /// Through points `[u, v]` at ascending t.
    pub fn through(t: &[f64], points: &[[f64; 2]]) -> Option<Self> {
        let of = |k: usize| Spline::new(t.to_vec(), points.iter().map(|p| p[k]).collect());
        Some(Self { u: of(0)?, v: of(1)? })
    }

    /// Range of t.
    pub fn range(&self) -> [f64; 2] {
        self.u.range()
    }

    /// The point at t.
    pub fn at(&self, t: f64) -> CurvePoint {
        CurvePoint { u: self.u.at(t), v: self.v.at(t) }
    }

    /// The same points the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let turned = |s: &Spline| Spline {
            x: s.x.iter().rev().map(|x| -x).collect(),
            y: s.y.iter().rev().copied().collect(),
            bend: s.bend.iter().rev().copied().collect(),
        };
        Self { u: turned(&self.u), v: turned(&self.v) }
    }
}

/// A line of a path: where the cutter touches, and with how much material left.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What the line is called in messages and tables: `u 0.505`, `theta 175 deg`, `layer 2, v 0.3`.
    pub name: String,
    /// Where it runs.
    pub curve: ParameterCurve,
    /// Material left on the surface, mm.
    pub allowance: f64,
    /// The cutter goes from the line before to this one on the surface, without a retract.
    pub joined: bool,
    /// The ruling that the flank of the cutter lies along; none where it touches in a point.
    pub ruling: Option<Ruling>,
}

impl Line {
    /// A line for its own, with nothing left on the surface.
    pub fn new(name: String, curve: ParameterCurve) -> Self {
        Self { name, curve, allowance: 0.0, joined: false, ruling: None }
    }
}

/// The curve through points of which one parameter is the running one.
pub(crate) fn fitted(t: &[f64], points: &[[f64; 2]], what: &str, section: f64) -> Result<ParameterCurve, PathError> {
    ParameterCurve::through(t, points)
        .ok_or_else(|| PathError::NoLine { what: format!("{what} is not a curve through its points"), section })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_met_exactly_with_their_derivatives_up_to_the_ends() {
        let f = |x: f64| [2.0 - x + 0.5 * x * x - 0.3 * x.powi(3), -1.0 + x - 0.9 * x * x, 1.0 - 1.8 * x];
        let x: Vec<f64> = vec![-1.0, -0.4, 0.1, 0.2, 1.3, 2.0];
        let spline = Spline::new(x.clone(), x.iter().map(|&x| f(x)[0]).collect()).unwrap();
        for k in 0..=60 {
            let x = -1.0 + 0.05 * f64::from(k);
            for (a, b) in spline.at(x).iter().zip(f(x)) {
                assert!((a - b).abs() < 1e-12, "{x}: {a} {b}");
            }
        }
    }

    #[test]
    fn smooth_data_converge_with_the_fourth_power_of_the_step() {
        let worst = |n: usize| {
            let x: Vec<f64> = (0..=n).map(|k| 3.0 * k as f64 / n as f64).collect();
            let spline = Spline::new(x.clone(), x.iter().map(|x| x.sin()).collect()).unwrap();
            (0..=1000).map(|k| 0.003 * f64::from(k)).map(|x| (spline.at(x)[0] - x.sin()).abs()).fold(0.0, f64::max)
        };
        assert!((12.0..24.0).contains(&(worst(20) / worst(40))), "{} {}", worst(20), worst(40));
    }

    #[test]
    fn two_and_three_nodes_and_bad_nodes() {
        assert_eq!(Spline::new(vec![1.0, 3.0], vec![5.0, 9.0]).unwrap().at(2.5), [8.0, 2.0, 0.0]);
        let parabola = Spline::new(vec![0.0, 1.0, 3.0], vec![0.0, 1.0, 9.0]).unwrap().at(2.0);
        assert!(
            (parabola[0] - 4.0).abs() < 1e-14 && (parabola[1] - 4.0).abs() < 1e-14 && (parabola[2] - 2.0).abs() < 1e-14
        );
        assert!(Spline::new(vec![0.0, 0.0], vec![1.0, 2.0]).is_none());
        assert!(Spline::new(vec![0.0], vec![1.0]).is_none());
        assert!(Spline::new(vec![0.0, 1.0], vec![f64::NAN, 1.0]).is_none());
    }

    #[test]
    fn a_reversed_curve_has_the_same_points() {
        let curve = ParameterCurve::through(&[0.0, 1.0, 2.0, 4.0], &[[0.0, 0.0], [1.0, 0.5], [1.5, 2.0], [1.2, 3.0]]);
        let (curve, back) = (curve.clone().unwrap(), curve.unwrap().reversed());
        for t in [0.0, 0.3, 1.7, 4.0] {
            let (a, b) = (curve.at(t), back.at(-t));
            assert!(
                (a.u[0] - b.u[0]).abs() < 1e-14 && (a.v[1] + b.v[1]).abs() < 1e-13 && (a.u[2] - b.u[2]).abs() < 1e-13
            );
        }
    }
}
