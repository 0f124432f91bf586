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

/// Head of a row of a fixed base.
const NONE: [f64; 6] = [0.0; 6];

/// Splits a row after the six velocities of a floating base. The head of a fixed base is zero.
#[inline(always)]
fn split_base(row: &[f64], base: usize) -> (&[f64; 6], &[f64]) {
    if base == 6 { row.split_first_chunk().unwrap_or((&NONE, row)) } else { (&NONE, row) }
}

/// The first six of `x` for a floating base, zero for a fixed one.
#[inline(always)]
fn base_of(x: &[f64], base: usize) -> [f64; 6] {
    *split_base(x, base).0
}

/// Factorises in place; `least` is scratch of length nv. First the joints, then the base, whose
/// rows all joints change.
fn eliminate(factor: &mut TreeMatrix, least: &mut [f64]) -> Result<(), DynamicsError> {
    for (k, least) in least.iter_mut().enumerate() {
        // A pivot below this fraction of its initial diagonal is rounding, not inertia.
        *least = 16.0 * f64::EPSILON * factor.row(k).last().expect("a row contains its diagonal");
    }
    let base = factor.pattern().base();
    for k in (base..factor.len()).rev() {
        eliminate_row(factor, k, base, least[k])?;
    }
    if base == 6 {
        subtract_joints_from_base(factor);
    }
    for k in (0..base).rev() {
        eliminate_row(factor, k, 0, least[k])?;
    }
    Ok(())
}

/// Scales row `k` and subtracts it from the rows of its ancestors, without the first `base`. Its
/// pivot must exceed `least`.
fn eliminate_row(factor: &mut TreeMatrix, k: usize, base: usize, least: f64) -> Result<(), DynamicsError> {
    let (before, row, pattern) = factor.split_row(k);
    let (diagonal, row) = row.split_last_mut().expect("a row contains its diagonal");
    let pivot = *diagonal;
    // This form of the comparison also rejects NaN.
    if !(pivot > least && pivot < f64::INFINITY) {
        return Err(DynamicsError::Singular { dof: k, pivot });
    }
    // Row of the ancestor at depth e: its first e + 1 entries belong to the same velocities as
    // this row's. The next pivot depends only on 1 / pivot, so the square root is off the
    // critical path.
    let reciprocal = 1.0 / pivot;
    let (head, tail) = split_base(row, base);
    for (&ancestor, &entry) in pattern.chain(k)[base..].iter().zip(tail) {
        let scale = entry * reciprocal;
        let (first, rest) = before[pattern.range(ancestor)].split_at_mut(base);
        if let Ok(first) = <&mut [f64; 6]>::try_from(first) {
            first.iter_mut().zip(head).for_each(|(t, x)| *t -= scale * x);
        }
        rest.iter_mut().zip(tail).for_each(|(t, x)| *t -= scale * x);
    }
    let inverse = pivot.sqrt() * reciprocal;
    *diagonal = inverse;
    for x in row.iter_mut() {
        *x *= inverse;
    }
    Ok(())
}

/// Subtracts the finished rows of all joints from the six rows of a floating base, with which every
/// row begins: `B -= sum l_k l_k^T`, l_k the first six entries of row k.
///
/// The lower triangle of B, with rows of even length, stays in vector registers.
fn subtract_joints_from_base(factor: &mut TreeMatrix) {
    let mut rows = ([[0.0; 2]; 2], [[0.0; 4]; 2], [[0.0; 6]; 2]);
    for i in 0..2 {
        rows.0[i][..=i].copy_from_slice(factor.row(i));
        rows.1[i][..=i + 2].copy_from_slice(factor.row(i + 2));
        rows.2[i][..=i + 4].copy_from_slice(factor.row(i + 4));
    }
    for k in (6..factor.len()).rev() {
        let Some(l) = factor.row(k).first_chunk::<6>() else { continue };
        for i in 0..2 {
            rows.0[i].iter_mut().zip(l).for_each(|(x, y)| *x -= l[i] * y);
            rows.1[i].iter_mut().zip(l).for_each(|(x, y)| *x -= l[i + 2] * y);
            rows.2[i].iter_mut().zip(l).for_each(|(x, y)| *x -= l[i + 4] * y);
        }
    }
    for i in 0..2 {
        factor.row_mut(i).1.copy_from_slice(&rows.0[i][..=i]);
        factor.row_mut(i + 2).1.copy_from_slice(&rows.1[i][..=i + 2]);
        factor.row_mut(i + 4).1.copy_from_slice(&rows.2[i][..=i + 4]);
    }
}

/// `x = M^-1 x`, length nv.
pub fn solve(ws: &Workspace, x: &mut [f64]) {
    solve_lt(&ws.factor, x);
    solve_l(&ws.factor, x);
}

/// First half: `x = L^-T x`, length nv.
pub fn solve_lt(factor: &TreeMatrix, x: &mut [f64]) {
    let (base, pattern) = (factor.pattern().base(), factor.pattern());
    // What the joints subtract from the base stays in registers.
    let mut first = base_of(x, base);
    for k in (base..factor.len()).rev() {
        let (diagonal, row) = factor.row(k).split_last().expect("a row contains its diagonal");
        let y = x[k] * diagonal;
        x[k] = y;
        let (head, tail) = split_base(row, base);
        first.iter_mut().zip(head).for_each(|(x, l)| *x -= l * y);
        for (&j, &l) in pattern.chain(k)[base..].iter().zip(tail) {
            x[j] -= l * y;
        }
    }
    x[..base].copy_from_slice(&first[..base]);
    for k in (0..base).rev() {
        let row = factor.row(k);
        let y = x[k] * row[k];
        x[k] = y;
        x.iter_mut().zip(&row[..k]).for_each(|(x, l)| *x -= l * y);
    }
}

/// Second half: `x = L^-1 x`, length nv.
pub fn solve_l(factor: &TreeMatrix, x: &mut [f64]) {
    let (base, pattern) = (factor.pattern().base(), factor.pattern());
    for k in 0..base {
        let row = factor.row(k);
        let sum = row[..k].iter().zip(&*x).fold(x[k], |sum, (l, x)| sum - l * x);
        x[k] = sum * row[k];
    }
    let first = base_of(x, base);
    for k in base..factor.len() {
        let (diagonal, row) = factor.row(k).split_last().expect("a row contains its diagonal");
        let (head, tail) = split_base(row, base);
        let part = |i: usize| head[i] * first[i] + head[i + 2] * first[i + 2] + head[i + 4] * first[i + 4];
        let mut sum = x[k] - (part(0) + part(1));
        for (&j, &l) in pattern.chain(k)[base..].iter().zip(tail) {
            sum -= l * x[j];
        }
        x[k] = sum * diagonal;
    }
}
