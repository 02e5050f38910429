//! Which crossed edges of a cell belong to the same sheet of surface, for all 256 configurations.

use std::sync::LazyLock;

/// Edges of a cell.
pub(crate) const EDGES: usize = 12;
/// No crossing on the edge.
const NONE: u8 = 255;

/// Corner c of a cell has the offsets (c & 1, c >> 1 & 1, c >> 2 & 1); edge e = 4 axis + du + 2 dv runs along
/// `axis` from the corner with offsets du and dv along axis + 1 and axis + 2 (modulo 3).
pub(crate) struct Sheets {
    sheet: Vec<[u8; EDGES]>,
    count: Vec<u8>,
}

impl Sheets {
    /// The table, made once: it depends on nothing, and a tile is looked at thousands of times in a run.
    pub(crate) fn table() -> &'static Self {
        static TABLE: LazyLock<Sheets> = LazyLock::new(Sheets::new);
        &TABLE
    }

    fn new() -> Self {
        let tables: Vec<([u8; EDGES], u8)> = (0..=255_u8).map(sheets).collect();
        Self { sheet: tables.iter().map(|t| t.0).collect(), count: tables.iter().map(|t| t.1).collect() }
    }

    /// Number of sheets.
    pub(crate) fn count(&self, config: u8) -> usize {
        usize::from(self.count[usize::from(config)])
    }

    /// Sheet that crosses an edge.
    pub(crate) fn of(&self, config: u8, edge: usize) -> Option<usize> {
        let s = self.sheet[usize::from(config)][edge];
        (s != NONE).then_some(usize::from(s))
    }

    pub(crate) fn edge_index(axis: usize, du: usize, dv: usize) -> usize {
        4 * axis + du + 2 * dv
    }

    /// Axis and lower corner of an edge.
    pub(crate) fn edge(e: usize) -> (usize, [usize; 3]) {
        let axis = e / 4;
        let mut offset = [0; 3];
        offset[(axis + 1) % 3] = e & 1;
        offset[(axis + 2) % 3] = e >> 1 & 1;
        (axis, offset)
    }

    /// Whether the corner holds material.
    pub(crate) fn holds(config: u8, offset: [usize; 3]) -> bool {
        config >> (offset[0] + 2 * offset[1] + 4 * offset[2]) & 1 == 1
    }
}

fn sheets(config: u8) -> ([u8; EDGES], u8) {
    let crossed = |e: usize| {
        let (axis, low) = Sheets::edge(e);
        let mut high = low;
        high[axis] = 1;
        Sheets::holds(config, low) != Sheets::holds(config, high)
    };
    let mut parent: [usize; EDGES] = std::array::from_fn(|e| e);
    let root = |parent: &[usize; EDGES], mut e: usize| {
        while parent[e] != e {
            e = parent[e];
        }
        e
    };
    let mut join = |a: usize, b: usize| {
        let (a, b) = (root(&parent, a), root(&parent, b));
        parent[a.max(b)] = a.min(b);
    };
    for normal in 0..3 {
        let (u, v) = ((normal + 1) % 3, (normal + 2) % 3);
        for side in 0..2 {
            // Edges of the face: along u at v = 0 and 1, along v at u = 0 and 1. In the index of an edge
            // along u the first offset is along v, the second along normal; along v the first is along
            // normal, the second along u.
            let along_u = |at_v: usize| Sheets::edge_index(u, at_v, side);
            let along_v = |at_u: usize| Sheets::edge_index(v, side, at_u);
            let face = [along_u(0), along_v(1), along_u(1), along_v(0)];
            let hit: Vec<usize> = face.into_iter().filter(|&e| crossed(e)).collect();
            if let [a, b] = hit[..] {
                join(a, b);
            } else if hit.len() == 4 {
                for (at_u, at_v) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let mut corner = [0; 3];
                    (corner[normal], corner[u], corner[v]) = (side, at_u, at_v);
                    if Sheets::holds(config, corner) {
                        join(along_u(at_v), along_v(at_u));
                    }
                }
            }
        }
    }
    let mut table = [NONE; EDGES];
    let mut count = 0;
    let mut name = [NONE; EDGES];
    for (e, sheet) in table.iter_mut().enumerate().filter(|(e, _)| crossed(*e)) {
        let r = root(&parent, e);
        if name[r] == NONE {
            name[r] = count;
            count += 1;
        }
        *sheet = name[r];
    }
    (table, count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_crossed_edge_has_a_sheet_and_diagonal_corners_have_two() {
        let s = Sheets::new();
        assert_eq!(s.count(0), 0);
        assert_eq!(s.count(255), 0);
        assert_eq!(s.count(0b0000_0001), 1);
        assert_eq!(s.count(0b1000_0001), 2, "opposite corners");
        assert_eq!(s.count(0b0000_1001), 2, "corners across a face diagonal");
        assert_eq!(s.count(0b0110_1001), 4, "checkerboard");
        assert_eq!(s.count(0b0000_1111), 1);
        for config in 1..255_u8 {
            let n = s.count(config);
            for sheet in 0..n {
                let edges = (0..EDGES).filter(|&e| s.of(config, e) == Some(sheet)).count();
                assert!((3..=12).contains(&edges), "config {config} sheet {sheet} has {edges} edges");
            }
        }
    }
}
