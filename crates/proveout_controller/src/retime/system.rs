//! The system of Newton's method for the unknowns of eight intervals, summed lane by lane before it goes into that of all.
//!
//! An interval is a cubic in the part t of it, `b = p_0 + p_1 t + p_2 t^2 + p_3 t^3`, and its nodes give to the system of these four. Near to all of it
//! is b itself: a change of the p by as much acts on it by as much, and what single precision loses stays as small as it is. In
//! the values and slopes at the ends of short intervals, which the unknowns are, it would not: there b'' is a difference of large numbers.
//! From the one to the others it goes in double precision, once for all nodes of an interval:
//!
//! ```text
//!   p_0   |  1   .   .   . | b_0
//!   p_1 = |  .   w   .   . | b'_0 H        w = h/H
//!   p_2   | -3 -2w   3  -w | b_1
//!   p_3   |  2   w  -2   w | b'_1 H
//! ```

use super::{
    lanes::{LANES, Lanes, Wide},
    solver::Work,
};

/// The polynomials of eight intervals from their unknowns, `w` as above.
#[inline(always)]
pub(super) fn polynomial(w: Wide, u: &[Wide; 4]) -> [Lanes; 4] {
    let [begin, end] = [u[1] * w, u[3] * w];
    let rise = u[2] - u[0];
    let bend = rise * 3.0 - begin * 2.0 - end;
    let twist = begin + end - rise * 2.0;
    [u[0].narrow(), begin.narrow(), bend.narrow(), twist.narrow()]
}

/// b, b' and b'' at a part of the interval, by that part.
#[inline(always)]
pub(super) fn state(t: Lanes, p: &[Lanes; 4]) -> [Lanes; 3] {
    let (end, bend) = (t * p[3], p[2] * 2.0);
    [p[0] + t * (p[1] + t * (p[2] + end)), p[1] + t * (bend + end * 3.0), bend + end * 6.0]
}

/// A row along the p as one along the unknowns.
#[inline(always)]
fn turned(w: Wide, p: [Lanes; 4]) -> [Wide; 4] {
    turned_wide(w, [p[0].wide(), p[1].wide(), p[2].wide(), p[3].wide()])
}

#[inline(always)]
fn turned_wide(w: Wide, p: [Wide; 4]) -> [Wide; 4] {
    [p[0] - p[2] * 3.0 + p[3] * 2.0, w * (p[1] - p[2] * 2.0 + p[3]), p[2] * 3.0 - p[3] * 2.0, w * (p[3] - p[2])]
}

/// b, b' and b'' at a part t of the interval by p_2 and p_3; by p_0 they are 1, 0 and 0, by p_1 t, 1 and 0.
struct Powers {
    t: Lanes,
    two: [Lanes; 2],
    three: [Lanes; 3],
}

impl Powers {
    #[inline(always)]
    fn new(t: Lanes) -> Self {
        let square = t * t;
        Self { t, two: [square, t * 2.0], three: [square * t, square * 3.0, t * 6.0] }
    }

    /// A row along b, b' and b'' as one along the p.
    #[inline(always)]
    fn along(&self, b: Lanes, slope: Lanes, bend: Lanes) -> [Lanes; 4] {
        let Self { t, two, three } = self;
        [b, *t * b + slope, two[0] * b + two[1] * slope + bend * 2.0, three[0] * b + three[1] * slope + three[2] * bend]
    }
}

/// What eight intervals give to the system of their p: upper triangle row by row, and both right sides.
pub(super) struct System {
    matrix: [Lanes; 10],
    right: [Lanes; 4],
    central: [Lanes; 4],
}

/// Places of a row in the upper triangle.
const ROWS: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];

impl System {
    pub(super) const ZERO: Self =
        Self { matrix: [Lanes::ZERO; 10], right: [Lanes::ZERO; 4], central: [Lanes::ZERO; 4] };

    /// Adds a node of each.
    #[inline(always)]
    pub(super) fn add(&mut self, t: Lanes, g: &[Lanes; 3], central: &[Lanes; 3], m: &[Lanes; 6]) {
        let powers = Powers::new(t);
        let (right, middle) = (powers.along(g[0], g[1], g[2]), powers.along(central[0], central[1], central[2]));
        for i in 0..4 {
            self.right[i] += right[i];
            self.central[i] += middle[i];
        }
        // Rows of the matrix for b, b' and b'', along the p.
        let (value, slope, bend) =
            (powers.along(m[0], m[1], m[2]), powers.along(m[1], m[3], m[4]), powers.along(m[2], m[4], m[5]));
        for j in 0..4 {
            let column = powers.along(value[j], slope[j], bend[j]);
            for i in 0..=j {
                self.matrix[ROWS[i][j]] += column[i];
            }
        }
    }

    /// Adds it to the whole.
    #[inline(always)]
    pub(super) fn put(&self, w: Wide, first: &[usize; LANES], work: &mut Work) {
        let (right, central) = (turned(w, self.right), turned(w, self.central));
        let m = &self.matrix;
        let rows = [
            turned(w, [m[0], m[1], m[2], m[3]]),
            turned(w, [m[1], m[4], m[5], m[6]]),
            turned(w, [m[2], m[5], m[7], m[8]]),
            turned(w, [m[3], m[6], m[8], m[9]]),
        ];
        let mut matrix = [[Wide::ZERO; 4]; 4];
        for j in 0..4 {
            matrix[j] = turned_wide(w, [rows[0][j], rows[1][j], rows[2][j], rows[3][j]]);
        }
        for lane in 0..LANES {
            for i in 0..4 {
                let at = first[lane] + i;
                work.right[at] -= right[i].0[lane];
                work.central[at] -= central[i].0[lane];
                for (own, value) in work.matrix[at].iter_mut().zip(&matrix[i][i..]) {
                    *own += value.0[lane];
                }
            }
        }
    }
}
