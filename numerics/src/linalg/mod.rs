//! Dense linear algebra of small systems that nalgebra does not provide: solves with redundant
//! rows, in-place Cholesky, the discrete Riccati equation, Lemke's method for linear
//! complementarity problems, and the acceleration of fixed-point iterations.
//!
//! Imports: no other room. Used by: `contact`, `task`.

pub mod anderson;
pub mod cholesky;
pub mod lemke;
pub mod linear;
pub mod riccati;

/// Length from which sums are split.
const LONG: usize = 32;

/// `a . b` of the shorter length. Long ones are added in four partial sums, as additions would wait for each other.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    if n < LONG {
        return a.iter().zip(b).map(|(a, b)| a * b).sum();
    }
    let (a, a_rest) = a[..n].as_chunks::<4>();
    let (b, b_rest) = b[..n].as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
