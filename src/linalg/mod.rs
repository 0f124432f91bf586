//! Dense linear algebra of small systems that nalgebra does not provide: solves with redundant
//! rows, in-place Cholesky, the discrete Riccati equation, Lemke's method for linear
//! complementarity problems, and the acceleration of fixed-point iterations.
//!
//! Imports: nothing of this crate. Used by: `contact`, `task`.

pub mod anderson;
pub mod cholesky;
pub mod lemke;
pub mod linear;
pub mod riccati;
