//! Symmetric positive definite matrices of few diagonals: `m[i][k]` is the element (i, i - k), the main
//! diagonal and those below it.

/// Cholesky factorization in place; false where a pivot is not above zero.
pub(crate) fn factor<const BAND: usize>(m: &mut [[f64; BAND]]) -> bool {
    for i in 0..m.len() {
        for k in (0..BAND).rev() {
            let Some(j) = i.checked_sub(k) else { continue };
            let mut sum = m[i][k];
            for p in 1..BAND - k {
                if p <= j {
                    sum -= m[i][k + p] * m[j][p];
                }
            }
            if k > 0 {
                m[i][k] = sum / m[j][0];
            } else if sum > 0.0 && sum.is_finite() {
                m[i][0] = sum.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}

/// Solves in place with the factors; the solution replaces the right side.
pub(crate) fn solve<const BAND: usize>(m: &[[f64; BAND]], b: &mut [f64]) {
    let n = m.len();
    for i in 0..n {
        let sum: f64 = (1..BAND.min(i + 1)).map(|k| m[i][k] * b[i - k]).sum();
        b[i] = (b[i] - sum) / m[i][0];
    }
    for i in (0..n).rev() {
        let sum: f64 = (1..BAND).filter(|k| i + k < n).map(|k| m[i + k][k] * b[i + k]).sum();
        b[i] = (b[i] - sum) / m[i][0];
    }
}
