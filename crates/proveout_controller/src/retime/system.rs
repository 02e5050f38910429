//! The system of Newton's method for the unknowns of eight intervals, summed lane by lane before it goes into that of all.
//!
//! An interval is a cubic in the part t of it, `b = p_0 + p_1 t + p_2 t^2 + p_3 t^3`, and its nodes give to the system of these four in single
//! precision: what rounding takes from an entry is small beside it, and b as a whole is `p_0` alone. Along the unknowns, values and slopes at
//! both ends, b as a whole is a sum in which the far larger entries of b'' cancel, and single precision would leave nothing of it. From
//! the one to the others it goes in double precision, once for all nodes of an interval:
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

/// b, b' and b'' at a part t of the interval by `p_2` and `p_3`; by `p_0` they are 1, 0 and 0, by `p_1` t, 1 and 0.
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
        for (lane, first) in first.iter().enumerate() {
            // Four rows of the diagonal and the three above it; what they have behind the four unknowns is zero here.
            let own = [&mut work.right, &mut work.central].map(|all| all[*first..].first_chunk_mut::<4>());
            let [Some(own_right), Some(own_central)] = own else { continue };
            let Some(own) = work.matrix[*first..].first_chunk_mut::<4>() else { continue };
            for i in 0..4 {
                own_right[i] -= right[i].0[lane];
                own_central[i] -= central[i].0[lane];
                let mut row = [0.0; 4];
                for j in i..4 {
                    row[j - i] = matrix[i][j].0[lane];
                }
                for k in 0..4 {
                    own[i][k] += row[k];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::lanes::Eight, *};

    /// b, b' and b'' by the unknowns, Hermite's way.
    fn basis(w: f64, t: f64) -> [[f64; 4]; 3] {
        let r = 1.0 - t;
        [
            [r * r * (1.0 + 2.0 * t), w * t * r * r, t * t * (3.0 - 2.0 * t), -w * t * t * r],
            [-6.0 * t * r, w * r * (r - 2.0 * t), 6.0 * t * r, w * t * (t - 2.0 * r)],
            [12.0 * t - 6.0, w * (6.0 * t - 4.0), 6.0 - 12.0 * t, w * (6.0 * t - 2.0)],
        ]
    }

    /// Numbers between -0.5 and 0.5.
    fn random() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    #[test]
    fn places_of_an_interval_are_those_of_its_unknowns() {
        let mut random = random();
        for w in [0.02, 0.4, 1.0] {
            let u: [f64; 4] = std::array::from_fn(|_| 10.0 * random());
            let p = polynomial(Wide::all(w), &u.map(Wide::all));
            for k in 0..=8 {
                let t = 0.125 * k as f64;
                for (found, row) in state(Lanes::all(t as f32), &p).iter().zip(basis(w, t)) {
                    let known: f64 = row.iter().zip(u).map(|(e, u)| e * u).sum();
                    assert!((f64::from(found.0[5]) - known).abs() < 2e-5, "{w} {t}: {found:?} {known}");
                }
            }
        }
    }

    /// The nodes of eight intervals give to the system what they do in double precision. A change of b as a whole keeps what it is
    /// worth to six digits, though b'' is worth a million times as much and is a difference of the unknowns.
    #[test]
    fn nodes_give_what_they_do_in_double_precision() {
        let mut random = random();
        let lengths = Eight(std::array::from_fn(|lane| 0.02 + 0.14 * lane as f64));
        let first: [usize; LANES] = std::array::from_fn(|lane| 2 * lane);
        let mut work = Work::default();
        work.matrix.resize(2 * LANES + 2, [0.0; 4]);
        work.right.resize(2 * LANES + 2, 0.0);
        work.central.resize(2 * LANES + 2, 0.0);
        let mut known = [[0.0; 18]; 18];
        let (mut right, mut central) = ([0.0; 18], [0.0; 18]);
        let mut system = System::ZERO;
        let mut worth = 0.0;
        for t in [0.0, 0.3, 0.7, 1.0] {
            let g: [f64; 3] = std::array::from_fn(|_| random());
            let h: [f64; 3] = std::array::from_fn(|_| random());
            // A row along each of b, b' and b''.
            let weights = [1.0 + random(), 30.0 * (1.0 + random()), 1e6 * (1.0 + random())];
            let m = [weights[0], 0.0, 0.0, weights[1], 0.0, weights[2]];
            let narrow = |x: f64| Lanes::all(x as f32);
            system.add(narrow(t), &g.map(narrow), &h.map(narrow), &m.map(narrow));
            worth += weights[0] * LANES as f64;
            for lane in 0..LANES {
                let e = basis(lengths.0[lane], f64::from(t as f32));
                for i in 0..4 {
                    for (k, row) in e.iter().enumerate() {
                        right[2 * lane + i] -= g[k] * row[i];
                        central[2 * lane + i] -= h[k] * row[i];
                        for j in 0..4 {
                            known[2 * lane + i][2 * lane + j] += weights[k] * row[i] * row[j];
                        }
                    }
                }
            }
        }
        system.put(lengths, &first, &mut work);
        let mut whole = 0.0;
        for i in 0..18 {
            assert!((work.right[i] - right[i]).abs() < 2e-5, "{i}: {} {}", work.right[i], right[i]);
            assert!((work.central[i] - central[i]).abs() < 2e-5, "{i}: {} {}", work.central[i], central[i]);
            for k in 0..4.min(18 - i) {
                let (found, own) = (work.matrix[i][k], known[i][i + k]);
                let scale = (known[i][i] * known[i + k][i + k]).sqrt();
                assert!((found - own).abs() <= 1e-6 * scale, "{i} {k}: {found} {own}");
                if i % 2 == 0 && k % 2 == 0 {
                    whole += found * if k == 0 { 1.0 } else { 2.0 };
                }
            }
        }
        assert!((whole / worth - 1.0).abs() < 1e-5, "{whole} {worth}");
    }
}
