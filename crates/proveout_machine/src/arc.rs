//! Great circle arcs between tool axes.

use proveout_geom::Vector;

/// The shorter arc between two unit vectors; of opposite ones any.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    from: Vector,
    to: Vector,
    /// Unit vector along the arc at its begin; zero for an arc without length.
    way: Vector,
    length: f64,
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

impl Arc {
    pub(crate) fn new(from: &Vector, to: &Vector) -> Self {
        let across = to - from * from.dot(to);
        let way = match across.try_normalize(1e-15) {
            Some(way) => way,
            None if from.dot(to) > 0.0 => Vector::zeros(),
            None => {
                let smallest = from.iamin();
                from.cross(&Vector::ith(smallest, 1.0)).normalize()
            }
        };
        Self { from: *from, to: *to, way, length: angle(from, to) }
    }

    /// Point at a part of the length.
    pub(crate) fn at(&self, part: f64) -> Vector {
        if part <= 0.0 {
            return self.from;
        }
        if part >= 1.0 {
            return self.to;
        }
        let (s, c) = (part * self.length).sin_cos();
        (self.from * c + self.way * s).normalize()
    }

    /// Part of the length at which the arc is nearest to a unit vector.
    pub(crate) fn nearest(&self, v: &Vector) -> f64 {
        if self.length == 0.0 {
            return 0.0;
        }
        let foot = v.dot(&self.way).atan2(v.dot(&self.from));
        if (0.0..=self.length).contains(&foot) {
            return foot / self.length;
        }
        if angle(v, &self.from) <= angle(v, &self.to) { 0.0 } else { 1.0 }
    }

    /// Angle between a unit vector and the arc.
    pub(crate) fn distance(&self, v: &Vector) -> f64 {
        angle(v, &self.at(self.nearest(v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_foot_lies_on_the_arc_or_at_its_ends() {
        let arc = Arc::new(&Vector::x(), &Vector::y());
        let v = Vector::new(1.0, 1.0, 1.0).normalize();
        assert!((arc.nearest(&v) - 0.5).abs() < 1e-15);
        assert!((arc.distance(&v) - (1.0_f64 / 3.0).sqrt().asin()).abs() < 1e-15);
        assert_eq!(arc.nearest(&-Vector::y()), 0.0);
        assert!((arc.distance(&Vector::new(-1.0, 0.0, 0.0)) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!(Arc::new(&Vector::z(), &Vector::z()).distance(&Vector::z()), 0.0);
        assert!((Arc::new(&Vector::z(), &-Vector::z()).at(0.5).z).abs() < 1e-15);
    }
}
