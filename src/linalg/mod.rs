//! Dense linear algebra of small systems that nalgebra does not have: solves with redundant rows, in-place Cholesky,
//! the discrete Riccati equation, and Lemke's method for linear complementarity problems.
//!
//! Imports nothing of this crate. `contact` and `task` call it.

pub mod cholesky;
pub mod lemke;
pub mod linear;
pub mod riccati;
