//! The points whose heights are asked for.

use proveout_geom::{Point, Vector};

/// Points of a design surface in rows and columns, with outward unit normals, in the frame of the motion (W).
/// Neighbors are neighbors on the surface; a profile is a lattice of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    columns: usize,
    points: Vec<Point>,
    normals: Vec<Vector>,
}

impl Lattice {
    /// A lattice with columns running fastest; none unless points and normals fill whole rows.
    pub fn new(columns: usize, points: Vec<Point>, normals: Vec<Vector>) -> Option<Self> {
        (columns > 0 && !points.is_empty() && points.len().is_multiple_of(columns) && points.len() == normals.len())
            .then_some(Self { columns, points, normals })
    }

    /// A plane rectangle of `columns` x `rows` points with steps in mm: `origin + i step[0] x + j step[1] y`,
    /// normal x cross y.
    pub fn plane(origin: Point, x: Vector, y: Vector, step: [f64; 2], columns: usize, rows: usize) -> Option<Self> {
        let points = (0..rows)
            .flat_map(|j| (0..columns).map(move |i| origin + x * (i as f64 * step[0]) + y * (j as f64 * step[1])))
            .collect();
        Self::new(columns, points, vec![x.cross(&y).normalize(); columns * rows])
    }

    /// Points in a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.points.len() / self.columns
    }

    /// All points, row by row.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Their normals.
    pub fn normals(&self) -> &[Vector] {
        &self.normals
    }
}
