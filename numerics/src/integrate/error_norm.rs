//! Norm of the error of a step over groups of components.
//!
//! ```text
//! max over groups g of |e_g| / (absolute + relative max(|y_g|, |y1_g|))
//! ```
//!
//! with Euclidean norms over the components of a group, y at the start and y1 at the end of the
//! step. Components of one vector form a group, so that the norm does not depend on the axes in
//! which the vector is expressed.

use crate::math;
use std::ops::Range;

/// The error of a step in units of its tolerance. `error` gives its components, `ends` the solution
/// at both ends of the step. Infinite if an error is not finite.
pub fn error_norm(
    groups: impl Iterator<Item = Range<usize>>,
    (relative, absolute): (f64, f64),
    ends: [&[f64]; 2],
    error: impl Fn(usize) -> f64,
) -> f64 {
    let mut worst: f64 = 0.0;
    for group in groups {
        // The square root of a rounded square is exact.
        let is_single = group.len() == 1;
        let norm = |y: &[f64]| match &y[group.clone()] {
            [x] => x.abs(),
            all => all.iter().map(|x| x * x).sum::<f64>().sqrt(),
        };
        let squares = || group.clone().map(|i| math::powi(error(i), 2)).sum::<f64>();
        let e = if is_single { error(group.start).abs() } else { squares().sqrt() };
        if !e.is_finite() {
            return f64::INFINITY;
        }
        worst = worst.max(e / (absolute + relative * norm(ends[0]).max(norm(ends[1]))));
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_of_a_group_do_not_matter() {
        let (sin, cos) = 0.7f64.sin_cos();
        let turn = |v: [f64; 3]| [v[0] * cos - v[1] * sin, v[0] * sin + v[1] * cos, v[2]];
        let (y, y1, e) = ([3.0, -1.0, 0.2], [2.9, -1.5, 0.3], [2e-6, 5e-6, -1e-7]);
        let norm = |y: [f64; 3], y1: [f64; 3], e: [f64; 3]| {
            error_norm([0..2, 2..3].into_iter(), (1e-6, 1e-8), [&y, &y1], |i| e[i])
        };
        let (straight, turned) = (norm(y, y1, e), norm(turn(y), turn(y1), turn(e)));
        // Rounding.
        assert!((straight - turned).abs() < 1e-14 * straight, "{straight} {turned}");
        let expected = 29f64.sqrt() * 1e-6 / (1e-8 + 1e-6 * (2.9f64 * 2.9 + 1.5 * 1.5).sqrt().max(10f64.sqrt()));
        assert!((straight - expected).abs() < 1e-14 * straight, "{straight} {expected}");
        // Each group alone.
        assert_eq!(norm(y, y1, [0.0, 0.0, -1e-7]), 1e-7 / (1e-8 + 1e-6 * 0.3));
        assert_eq!(norm(y, y1, [0.0, f64::NAN, 0.0]), f64::INFINITY);
    }
}
