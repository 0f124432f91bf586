//! Cholesky factorisation in place: small dense symmetric systems `A x = b`, `A = L L^T` positive
//! definite.

use super::{LONG, dot};

/// A symmetric matrix and its factor, row-major, `n` x `n`.
#[derive(Clone, Debug)]
pub struct Symmetric {
    n: usize,
    /// Entries; only the lower triangle is read.
    pub entries: Vec<f64>,
}

impl Symmetric {
    /// The zero matrix of order `n`.
    pub fn zeros(n: usize) -> Self {
        Symmetric { n, entries: vec![0.0; n * n] }
    }

    /// Changes the order to `n`. Allocates only beyond the greatest order so far.
    pub fn set_order(&mut self, n: usize) {
        self.n = n;
        self.entries.resize(n * n, 0.0);
    }

    /// Replaces A by its factor; false when A is not positive definite.
    pub fn factorize(&mut self) -> bool {
        let (n, a) = (self.n, &mut self.entries);
        for j in 0..n {
            let (above, rest) = a.split_at_mut(j * n + n);
            let row = &mut above[j * n..];
            let pivot = row[j] - dot(&row[..j], &row[..j]);
            if !(pivot > 0.0) {
                return false;
            }
            let diagonal = pivot.sqrt();
            row[j] = diagonal;
            for lower in rest.chunks_exact_mut(n) {
                lower[j] = (lower[j] - dot(&row[..j], &lower[..j])) / diagonal;
            }
        }
        true
    }

    /// Solves `b := A^-1 b` with the factor.
    pub fn solve(&self, b: &mut [f64]) {
        let (n, l) = (self.n, &self.entries);
        for i in 0..n {
            b[i] = (b[i] - dot(&l[i * n..i * n + i], &b[..i])) / l[i * n + i];
        }
        if n < LONG {
            for i in (0..n).rev() {
                let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * b[k]).sum();
                b[i] = (b[i] - sum) / l[i * n + i];
            }
            return;
        }
        // The same along the rows, which are contiguous.
        for i in (0..n).rev() {
            let (above, at) = b.split_at_mut(i);
            at[0] /= l[i * n + i];
            above.iter_mut().zip(&l[i * n..i * n + i]).for_each(|(b, l)| *b -= l * at[0]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_hilbert_matrix_and_refuses_an_indefinite_one() {
        // Hilbert matrix of order 4: inverse times ones is (-4, 60, -180, 140); condition 1.6e4
        // times rounding.
        let mut a = Symmetric::zeros(4);
        for i in 0..4 {
            for j in 0..4 {
                a.entries[4 * i + j] = 1.0 / (i + j + 1) as f64;
            }
        }
        assert!(a.factorize());
        let mut x = [1.0; 4];
        a.solve(&mut x);
        for (got, truth) in x.iter().zip([-4.0, 60.0, -180.0, 140.0]) {
            assert!((got - truth).abs() < 1e-9, "{x:?}");
        }
        let mut indefinite = Symmetric { n: 2, entries: vec![1.0, 2.0, 2.0, 1.0] };
        assert!(!indefinite.factorize());
    }
}
