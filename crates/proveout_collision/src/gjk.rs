//! Distance of two convex bodies between two bounds that meet.
//!
//! The method of Gilbert, Johnson and Keerthi (1988) looks for the point v of the difference B - A that is
//! nearest to the origin. Each round knows two numbers: |v|, the distance of two points of the bodies, and
//! the distance of two parallel planes across v with A on one side and B on the other:
//!
//! ```text
//!            A          |          |      B              planes across v, through the supports of both:
//!          .----.       |          |   .-----.           proved  = (s_B(-n) - s_A(n)) n,  n = v / |v|
//!         (      )p ----|----v-----|---q      )          true distance  <= |v| = |q - p|
//!          '----'       |          |   '-----'
//! ```
//!
//! The true distance lies between them, whatever rounding has done to v: planes prove, points are there. It
//! ends where both agree, not where v stops to change. The usual end (a part of |v|, or of the size of the
//! bodies) calls two bodies met that are some micrometers apart, if one of them is long and thin.
//!
//! A simplex of four points that holds the origin proves that the bodies meet.

use proveout_geom::{Point, Vector};

/// Rounds at most. Bodies with corners alone take some ten, a rim along an edge some thirty.
const MOST_ROUNDS: usize = 120;
/// Rounds without a shorter v after which rounding is all that is left.
const MOST_IN_VAIN: usize = 3;
/// A round is in vain when it comes nearer by less than this part.
const NEARER: f64 = 1e-12;
/// Square of the height of a triangle, as a part of that of its longest edge, below which it has no face.
const NO_FACE: f64 = 1e-28;

/// What is known of a distance, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DistanceBounds {
    /// Proved by two planes; zero or less where none is.
    pub(crate) proved: f64,
    /// Distance of the two points; zero where the bodies meet.
    pub(crate) apart: f64,
    /// A point of the first body.
    pub(crate) on_first: Point,
    /// A point of the second.
    pub(crate) on_second: Point,
    /// The bodies meet: the origin lies in a simplex of their difference.
    pub(crate) meet: bool,
}

/// A point of the difference, and the two that it is made of.
#[derive(Clone, Copy)]
struct DifferencePoint {
    w: Vector,
    on_first: Point,
    on_second: Point,
}

/// Nearest points of two convex bodies. `supports` gives the point of the first body that is farthest along a
/// unit vector, and that of the second that is least far; `start` is any vector from the first to the second.
/// It ends where proof and points agree to `within`, or where `bound` is proved.
pub(crate) fn nearest(
    supports: impl Fn(&Vector) -> [Point; 2],
    start: &Vector,
    [within, bound]: [f64; 2],
) -> DistanceBounds {
    let corner = |n: &Vector| {
        let [on_first, on_second] = supports(n);
        DifferencePoint { w: on_second - on_first, on_first, on_second }
    };
    let first = start.try_normalize(0.0).unwrap_or_else(Vector::z);
    let mut simplex = vec![corner(&first)];
    let mut best = DistanceBounds {
        proved: simplex[0].w.dot(&first),
        apart: simplex[0].w.norm(),
        on_first: simplex[0].on_first,
        on_second: simplex[0].on_second,
        meet: false,
    };
    let mut v = simplex[0].w;
    let mut in_vain = 0;
    for _ in 0..MOST_ROUNDS {
        if best.apart <= 0.0 {
            best.meet = true;
            break;
        }
        let Some(n) = v.try_normalize(0.0) else {
            best.meet = true;
            break;
        };
        let next = corner(&n);
        best.proved = best.proved.max(next.w.dot(&n));
        if best.apart - best.proved <= within * (1.0 + best.apart) || best.proved >= bound {
            break;
        }
        if simplex.iter().any(|c| c.w == next.w) {
            break;
        }
        simplex.push(next);
        let Some(weights) = nearest_to_origin(&simplex) else {
            (best.apart, best.meet) = (0.0, true);
            break;
        };
        let mean = |of: &dyn Fn(&DifferencePoint) -> Vector| {
            simplex.iter().zip(&weights).fold(Vector::zeros(), |sum, (c, weight)| sum + of(c) * *weight)
        };
        v = mean(&|c| c.w);
        let apart = v.norm();
        if apart < best.apart {
            in_vain = if apart < best.apart * (1.0 - NEARER) { 0 } else { in_vain + 1 };
            best.apart = apart;
            best.on_first = Point::from(mean(&|c| c.on_first.coords));
            best.on_second = Point::from(mean(&|c| c.on_second.coords));
        } else {
            in_vain += 1;
        }
        if in_vain > MOST_IN_VAIN {
            break;
        }
        let mut kept = weights.iter().map(|weight| *weight > 0.0);
        simplex.retain(|_| kept.next().unwrap_or(false));
    }
    best
}

/// Weights of the corners for the point of their hull that is nearest to the origin; none where it lies
/// inside of four of them.
fn nearest_to_origin(simplex: &[DifferencePoint]) -> Option<Vec<f64>> {
    let n = simplex.len();
    if n >= 4 && holds_origin(simplex) {
        return None;
    }
    let mut best = (f64::INFINITY, vec![0.0; n]);
    // Vertices, edges and faces: each subset of up to three, with the weights of its own plane where these
    // are all above zero.
    for set in 1_u32..(1 << n) {
        let members: Vec<usize> = (0..n).filter(|k| set >> k & 1 == 1).collect();
        let of = |k: usize| simplex[members[k]].w;
        let weights = match members.len() {
            1 => Some(vec![1.0]),
            2 => on_edge(of(0), of(1)),
            3 => on_face(of(0), of(1), of(2)),
            _ => None,
        };
        let Some(weights) = weights else { continue };
        let v = weights.iter().enumerate().fold(Vector::zeros(), |sum, (k, weight)| sum + of(k) * *weight);
        let square = v.norm_squared();
        if square < best.0 {
            let mut all = vec![0.0; n];
            members.iter().zip(&weights).for_each(|(k, weight)| all[*k] = *weight);
            best = (square, all);
        }
    }
    Some(best.1)
}

/// Weights of two points for the foot of the origin between them.
fn on_edge(a: Vector, b: Vector) -> Option<Vec<f64>> {
    let way = b - a;
    let t = -a.dot(&way) / way.norm_squared();
    (t > 0.0 && t < 1.0).then(|| vec![1.0 - t, t])
}

/// Weights of three points for the foot of the origin in their triangle. The longest edge is taken first, and
/// the way across it without its share along it: so a thin triangle loses no more digits than it has to.
fn on_face(a: Vector, b: Vector, c: Vector) -> Option<Vec<f64>> {
    let points = [a, b, c];
    let length = |k: usize| (points[(k + 1) % 3] - points[k]).norm_squared();
    let first = (0..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [i, j, k] = [first, (first + 1) % 3, (first + 2) % 3];
    let (along, side) = (points[j] - points[i], points[k] - points[i]);
    let square = along.norm_squared();
    let part = side.dot(&along) / square;
    let across = side - along * part;
    let height = across.norm_squared();
    if height.is_nan() || height <= NO_FACE * square {
        return None;
    }
    let t = -points[i].dot(&across) / height;
    let s = -points[i].dot(&along) / square - part * t;
    let mut weights = vec![0.0; 3];
    (weights[i], weights[j], weights[k]) = (1.0 - s - t, s, t);
    weights.iter().all(|w| *w > 0.0).then_some(weights)
}

/// Whether four points hold the origin: it is on the inner side of each face.
fn holds_origin(simplex: &[DifferencePoint]) -> bool {
    let w: Vec<Vector> = simplex.iter().map(|c| c.w).collect();
    [[0, 1, 2, 3], [0, 1, 3, 2], [0, 2, 3, 1], [1, 2, 3, 0]].iter().all(|&[a, b, c, d]| {
        let normal = (w[b] - w[a]).cross(&(w[c] - w[a]));
        let (own, origin) = (normal.dot(&(w[d] - w[a])), normal.dot(&-w[a]));
        own * origin > 0.0
    })
}
