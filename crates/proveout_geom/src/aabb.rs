use crate::{Point, Vector};

/// Axis-aligned box, mm. Empty when a lower bound is above its upper bound.
///
/// ```
/// use proveout_geom::{Aabb, Point, Vector};
///
/// let block = Aabb::of_points(&[Point::new(0.0, 0.0, -20.0), Point::new(100.0, 60.0, 0.0)]);
/// assert_eq!(block.size(), Vector::new(100.0, 60.0, 20.0)); // mm
/// assert_eq!(block.center(), Point::new(50.0, 30.0, -10.0));
/// assert_eq!(block.expanded(1.0).min, Point::new(-1.0, -1.0, -21.0));
/// assert!(block.contains(&block.max) && !block.contains(&Point::new(50.0, 30.0, 1.0)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Point,
    /// Largest coordinates.
    pub max: Point,
}

impl Aabb {
    /// The box that holds nothing and that [`Self::grow`] starts from.
    pub fn empty() -> Self {
        Self { min: Point::from([f64::INFINITY; 3]), max: Point::from([f64::NEG_INFINITY; 3]) }
    }

    /// The smallest box round some points.
    pub fn of_points<'a>(points: impl IntoIterator<Item = &'a Point>) -> Self {
        let mut all = Self::empty();
        for p in points {
            all.grow(p);
        }
        all
    }

    /// Extends the box to a point.
    #[inline]
    pub fn grow(&mut self, p: &Point) {
        self.min = self.min.inf(p);
        self.max = self.max.sup(p);
    }

    /// The box round both.
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// The box with every face moved outward by `margin` (mm).
    #[inline]
    pub fn expanded(&self, margin: f64) -> Self {
        let by = Vector::repeat(margin);
        Self { min: self.min - by, max: self.max + by }
    }

    /// True when no point is inside.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// True when the boxes share a point; touching counts.
    #[inline]
    pub fn intersects(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i] <= other.max[i] && other.min[i] <= self.max[i])
    }

    /// True when the point is inside or on the skin.
    #[inline]
    pub fn contains(&self, p: &Point) -> bool {
        (0..3).all(|i| self.min[i] <= p[i] && p[i] <= self.max[i])
    }

    /// Edge lengths, mm.
    #[inline]
    pub fn size(&self) -> Vector {
        self.max - self.min
    }

    /// Middle of the box.
    #[inline]
    pub fn center(&self) -> Point {
        nalgebra::center(&self.min, &self.max)
    }
}
