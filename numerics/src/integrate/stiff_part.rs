//! The stiff part of a Jacobian, of low rank, for [`StiffSolver`](super::StiffSolver), whose symbols it has.

use crate::math;
use std::ops::Range;

/// Index and value of the entries of a row that are not zero.
pub type SparseRow = Vec<(usize, f64)>;

/// The stiff part of a Jacobian, a sum of products of a column and a row, and rates of positions.
#[derive(Clone, Debug)]
pub struct StiffPart {
    /// Columns u_r, each as long as the system.
    columns: Vec<Vec<f64>>,
    /// Where the columns in use are not zero.
    ranges: Vec<Range<usize>>,
    /// Rows v_r.
    pub(super) rows: Vec<SparseRow>,
    /// Number of products in use.
    pub(super) rank: usize,
    /// N: entries with row, column and value. No column is the row of another.
    pub rates: Vec<(usize, usize, f64)>,
    /// Where the entries of each row begin; one more than there are rows.
    first_rates: Vec<usize>,
    /// T, as long as the system; empty if it is zero.
    pub by_time: Vec<f64>,
    /// U by rows.
    by_equation: Vec<f64>,
    /// V^T U and V^T N U, by rows.
    pub(super) products: [Vec<f64>; 2],
    /// Number of equations.
    n: usize,
    /// Vectors of a power iteration.
    iterates: [Vec<f64>; 2],
}

impl StiffPart {
    /// An empty part of systems of `n` equations, with room for `rank` products.
    pub fn new(n: usize, rank: usize) -> Self {
        StiffPart {
            columns: vec![vec![0.0; n]; rank],
            ranges: Vec::with_capacity(rank),
            // A clone of an empty list has no room.
            rows: (0..rank).map(|_| Vec::with_capacity(n)).collect(),
            rank: 0,
            rates: Vec::with_capacity(2 * n),
            first_rates: vec![0; n + 1],
            by_time: Vec::with_capacity(n),
            by_equation: Vec::with_capacity(n * rank),
            products: [Vec::with_capacity(rank * rank), Vec::with_capacity(rank * rank)],
            n,
            iterates: [Vec::with_capacity(rank), Vec::with_capacity(rank)],
        }
    }

    /// Makes room for `rank` products.
    pub(super) fn reserve(&mut self, rank: usize) {
        let n = self.n;
        while self.columns.len() < rank {
            self.columns.push(vec![0.0; n]);
            self.rows.push(Vec::with_capacity(n));
        }
        self.by_equation.reserve((n * rank).saturating_sub(self.by_equation.len()));
        self.ranges.reserve(rank.saturating_sub(self.ranges.len()));
        self.products.iter_mut().for_each(|list| list.reserve((rank * rank).saturating_sub(list.len())));
        self.iterates.iter_mut().for_each(|list| list.reserve(rank.saturating_sub(list.len())));
    }

    /// Removes all products, N and T.
    pub fn clear(&mut self) {
        self.rank = 0;
        self.rates.clear();
        self.by_time.clear();
    }

    /// Adds `factor` times the column of a product to T.
    pub fn add_by_time(&mut self, r: usize, factor: f64) {
        let column = &self.columns[r];
        self.by_time.resize(column.len(), 0.0);
        self.by_time.iter_mut().zip(column).for_each(|(t, u)| *t += factor * u);
    }

    /// Keeps the first products.
    pub fn truncate(&mut self, rank: usize) {
        self.rank = self.rank.min(rank);
    }

    /// Number of products.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Adds a product of zeros and returns its row and its column; none if there is no room.
    pub fn add(&mut self) -> Option<(&mut SparseRow, &mut [f64])> {
        let (row, column) = (self.rows.get_mut(self.rank)?, &mut self.columns[self.rank]);
        self.rank += 1;
        row.clear();
        column.fill(0.0);
        Some((row, column))
    }

    /// Row and column of a product.
    pub fn product(&mut self, r: usize) -> (&mut SparseRow, &mut [f64]) {
        (&mut self.rows[r], &mut self.columns[r])
    }

    /// Computes the products of rows and columns; needed after all were set.
    pub fn complete(&mut self) {
        self.ranges.clear();
        self.ranges.extend(self.columns[..self.rank].iter().map(|column| {
            let first = column.iter().position(|x| *x != 0.0).unwrap_or(column.len());
            first..column.iter().rposition(|x| *x != 0.0).map_or(first, |last| last + 1)
        }));
        if !self.rates.is_sorted_by_key(|(to, _, _)| *to) {
            self.rates.sort_unstable_by_key(|(to, from, _)| (*to, *from));
        }
        self.first_rates.fill(0);
        self.rates.iter().for_each(|(to, _, _)| self.first_rates[to + 1] += 1);
        (0..self.n).for_each(|i| self.first_rates[i + 1] += self.first_rates[i]);
        let n = self.rank;
        self.by_equation.clear();
        self.by_equation.resize(self.n * n, 0.0);
        for (c, (column, range)) in self.columns.iter().zip(&self.ranges).enumerate() {
            range.clone().for_each(|i| self.by_equation[i * n + c] = column[i]);
        }
        let add = |sums: &mut [f64], i: usize, x: f64| {
            sums.iter_mut().zip(&self.by_equation[i * n..(i + 1) * n]).for_each(|(sum, u)| *sum += x * u);
        };
        let [direct, by_rates] = &mut self.products;
        for list in [&mut *direct, &mut *by_rates] {
            list.clear();
            list.resize(n * n, 0.0);
        }
        let rows = direct.chunks_exact_mut(n.max(1)).zip(by_rates.chunks_exact_mut(n.max(1)));
        for (row, (direct, by_rates)) in self.rows.iter().zip(rows) {
            for &(i, x) in row {
                add(direct, i, x);
                let rates = &self.rates[self.first_rates[i]..self.first_rates[i + 1]];
                rates.iter().for_each(|(_, from, value)| add(by_rates, *from, value * x));
            }
        }
    }

    /// Upper bound of the modulus of the eigenvalues of the products, 1/s: the norm of V^T U. Needs
    /// [`complete`](Self::complete).
    pub fn rate(&self) -> f64 {
        let square = |row: &[f64]| row.iter().map(|direct| math::powi(*direct, 2)).sum::<f64>();
        self.products[0].chunks(self.rank.max(1)).map(square).sum::<f64>().sqrt()
    }

    /// Estimate of the modulus of the eigenvalues of A, 1/s, from those of `V^T U` and `V^T N U`, d and k: the greater
    /// root of `x^2 = d x + k`. Needs [`complete`](Self::complete).
    pub fn rate_bound(&mut self) -> f64 {
        let [d, k] = [0, 1].map(|part| self.greatest_eigenvalue(part));
        0.5 * (d + (d * d + 4.0 * k).sqrt())
    }

    /// Modulus of the greatest eigenvalue of `V^T U` (0) or `V^T N U` (1), after some power iterations.
    fn greatest_eigenvalue(&mut self, part: usize) -> f64 {
        let n = self.rank;
        let [x, y] = &mut self.iterates;
        x.clear();
        x.extend((0..n).map(|i| 1.0 + i as f64 / n as f64));
        let mut value = 0.0;
        for _ in 0..6 {
            let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(length > 0.0) {
                return value;
            }
            let row = |r: usize| (0..n).map(|c| self.products[part][r * n + c] * x[c]).sum::<f64>() / length;
            y.clear();
            y.extend((0..n).map(row));
            std::mem::swap(x, y);
            value = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        }
        value
    }

    /// Adds `factor * U weights` to `out`. Needs [`complete`](Self::complete).
    pub(super) fn add_columns(&self, factor: f64, weights: &[f64], out: &mut [f64]) {
        for ((weight, column), range) in weights.iter().zip(&self.columns).zip(&self.ranges) {
            let weight = factor * weight;
            out[range.clone()].iter_mut().zip(&column[range.clone()]).for_each(|(out, u)| *out += weight * u);
        }
    }

    /// Replaces x by `(1 + factor N) x`.
    pub(super) fn add_rates(&self, factor: f64, x: &mut [f64]) {
        self.rates.iter().for_each(|(to, from, value)| x[*to] += factor * value * x[*from]);
    }
}

pub(super) fn sparse_dot(row: &[(usize, f64)], x: &[f64]) -> f64 {
    row.iter().map(|(i, v)| v * x[*i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_bound_is_that_of_springs_and_dampers() {
        for (w, z) in [(100.0, 0.0), (100.0, 50.0)] {
            let mut part = StiffPart::new(2, 1);
            part.rates.push((0, 1, 1.0));
            let (row, column) = part.add().unwrap();
            row.extend([(0, w * w), (1, 2.0 * z * w)]);
            column.copy_from_slice(&[0.0, -1.0]);
            part.complete();
            // The greater root of x^2 = 2 z w x + w^2, at most 1 + 1/(4 z^2) of the fastest eigenvalue.
            let bound = z * w + (z * z * w * w + w * w).sqrt();
            assert!((part.rate_bound() / bound - 1.0).abs() < 1e-12);
        }
    }
}
