//! Branch-sparse factorisation M = L^T L with L lower triangular on the pattern of M, and its
//! solves.
//!
//! Eliminating the leaves first keeps every zero of M zero ([Featherstone 2008], section 6.5, table
//! 6.3). The factor stores 1 / L_kk on its diagonal.

use super::DynamicsError;
use super::tree_matrix::TreeMatrix;
use super::workspace::Workspace;

/// Factorises `ws.mass` into `ws.factor`. Needs `crba::mass_matrix`.
///
/// # Errors
/// [`DynamicsError::Singular`] when a pivot is not positive beyond rounding.
pub fn factorize(ws: &mut Workspace) -> Result<(), DynamicsError> {
    ws.factor.copy_from(&ws.mass);
    eliminate(&mut ws.factor, &mut ws.scratch)
}

/// As [`factorize`], of M + diag(`shift`): implicit joint damping has `shift = dt damping`. `shift`
/// has length nv.
///
/// # Errors
/// As [`factorize`].
pub fn factorize_shifted(ws: &mut Workspace, shift: &[f64]) -> Result<(), DynamicsError> {
    factorize_prescribed(ws, shift, &[])
}

/// As [`factorize_shifted`], without the velocities `prescribed`: their rows and columns become
/// those of the unit matrix. [`solve`] then leaves their entries unchanged.
///
/// # Errors
/// As [`factorize`].
pub fn factorize_prescribed(ws: &mut Workspace, shift: &[f64], prescribed: &[usize]) -> Result<(), DynamicsError> {
    ws.factor.copy_from(&ws.mass);
    shift_and_eliminate(ws, shift, prescribed)
}

/// As [`factorize_prescribed`], of M + `added` + diag(`shift`); `added` has the pattern of M.
///
/// # Errors
/// As [`factorize`].
pub fn factorize_with(
    ws: &mut Workspace,
    added: &TreeMatrix,
    shift: &[f64],
    prescribed: &[usize],
) -> Result<(), DynamicsError> {
    ws.factor.copy_from(&ws.mass);
    ws.factor.add(added);
    shift_and_eliminate(ws, shift, prescribed)
}

fn shift_and_eliminate(ws: &mut Workspace, shift: &[f64], prescribed: &[usize]) -> Result<(), DynamicsError> {
    for (k, s) in shift.iter().enumerate() {
        *ws.factor.row_mut(k).1.last_mut().expect("a row contains its diagonal") += s;
    }
    prescribed.iter().for_each(|k| ws.factor.decouple(*k));
    eliminate(&mut ws.factor, &mut ws.scratch)
}

/// Factorises in place; `least` is scratch of length nv.
fn eliminate(factor: &mut TreeMatrix, least: &mut [f64]) -> Result<(), DynamicsError> {
    for (k, least) in least.iter_mut().enumerate() {
        // A pivot below this fraction of its initial diagonal is rounding, not inertia.
        *least = 16.0 * f64::EPSILON * factor.row(k).last().expect("a row contains its diagonal");
    }
    for k in (0..factor.len()).rev() {
        let (before, row, pattern) = factor.split_row(k);
        let (diagonal, row) = row.split_last_mut().expect("a row contains its diagonal");
        let pivot = *diagonal;
        // This form of the comparison also rejects NaN.
        if !(pivot > least[k] && pivot < f64::INFINITY) {
            return Err(DynamicsError::Singular { dof: k, pivot });
        }
        // Row of the ancestor at depth e: its first e + 1 entries belong to the same velocities as
        // this row's. The next pivot depends only on 1 / pivot, so the square root is off the
        // critical path.
        let reciprocal = 1.0 / pivot;
        for (e, &ancestor) in pattern.chain(k)[..row.len()].iter().enumerate() {
            let scale = row[e] * reciprocal;
            let target = &mut before[pattern.range(ancestor)];
            for (t, &x) in target.iter_mut().zip(&*row) {
                *t -= scale * x;
            }
        }
        let inverse = pivot.sqrt() * reciprocal;
        *diagonal = inverse;
        for x in row.iter_mut() {
            *x *= inverse;
        }
    }
    Ok(())
}

/// `x = M^-1 x`, length nv.
pub fn solve(ws: &Workspace, x: &mut [f64]) {
    solve_lt(&ws.factor, x);
    solve_l(&ws.factor, x);
}

/// First half: `x = L^-T x`, length nv.
pub fn solve_lt(factor: &TreeMatrix, x: &mut [f64]) {
    for k in (0..factor.len()).rev() {
        let row = factor.row(k);
        let above = row.len() - 1;
        let y = x[k] * row[above];
        x[k] = y;
        for (&j, &l) in factor.pattern().chain(k)[..above].iter().zip(row) {
            x[j] -= l * y;
        }
    }
}

/// Second half: `x = L^-1 x`, length nv.
pub fn solve_l(factor: &TreeMatrix, x: &mut [f64]) {
    for k in 0..factor.len() {
        let row = factor.row(k);
        let above = row.len() - 1;
        let mut sum = x[k];
        for (&j, &l) in factor.pattern().chain(k)[..above].iter().zip(row) {
            sum -= l * x[j];
        }
        x[k] = sum * row[above];
    }
}
