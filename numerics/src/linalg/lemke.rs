//! Lemke's pivoting algorithm for linear complementarity problems.
//!
//! ```text
//! w = M z + q,    w >= 0,  z >= 0,  w . z = 0
//! ```
//!
//! An artificial variable z0 makes `w = M z + q + z0` feasible. It enters the basis for the most
//! negative row. From then on the complement of the variable that left enters, until z0 leaves
//! (solved) or no row blocks (a ray). For copositive M, as in contact with friction, a ray means
//! that the constraints contradict each other.
//!
//! The dictionary (basic variables in terms of the others) is dense: n rows, n + 1 columns and the
//! constants. The singular matrices of four vertices on one sole cause ties of the ratio test. They
//! are broken lexicographically by the rows of the inverse basis, so that no basis recurs; z0
//! leaves whenever it can.
//!
//! Sources: [Lemke 1965]; [Cottle 1992], sections 4.4 and 4.9.

/// Least coefficient that blocks. Smaller ones are rounding of a singular matrix with entries of
/// order one, grown over some hundred pivots.
const LEAST_SLOPE: f64 = 1e-9;

/// Outcome of the algorithm.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum LemkeOutcome {
    /// A solution was found.
    Solved,
    /// Ended on a ray, without a solution.
    Ray,
    /// Ended after too many pivots.
    Limit,
}

/// The dictionary and its scratch, allocated once.
///
/// Variables are numbered: w_i is i, z_i is n + i, z0 is 2 n.
#[derive(Clone, Debug)]
pub struct Lemke {
    n: usize,
    /// n rows of n + 2: coefficients of the nonbasic variables, then the constant.
    table: Vec<f64>,
    basic: Vec<usize>,
    nonbasic: Vec<usize>,
    /// Position of each variable: row, or n + column.
    position: Vec<usize>,
    pivot_row: Vec<f64>,
    ties: Vec<usize>,
    /// Tie thresholds: between entries of the inverse basis, and between constants.
    tie: [f64; 2],
}

impl Lemke {
    /// Allocates for problems of at most `n` unknowns.
    pub fn new(n: usize) -> Self {
        Lemke {
            n: 0,
            table: vec![0.0; n * (n + 2)],
            basic: vec![0; n],
            nonbasic: vec![0; n + 1],
            position: vec![0; 2 * n + 1],
            pivot_row: vec![0.0; n + 2],
            ties: Vec::with_capacity(n),
            tie: [0.0; 2],
        }
    }

    /// Begins a problem of `n` unknowns with zero M and q.
    pub fn begin(&mut self, n: usize) {
        self.n = n;
        let stride = n + 2;
        self.table[..n * stride].fill(0.0);
        for i in 0..n {
            self.table[i * stride + n] = 1.0;
            (self.basic[i], self.nonbasic[i]) = (i, n + i);
            (self.position[i], self.position[n + i]) = (i, n + i);
        }
        self.nonbasic[n] = 2 * n;
        self.position[2 * n] = 2 * n;
    }

    /// Row `i` of M, n numbers, to be filled between [`begin`](Self::begin) and
    /// [`solve`](Self::solve).
    pub fn row(&mut self, i: usize) -> &mut [f64] {
        &mut self.table[i * (self.n + 2)..][..self.n]
    }

    /// Sets q_i.
    pub fn set_constant(&mut self, i: usize, q: f64) {
        self.table[(i + 1) * (self.n + 2) - 1] = q;
    }

    /// Solves; `z` is the solution, or zero. Ratios that differ by less than `tie`, relative to the
    /// constants, count as equal: a small one is accurate, a large one tolerates rounding. Returns
    /// the outcome and the number of pivots. M and q are overwritten.
    pub fn solve(&mut self, z: &mut [f64], tie: f64) -> (LemkeOutcome, usize) {
        let (n, stride) = (self.n, self.n + 2);
        z[..n].fill(0.0);
        let size = (0..n).map(|i| self.constant(i).abs()).fold(0.0, f64::max);
        self.tie = [tie, tie * size];
        // Of equally negative rows the last is lexicographically least.
        let Some(mut row) = (0..n).min_by(|&i, &j| self.constant(i).total_cmp(&self.constant(j)).then(j.cmp(&i)))
        else {
            return (LemkeOutcome::Solved, 0);
        };
        if self.constant(row) >= 0.0 {
            return (LemkeOutcome::Solved, 0);
        }
        let mut column = n;
        let limit = 50 * n + 100;
        for pivots in 1..=limit {
            let left = self.pivot(row, column);
            if left == 2 * n {
                for (i, &variable) in self.basic[..n].iter().enumerate() {
                    if variable >= n {
                        z[variable - n] = self.table[i * stride + n + 1].max(0.0);
                    }
                }
                return (LemkeOutcome::Solved, pivots);
            }
            let enters = if left < n { left + n } else { left - n };
            column = self.position[enters] - n;
            match self.blocking(column) {
                Some(blocking) => row = blocking,
                None => return (LemkeOutcome::Ray, pivots),
            }
        }
        (LemkeOutcome::Limit, limit)
    }

    fn constant(&self, i: usize) -> f64 {
        self.table[(i + 1) * (self.n + 2) - 1]
    }

    /// Row whose variable reaches zero first as that of `column` grows.
    fn blocking(&mut self, column: usize) -> Option<usize> {
        let (n, stride) = (self.n, self.n + 2);
        let mut least = f64::INFINITY;
        for i in 0..n {
            let slope = -self.table[i * stride + column];
            if slope > LEAST_SLOPE {
                least = least.min(self.constant(i).max(0.0) / slope);
            }
        }
        if least == f64::INFINITY {
            return None;
        }
        self.ties.clear();
        for i in 0..n {
            let slope = -self.table[i * stride + column];
            if slope > LEAST_SLOPE && self.constant(i).max(0.0) - least * slope <= self.tie[1] {
                if self.basic[i] == 2 * n {
                    return Some(i);
                }
                self.ties.push(i);
            }
        }
        // Rows that are not least are dropped, column by column of the inverse basis.
        for j in 0..n {
            if self.ties.len() == 1 {
                break;
            }
            let ratio = |i: usize| {
                let inverse = match self.position[j] {
                    row if row < n => f64::from(row == i),
                    at => -self.table[i * stride + at - n],
                };
                inverse / -self.table[i * stride + column]
            };
            let least = self.ties.iter().map(|&i| ratio(i)).fold(f64::INFINITY, f64::min);
            let mut kept = 0;
            for at in 0..self.ties.len() {
                let i = self.ties[at];
                if ratio(i) <= least + self.tie[0] * (1.0 + least.abs()) {
                    self.ties[kept] = i;
                    kept += 1;
                }
            }
            self.ties.truncate(kept);
        }
        self.ties.first().copied()
    }

    /// Exchanges the variables of a row and a column; returns the one that leaves the basis.
    fn pivot(&mut self, row: usize, column: usize) -> usize {
        let (n, stride) = (self.n, self.n + 2);
        let factor = 1.0 / self.table[row * stride + column];
        let pivot_row = &mut self.pivot_row[..stride];
        let own = &mut self.table[row * stride..(row + 1) * stride];
        own.iter_mut().for_each(|x| *x *= -factor);
        own[column] = factor;
        pivot_row.copy_from_slice(own);
        for (i, other) in self.table[..n * stride].chunks_exact_mut(stride).enumerate() {
            let x = std::mem::take(&mut other[column]);
            if i == row {
                other[column] = x;
            } else if x != 0.0 {
                other.iter_mut().zip(&*pivot_row).for_each(|(a, b)| *a += x * b);
            }
        }
        let (leaves, enters) = (self.basic[row], self.nonbasic[column]);
        (self.basic[row], self.nonbasic[column]) = (enters, leaves);
        (self.position[enters], self.position[leaves]) = (row, n + column);
        leaves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solve(m: &[&[f64]], q: &[f64]) -> (LemkeOutcome, Vec<f64>, usize) {
        let mut lemke = Lemke::new(q.len());
        lemke.begin(q.len());
        for (i, row) in m.iter().enumerate() {
            lemke.row(i).copy_from_slice(row);
            lemke.set_constant(i, q[i]);
        }
        let mut z = vec![0.0; q.len()];
        let (end, pivots) = lemke.solve(&mut z, 1e-12);
        (end, z, pivots)
    }

    #[test]
    fn textbook_problems_are_solved() {
        // Positive definite: unique solutions, by hand.
        let (end, z, _) = solve(&[&[2.0, 1.0], &[1.0, 2.0]], &[-5.0, -6.0]);
        assert_eq!(end, LemkeOutcome::Solved);
        assert!((z[0] - 4.0 / 3.0).abs() < 1e-15 && (z[1] - 7.0 / 3.0).abs() < 1e-15, "{z:?}");
        let (end, z, _) = solve(&[&[2.0, 1.0], &[1.0, 2.0]], &[-5.0, 6.0]);
        assert_eq!((end, z.as_slice()), (LemkeOutcome::Solved, &[2.5, 0.0][..]));
        // Nothing to do.
        assert_eq!(solve(&[&[2.0, 1.0], &[1.0, 2.0]], &[0.0, 6.0]), (LemkeOutcome::Solved, vec![0.0, 0.0], 0));
        // w1 = -z2 - 1 can never be feasible.
        assert_eq!(solve(&[&[0.0, -1.0], &[1.0, 0.0]], &[-1.0, 1.0]).0, LemkeOutcome::Ray);
    }

    /// [Murty 1978]: M lower triangular, 1 on and 2 below the diagonal, and -q_i = 2^n + 2^(n-1) +
    /// .. of i + 1 terms makes Lemke's path visit 2^n bases. Another pivot rule would take another
    /// number.
    #[test]
    fn murtys_problem_takes_two_to_the_n_pivots() {
        for n in 2..=6 {
            let m: Vec<Vec<f64>> =
                (0..n).map(|i| (0..n).map(|j| [2.0, 1.0, 0.0][(1 + j.cmp(&i) as i32) as usize]).collect()).collect();
            let q: Vec<f64> = (0..n).map(|i| -(0..=i).map(|k| f64::powi(2.0, (n - k) as i32)).sum::<f64>()).collect();
            let rows: Vec<&[f64]> = m.iter().map(Vec::as_slice).collect();
            let (end, z, pivots) = solve(&rows, &q);
            let mut truth = vec![0.0; n];
            truth[0] = f64::powi(2.0, n as i32);
            assert_eq!((end, z, pivots), (LemkeOutcome::Solved, truth, 1 << n));
        }
    }

    #[test]
    fn equal_rows_are_solved() {
        // Rank one, every ratio a tie: the load of one body on many equal points.
        for n in [2, 5, 12] {
            let m = vec![vec![1.0; n]; n];
            let rows: Vec<&[f64]> = m.iter().map(Vec::as_slice).collect();
            let (end, z, pivots) = solve(&rows, &vec![-1.0; n]);
            assert!(end == LemkeOutcome::Solved && pivots <= n + 1, "{end:?} {pivots}");
            assert_eq!(z.iter().sum::<f64>(), 1.0);
        }
    }
}
