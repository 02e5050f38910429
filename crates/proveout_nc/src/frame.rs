//! Transforms between coordinate systems, with exact right angles.

use crate::WorkOffset;

/// Cosine of the angle between two directions above which they are one.
pub(crate) const SAME_DIRECTION: f64 = 1.0 - 1e-9;
/// Cosine of the angle between two directions below which they are at right angles.
pub(crate) const SQUARE: f64 = 1e-9;
/// A scale this near to one is none.
pub(crate) const UNIT_SCALE: f64 = 1e-9;
/// Scales that differ by no more than this part of the larger one are the same.
const SAME_SCALE: f64 = 1e-9;
/// A vector that is no longer than this has no direction.
const NO_LENGTH: f64 = 1e-12;

/// Sine and cosine of an angle in degrees; exact at multiples of 90 degrees.
pub(crate) fn sin_cos_degrees(angle: f64) -> (f64, f64) {
    let turn = angle.rem_euclid(360.0);
    // Comparison of exact values: rem_euclid of a multiple of 90 is exact.
    if turn == 0.0 {
        (0.0, 1.0)
    } else if turn == 90.0 {
        (1.0, 0.0)
    } else if turn == 180.0 {
        (0.0, -1.0)
    } else if turn == 270.0 {
        (-1.0, 0.0)
    } else {
        angle.to_radians().sin_cos()
    }
}

/// Affine map of points, and offsets of the rotary axes A, B, C that go with it.
///
/// `a_from_b.apply(p_in_b)` is the point in a: `linear * p + translation`. Composition reads left to right:
/// `a_from_b.then(&b_from_c)` is `a_from_c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Rotation, mirror and scale, row by row.
    pub(crate) linear: [[f64; 3]; 3],
    /// mm.
    pub(crate) translation: [f64; 3],
    /// Radian.
    pub(crate) rotary: [f64; 3],
}

impl From<WorkOffset> for Frame {
    fn from(offset: WorkOffset) -> Self {
        Self { rotary: offset.rotary, ..Self::translation(offset.translation) }
    }
}

impl Frame {
    pub(crate) const IDENTITY: Self =
        Self { linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3], rotary: [0.0; 3] };

    pub(crate) fn translation(translation: [f64; 3]) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// Rotation about X (0), Y (1) or Z (2) by an angle in degrees.
    pub(crate) fn rotation(axis: usize, degrees: f64) -> Self {
        let (s, c) = sin_cos_degrees(degrees);
        let mut frame = Self::IDENTITY;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        frame.linear[u][u] = c;
        frame.linear[u][v] = -s;
        frame.linear[v][u] = s;
        frame.linear[v][v] = c;
        frame
    }

    /// Turns by angles in degrees, each about an axis as the turns before have left it; in the reverse order
    /// they are turns about fixed axes.
    pub(crate) fn turned(turns: impl IntoIterator<Item = (usize, f64)>) -> Self {
        turns.into_iter().fold(Self::IDENTITY, |before, (axis, degrees)| before.then(&Self::rotation(axis, degrees)))
    }

    /// Rotation by angles in degrees about Z, the new Y and the newest X, in this order: Rz Ry Rx.
    pub(crate) fn rpy([x, y, z]: [f64; 3]) -> Self {
        Self::turned([(2, z), (1, y), (0, x)])
    }

    /// The system with these directions of its axes, which are square to each other, at an origin.
    pub(crate) fn of_axes(origin: [f64; 3], [x, y, z]: [[f64; 3]; 3]) -> Self {
        // Adding 0.0 turns -0.0 into 0.0.
        Self {
            linear: std::array::from_fn(|row| [x[row] + 0.0, y[row] + 0.0, z[row] + 0.0]),
            ..Self::translation(origin)
        }
    }

    /// Scale along the axes; negative factors mirror.
    pub(crate) fn scale(factors: [f64; 3]) -> Self {
        let mut frame = Self::IDENTITY;
        for (i, factor) in factors.into_iter().enumerate() {
            frame.linear[i][i] = factor;
        }
        frame
    }

    /// `a_from_b.then(&b_from_c)` = `a_from_c`.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        let mut linear = [[0.0; 3]; 3];
        for (row, out) in linear.iter_mut().enumerate() {
            for (column, cell) in out.iter_mut().enumerate() {
                // Adding 0.0 turns -0.0 into 0.0, so that right angles print as 0.
                *cell = (0..3).map(|k| self.linear[row][k] * inner.linear[k][column]).sum::<f64>() + 0.0;
            }
        }
        let rotary = std::array::from_fn(|i| self.rotary[i] + inner.rotary[i]);
        Self { linear, translation: self.apply(inner.translation), rotary }
    }

    pub(crate) fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.translation[i] + dot(self.linear[i], p))
    }

    /// Directions: without the translation.
    pub(crate) fn apply_vector(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| dot(self.linear[i], v))
    }

    pub(crate) fn determinant(&self) -> f64 {
        dot(self.linear[0], cross(self.linear[1], self.linear[2]))
    }

    /// Inverse of the linear part; none when a scale factor is zero.
    pub(crate) fn inverse_linear(&self) -> Option<[[f64; 3]; 3]> {
        let det = self.determinant();
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let m = &self.linear;
        // Columns of the adjugate are cross products of rows.
        let columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
        Some(std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row] / det + 0.0)))
    }

    /// Common scale factor of all directions; none when they differ by more than 1e-9 or the map is
    /// degenerate.
    pub(crate) fn uniform_scale(&self) -> Option<f64> {
        let length = |axis: usize| (0..3).map(|row| self.linear[row][axis].powi(2)).sum::<f64>().sqrt();
        let (x, y, z) = (length(0), length(1), length(2));
        let column = |axis: usize| [self.linear[0][axis], self.linear[1][axis], self.linear[2][axis]];
        let near = |a: f64, b: f64| (a - b).abs() <= SAME_SCALE * a.abs().max(b.abs());
        let square = |a: usize, b: usize| dot(column(a), column(b)).abs() <= SQUARE * x * x;
        (x > 0.0 && near(x, y) && near(x, z) && square(0, 1) && square(0, 2) && square(1, 2)).then_some(x)
    }

    pub(crate) fn is_rotated(&self) -> bool {
        self.linear != Self::IDENTITY.linear
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(crate) fn add_scaled(a: [f64; 3], b: [f64; 3], factor: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

pub(crate) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Unit vector; none for a vector without length.
pub(crate) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length > NO_LENGTH && length.is_finite()).then(|| a.map(|v| v / length + 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact() {
        assert_eq!(sin_cos_degrees(90.0), (1.0, 0.0));
        assert_eq!(sin_cos_degrees(-90.0), (-1.0, 0.0));
        assert_eq!(sin_cos_degrees(540.0), (0.0, -1.0));
        let quarter = Frame::rotation(1, 90.0);
        assert_eq!(quarter.apply([31.0, -15.001, 165.236]), [165.236, -15.001, -31.0]);
    }

    #[test]
    fn one_block_rotation_is_z_then_new_y_then_newest_x() {
        let one = Frame::rpy([20.0, 30.0, 40.0]);
        let steps = Frame::rotation(2, 40.0).then(&Frame::rotation(1, 30.0)).then(&Frame::rotation(0, 20.0));
        assert_eq!(one, steps);
        // Independent: the image of e_x of Rz Ry Rx is (cz cy, sz cy, -sy).
        let (z, y) = (40f64.to_radians(), 30f64.to_radians());
        let x = one.apply_vector([1.0, 0.0, 0.0]);
        for (got, want) in x.into_iter().zip([z.cos() * y.cos(), z.sin() * y.cos(), -y.sin()]) {
            assert!((got - want).abs() < 1e-15, "{got} {want}");
        }
    }

    #[test]
    fn inverse_undoes() {
        let frame = Frame::rpy([11.0, -23.0, 71.0]).then(&Frame::scale([2.0, -3.0, 0.5]));
        let inverse = Frame { linear: frame.inverse_linear().unwrap(), ..Frame::IDENTITY };
        let back = inverse.apply_vector(frame.apply_vector([1.0, 2.0, 3.0]));
        for (got, want) in back.into_iter().zip([1.0, 2.0, 3.0]) {
            assert!((got - want).abs() < 1e-14);
        }
    }
}
