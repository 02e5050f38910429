//! The system of Newton's method for the unknowns of eight intervals, summed lane by lane before it goes into
//! that of all.

use super::{
    lanes::{LANES, Lanes},
    solver::SolverVectors,
};

/// What eight intervals give to the system of their unknowns: upper triangle row by row, and both right
/// sides.
pub(super) struct System {
    matrix: [Lanes; 10],
    right: [Lanes; 4],
    central: [Lanes; 4],
}

impl System {
    pub(super) const ZERO: Self =
        Self { matrix: [Lanes::ZERO; 10], right: [Lanes::ZERO; 4], central: [Lanes::ZERO; 4] };

    /// Adds a node of each.
    #[inline(always)]
    pub(super) fn add(&mut self, e: &[[Lanes; 4]; 3], g: &[Lanes; 3], central: &[Lanes; 3], m: &[Lanes; 6]) {
        let full = [[m[0], m[1], m[2]], [m[1], m[3], m[4]], [m[2], m[4], m[5]]];
        let mut place = 0;
        for i in 0..4 {
            let own = [e[0][i], e[1][i], e[2][i]];
            self.right[i] += own[0] * g[0] + own[1] * g[1] + own[2] * g[2];
            self.central[i] += own[0] * central[0] + own[1] * central[1] + own[2] * central[2];
            let mut left = [Lanes::ZERO; 3];
            for (c, left) in left.iter_mut().enumerate() {
                *left = own[0] * full[0][c] + own[1] * full[1][c] + own[2] * full[2][c];
            }
            for j in i..4 {
                self.matrix[place] += left[0] * e[0][j] + left[1] * e[1][j] + left[2] * e[2][j];
                place += 1;
            }
        }
    }

    /// Adds it to the whole.
    #[inline(always)]
    pub(super) fn put(&self, first: &[usize; LANES], work: &mut SolverVectors) {
        for lane in 0..LANES {
            let mut place = 0;
            for i in 0..4 {
                let at = first[lane] + i;
                work.right[at] -= self.right[i].0[lane];
                work.central[at] -= self.central[i].0[lane];
                for own in work.matrix[at].iter_mut().take(4 - i) {
                    *own += self.matrix[place].0[lane];
                    place += 1;
                }
            }
        }
    }
}
