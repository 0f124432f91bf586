//! The discrete algebraic Riccati equation of a system of order 4 with one input.
//!
//! ```text
//! P = A^T P A - A^T P b (R + b^T P b)^-1 b^T P A + Q
//! ```
//!
//! solved by the structure-preserving doubling algorithm
//!
//! ```text
//! A' = A W A,   G' = G + A W G A^T,   H' = H + A^T H W A,   W = (1 + G H)^-1;   H -> P
//! ```
//!
//! from `A, G = b b^T / R, H = Q`, which squares the closed loop in each step. Source: [Chu 2004],
//! section 3.

use nalgebra::{Matrix4, Vector4};

/// Greatest number of doublings. Each squares the closed loop, so 30 amount to 1e9 steps.
const MOST_DOUBLINGS: usize = 30;

/// The stabilising P and its residual, relative to its greatest entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Solution P.
    pub p: Matrix4<f64>,
    /// Greatest entry of the right side less the left, relative to the greatest of P.
    pub residual: f64,
}

/// Feedback gain `(R + b^T P b)^-1 b^T P A` as a column.
pub fn gain(a: &Matrix4<f64>, b: &Vector4<f64>, r: f64, p: &Matrix4<f64>) -> Vector4<f64> {
    a.transpose() * p * b / (r + (b.transpose() * p * b)[0])
}

/// Solves the equation; `None` if the doubling does not converge (no stabilising solution, or
/// numbers out of range).
pub fn solve(a: &Matrix4<f64>, b: &Vector4<f64>, q: &Matrix4<f64>, r: f64) -> Option<Solution> {
    let (mut ak, mut g, mut h) = (*a, b * b.transpose() / r, *q);
    for _ in 0..MOST_DOUBLINGS {
        let w = (Matrix4::identity() + g * h).lu().try_inverse()?;
        let next = h + ak.transpose() * h * w * ak;
        g += ak * w * g * ak.transpose();
        ak = ak * w * ak;
        let change = (next - h).abs().max();
        h = (next + next.transpose()) * 0.5;
        if change <= 1e-15 * h.abs().max() {
            break;
        }
    }
    // Newton steps remove the rounding of the doubling.
    for _ in 0..2 {
        let k = gain(a, b, r, &h);
        h = lyapunov(a - b * k.transpose(), k * k.transpose() * r + q);
    }
    let residual = residual(a, b, q, r, &h);
    (residual < SOLVED).then_some(Solution { p: h, residual })
}

/// Residual above which a solution is rejected.
const SOLVED: f64 = 1e-10;

/// `P = A^T P A + Q` for a stable A, by doubling: a step of Newton's method for the Riccati
/// equation when A is the closed loop and Q its cost.
fn lyapunov(mut a: Matrix4<f64>, mut p: Matrix4<f64>) -> Matrix4<f64> {
    for _ in 0..MOST_DOUBLINGS {
        let term = a.transpose() * p * a;
        p += term;
        a *= a;
        if term.abs().max() <= 1e-17 * p.abs().max() {
            break;
        }
    }
    (p + p.transpose()) * 0.5
}

/// Residual of the equation at `p`, relative to its greatest entry.
pub fn residual(a: &Matrix4<f64>, b: &Vector4<f64>, q: &Matrix4<f64>, r: f64, p: &Matrix4<f64>) -> f64 {
    let k = gain(a, b, r, p);
    let right = a.transpose() * p * (a - b * k.transpose()) + q;
    (right - p).abs().max() / p.abs().max()
}
