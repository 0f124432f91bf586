//! Dense linear solve with redundant constraints: complete pivoting, least-norm solution.
//!
//! Gaussian elimination with complete pivoting on a small square system. Pivots below `RANK` times
//! the largest count as zero. A consistent redundant system has many solutions; the one of least
//! norm is returned. The resulting motions do not depend on which redundant rows were dropped, and
//! the solution does not depend on the order of the unknowns.
//!
//! With the pivoted factors U = [U_1 U_2] of rank r, the null space is spanned by the columns of
//! [-Z; 1], `U_1 Z = U_2`, and the least-norm solution of the basic one (x_b, 0) is
//! `(x_b - Z y, y)`, `(1 + Z^T Z) y = Z^T x_b`.
//!
//! A symmetric matrix that is clearly positive definite has no redundant rows. It is factorised
//! without a search for pivots, `A = U^T D^-1 U` with the pivots D on the diagonal of U. The first
//! pivot that is not clearly positive ends this, and the matrix is factorised as any other. So is a
//! matrix that is expected to be regular, if pivots sought within their columns come near zero.
//!
//! Pivots in a fixed order may all be clearly positive although the matrix is singular: where the last entries
//! of a null vector are small, each pivot is only as small as the square of the ratio of two of them. If some
//! pivot is small, a vector z with `U z = D s`, s of 1 and -1, is therefore computed from its last entry on, with
//! signs that let it grow. As `z^T A z = s^T D s`, the least eigenvalue is at most `n max(D) / |z|^2`.

use super::{LONG, dot};

/// Pivot, relative to the first, under which a row counts as redundant. Rounding of a 12 x 12
/// elimination stays near 1e-14; closed kinematic loops of real robots have pivots above 1e-9.
const RANK: f64 = 1e-12;

/// Pivot, relative to the first, up to which a row is nearly redundant. In closed loops the digits of a robot file, such
/// as an angle of pi with 9 of them, keep pivots from zero: forces without bound then resist what no digit shows.
pub const NEARLY_REDUNDANT: f64 = 1e-6;

/// Pivot, relative to the greatest diagonal entry, above which a symmetric matrix is clearly
/// definite, or relative to the greatest pivot, above which a matrix is clearly regular. It is far
/// above [`RANK`], as pivots in a fixed order indicate the rank only roughly.
const CLEAR: f64 = 1e-8;

/// Pivot, relative to the greatest diagonal entry, below which the least eigenvalue of a matrix is estimated.
const SMALL: f64 = 1e-3;

/// Kind of the last factorisation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Factors {
    /// Complete pivoting, factors in the caller's matrix.
    Complete,
    /// Of a definite matrix, in `copy`.
    Definite,
    /// Pivots within columns, in `copy`.
    Regular,
}

/// Scratch for systems up to a given size, and the last factorisation.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Unknown of each column after pivoting.
    column: Vec<usize>,
    /// Row that was exchanged with row k at step k.
    row: Vec<usize>,
    rank: usize,
    /// Pivot, relative to the first, up to which rows count as redundant, and the least above it.
    redundant: f64,
    least: f64,
    factors: Factors,
    /// Factors of a definite or regular matrix, row-major, and the inverses of the pivots.
    copy: Vec<f64>,
    inverse: Vec<f64>,
    scratch: Vec<f64>,
    /// Z, one column after the other, and 1 + Z^T Z.
    null: Vec<f64>,
    gram: Vec<f64>,
}

impl Linear {
    /// Allocates for systems of at most `n` unknowns.
    pub fn new(n: usize) -> Self {
        Linear {
            column: vec![0; n],
            row: vec![0; n],
            rank: 0,
            redundant: RANK,
            least: 1.0,
            factors: Factors::Complete,
            copy: vec![0.0; n * n],
            inverse: vec![0.0; n],
            scratch: vec![0.0; n],
            null: vec![0.0; n * n],
            gram: vec![0.0; n * n],
        }
    }

    /// Rank of the last matrix.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Whether the last matrix had rows that were nearly redundant, and did not count as redundant.
    pub fn has_nearly_redundant(&self) -> bool {
        self.least <= NEARLY_REDUNDANT
    }

    /// Whether rows of the next matrices that are nearly redundant count as redundant.
    pub fn drop_nearly_redundant(&mut self, drop: bool) {
        self.redundant = if drop { NEARLY_REDUNDANT } else { RANK };
    }

    /// Solves `A x = b` in place: `a` is n x n row-major and becomes its factors, `b` becomes x.
    /// Returns the rank.
    pub fn solve(&mut self, a: &mut [f64], b: &mut [f64]) -> usize {
        self.factor(a, b.len());
        self.apply(a, b);
        self.rank
    }

    /// As [`solve`](Self::solve), for a symmetric matrix, of which a clearly definite one stays
    /// unchanged.
    pub fn solve_symmetric(&mut self, a: &mut [f64], b: &mut [f64]) -> usize {
        if !self.factor_definite(a, b.len()) {
            self.factor(a, b.len());
        }
        self.apply(a, b);
        self.rank
    }

    /// As [`solve`](Self::solve), cheaper for a matrix that is clearly regular; it stays unchanged.
    pub fn solve_regular(&mut self, a: &mut [f64], b: &mut [f64]) -> usize {
        if !self.factor_regular(a, b.len()) {
            self.factor(a, b.len());
        }
        self.apply(a, b);
        self.rank
    }

    /// Factors a matrix into `copy`, with pivots sought within their columns. Returns whether it is
    /// clearly regular.
    fn factor_regular(&mut self, a: &[f64], n: usize) -> bool {
        let copy = &mut self.copy[..n * n];
        copy.copy_from_slice(a);
        let (mut least, mut greatest) = (f64::INFINITY, 0f64);
        for k in 0..n {
            let size = |i: usize| copy[i * n + k].abs();
            let pivot = (k + 1..n).fold(k, |best, i| if size(i) > size(best) { i } else { best });
            (least, greatest) = (least.min(size(pivot)), greatest.max(size(pivot)));
            if !(least > CLEAR * greatest) {
                return false;
            }
            self.row[k] = pivot;
            let (above, below) = copy.split_at_mut((k + 1) * n);
            let pivot_row = &mut above[k * n..];
            if pivot != k {
                pivot_row.swap_with_slice(&mut below[(pivot - k - 1) * n..][..n]);
            }
            self.inverse[k] = 1.0 / pivot_row[k];
            for row in below.chunks_exact_mut(n) {
                let f = row[k] * self.inverse[k];
                row[k] = f;
                row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]).for_each(|(x, p)| *x -= f * p);
            }
        }
        (self.rank, self.factors, self.least) = (n, Factors::Regular, 1.0);
        true
    }

    /// Solves with the factors of a regular matrix, in place.
    fn apply_regular(&self, b: &mut [f64]) {
        let n = b.len();
        (0..n).for_each(|k| b.swap(k, self.row[k]));
        for k in 1..n {
            b[k] -= dot(&self.copy[k * n..k * n + k], &b[..k]);
        }
        for k in (0..n).rev() {
            let sum = dot(&self.copy[k * n + k + 1..(k + 1) * n], &b[k + 1..]);
            b[k] = (b[k] - sum) * self.inverse[k];
        }
    }

    /// Factors a symmetric matrix into `copy`. Returns whether it is clearly positive definite.
    fn factor_definite(&mut self, a: &[f64], n: usize) -> bool {
        let upper = &mut self.copy[..n * n];
        upper.copy_from_slice(a);
        let least = CLEAR * (0..n).map(|k| a[k * n + k]).fold(0.0, f64::max);
        let inverse = &mut self.inverse[..n];
        let definite = match n {
            6 => eliminate_definite(upper.as_chunks_mut::<6>().0, inverse, least),
            12 => eliminate_definite(upper.as_chunks_mut::<12>().0, inverse, least),
            _ => eliminate_definite_of_any_order(upper, inverse, least),
        };
        let definite = definite && !is_nearly_singular(upper, inverse, least, &mut self.scratch[..n]);
        if definite {
            (self.rank, self.factors, self.least) = (n, Factors::Definite, 1.0);
        }
        definite
    }

    /// Solves `U^T D^-1 U x = b` in place.
    fn apply_definite(&self, b: &mut [f64]) {
        let n = b.len();
        match n {
            6 => solve_transposed(self.copy.as_chunks::<6>().0, &self.inverse, b),
            12 => solve_transposed(self.copy.as_chunks::<12>().0, &self.inverse, b),
            _ => {
                for k in 0..n {
                    b[k] *= self.inverse[k];
                    let (done, rest) = b.split_at_mut(k + 1);
                    let row = &self.copy[k * n + k + 1..(k + 1) * n];
                    rest.iter_mut().zip(row).for_each(|(b, u)| *b -= u * done[k]);
                }
            }
        }
        for k in (0..n).rev() {
            b[k] -= dot(&self.copy[k * n + k + 1..(k + 1) * n], &b[k + 1..]) * self.inverse[k];
        }
    }

    /// Factors `a`, n x n row-major, in place.
    pub fn factor(&mut self, a: &mut [f64], n: usize) {
        self.factors = Factors::Complete;
        let column = &mut self.column[..n];
        column.iter_mut().enumerate().for_each(|(i, c)| *c = i);
        (self.rank, self.least) = (n, 1.0);
        let mut first = 0.0;
        // Greatest entry of each row that is left.
        let greatest = &mut self.scratch[..n];
        greatest.iter_mut().zip(a.chunks_exact(n.max(1))).for_each(|(g, row)| *g = largest(row));
        for k in 0..n {
            let (mut pi, mut best) = (k, 0.0);
            for (i, g) in greatest.iter().enumerate().skip(k) {
                if *g > best {
                    (pi, best) = (i, *g);
                }
            }
            let pj = a[pi * n + k..(pi + 1) * n].iter().position(|x| x.abs() == best).map_or(k, |j| k + j);
            if k == 0 {
                first = best;
            }
            if best <= self.redundant * first || best == 0.0 {
                self.rank = k;
                break;
            }
            self.least = best / first;
            self.row[k] = pi;
            if pi != k {
                for j in 0..n {
                    a.swap(k * n + j, pi * n + j);
                }
                greatest[pi] = greatest[k];
            }
            if pj != k {
                for i in 0..n {
                    a.swap(i * n + k, i * n + pj);
                }
                column.swap(k, pj);
            }
            let inverse = 1.0 / a[k * n + k];
            let (upper, lower) = a.split_at_mut((k + 1) * n);
            let pivot_row = &upper[k * n + k + 1..(k + 1) * n];
            for (row, g) in lower.chunks_exact_mut(n).zip(&mut greatest[k + 1..]) {
                let f = row[k] * inverse;
                row[k] = f;
                // Otherwise the row stays as it is.
                if f != 0.0 {
                    row[k + 1..].iter_mut().zip(pivot_row).for_each(|(x, p)| *x -= f * p);
                    *g = largest(&row[k + 1..]);
                }
            }
        }
    }

    /// Solves with the factors that [`factor`](Self::factor) left in `a`: `b` becomes x.
    pub fn apply(&mut self, a: &[f64], b: &mut [f64]) {
        match self.factors {
            Factors::Complete => self.apply_complete(a, b),
            Factors::Definite => self.apply_definite(b),
            Factors::Regular => self.apply_regular(b),
        }
    }

    fn apply_complete(&mut self, a: &[f64], b: &mut [f64]) {
        let (n, rank) = (b.len(), self.rank);
        // The multipliers were exchanged along with their rows.
        (0..rank).for_each(|k| b.swap(k, self.row[k]));
        for k in 1..rank {
            // Small systems are solved entry by entry, the same up to rounding.
            if n < LONG {
                for j in 0..k {
                    b[k] -= a[k * n + j] * b[j];
                }
            } else {
                b[k] -= dot(&a[k * n..k * n + k], &b[..k]);
            }
        }
        b[rank..].fill(0.0);
        for k in (0..rank).rev() {
            let sum = dot(&a[k * n + k + 1..k * n + rank], &b[k + 1..rank]);
            b[k] = (b[k] - sum) / a[k * n + k];
        }
        if rank < n {
            self.least_norm(a, b);
        }
        let x = &mut self.scratch[..n];
        for (k, &c) in self.column[..n].iter().enumerate() {
            x[c] = b[k];
        }
        b.copy_from_slice(x);
    }

    /// Turns the basic solution `b` (in pivoted order) into that of least norm.
    fn least_norm(&mut self, a: &[f64], b: &mut [f64]) {
        let (n, rank) = (b.len(), self.rank);
        let free = n - rank;
        let (x, y) = b.split_at_mut(rank);
        for f in 0..free {
            let z = &mut self.null[f * rank..(f + 1) * rank];
            for k in (0..rank).rev() {
                let row = &a[k * n..(k + 1) * n];
                z[k] = (row[rank + f] - dot(&row[k + 1..rank], &z[k + 1..])) / row[k];
            }
        }
        let z = |f: usize| &self.null[f * rank..(f + 1) * rank];
        for (f, y) in y.iter_mut().enumerate() {
            *y = dot(z(f), x);
            (0..free).for_each(|g| self.gram[f * free + g] = f64::from(u8::from(f == g)) + dot(z(f), z(g)));
        }
        cholesky_solve(&mut self.gram[..free * free], y);
        for (f, y) in y.iter().enumerate() {
            x.iter_mut().zip(&self.null[f * rank..]).for_each(|(x, z)| *x -= z * y);
        }
    }
}

/// Whether a matrix with these pivots and rows U is found to have an eigenvalue under `least`, [`CLEAR`] times its
/// greatest diagonal entry; see the module. `z` is scratch.
fn is_nearly_singular(upper: &[f64], inverse: &[f64], least: f64, z: &mut [f64]) -> bool {
    let n = inverse.len();
    let smallest = 1.0 / inverse.iter().fold(0.0, |most: f64, x| most.max(*x));
    if smallest > SMALL * least / CLEAR {
        return false;
    }
    for k in (0..n).rev() {
        let sum = dot(&upper[k * n + k + 1..(k + 1) * n], &z[k + 1..]) * inverse[k];
        z[k] = -(sum + 1f64.copysign(sum));
    }
    // No pivot exceeds its diagonal entry.
    CLEAR * dot(z, z) > n as f64
}

/// Greatest size of the entries of a row.
fn largest(row: &[f64]) -> f64 {
    let (chunks, rest) = row.as_chunks::<4>();
    let mut most = [0.0; 4];
    let keep = |most: &mut f64, x: f64| *most = if x > *most { x } else { *most };
    for chunk in chunks {
        most.iter_mut().zip(chunk).for_each(|(most, x)| keep(most, x.abs()));
    }
    rest.iter().for_each(|x| keep(&mut most[0], x.abs()));
    most.into_iter().fold(0.0, f64::max)
}

/// Replaces a symmetric matrix by U on and above the diagonal, and writes the inverses of the pivots.
/// Returns whether all pivots exceed `least`.
///
/// Below the diagonal numbers without meaning result: rows of constant length stay in registers.
fn eliminate_definite<const N: usize>(rows: &mut [[f64; N]], inverse: &mut [f64], least: f64) -> bool {
    for (k, inverse) in inverse.iter_mut().enumerate() {
        let pivot_row = rows[k];
        if !(pivot_row[k] > least) {
            return false;
        }
        *inverse = 1.0 / pivot_row[k];
        for (row, x) in rows[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
            let f = x * *inverse;
            row.iter_mut().zip(&pivot_row).for_each(|(x, p)| *x -= f * p);
        }
    }
    true
}

/// Solves `U^T D^-1 x = b` in place, `rows` of [`eliminate_definite`].
fn solve_transposed<const N: usize>(rows: &[[f64; N]], inverse: &[f64], b: &mut [f64]) {
    // Numbers before the present one have no meaning in `rest`.
    let mut rest: [f64; N] = std::array::from_fn(|i| b[i]);
    for (k, ((b, row), inverse)) in b.iter_mut().zip(rows).zip(inverse).enumerate() {
        let x = rest[k] * inverse;
        *b = x;
        rest.iter_mut().zip(row).for_each(|(rest, u)| *rest -= u * x);
    }
}

/// As [`eliminate_definite`], without writing below the diagonal. Zeros at the ends of rows are skipped:
/// contacts of a stack act on their neighbours only.
fn eliminate_definite_of_any_order(upper: &mut [f64], inverse: &mut [f64], least: f64) -> bool {
    let n = inverse.len();
    for (k, inverse) in inverse.iter_mut().enumerate() {
        let (above, below) = upper.split_at_mut((k + 1) * n);
        let pivot_row = &above[k * n..];
        if !(pivot_row[k] > least) {
            return false;
        }
        *inverse = 1.0 / pivot_row[k];
        let end = pivot_row.iter().rposition(|x| *x != 0.0).map_or(k, |last| last + 1);
        for (i, row) in below.chunks_exact_mut(n).enumerate().map(|(i, row)| (k + 1 + i, row)).take(end - k - 1) {
            let f = pivot_row[i] * *inverse;
            row[i..end].iter_mut().zip(&pivot_row[i..end]).for_each(|(x, p)| *x -= f * p);
        }
    }
    true
}

/// Solves `G y = b` in place for a symmetric positive definite G, n x n.
fn cholesky_solve(g: &mut [f64], b: &mut [f64]) {
    let n = b.len();
    for k in 0..n {
        for i in k..n {
            let sum: f64 = (0..k).map(|j| g[i * n + j] * g[k * n + j]).sum();
            let rest = g[i * n + k] - sum;
            g[i * n + k] = if i == k { rest.sqrt() } else { rest / g[k * n + k] };
        }
    }
    for k in 0..n {
        let sum: f64 = (0..k).map(|j| g[k * n + j] * b[j]).sum();
        b[k] = (b[k] - sum) / g[k * n + k];
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| g[j * n + k] * b[j]).sum();
        b[k] = (b[k] - sum) / g[k * n + k];
    }
}

#[cfg(test)]
mod tests;
