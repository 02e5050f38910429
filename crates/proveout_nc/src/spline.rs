//! B-splines and NURBS: cut into Bezier pieces, each of which is a cubic of the command model or a row of
//! chords.
//!
//! Inserting a knot (W. Boehm, *Inserting new knots into B-spline curves*, 1980) leaves the curve
//! unchanged. Once every inner knot is repeated as often as the degree, the control points of a
//! piece are those of a Bezier curve. Such a curve lies in the convex hull of its control points (of
//! the projected ones, where all weights are positive), so that no point of it is farther from a
//! chord than they are. Pieces are halved until that distance is within the tolerance.

use crate::codes;
use crate::diagnostic::{Fault, Span};

/// X, Y, Z times the weight, and the weight.
pub(crate) type Homogeneous = [f64; 4];

/// Largest distance of a chord from the curve that it replaces, mm: below what programs write.
pub(crate) const CHORD_TOLERANCE_MM: f64 = 0.001;
/// Halvings of one piece: a chord is then the billionth part of it.
const MAX_HALVINGS: u32 = 30;
/// Most chords of one piece: those of an arc of a kilometer are fewer.
pub(crate) const MAX_CHORDS: usize = 20_000;
/// Weights that differ by no more than this part are equal.
const SAME_WEIGHT: f64 = 1e-12;

fn mix(a: &Homogeneous, b: &Homogeneous, t: f64) -> Homogeneous {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// The point of a homogeneous one.
pub(crate) fn projected(p: &Homogeneous) -> [f64; 3] {
    std::array::from_fn(|i| p[i] / p[3])
}

/// Bezier pieces of a B-spline whose end knots are repeated degree + 1 times. `knots` do not fall,
/// `knots.len()` is `points.len() + degree + 1`.
pub(crate) fn bezier_pieces(degree: usize, knots: &[f64], points: &[Homogeneous]) -> Vec<Vec<Homogeneous>> {
    let (mut knots, mut points) = (knots.to_vec(), points.to_vec());
    if degree == 0 || points.len() <= degree || knots.len() != points.len() + degree + 1 {
        return Vec::new();
    }
    let mut at = degree + 1;
    while at + degree + 1 < knots.len() {
        let knot = knots[at];
        let times = knots.iter().filter(|k| **k == knot).count();
        for _ in times..degree {
            insert(degree, &mut knots, &mut points, knot);
        }
        at += times.max(degree);
    }
    (0..points.len() - 1).step_by(degree).filter_map(|i| points.get(i..=i + degree).map(<[_]>::to_vec)).collect()
}

fn insert(degree: usize, knots: &mut Vec<f64>, points: &mut Vec<Homogeneous>, knot: f64) {
    // The last knot that is not above the new one.
    let span = knots.iter().rposition(|k| *k <= knot).unwrap_or(degree);
    let times = knots.iter().filter(|k| **k == knot).count();
    let mut fresh = Vec::with_capacity(points.len() + 1);
    for i in 0..=points.len() {
        fresh.push(if i + degree <= span {
            points[i]
        } else if i + times > span {
            points[i - 1]
        } else {
            let t = (knot - knots[i]) / (knots[i + degree] - knots[i]);
            mix(&points[i - 1], &points[i], t)
        });
    }
    *points = fresh;
    knots.insert(span + 1, knot);
}

/// A piece as a cubic Bezier curve, where its degree is at most 3 and all weights are equal.
pub(crate) fn cubic(piece: &[Homogeneous]) -> Option<[[f64; 3]; 4]> {
    let weight = piece.first()?[3];
    if piece.iter().any(|p| (p[3] - weight).abs() > SAME_WEIGHT * weight.abs()) {
        return None;
    }
    let p: Vec<[f64; 3]> = piece.iter().map(projected).collect();
    let between = |a: [f64; 3], b: [f64; 3], t: f64| -> [f64; 3] { std::array::from_fn(|i| a[i] + t * (b[i] - a[i])) };
    match *p.as_slice() {
        [a, b] => Some([a, between(a, b, 1.0 / 3.0), between(a, b, 2.0 / 3.0), b]),
        [a, m, b] => Some([a, between(a, m, 2.0 / 3.0), between(b, m, 2.0 / 3.0), b]),
        [a, b, c, d] => Some([a, b, c, d]),
        _ => None,
    }
}

/// Ends of chords along a piece, without its start; none where they would be too many.
pub(crate) fn chords(piece: &[Homogeneous], tolerance: f64) -> Option<Vec<[f64; 3]>> {
    let mut ends = Vec::new();
    let mut rest = vec![(piece.to_vec(), 0)];
    while let Some((piece, halvings)) = rest.pop() {
        if ends.len() >= MAX_CHORDS {
            return None;
        }
        let (Some(first), Some(last)) = (piece.first().map(projected), piece.last().map(projected)) else { continue };
        if halvings >= MAX_HALVINGS || piece.iter().all(|p| from_segment(projected(p), first, last) <= tolerance) {
            ends.push(last);
            continue;
        }
        let (left, right) = halved(&piece);
        rest.push((right, halvings + 1));
        rest.push((left, halvings + 1));
    }
    Some(ends)
}

/// A curve that would take too many chords.
pub(crate) fn too_long(span: Span) -> Fault {
    let message = format!("a piece of the curve needs more than {MAX_CHORDS} chords within {CHORD_TOLERANCE_MM} mm");
    Fault::new(codes::LOOP_LIMIT, span, message).help("check its points and weights, or write more points")
}

/// de Casteljau at the middle.
fn halved(piece: &[Homogeneous]) -> (Vec<Homogeneous>, Vec<Homogeneous>) {
    let mut row = piece.to_vec();
    let (mut left, mut right) = (Vec::with_capacity(row.len()), Vec::with_capacity(row.len()));
    while let (Some(first), Some(last)) = (row.first(), row.last()) {
        left.push(*first);
        right.push(*last);
        row = row.windows(2).map(|pair| mix(&pair[0], &pair[1], 0.5)).collect();
    }
    right.reverse();
    (left, right)
}

fn from_segment(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let (way, off): ([f64; 3], [f64; 3]) = (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| p[i] - a[i]));
    let dot = |u: &[f64; 3], v: &[f64; 3]| u.iter().zip(v).map(|(u, v)| u * v).sum::<f64>();
    let square = dot(&way, &way);
    let t = if square > 0.0 { (dot(&off, &way) / square).clamp(0.0, 1.0) } else { 0.0 };
    let rest: [f64; 3] = std::array::from_fn(|i| off[i] - t * way[i]);
    dot(&rest, &rest).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curve by its definition (de Boor and Cox).
    fn point(degree: usize, knots: &[f64], points: &[Homogeneous], u: f64) -> [f64; 3] {
        let span = (degree..points.len()).rfind(|&k| knots[k] <= u).unwrap_or(degree);
        let mut d: Vec<Homogeneous> = (0..=degree).map(|j| points[span - degree + j]).collect();
        for r in 1..=degree {
            for j in (r..=degree).rev() {
                let i = span - degree + j;
                let t = (u - knots[i]) / (knots[i + degree + 1 - r] - knots[i]);
                d[j] = mix(&d[j - 1], &d[j], t);
            }
        }
        projected(&d[degree])
    }

    fn bezier(piece: &[Homogeneous], t: f64) -> [f64; 3] {
        let mut row = piece.to_vec();
        while row.len() > 1 {
            row = row.windows(2).map(|pair| mix(&pair[0], &pair[1], t)).collect();
        }
        projected(&row[0])
    }

    fn example(weights: &[f64]) -> Vec<Homogeneous> {
        let at =
            [[0.0, 0.0, 1.0], [1.0, 3.0, 1.0], [4.0, 2.0, 0.0], [5.0, -1.0, 2.0], [8.0, 0.0, 1.0], [9.0, 4.0, 3.0]];
        at.iter().zip(weights).map(|(p, w)| [p[0] * w, p[1] * w, p[2] * w, *w]).collect()
    }

    #[test]
    fn pieces_are_the_curve() {
        for degree in 1..=4 {
            let points = example(&[1.0, 2.0, 0.5, 1.0, 3.0, 1.0]);
            let count = points.len();
            let knots: Vec<f64> =
                (0..=count + degree).map(|i| i.saturating_sub(degree).min(count - degree) as f64).collect();
            let pieces = bezier_pieces(degree, &knots, &points);
            assert_eq!(pieces.len(), count - degree);
            for (k, piece) in pieces.iter().enumerate() {
                for step in 0..8 {
                    let t = f64::from(step) / 8.0;
                    let (a, b) = (bezier(piece, t), point(degree, &knots, &points, k as f64 + t));
                    assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-12), "{degree} {k} {t}: {a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn chords_stay_within_the_tolerance() {
        let points = example(&[1.0, 2.0, 0.5, 1.0, 1.0, 1.0]);
        let piece = &points[..4];
        let mut ends = vec![projected(&piece[0])];
        ends.extend(chords(piece, 0.001).expect("few chords"));
        assert_eq!(ends.last().copied(), Some(projected(&piece[3])));
        for step in 0..=1000 {
            let p = bezier(piece, f64::from(step) / 1000.0);
            let near = ends.windows(2).map(|pair| from_segment(p, pair[0], pair[1])).fold(f64::INFINITY, f64::min);
            assert!(near <= 0.001, "{step}: {near}");
        }
    }

    #[test]
    fn low_degrees_are_cubics_exactly() {
        let points = example(&[2.0; 6]);
        for degree in 1..=3 {
            let cubic = cubic(&points[..=degree]).unwrap().map(|[x, y, z]| [x, y, z, 1.0]);
            for step in 0..=8 {
                let t = f64::from(step) / 8.0;
                let (a, b) = (bezier(&cubic, t), bezier(&points[..=degree], t));
                assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-14), "{a:?} {b:?}");
            }
        }
        assert!(cubic(&example(&[1.0, 2.0, 1.0, 1.0, 1.0, 1.0])[..3]).is_none());
        assert!(cubic(&points[..5]).is_none());
    }
}
