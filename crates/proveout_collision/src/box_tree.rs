//! Trees of boxes, and the nearest leaves of two of them.
//!
//! [`nearest_leaves`] goes down two trees at once, the nearer pair of boxes first, and leaves out what cannot
//! be nearer than the best so far. What is left out is not forgotten: the smallest bound of all that was left
//! out is a proved lower bound of the distance, which a caller that only asks "farther than this?" gets for
//! nothing.
//!
//! ```text
//!    boxes of a, turned into the frame of b      gap along axis i = |c_i| - h_b,i - (|R| h_a)_i
//!         ___                                    bound            = | (max(gap_i, 0)) |,
//!        /\  \        .----.                     the larger of the ones in the frames of a and of b
//!       /  \_/|  -c-> |    |
//!       \__/_\/       '----'
//! ```
//!
//! A caller that knows leaves which were nearest a moment ago (*warm start*; Lin and Canny 1991) hands their
//! distance in as the best so far, and most of both trees is never looked at.
//!
//! *Roughly.* The exact distance of something far away is not needed, and it is the most costly: a
//! ring of a table is as far from a bearing at a thousand places, and all of them must be opened to
//! find the nearest. A caller names the distance up to which it needs to be exact; beyond it a pair
//! of boxes is left out as soon as it is no nearer than [`ROUGH`] of the best so far. The answer is
//! then a proved distance and a measured one, with the true one between them.

use nalgebra::Matrix3;
use proveout_geom::{Point, Pose, Vector};

/// A tree of boxes along the axes of a frame of its own, with numbered items in its leaves.
pub trait BoxTree {
    /// A node of the tree.
    type Node: Copy;

    /// The node that holds everything; none for an empty tree.
    fn root(&self) -> Option<Self::Node>;

    /// Middle of the box of a node and half its edges, mm.
    fn bounds(&self, node: Self::Node) -> (Point, Vector);

    /// What a node holds.
    fn open(&self, node: Self::Node) -> Branch<Self::Node>;
}

/// What a node of a tree holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Branch<N> {
    /// Two nodes.
    Two(N, N),
    /// Items, by number.
    Leaf(std::ops::Range<u32>),
}

/// Answer to "which leaves are nearest, as far as nearer than a limit".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NearestLeaves<W> {
    /// Nothing is nearer than the limit; the distance that is proved, mm, at least the limit. Infinite for an
    /// empty tree.
    Beyond(f64),
    /// The smallest distance, mm, and what belongs to it.
    At(f64, W),
    /// A proved distance and a measured one, mm, with the smallest between them, and what belongs to the
    /// second.
    Between([f64; 2], W),
}

/// Part of the best distance so far at which boxes are left out where no exact distance is asked for. Each
/// query proves at least this part of the distance, so that a third more of them are needed than with exact
/// ones; each opens a small part of the boxes.
pub(crate) const ROUGH: f64 = 0.75;

/// What a search may cost and has cost, in pairs of boxes (some 30 ns each). A count and no time, so that the
/// same is found everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Not more than this.
    pub(crate) most: u64,
    pub(crate) spent: u64,
}

impl Effort {
    /// Pairs of boxes that take as long as the distance of two items.
    const ITEM: u64 = 8;
    /// The same of a convex body and a triangle: GJK and planes across.
    const CONVEX_ITEM: u64 = 32;

    pub(crate) const fn at_most(most: u64) -> Self {
        Self { most, spent: 0 }
    }

    /// As much as it takes.
    pub(crate) const fn unlimited() -> Self {
        Self::at_most(u64::MAX)
    }
}

/// The nearest items of two trees where they are below `limit` (mm), or below what `start` says of two items.
///
/// `distance` gives the distance of item i of `a` from item j of `b`, or a lower bound of it above its third
/// argument, with what belongs to it. The search ends at once when it says zero.
pub fn nearest_leaves<A: BoxTree, B: BoxTree, W>(
    a: &A,
    b: &B,
    b_from_a: &Pose,
    limit: f64,
    start: Option<(f64, W)>,
    distance: impl FnMut(u32, u32, f64) -> (f64, W),
) -> NearestLeaves<W> {
    near_leaves((a, b), b_from_a, [f64::INFINITY, limit], start, distance)
}

/// The same, where a distance needs to be exact only up to the first of two limits; the second is that of
/// [`nearest_leaves`].
pub(crate) fn near_leaves<A: BoxTree, B: BoxTree, W>(
    pair: (&A, &B),
    b_from_a: &Pose,
    limits: [f64; 2],
    start: Option<(f64, W)>,
    distance: impl FnMut(u32, u32, f64) -> (f64, W),
) -> NearestLeaves<W> {
    near_leaves_grown(pair, b_from_a, ([Vector::zeros(); 2], &mut Effort::unlimited()), limits, start, distance)
}

/// The same where `distance` adds something to every item of `a`; `grown` is half its box, along
/// the axes of a and of b, mm. When the effort is used up it ends with what is proved by then: it
/// may return [`NearestLeaves::Beyond`] with a smaller distance than the limit, and
/// [`NearestLeaves::Between`] where an exact one was wanted.
pub(crate) fn near_leaves_grown<A: BoxTree, B: BoxTree, W>(
    (a, b): (&A, &B),
    b_from_a: &Pose,
    (grown, effort): ([Vector; 2], &mut Effort),
    [exact, limit]: [f64; 2],
    start: Option<(f64, W)>,
    mut distance: impl FnMut(u32, u32, f64) -> (f64, W),
) -> NearestLeaves<W> {
    let (Some(root_a), Some(root_b)) = (a.root(), b.root()) else { return NearestLeaves::Beyond(f64::INFINITY) };
    let frames = BoxFrames { b_from_a: *b_from_a, size: b_from_a.rotation.abs(), grown };
    // What is left out is at least as far as the best was then, and the best only falls.
    let mut left_out = f64::INFINITY;
    let mut bound = limit;
    let mut best = None;
    if let Some((d, w)) = start {
        if d < bound {
            (bound, best) = (d, Some(w));
        } else {
            left_out = d;
        }
    }
    // What is no nearer than this is left out.
    let enough = |best: f64| if best <= exact { best } else { exact.max(ROUGH * best).min(best) };
    let mut open_below = if best.is_some() { enough(bound) } else { bound };
    let apart = |x: A::Node, y: B::Node| frames.apart(&frames.moved(a.bounds(x)), &b.bounds(y));
    let mut open = vec![(apart(root_a, root_b), root_a, root_b)];
    while let Some((least, x, y)) = open.pop() {
        if effort.spent >= effort.most {
            left_out = open.iter().map(|o| o.0).fold(left_out.min(least), f64::min);
            break;
        }
        effort.spent += 1;
        if bound <= 0.0 {
            // Nothing that is left is looked at any more.
            left_out = left_out.min(0.0);
            break;
        }
        if least >= open_below {
            left_out = left_out.min(least);
            continue;
        }
        let pairs = match (a.open(x), b.open(y)) {
            (Branch::Leaf(items_a), Branch::Leaf(items_b)) => {
                for i in items_a {
                    for j in items_b.clone() {
                        effort.spent += Effort::ITEM;
                        let (d, w) = distance(i, j, open_below);
                        if d < open_below {
                            (bound, best) = (d, Some(w));
                            open_below = enough(bound);
                        } else {
                            left_out = left_out.min(d);
                        }
                    }
                }
                continue;
            }
            (Branch::Two(..), Branch::Two(m, n)) if a.bounds(x).1.norm_squared() < b.bounds(y).1.norm_squared() => {
                let box_a = frames.moved(a.bounds(x));
                [m, n].map(|n| (frames.apart(&box_a, &b.bounds(n)), x, n))
            }
            (Branch::Two(m, n), _) => {
                let box_b = b.bounds(y);
                [m, n].map(|n| (frames.apart(&frames.moved(a.bounds(n)), &box_b), n, y))
            }
            (_, Branch::Two(m, n)) => {
                let box_a = frames.moved(a.bounds(x));
                [m, n].map(|n| (frames.apart(&box_a, &b.bounds(n)), x, n))
            }
        };
        let [first, second] = pairs;
        let (near, far) = if first.0 <= second.0 { (first, second) } else { (second, first) };
        for pair in [far, near] {
            if pair.0 < open_below {
                open.push(pair);
            } else {
                left_out = left_out.min(pair.0);
            }
        }
    }
    match best {
        None => NearestLeaves::Beyond(left_out),
        Some(w) if left_out < bound => NearestLeaves::Between([left_out, bound], w),
        Some(w) => NearestLeaves::At(bound, w),
    }
}

/// The nearest item of one tree; as [`nearest_leaves`], with `apart` for the lower bound of what a node
/// holds; it need not be better than its second argument. After the most effort it ends with what is proved
/// by then, as [`near_leaves_grown`] does.
pub(crate) fn nearest_leaf<B: BoxTree, W>(
    tree: &B,
    apart: impl Fn(B::Node, f64) -> f64,
    (limit, effort): (f64, &mut Effort),
    start: Option<(f64, W)>,
    mut distance: impl FnMut(u32, f64) -> (f64, W),
) -> NearestLeaves<W> {
    let Some(root) = tree.root() else { return NearestLeaves::Beyond(f64::INFINITY) };
    let of = |node: B::Node, bound: f64| (apart(node, bound), node);
    let (mut left_out, mut bound, mut best) = (f64::INFINITY, limit, None);
    if let Some((d, w)) = start {
        if d < bound {
            (bound, best) = (d, Some(w));
        } else {
            left_out = d;
        }
    }
    let mut open = vec![of(root, bound)];
    while let Some((least, node)) = open.pop() {
        if effort.spent >= effort.most {
            left_out = open.iter().map(|o| o.0).fold(left_out.min(least), f64::min);
            break;
        }
        effort.spent += 1;
        if bound <= 0.0 {
            // Nothing that is left is looked at any more.
            left_out = left_out.min(0.0);
            break;
        }
        if least >= bound {
            left_out = left_out.min(least);
            continue;
        }
        match tree.open(node) {
            Branch::Leaf(items) => {
                for i in items {
                    effort.spent += Effort::CONVEX_ITEM;
                    let (d, w) = distance(i, bound);
                    if d < bound {
                        (bound, best) = (d, Some(w));
                    } else {
                        left_out = left_out.min(d);
                    }
                }
            }
            Branch::Two(x, y) => {
                let (x, y) = (of(x, bound), of(y, bound));
                let (near, far) = if x.0 <= y.0 { (x, y) } else { (y, x) };
                for next in [far, near] {
                    if next.0 < bound {
                        open.push(next);
                    } else {
                        left_out = left_out.min(next.0);
                    }
                }
            }
        }
    }
    match best {
        None => NearestLeaves::Beyond(left_out),
        Some(w) if left_out < bound => NearestLeaves::Between([left_out, bound], w),
        Some(w) => NearestLeaves::At(bound, w),
    }
}

/// A box of tree a: its middle in the frame of b, and half its edges along the axes of a and of b.
#[derive(Clone, Copy)]
struct TurnedBox {
    middle: Point,
    half: Vector,
    half_in_b: Vector,
}

struct BoxFrames {
    b_from_a: Pose,
    size: Matrix3<f64>,
    /// Half the box of what is added to a, along the axes of a and of b.
    grown: [Vector; 2],
}

impl BoxFrames {
    fn moved(&self, (middle, half): (Point, Vector)) -> TurnedBox {
        let [in_a, in_b] = self.grown;
        TurnedBox { middle: self.b_from_a.point(&middle), half: half + in_a, half_in_b: self.size * half + in_b }
    }

    /// Lower bound of the distance of two boxes.
    fn apart(&self, a: &TurnedBox, b: &(Point, Vector)) -> f64 {
        let way = a.middle - b.0;
        let outside = |x: f64| x.max(0.0);
        let in_b = (way.abs() - a.half_in_b - b.1).map(outside).norm_squared();
        let way_in_a = self.b_from_a.rotation.tr_mul(&way);
        let in_a = (way_in_a.abs() - a.half - self.size.tr_mul(&b.1)).map(outside).norm_squared();
        in_a.max(in_b).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::revolved_mesh;

    use super::*;
    use crate::triangle;
    use crate::triangle_tree::TriangleTree;

    fn torus(large: f64, small: f64, around: usize, along: usize) -> Vec<[Point; 3]> {
        let at = |i: usize, k: usize| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / along as f64).sin_cos();
            let (t, d) = (std::f64::consts::TAU * k as f64 / around as f64).sin_cos();
            Point::new((large + small * d) * c, (large + small * d) * s, small * t)
        };
        let quad = |(i, k): (usize, usize)| {
            let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..along).flat_map(|i| (0..around).map(move |k| (i, k))).flat_map(quad).collect()
    }

    fn poses() -> Vec<Pose> {
        (0..40)
            .map(|k| {
                let a = f64::from(k);
                let way = Vector::new(20.0 * (0.7 * a).sin(), 9.0 * (1.1 * a).cos(), 2.0 + 0.6 * a);
                Pose::from_rpy(way, 0.3 * a, 0.17 * a, 0.5 * a)
            })
            .collect()
    }

    #[test]
    fn the_nearest_leaves_are_those_of_all_pairs() {
        let a = TriangleTree::of_triangles(torus(10.0, 3.0, 9, 14));
        let b = TriangleTree::new(&revolved_mesh(&[[0.0, 0.0], [4.0, 0.0], [2.0, 7.0], [0.0, 7.0]], 13));
        let mut warm: Option<(u32, u32)> = None;
        let (mut far, mut meeting) = (0, 0);
        for pose in poses() {
            let moved = |i: u32| a.corners(i).map(|p| pose.point(&p));
            let of = |i: u32, j: u32| triangle::nearest(&moved(i), b.corners(j)).square.sqrt();
            let all = |f: &mut dyn FnMut(f64)| {
                for i in 0..a.triangles().len() as u32 {
                    (0..b.triangles().len() as u32).for_each(|j| f(of(i, j)));
                }
            };
            let mut least = f64::INFINITY;
            all(&mut |d| least = least.min(d));
            let mut looked = 0;
            for start in [None, warm.map(|(i, j)| (of(i, j), (i, j)))] {
                looked = 0;
                let found = nearest_leaves(&a, &b, &pose, 1e9, start, |i, j, _| {
                    looked += 1;
                    (of(i, j), (i, j))
                });
                let NearestLeaves::At(d, (i, j)) = found else { panic!("{found:?}") };
                assert!((d - least).abs() < 1e-12 && (of(i, j) - d).abs() < 1e-12, "{d} {least}");
                warm = Some((i, j));
            }
            assert!(looked < 2000, "{looked} of {}", a.triangles().len() * b.triangles().len());
            meeting += usize::from(least == 0.0);
            // A question with a limit is answered with a bound that holds and is no less than the limit.
            if least > 0.0 {
                far += 1;
                let limit = 0.9 * least;
                let found = nearest_leaves(&a, &b, &pose, limit, None, |i, j, _| (of(i, j), ()));
                let NearestLeaves::Beyond(bound) = found else { panic!("{found:?}") };
                assert!(limit <= bound && bound <= least + 1e-12, "{limit} {bound} {least}");
                // A limit that nothing can be nearer than proves no distance.
                let none = nearest_leaves(&a, &b, &pose, 0.0, None, |i, j, _| (of(i, j), ()));
                assert_eq!(none, NearestLeaves::Beyond(0.0));
                // Roughly: what is proved is no less than what must be exact, and the part that is promised.
                let ask = |exact: f64, asked: &mut usize| {
                    near_leaves((&a, &b), &pose, [exact, f64::INFINITY], None, |i, j, _| {
                        *asked += 1;
                        (of(i, j), (i, j))
                    })
                };
                let mut asked = [0; 3];
                let found = [2.0, 0.9, 0.1].into_iter().zip(&mut asked).map(|(part, n)| ask(part * least, n));
                let found: Vec<_> = found.collect();
                assert!(matches!(found[0], NearestLeaves::At(d, _) if (d - least).abs() < 1e-12), "{:?}", found[0]);
                for (found, exact) in found[1..].iter().zip([0.9 * least, 0.1 * least]) {
                    let ([low, high], (i, j)) = match *found {
                        NearestLeaves::At(d, w) => ([d; 2], w),
                        NearestLeaves::Between(d, w) => (d, w),
                        NearestLeaves::Beyond(_) => panic!("{found:?}"),
                    };
                    assert!(low <= least + 1e-12 && least <= high + 1e-12, "{low} {least} {high}");
                    assert!(low >= exact && low >= ROUGH * least - 1e-12 && of(i, j) == high, "{low} {least} {exact}");
                }
                assert!(asked[2] <= asked[0], "{asked:?}");
            }
        }
        assert!(far > 10 && meeting > 3, "{far} {meeting}");
    }

    #[test]
    fn an_empty_tree_is_far_from_everything() {
        let (a, b) = (TriangleTree::of_triangles(Vec::new()), TriangleTree::of_triangles(torus(5.0, 1.0, 4, 4)));
        let found = nearest_leaves(&a, &b, &Pose::identity(), 1.0, None, |_, _, _| (0.0, ()));
        assert_eq!(found, NearestLeaves::Beyond(f64::INFINITY));
    }
}
