//! Boxes over the triangles of a mesh.

use proveout_geom::{Aabb, Point};

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Boxes of a binary tree over triangles, in the frame of the mesh.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree {
    nodes: Vec<BoxNode>,
    /// Corners, leaf by leaf.
    triangles: Vec<[Point; 3]>,
}

#[derive(Clone, Copy, Debug)]
struct BoxNode {
    bounds: Aabb,
    /// First triangle of a leaf; else the first of two children that stand side by side.
    first: u32,
    /// Triangles of a leaf; zero otherwise.
    count: u32,
}

impl BoxTree {
    /// Over triangles in any order; none give a tree without nodes.
    pub(crate) fn new(mut triangles: Vec<[Point; 3]>) -> Self {
        let empty = BoxNode { bounds: Aabb::empty(), first: 0, count: 0 };
        let mut nodes = Vec::new();
        if !triangles.is_empty() {
            nodes.push(empty);
            let mut open = vec![(0, 0, triangles.len())];
            while let Some((node, from, to)) = open.pop() {
                let own = &mut triangles[from..to];
                nodes[node].bounds = Aabb::of_points(own.iter().flatten());
                if own.len() <= LEAF {
                    (nodes[node].first, nodes[node].count) = (from as u32, own.len() as u32);
                    continue;
                }
                // Halves by the middles along the longest side of their box: two leaves differ by one triangle at most.
                let middle = |t: &[Point; 3]| (t[0].coords + t[1].coords + t[2].coords) / 3.0;
                let size = Aabb::of_points(&own.iter().map(|t| Point::from(middle(t))).collect::<Vec<_>>()).size();
                let axis = size.imax();
                let half = own.len() / 2;
                own.select_nth_unstable_by(half, |x, y| middle(x)[axis].total_cmp(&middle(y)[axis]));
                let child = nodes.len();
                nodes[node].first = child as u32;
                nodes.extend([empty; 2]);
                open.extend([(child, from, from + half), (child + 1, from + half, to)]);
            }
        }
        Self { nodes, triangles }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    pub(crate) fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// The two nodes below; none below a leaf.
    pub(crate) fn children(&self, node: u32) -> Option<[u32; 2]> {
        let n = &self.nodes[node as usize];
        (n.count == 0).then_some([n.first, n.first + 1])
    }

    /// Triangles of a leaf.
    pub(crate) fn triangles(&self, node: u32) -> &[[Point; 3]] {
        let n = &self.nodes[node as usize];
        &self.triangles[n.first as usize..(n.first + n.count) as usize]
    }
}

#[cfg(test)]
mod tests {
    use proveout_geom::cylinder_mesh;

    use super::*;

    #[test]
    fn every_triangle_stands_in_one_leaf_and_in_the_boxes_above() {
        let mesh = cylinder_mesh(3.0, 0.0, 5.0, 97);
        let corners = |t: &[u32; 3]| t.map(|k| mesh.positions[k as usize]);
        let tree = BoxTree::new(mesh.triangles.iter().map(corners).collect());
        let (mut open, mut seen) = (vec![0], 0);
        while let Some(node) = open.pop() {
            let bounds = tree.bounds(node);
            let inner: Vec<Point> = match tree.children(node) {
                Some(both) => {
                    open.extend(both);
                    both.iter().flat_map(|c| [tree.bounds(*c).min, tree.bounds(*c).max]).collect()
                }
                None => {
                    seen += tree.triangles(node).len();
                    tree.triangles(node).iter().flatten().copied().collect()
                }
            };
            assert!(inner.iter().all(|p| bounds.contains(p)));
        }
        assert_eq!(seen, mesh.triangles.len());
        assert!(BoxTree::new(Vec::new()).is_empty());
    }
}
