//! Anderson's acceleration of a fixed-point iteration `x <- G(x)` [Walker 2011].
//!
//! With the changes dG and dr of the last results G(x) and of `r = G(x) - x`, the next point is
//! `G - dG c` with the c that minimizes `|r - dr c|`. It starts anew where |r| grows.

use crate::linalg::cholesky::Symmetric;
use crate::linalg::dot;
use nalgebra::Vector3;

/// Iterations that are combined.
const MEMORY: usize = 20;
/// Growth of |r| per iteration at which the acceleration starts anew.
const GROWS: f64 = 2.0;
/// Regularization of the least squares, relative: changes are nearly dependent near the solution.
const DEPENDENT: f64 = 1e-12;

/// The last iterations and the scratch of their combination.
#[derive(Clone, Debug)]
pub struct Anderson {
    /// Changes of G and r, one after the other; the oldest is replaced.
    results: Vec<f64>,
    residuals: Vec<f64>,
    count: usize,
    next: usize,
    /// The last G and r, and the size of r; none after a restart.
    last: Vec<f64>,
    last_residual: Vec<f64>,
    last_size: Option<f64>,
    point: Vec<f64>,
    /// Products of the changes of r, and their factor.
    gram: Vec<f64>,
    factor: Symmetric,
    coefficients: Vec<f64>,
}

impl Anderson {
    /// For points of at most `n` numbers.
    pub fn new(n: usize) -> Self {
        Anderson {
            results: vec![0.0; MEMORY * n],
            residuals: vec![0.0; MEMORY * n],
            count: 0,
            next: 0,
            last: Vec::with_capacity(n),
            last_residual: Vec::with_capacity(n),
            last_size: None,
            point: Vec::with_capacity(n),
            gram: vec![0.0; MEMORY * MEMORY],
            factor: Symmetric::zeros(MEMORY),
            coefficients: vec![0.0; MEMORY],
        }
    }

    /// Forgets all iterations.
    pub fn restart(&mut self) {
        (self.count, self.next, self.last_size) = (0, 0, None);
    }

    /// The next point after an iteration from x to G(x), given as pairs of three numbers each; none
    /// if it is G(x) itself.
    pub fn combine(&mut self, sequence: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)> + Clone) -> Option<&[f64]> {
        let size = sequence.clone().map(|(x, g)| (g - x).norm_squared()).sum::<f64>().sqrt();
        let n = 3 * sequence.clone().count();
        match self.last_size {
            Some(last) if size <= GROWS * last => {
                let at = self.next * n..(self.next + 1) * n;
                let results = self.results[at.clone()].chunks_exact_mut(3).zip(self.last.chunks_exact(3));
                let residuals = self.residuals[at].chunks_exact_mut(3).zip(self.last_residual.chunks_exact(3));
                for (((x, g), (dg, before)), (dr, residual)) in sequence.clone().zip(results).zip(residuals) {
                    for axis in 0..3 {
                        dg[axis] = g[axis] - before[axis];
                        dr[axis] = g[axis] - x[axis] - residual[axis];
                    }
                }
                self.count = (self.count + 1).min(MEMORY);
                let changes = self.residuals.chunks_exact(n).take(self.count);
                for (i, change) in changes.enumerate() {
                    let product = dot(change, &self.residuals[self.next * n..(self.next + 1) * n]);
                    self.gram[i * MEMORY + self.next] = product;
                    self.gram[self.next * MEMORY + i] = product;
                }
                self.next = (self.next + 1) % MEMORY;
            }
            Some(_) => self.restart(),
            None => {}
        }
        self.last_size = Some(size);
        self.last.clear();
        self.last_residual.clear();
        for (x, g) in sequence {
            self.last.extend_from_slice(g.as_slice());
            self.last_residual.extend_from_slice((g - x).as_slice());
        }
        let m = self.count;
        if m == 0 {
            return None;
        }
        self.factor.set_order(m);
        let trace: f64 = (0..m).map(|i| self.gram[i * MEMORY + i]).sum();
        for (i, row) in self.factor.entries.chunks_exact_mut(m).enumerate() {
            row.copy_from_slice(&self.gram[i * MEMORY..i * MEMORY + m]);
            row[i] += DEPENDENT * trace;
        }
        for (c, change) in self.coefficients.iter_mut().zip(self.residuals.chunks_exact(n)).take(m) {
            *c = dot(change, &self.last_residual);
        }
        if !self.factor.factorize() {
            self.restart();
            return None;
        }
        self.factor.solve(&mut self.coefficients[..m]);
        self.point.clear();
        self.point.extend_from_slice(&self.last);
        for (c, dg) in self.coefficients[..m].iter().zip(self.results.chunks_exact(n)) {
            self.point.iter_mut().zip(dg).for_each(|(x, dg)| *x -= c * dg);
        }
        Some(&self.point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_iteration_ends_in_as_many_steps_as_it_has_unknowns() {
        // x <- A x + b with eigenvalues up to 0.999: alone it gains a factor of 20 in 3000 steps.
        let rates = [0.999, 0.9, -0.8, 0.5, 0.99, 0.1];
        let map = |x: &[f64]| -> Vec<f64> { x.iter().zip(rates).map(|(x, a)| a * x + 1.0).collect() };
        let mut acceleration = Anderson::new(6);
        let mut x = vec![0.0; 6];
        for _ in 0..8 {
            let g = map(&x);
            let pairs = x.chunks(3).zip(g.chunks(3));
            let pairs = pairs.map(|(x, g)| (Vector3::from_column_slice(x), Vector3::from_column_slice(g)));
            let next = acceleration.combine(pairs).map(<[f64]>::to_vec);
            x = next.unwrap_or(g);
        }
        // Truth 1 / (1 - a). The regularization, 1e-12, times the square of the greatest ratio of
        // 1 - a, 900, times the truth.
        for (x, a) in x.iter().zip(rates) {
            assert!((x * (1.0 - a) - 1.0).abs() < 1e-6, "{x} for {a}");
        }
    }
}
