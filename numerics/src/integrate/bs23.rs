//! Bogacki-Shampine 3(2) with dense output of order 3.
//!
//! Source: [Bogacki 1989]. The error is the difference to the embedded method of order 2, b* =
//! (7/24, 1/4, 1/3, 1/8). Between the ends the cubic Hermite interpolant has the order of the
//! solution.

use super::runge_kutta::{DenseOutput, Tableau};

/// Tableau of Bogacki and Shampine, order 3(2).
pub static BS23: Tableau = Tableau {
    name: "bs23",
    order: 3,
    dense_order: 3,
    c: &[0.0, 1.0 / 2.0, 3.0 / 4.0, 1.0],
    a: &[&[], &[1.0 / 2.0], &[0.0, 3.0 / 4.0], &[2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0]],
    error: &[-5.0 / 72.0, 1.0 / 12.0, 1.0 / 9.0, -1.0 / 8.0],
    dense: DenseOutput::Hermite,
};
