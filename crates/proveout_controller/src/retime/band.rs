//! Solves a symmetric system with three diagonals on each side of the main one by the root-free
//! Cholesky factorization (L D L'), from both ends at once.
//!
//! ```text
//!   0 1 2 .. --->  t | m m m |  <--- .. n-2 n-1
//! ```
//!
//! Each elimination waits for the one before it, but not for that at the other end. Three unknowns are left
//! where both meet.

/// Unknowns that are left in the middle: as many as one elimination reaches.
const MIDDLE: usize = 3;

/// Solves in place; the solution replaces the right side. Rows hold the diagonal and the three above it.
/// False where the matrix is not positive definite.
#[inline(always)]
pub(super) fn factor_and_solve(m: &mut [[f64; 4]], x: &mut [f64]) -> bool {
    let n = m.len().min(x.len());
    let (m, x) = (&mut m[..n], &mut x[..n]);
    let first = n.saturating_sub(MIDDLE) / 2;
    let behind = (first + MIDDLE).min(n);
    let both = first.min(n - behind);
    let mut good = true;
    for k in 0..both {
        good &= down(m, x, k, n) & up(m, x, n - 1 - k);
    }
    for i in both..first {
        good &= down(m, x, i, n);
    }
    for j in (behind..n - both).rev() {
        good &= up(m, x, j);
    }
    for i in first..behind {
        good &= down(m, x, i, behind);
    }
    if !good {
        return false;
    }
    for i in (first..behind).rev() {
        let above = (1..behind - i).map(|k| m[i][k] * x[i + k]).sum::<f64>();
        x[i] = x[i] * m[i][0] - above;
    }
    for k in 0..first.max(n - behind) {
        if let Some(i) = (first.checked_sub(k + 1)).filter(|i| i + 3 < n) {
            x[i] = x[i] * m[i][0] - m[i][3] * x[i + 3] - m[i][2] * x[i + 2] - m[i][1] * x[i + 1];
        }
        let j = behind + k;
        if j < n {
            x[j] = x[j] * m[j][0] - m[j - 3][3] * x[j - 3] - m[j - 2][2] * x[j - 2] - m[j - 1][1] * x[j - 1];
        }
    }
    true
}

/// Eliminates an unknown from those after it, up to `end`.
#[inline(always)]
fn down(m: &mut [[f64; 4]], x: &mut [f64], i: usize, end: usize) -> bool {
    let [d, r1, r2, r3] = m[i];
    let (over, right) = (1.0 / d, x[i]);
    let l = [r1 * over, r2 * over, r3 * over];
    // Entries past the end are factors of the other side.
    let rest = end - i - 1;
    m[i][0] = over;
    if rest > 0 {
        m[i][1] = l[0];
        m[i + 1][0] -= l[0] * r1;
        x[i + 1] -= l[0] * right;
    }
    if rest > 1 {
        m[i][2] = l[1];
        m[i + 1][1] -= l[0] * r2;
        m[i + 2][0] -= l[1] * r2;
        x[i + 2] -= l[1] * right;
    }
    if rest > 2 {
        m[i][3] = l[2];
        m[i + 1][2] -= l[0] * r3;
        m[i + 2][1] -= l[1] * r3;
        m[i + 3][0] -= l[2] * r3;
        x[i + 3] -= l[2] * right;
    }
    d > 0.0 && d.is_finite()
}

/// Takes an unknown out of the three before it, and leaves its factors in their rows.
#[inline(always)]
fn up(m: &mut [[f64; 4]], x: &mut [f64], j: usize) -> bool {
    let (d, right) = (m[j][0], x[j]);
    let over = 1.0 / d;
    let (r1, r2, r3) = (m[j - 1][1], m[j - 2][2], m[j - 3][3]);
    let l = [r1 * over, r2 * over, r3 * over];
    m[j][0] = over;
    (m[j - 1][1], m[j - 2][2], m[j - 3][3]) = (l[0], l[1], l[2]);
    m[j - 1][0] -= l[0] * r1;
    m[j - 2][1] -= l[1] * r1;
    m[j - 3][2] -= l[2] * r1;
    m[j - 2][0] -= l[1] * r2;
    m[j - 3][1] -= l[2] * r2;
    m[j - 3][0] -= l[2] * r3;
    x[j - 1] -= l[0] * right;
    x[j - 2] -= l[1] * right;
    x[j - 3] -= l[2] * right;
    d > 0.0 && d.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Systems of every size up to forty with a known solution; what is not positive definite is refused.
    #[test]
    fn solutions_are_found_from_both_ends() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for n in 1..=40_usize {
            // Diagonally dominant: six entries of half at most, with a diagonal above three.
            let mut m: Vec<[f64; 4]> = (0..n).map(|_| [3.5 + random(), random(), random(), random()]).collect();
            let solution: Vec<f64> = (0..n).map(|_| random()).collect();
            let mut x = vec![0.0; n];
            for i in 0..n {
                x[i] += m[i][0] * solution[i];
                for k in 1..4.min(n - i) {
                    x[i] += m[i][k] * solution[i + k];
                    x[i + k] += m[i][k] * solution[i];
                }
            }
            let whole = m.clone();
            assert!(factor_and_solve(&mut m, &mut x), "{n}");
            for (found, known) in x.iter().zip(&solution) {
                assert!((found - known).abs() < 1e-14 * n as f64, "{n}: {found} {known}");
            }
            for i in 0..n {
                let mut m = whole.clone();
                m[i][0] = -1.0;
                assert!(!factor_and_solve(&mut m, &mut vec![1.0; n]), "{n} {i}");
            }
        }
    }
}
