//! Balls in a tree: which centers are nearest to a point, and which balls come near it.

use proveout_geom::Point;

/// Items of a leaf.
const LEAF: usize = 4;
/// Relative margin of the bounds against rounding.
const MARGIN: f64 = 1e-12;

/// Balls by number.
#[derive(Clone, Debug, Default)]
pub(super) struct BallTree {
    nodes: Vec<BallNode>,
    /// Center, radius and number of each, in the order of the leaves.
    balls: Vec<(Point, f64, u32)>,
}

/// Some balls that lie together.
#[derive(Clone, Copy, Debug)]
struct BallNode {
    middle: Point,
    /// No center is farther from the middle, and no point of a ball.
    spread: f64,
    reach: f64,
    /// First ball and how many; or none, and the first of two nodes.
    first: u32,
    count: u32,
}

/// Lowest and highest coordinates of centers.
fn extent(balls: &[(Point, f64, u32)]) -> (Point, Point) {
    balls.iter().fold((balls[0].0, balls[0].0), |(low, high), b| (low.inf(&b.0), high.sup(&b.0)))
}

impl BallNode {
    fn of(balls: &[(Point, f64, u32)], first: usize) -> Self {
        let (low, high) = extent(balls);
        let middle = nalgebra::center(&low, &high);
        let (mut spread, mut reach) = (0.0_f64, 0.0_f64);
        for (center, radius, _) in balls {
            let far = (center - middle).norm() * (1.0 + MARGIN);
            (spread, reach) = (spread.max(far), reach.max(far + radius));
        }
        Self { middle, spread, reach, first: first as u32, count: balls.len() as u32 }
    }
}

impl BallTree {
    /// Balls of centers and radii, mm, numbered as they come.
    pub(super) fn new(balls: impl Iterator<Item = (Point, f64)>) -> Self {
        let mut balls: Vec<(Point, f64, u32)> = balls.zip(0..).map(|((p, r), k)| (p, r, k)).collect();
        let mut nodes = Vec::new();
        let mut open = Vec::new();
        if !balls.is_empty() {
            nodes.push(BallNode::of(&balls, 0));
            open.push((0, 0..balls.len()));
        }
        while let Some((at, range)) = open.pop() {
            if range.len() <= LEAF {
                continue;
            }
            let part = &mut balls[range.clone()];
            let (low, high) = extent(part);
            let axis = (high - low).imax();
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.2.cmp(&b.2)));
            let first = nodes.len();
            for half in [range.start..range.start + half, range.start + half..range.end] {
                nodes.push(BallNode::of(&balls[half.clone()], half.start));
                open.push((nodes.len() - 1, half));
            }
            (nodes[at].first, nodes[at].count) = (first as u32, 0);
        }
        Self { nodes, balls }
    }

    fn held(&self, node: &BallNode) -> &[(Point, f64, u32)] {
        &self.balls[node.first as usize..(node.first + node.count) as usize]
    }

    /// The balls whose centers are nearest to a point, by number, the nearest first; fewer where there are
    /// not so many.
    pub(super) fn nearest<const N: usize>(&self, p: &Point) -> impl Iterator<Item = u32> + use<N> {
        let mut best = [(f64::INFINITY, u32::MAX); N];
        let apart = |node: &BallNode| (node.middle - p).norm() - node.spread;
        let mut open: Vec<(f64, u32)> = Vec::with_capacity(32);
        open.extend(self.nodes.first().map(|root| (apart(root), 0)));
        while let Some((least, at)) = open.pop() {
            if least > 0.0 && least * least > best[N - 1].0 * (1.0 + MARGIN) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                let [x, y] = [node.first, node.first + 1].map(|k| (apart(&self.nodes[k as usize]), k));
                // The nearer one is looked at first.
                open.extend(if x.0 < y.0 { [y, x] } else { [x, y] });
                continue;
            }
            for (center, _, number) in self.held(node) {
                let far = (center - p).norm_squared();
                if far < best[N - 1].0 {
                    best[N - 1] = (far, *number);
                    best.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                }
            }
        }
        best.into_iter().filter(|b| b.0.is_finite()).map(|b| b.1)
    }

    /// The balls that come nearer to a point than this, mm, by number.
    pub(super) fn within(&self, p: &Point, reach: f64, mut see: impl FnMut(u32)) {
        let mut open: Vec<u32> = Vec::with_capacity(32);
        open.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(at) = open.pop() {
            let node = &self.nodes[at as usize];
            if (node.middle - p).norm() * (1.0 - MARGIN) >= reach + node.reach {
                continue;
            }
            if node.count == 0 {
                open.extend([node.first + 1, node.first]);
                continue;
            }
            for (center, radius, number) in self.held(node) {
                let near = reach + radius;
                if near > 0.0 && (center - p).norm_squared() < near * near {
                    see(*number);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random balls, some of one center: the nearest and those near are those of all.
    #[test]
    fn what_is_near_is_what_all_balls_say() {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut random = |low: f64, high: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for count in [0, 1, 2, 4, 5, 9, 300] {
            let mut balls: Vec<(Point, f64)> = (0..count)
                .map(|_| (Point::new(random(-9.0, 9.0), random(-90.0, 9.0), random(-1.0, 1.0)), random(0.0, 3.0)))
                .collect();
            if count > 8 {
                balls[7].0 = balls[3].0;
            }
            let tree = BallTree::new(balls.iter().copied());
            for _ in 0..200 {
                let p = Point::new(random(-20.0, 20.0), random(-99.0, 20.0), random(-9.0, 9.0));
                let far = |k: u32| (balls[k as usize].0 - p).norm_squared();
                let mut all: Vec<u32> = (0..count as u32).collect();
                all.sort_by(|a, b| far(*a).total_cmp(&far(*b)).then(a.cmp(b)));
                all.truncate(3);
                assert_eq!(tree.nearest::<3>(&p).collect::<Vec<_>>(), all);
                for reach in [-1.0, 0.0, 0.5, 12.0, 200.0] {
                    let near =
                        |k: &u32| reach + balls[*k as usize].1 > 0.0 && far(*k).sqrt() < reach + balls[*k as usize].1;
                    let wanted: Vec<u32> = (0..count as u32).filter(near).collect();
                    let mut found = Vec::new();
                    tree.within(&p, reach, |k| found.push(k));
                    found.sort_unstable();
                    assert_eq!(found, wanted);
                }
            }
        }
    }
}
