//! What the data determine: singular directions of the Jacobian, standard errors and correlations.
//!
//! ```text
//! J = Q R,  R = U S V^T                      columns of J per relative change of each parameter
//! C = sum over determined k of v_k v_k^T / s_k^2
//! ```
//!
//! A direction `v_k` is not determined if
//!
//! - `s_k` is below the error of `J`, which is the difference of two Jacobians with different steps: or
//! - its standard error `1 / s_k` exceeds the whole range that the bounds leave along it.
//!
//! A parameter with a part in such a direction has no standard error.

// Products are of a matrix with a vector, or of two vectors: nalgebra adds them in one order on every processor.
#![allow(clippy::disallowed_types)]

use nalgebra::{DMatrix, DVector};

/// The least part of a parameter in a direction that is not determined, for which it counts as not
/// determined.
const PART: f64 = 0.01;

/// What a Jacobian determines. Indices are those of its columns.
#[derive(Clone, Debug)]
pub struct Determined {
    /// Covariance of the scaled parameters, of noise of variance 1.
    pub covariance: DMatrix<f64>,
    /// Whether each parameter is determined.
    pub parameters: Vec<bool>,
    /// Directions that are not determined, of length 1, the greatest part positive, with their
    /// singular values.
    pub blind: Vec<(Vec<f64>, f64)>,
    /// Greatest singular value.
    pub greatest: f64,
}

/// Greatest entry of a Jacobian whose products are finite.
const MOST: f64 = 1e140;

/// Judges a Jacobian per scaled parameter. `error` is the norm of its error, `ranges` the length of
/// each scaled parameter's range.
pub fn determine(jacobian: &DMatrix<f64>, error: f64, ranges: &[f64]) -> Determined {
    let p = jacobian.ncols();
    let mut found =
        Determined { covariance: DMatrix::zeros(p, p), parameters: vec![true; p], blind: Vec::new(), greatest: 0.0 };
    if p == 0 {
        return found;
    }
    // Products of its entries would overflow, and no decomposition of them ends: nothing is determined.
    if jacobian.iter().any(|x| x.is_nan() || x.abs() > MOST) {
        let direction = |k: usize| ((0..p).map(|i| if i == k { 1.0 } else { 0.0 }).collect(), 0.0);
        return Determined { parameters: vec![false; p], blind: (0..p).map(direction).collect(), ..found };
    }
    let rows = jacobian.nrows().max(p);
    let padded = DMatrix::from_fn(rows, p, |i, k| if i < jacobian.nrows() { jacobian[(i, k)] } else { 0.0 });
    let svd = padded.qr().r().svd(false, true);
    let (values, directions) = (&svd.singular_values, svd.v_t.unwrap_or_else(|| DMatrix::identity(p, p)));
    let greatest = values.iter().copied().fold(0.0, f64::max);
    found.greatest = greatest;
    for (k, value) in values.iter().enumerate() {
        let v: DVector<f64> = directions.row(k).transpose();
        let crossing = v.iter().zip(ranges).map(|(part, range)| range / part.abs().max(1e-300));
        let length = crossing.fold(f64::INFINITY, f64::min);
        // The factor covers rounding of a matrix without any other error.
        if *value <= error.max(greatest * 1e-13 * rows as f64) || value * length < 1.0 {
            v.iter().zip(&mut found.parameters).for_each(|(part, is)| *is &= part.abs() < PART);
            found.blind.push((v.iter().copied().collect(), *value));
        } else {
            found.covariance += &v * v.transpose() / (value * value);
        }
    }
    sparse_basis(&mut found.blind);
    found
}

/// Replaces directions by others that span the same space, each of few parameters: by Gauss-Jordan
/// elimination, so that each has a parameter that no other has.
fn sparse_basis(directions: &mut [(Vec<f64>, f64)]) {
    let count = directions.len();
    let mut pivots: Vec<usize> = Vec::new();
    for row in 0..count {
        // The greatest part that is left; equal ones by rounding go to the first.
        let (mut at, mut column, mut most) = (row, 0, 0.0);
        for (i, (v, _)) in directions.iter().enumerate().skip(row) {
            for (k, part) in v.iter().enumerate().filter(|(k, _)| !pivots.contains(k)) {
                if part.abs() > most * (1.0 + 1e-9) {
                    (at, column, most) = (i, k, part.abs());
                }
            }
        }
        directions.swap(row, at);
        pivots.push(column);
        let pivot = directions[row].0.clone();
        for (i, (v, _)) in directions.iter_mut().enumerate() {
            let share = if i == row { 1.0 - 1.0 / pivot[column] } else { v[column] / pivot[column] };
            v.iter_mut().zip(&pivot).for_each(|(part, of_pivot)| *part -= share * of_pivot);
        }
    }
    for (v, _) in directions.iter_mut() {
        let length = v.iter().map(|part| part * part).sum::<f64>().sqrt();
        let greatest =
            v.iter().fold(0.0_f64, |most, part| if part.abs() > most.abs() * (1.0 + 1e-9) { *part } else { most });
        v.iter_mut().for_each(|part| *part /= length * greatest.signum());
    }
}

/// A parameter of a direction: its name, its unit, and the change that 1 in the direction is.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The change of its value.
    pub scale: f64,
    /// Its value is below 0.
    pub is_negative: bool,
}

/// A direction in words: how the parameters change together without an effect.
pub fn describe(direction: &[f64], axes: &[Axis]) -> String {
    let greatest = direction.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    let mut parts: Vec<(f64, &Axis)> = direction.iter().map(|part| part / greatest).zip(axes).collect();
    parts.retain(|(part, _)| part.abs() >= PART);
    // Parts that are equal up to rounding keep the order of the parameters.
    parts.sort_by_key(|(part, _)| -(1e6 * part.abs()).round() as i64);
    match parts.as_slice() {
        [] => String::new(),
        [(_, axis)] => format!("the data do not determine `{}`: it has no effect on the signals", axis.name),
        all => {
            let changes: Vec<String> = all.iter().map(change).collect();
            let names: Vec<String> = all.iter().map(|(_, axis)| format!("`{}`", axis.name)).collect();
            let [others @ .., last] = names.as_slice() else { return String::new() };
            format!(
                "the data determine only the {} of {} and {last}: changes of {} have no effect together",
                combination(all),
                others.join(", "),
                changes.join(" and ")
            )
        }
    }
}

/// The function of the parameters that does not change along a direction.
fn combination(parts: &[(f64, &Axis)]) -> &'static str {
    let [(a, first), (b, second)] = parts else { return "combination" };
    let near = |x: f64, y: f64| (x - y).abs() <= 0.01 * x.abs().max(y.abs());
    let (da, db) = (a * first.scale, b * second.scale);
    let (ra, rb) = (if first.is_negative { -a } else { *a }, if second.is_negative { -b } else { *b });
    match () {
        () if first.unit == second.unit && near(da, -db) => "sum",
        () if first.unit == second.unit && near(da, db) => "difference",
        () if near(ra, -rb) => "product",
        () if near(ra, rb) => "ratio",
        () => "combination",
    }
}

fn change((part, axis): &(f64, &Axis)) -> String {
    let unit = if axis.unit == "1" { String::new() } else { format!(" {}", axis.unit) };
    format!("`{}` by {:+.4e}{unit}", axis.name, 0.01 * part * axis.scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_is_determined_and_the_difference_is_not() {
        // r depends on w0 + w1 and on w2.
        let j = DMatrix::from_row_slice(4, 3, &[1.0, 1.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 4.0]);
        let found = determine(&j, 1e-9, &[1e3; 3]);
        assert_eq!(found.parameters, [false, false, true]);
        assert_eq!(found.blind.len(), 1);
        let half = 0.5_f64.sqrt();
        let (direction, value) = &found.blind[0];
        // Rounding.
        assert!((direction[0] - half).abs() < 1e-14 && (direction[1] + half).abs() < 1e-14, "{direction:?}");
        assert!(*value < 1e-14 && (found.covariance[(2, 2)] - 1.0 / 25.0).abs() < 1e-15, "{found:?}");
        let axis =
            |name: &str, unit: &str, scale| Axis { name: name.into(), unit: unit.into(), scale, is_negative: false };
        let named = |a, b| describe(direction, &[a, b, axis("other", "1", 1.0)]);
        assert_eq!(
            named(axis("mass", "kg", 2.0), axis("friction", "1", 0.5)),
            "the data determine only the product of `mass` and `friction`: changes of `mass` by +2.0000e-2 kg and \
             `friction` by -5.0000e-3 have no effect together"
        );
        let sum = named(axis("a", "N", 1.0), axis("b", "N", 1.0));
        assert!(sum.starts_with("the data determine only the sum of `a` and `b`"), "{sum}");
        assert_eq!(
            describe(&[0.0, -1.0, 0.001], &[axis("a", "N", 1.0), axis("b", "N", 1.0), axis("c", "N", 1.0)]),
            "the data do not determine `b`: it has no effect on the signals"
        );
    }

    #[test]
    fn directions_of_a_space_are_chosen_with_few_parameters() {
        // r depends on w0 + w1 alone: w0 against w1, and w2, whatever the rotation of the two.
        let turn = 0.7_f64;
        let (a, b) = ([0.5_f64.sqrt(), -0.5_f64.sqrt(), 0.0], [0.0, 0.0, 1.0]);
        let mix = |c: f64, s: f64| (0..3).map(|k| c * a[k] + s * b[k]).collect::<Vec<_>>();
        let mut mixed = vec![(mix(turn.cos(), turn.sin()), 0.0), (mix(-turn.sin(), turn.cos()), 0.0)];
        sparse_basis(&mut mixed);
        mixed.sort_by(|x, y| x.0[0].total_cmp(&y.0[0]));
        for (found, exact) in mixed.iter().zip([b, a]) {
            // Rounding.
            assert!(found.0.iter().zip(exact).all(|(x, y)| (x - y).abs() < 1e-14), "{found:?}");
        }
    }

    #[test]
    fn the_covariance_is_the_inverse_of_the_normal_matrix() {
        let j = DMatrix::from_row_slice(4, 2, &[1.0, 0.5, 0.2, 2.0, -1.0, 0.3, 0.7, 0.1]);
        let found = determine(&j, 1e-9, &[1e3; 2]);
        let inverse = (j.transpose() * &j).try_inverse().unwrap();
        // Rounding.
        assert!((found.covariance - inverse).norm() < 1e-14);
        assert!(found.blind.is_empty() && found.parameters == [true, true]);
    }

    #[test]
    fn a_direction_wider_than_its_bounds_is_not_determined() {
        let j = DMatrix::from_row_slice(3, 2, &[100.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
        // A standard error of 2 within a range of 1.
        assert_eq!(determine(&j, 1e-9, &[1.0; 2]).parameters, [true, false]);
        assert_eq!(determine(&j, 1e-9, &[1.0, 3.0]).parameters, [true, true]);
    }

    #[test]
    fn a_matrix_whose_products_overflow_determines_nothing() {
        for value in [1e300, f64::INFINITY, f64::NAN] {
            let found = determine(&DMatrix::from_row_slice(2, 2, &[value, 0.0, 1.0, 1.0]), 1e-9, &[1.0; 2]);
            assert_eq!((found.parameters, found.blind.len()), (vec![false, false], 2), "{value}");
        }
    }
}
