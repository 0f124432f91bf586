//! The classical Runge-Kutta method of order 4, for fixed steps, with dense output of order 3.
//!
//! Source: Kutta, Beitrag zur naeherungsweisen Integration totaler Differentialgleichungen, Z. Math. Phys. 46 (1901). A fifth
//! evaluation at the end of the step gives the slope for the cubic of Hermite, whose error within a step, of the order h^4,
//! vanishes towards its ends.

use super::runge_kutta::{DenseOutput, Tableau};

/// See the module.
pub static RK4: Tableau = Tableau {
    name: "rk4",
    order: 4,
    dense_order: 3,
    c: &[0.0, 1.0 / 2.0, 1.0 / 2.0, 1.0, 1.0],
    a: &[&[], &[1.0 / 2.0], &[0.0, 1.0 / 2.0], &[0.0, 0.0, 1.0], &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0]],
    error: &[],
    dense: DenseOutput::Hermite,
};
