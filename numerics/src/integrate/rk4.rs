//! The classical Runge-Kutta method of order 4, for fixed steps, with dense output of order 3.
//!
//! Source: [Kutta 1901]. A fifth evaluation at the end of the step gives the slope for the cubic
//! Hermite interpolant. Its error within a step is of order h^4 and vanishes towards the ends.

use super::runge_kutta::{DenseOutput, Tableau};

/// Tableau of the classical method of order 4.
pub static RK4: Tableau = Tableau {
    name: "rk4",
    order: 4,
    dense_order: 3,
    c: &[0.0, 1.0 / 2.0, 1.0 / 2.0, 1.0, 1.0],
    a: &[&[], &[1.0 / 2.0], &[0.0, 1.0 / 2.0], &[0.0, 0.0, 1.0], &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0]],
    error: &[],
    dense: DenseOutput::Hermite,
};
