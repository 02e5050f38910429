//! Boxes over pieces of a body, and over its corners.
//!
//! A box lies along the axes or along the pieces (principal axes of their corners), whichever has less
//! skin: groups of triangles of a wall are flat, so one plane along the wall separates whole groups of them
//! from what runs along it.

use proveout_geom::{Aabb, Point, Pose, Vector};

/// A box by its middle and half of its edges.
pub(super) struct OrientedBox {
    pub(super) center: Vector,
    edges: [Vector; 3],
}

impl OrientedBox {
    pub(super) fn new(center: Vector, edges: [Vector; 3]) -> Self {
        Self { center, edges }
    }

    fn of_points(points: &[Point]) -> Self {
        let upright = Self::along(&[Vector::x(), Vector::y(), Vector::z()], points);
        let middle = points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords) / points.len().max(1) as f64;
        let spread = points.iter().fold(Pose::identity().rotation * 0.0, |sum, p| {
            let way = p.coords - middle;
            sum + way * way.transpose()
        });
        if !spread.iter().all(|x| x.is_finite()) {
            return upright;
        }
        let axes = spread.symmetric_eigen().eigenvectors;
        let leaning = Self::along(&[0, 1, 2].map(|k| axes.column(k).into_owned()), points);
        if leaning.skin() < upright.skin() { leaning } else { upright }
    }

    fn along(axes: &[Vector; 3], points: &[Point]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points {
            for (k, axis) in axes.iter().enumerate() {
                let at = axis.dot(&p.coords);
                (low[k], high[k]) = (low[k].min(at), high[k].max(at));
            }
        }
        let edges = [0, 1, 2].map(|k| axes[k] * (0.5 * (high[k] - low[k])));
        let center = (0..3).fold(Vector::zeros(), |sum, k| sum + axes[k] * (0.5 * (low[k] + high[k])));
        Self { center, edges }
    }

    fn skin(&self) -> f64 {
        let [a, b, c] = self.edges.each_ref().map(Vector::norm);
        a * b + b * c + c * a
    }

    /// No point of it lies farther along a direction, times the length of that.
    #[inline]
    pub(super) fn height(&self, along: &Vector) -> f64 {
        let [a, b, c] = &self.edges;
        self.center.dot(along) + a.dot(along).abs() + b.dot(along).abs() + c.dot(along).abs()
    }

    /// Half of its diagonal.
    pub(super) fn reach(&self) -> f64 {
        self.edges.iter().map(Vector::norm_squared).sum::<f64>().sqrt()
    }
}

/// A node of a tree of two branches each.
pub(super) struct BoundNode<B> {
    pub(super) bound: B,
    /// Half of its diagonal.
    pub(super) size: f64,
    /// A piece, or two nodes.
    pub(super) holds: Result<usize, [usize; 2]>,
}

/// Parted at the middle of the pieces along their longest side until each node holds one piece; the root
/// comes first.
pub(super) fn grow<B>(
    count: usize,
    bound: impl Fn(&[usize]) -> B,
    size: impl Fn(&B) -> f64,
    center: impl Fn(usize) -> Vector,
) -> Vec<BoundNode<B>> {
    let mut tree: Vec<BoundNode<B>> = Vec::new();
    let mut items: Vec<usize> = (0..count).collect();
    // Each range of items, and which of whose branches it is.
    let mut open = Vec::from_iter((count > 0).then_some((0, count, None)));
    while let Some((from, to, above)) = open.pop() {
        let part = &mut items[from..to];
        let bound = bound(part);
        let at = tree.len();
        tree.push(BoundNode { size: size(&bound), bound, holds: Ok(part[0]) });
        if let Some((parent, branch)) = above {
            let parent: &mut BoundNode<B> = &mut tree[parent];
            let mut two = parent.holds.err().unwrap_or_default();
            two[branch] = at;
            parent.holds = Err(two);
        }
        if part.len() > 1 {
            let centers = Aabb::of_points(&part.iter().map(|&i| Point::from(center(i))).collect::<Vec<_>>());
            let axis = centers.size().imax();
            let middle = part.len() / 2;
            part.select_nth_unstable_by(middle, |&x, &y| {
                center(x)[axis].total_cmp(&center(y)[axis]).then_with(|| x.cmp(&y))
            });
            open.extend([(from, from + middle, Some((at, 0))), (from + middle, to, Some((at, 1)))]);
        }
    }
    tree
}

/// Boxes over the pieces of a body.
pub(super) fn of_pieces(pieces: &[Vec<Point>]) -> Vec<BoundNode<OrientedBox>> {
    let bound = |items: &[usize]| {
        let points: Vec<Point> = items.iter().flat_map(|&i| &pieces[i]).copied().collect();
        OrientedBox::of_points(&points)
    };
    grow(pieces.len(), bound, OrientedBox::reach, |i| Aabb::of_points(&pieces[i]).center().coords)
}

/// Corners of a body, each once, in boxes.
pub(super) struct Corners {
    points: Vec<Point>,
    tree: Vec<CornerNode>,
}

struct CornerNode {
    center: Point,
    reach: f64,
    /// Its corners.
    range: [usize; 2],
    /// Its two branches, where it has more than [`LEAF`] corners.
    parts: Option<[usize; 2]>,
}

/// Corners that are looked at one by one.
const LEAF: usize = 8;

impl Corners {
    pub(super) fn new(mut points: Vec<Point>) -> Self {
        let order = |a: &Point, b: &Point| {
            a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
        };
        points.sort_unstable_by(order);
        points.dedup();
        let mut tree: Vec<CornerNode> = Vec::new();
        let mut open = Vec::from_iter((!points.is_empty()).then_some((0, points.len(), None)));
        while let Some((from, to, above)) = open.pop() {
            let part = &mut points[from..to];
            let bounds = Aabb::of_points(&*part);
            let at = tree.len();
            let (center, reach) = (bounds.center(), 0.5 * bounds.size().norm());
            tree.push(CornerNode { center, reach, range: [from, to], parts: None });
            if let Some((parent, branch)) = above {
                let parent: &mut CornerNode = &mut tree[parent];
                parent.parts.get_or_insert_default()[branch] = at;
            }
            if part.len() > LEAF {
                let (axis, middle) = (bounds.size().imax(), part.len() / 2);
                part.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]).then_with(|| order(a, b)));
                open.extend([(from, from + middle, Some((at, 0))), (from + middle, to, Some((at, 1)))]);
            }
        }
        Self { points, tree }
    }

    /// The largest of `of` at a corner; between two points it changes by no more than their distance. `near`
    /// is the corner that had it last.
    pub(super) fn largest(&self, of: impl Fn(&Point) -> f64, near: &mut usize) -> f64 {
        let mut most = self.points.get(*near).map_or(0.0, |p| of(p).max(0.0));
        let mut open = Vec::from_iter(self.tree.first().map(|n| (0, of(&n.center) + n.reach)));
        while let Some((at, bound)) = open.pop() {
            if bound <= most {
                continue;
            }
            let node = &self.tree[at];
            if let Some(two) = node.parts {
                let [one, other] = two.map(|k| (k, of(&self.tree[k].center) + self.tree[k].reach));
                open.extend(if one.1 < other.1 { [one, other] } else { [other, one] });
                continue;
            }
            for k in node.range[0]..node.range[1] {
                let here = of(&self.points[k]);
                if here > most {
                    (most, *near) = (here, k);
                }
            }
        }
        most
    }
}
