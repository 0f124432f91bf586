//! Linear systems with a stiff part of low rank.
//!
//! ```text
//! A = N + sum_r u_r v_r^T      N N = 0      (1 - q N)^-1 = 1 + q N
//! (1 - q A)^-1 x = (1 + q N) (x + q U S^-1 V^T (1 + q N) x)      S = 1 - q V^T (1 + q N) U
//! ```
//!
//! N has the rates of positions by velocities, without which the stiffness of a spring would be explicit.

use super::stiff_part::{StiffPart, sparse_dot};

/// The stiff part A of the next steps, and the factors of S, allocated once.
#[derive(Clone, Debug)]
pub struct StiffSolver {
    /// A.
    pub stiff: StiffPart,
    /// Coefficient of the factors, s.
    q: f64,
    /// The factors of the transpose of S by rows, with the inverse diagonal of U, its pivots, and a right side.
    small: Vec<f64>,
    pivots: Vec<usize>,
    right: Vec<f64>,
    change: Vec<f64>,
}

impl StiffSolver {
    /// Allocates for systems of `n` equations with a stiff part of up to `rank` products.
    pub fn new(n: usize, rank: usize) -> Self {
        StiffSolver {
            stiff: StiffPart::new(n, rank),
            q: 0.0,
            small: vec![0.0; rank * rank],
            pivots: vec![0; rank],
            right: vec![0.0; rank],
            change: vec![0.0; n],
        }
    }

    /// Makes room for a stiff part of `rank` products.
    pub fn reserve(&mut self, rank: usize) {
        if rank > self.right.len() {
            self.stiff.reserve(rank);
            self.small.resize(rank * rank, 0.0);
            self.pivots.resize(rank, 0);
            self.right.resize(rank, 0.0);
        }
    }

    /// Factorises the transpose of S for the coefficient `q`, `S^T = P L U`, so that solves add multiples of rows.
    /// Needed after a change of A.
    pub fn factorize(&mut self, q: f64) {
        self.q = q;
        let n = self.stiff.rank;
        let [direct, by_rates] = &self.stiff.products;
        for (r, (direct, by_rates)) in direct.chunks_exact(n.max(1)).zip(by_rates.chunks_exact(n.max(1))).enumerate() {
            for (c, (direct, by_rates)) in direct.iter().zip(by_rates).enumerate() {
                self.small[c * n + r] = -q * (direct + q * by_rates);
            }
            self.small[r * n + r] += 1.0;
        }
        for c in 0..n {
            let pivot = (c..n).max_by(|a, b| self.small[a * n + c].abs().total_cmp(&self.small[b * n + c].abs()));
            self.pivots[c] = pivot.unwrap_or(c);
            let (upper, lower) = self.small[..n * n].split_at_mut((c + 1) * n);
            let upper = &mut upper[c * n..];
            if self.pivots[c] > c {
                upper.swap_with_slice(&mut lower[(self.pivots[c] - c - 1) * n..][..n]);
            }
            let inverse = 1.0 / upper[c];
            for row in lower.chunks_exact_mut(n) {
                let factor = row[c] * inverse;
                row[c] = factor;
                row[c + 1..].iter_mut().zip(&upper[c + 1..]).for_each(|(x, u)| *x -= factor * u);
            }
            upper[c] = inverse;
        }
    }

    /// Replaces x by `(1 - q A)^-1 x`.
    pub fn solve(&mut self, x: &mut [f64]) {
        let (n, q) = (self.stiff.rank, self.q);
        // Positions of x + q N x are those in which the rows see it.
        self.stiff.add_rates(q, x);
        for (right, row) in self.right.iter_mut().zip(&self.stiff.rows).take(n) {
            *right = sparse_dot(row, x);
        }
        // S = U^T L^T P^T.
        for r in 0..n {
            let (row, rest) = (&self.small[r * n..(r + 1) * n], &mut self.right[r..n]);
            let y = rest[0] * row[r];
            rest[0] = y;
            rest[1..].iter_mut().zip(&row[r + 1..]).for_each(|(x, u)| *x -= y * u);
        }
        for r in (0..n).rev() {
            let z = self.right[r];
            let row = &self.small[r * n..r * n + r];
            self.right[..r].iter_mut().zip(row).for_each(|(x, l)| *x -= z * l);
        }
        for c in (0..n).rev() {
            self.right.swap(c, self.pivots[c]);
        }
        if self.stiff.rates.is_empty() {
            self.stiff.add_columns(q, &self.right, x);
            return;
        }
        let change = &mut self.change;
        change.fill(0.0);
        self.stiff.add_columns(q, &self.right, change);
        self.stiff.add_rates(q, change);
        x.iter_mut().zip(change).for_each(|(x, change)| *x += *change);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_invert_the_matrix_of_several_products() {
        // Columns in different places, one zero, and rows that see the rates.
        let columns = [[0.0, 0.0, 0.3, -2.0, 0.0], [0.0, 0.0, 4.0, 0.0, 1.5], [0.0; 5], [0.0, 0.0, 0.0, 0.7, -3.0]];
        let rows = [[2.0, 0.0, -1.0, 0.0, 0.5], [0.0, -3.0, 0.0, 0.4, 0.0], [1.0; 5], [0.6, 0.0, 0.0, -9.0, 0.0]];
        let mut solver = StiffSolver::new(5, 4);
        // Not in the order of the rows.
        solver.stiff.rates.extend([(1, 3, 0.8), (0, 2, 1.1), (1, 2, -0.4)]);
        let mut a = [[0.0; 5]; 5];
        solver.stiff.rates.iter().for_each(|(to, from, value)| a[*to][*from] = *value);
        for (column, row) in columns.iter().zip(&rows) {
            let (entries, u) = solver.stiff.add().unwrap();
            entries.extend(row.iter().copied().enumerate().filter(|(_, x)| *x != 0.0));
            u.copy_from_slice(column);
            for (i, u) in column.iter().enumerate() {
                a[i].iter_mut().zip(row).for_each(|(a, v)| *a += u * v);
            }
        }
        solver.stiff.complete();
        let q = 0.39;
        solver.factorize(q);
        let x = [0.3, -1.2, 2.0, 0.7, -0.1];
        let mut k = x;
        solver.solve(&mut k);
        for i in 0..5 {
            let product: f64 = a[i].iter().zip(&k).map(|(a, k)| a * k).sum();
            // Rounding.
            assert!((k[i] - q * product - x[i]).abs() < 1e-13, "{i}: {k:?}");
        }
    }
}
