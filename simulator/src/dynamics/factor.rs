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
    eliminate(&mut ws.factor, &mut ws.scratch)?;
    orthogonalize(ws, &[]);
    Ok(())
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

/// As [`factorize_prescribed`], of M + diag(`shift`) and what `add` adds, with the pattern of M.
///
/// # Errors
/// As [`factorize`].
pub fn factorize_with(
    ws: &mut Workspace,
    add: impl FnOnce(&mut TreeMatrix),
    shift: &[f64],
    prescribed: &[usize],
) -> Result<(), DynamicsError> {
    ws.factor.copy_from(&ws.mass);
    add(&mut ws.factor);
    shift_and_eliminate(ws, shift, prescribed)
}

fn shift_and_eliminate(ws: &mut Workspace, shift: &[f64], prescribed: &[usize]) -> Result<(), DynamicsError> {
    for (k, s) in shift.iter().enumerate() {
        *ws.factor.row_mut(k).1.last_mut().expect("a row contains its diagonal") += s;
    }
    prescribed.iter().for_each(|k| ws.factor.decouple(*k));
    eliminate(&mut ws.factor, &mut ws.scratch)?;
    orthogonalize(ws, prescribed);
    Ok(())
}

/// Refers the conditions of couplings and loops to the factor.
fn orthogonalize(ws: &mut Workspace, prescribed: &[usize]) {
    if ws.constraints.number() > 0 {
        let (factor, constraints) = (&ws.factor, &mut ws.constraints);
        constraints.orthogonalize(prescribed, |x| solve_lt(factor, x));
    }
}

/// Calls a function for the length of a row as a constant, or evaluates `$long` for longer rows. Rows
/// are short: loops over variable lengths would cost more than their numbers. `<_>` after the name leaves its second
/// parameter to be inferred.
macro_rules! by_length {
    ($length:expr, $function:ident $(<$more:tt>)? ($($argument:expr),*), $long:expr) => {
        match $length {
            0 => $function::<0 $(, $more)?>($($argument),*),
            1 => $function::<1 $(, $more)?>($($argument),*),
            2 => $function::<2 $(, $more)?>($($argument),*),
            3 => $function::<3 $(, $more)?>($($argument),*),
            4 => $function::<4 $(, $more)?>($($argument),*),
            5 => $function::<5 $(, $more)?>($($argument),*),
            6 => $function::<6 $(, $more)?>($($argument),*),
            7 => $function::<7 $(, $more)?>($($argument),*),
            8 => $function::<8 $(, $more)?>($($argument),*),
            9 => $function::<9 $(, $more)?>($($argument),*),
            10 => $function::<10 $(, $more)?>($($argument),*),
            11 => $function::<11 $(, $more)?>($($argument),*),
            12 => $function::<12 $(, $more)?>($($argument),*),
            13 => $function::<13 $(, $more)?>($($argument),*),
            14 => $function::<14 $(, $more)?>($($argument),*),
            15 => $function::<15 $(, $more)?>($($argument),*),
            16 => $function::<16 $(, $more)?>($($argument),*),
            _ => $long,
        }
    };
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

/// Factorises in place; `scratch` has length nv. First the joints, then the base, whose rows all
/// joints change.
fn eliminate(factor: &mut TreeMatrix, scratch: &mut [f64]) -> Result<(), DynamicsError> {
    for (least, (_, row)) in scratch.iter_mut().zip(factor.rows()) {
        // A pivot below this fraction of its initial diagonal is rounding, not inertia.
        *least = 16.0 * f64::EPSILON * row.last().expect("a row contains its diagonal");
    }
    let (base, nv) = (factor.pattern().base(), factor.len());
    for i in (0..nv - base).rev() {
        let k = factor.pattern().by_depth()[i];
        reduce_row(factor, k, 0, scratch)?;
    }
    (base..nv).for_each(|k| scale_row(factor, k, scratch[k]));
    if base == 6 {
        subtract_joints_from_base(factor);
        (0..6).rev().try_for_each(|k| reduce_row(factor, k, nv - 6, scratch))?;
        (0..6).for_each(|k| scale_row(factor, k, scratch[k]));
    }
    Ok(())
}

/// Subtracts from row `k` the rows of its descendants but the first `done`, which are not scaled
/// yet. Its pivot must exceed `scratch[k]`, which becomes 1 / pivot.
///
/// Row d of a descendant begins with entries for the same velocities as row k. The last of them,
/// entry (d, k), over the pivot of d is the factor of row d.
fn reduce_row(factor: &mut TreeMatrix, k: usize, done: usize, scratch: &mut [f64]) -> Result<(), DynamicsError> {
    let pivot = by_length!(
        factor.row(k).len(),
        subtract_descendants(factor, k, done, scratch),
        subtract_descendants_of_long_row(factor, k, done, scratch)
    );
    // This form of the comparison also rejects NaN.
    if !(pivot > scratch[k] && pivot < f64::INFINITY) {
        return Err(DynamicsError::Singular { dof: k, pivot });
    }
    // The next pivot depends only on 1 / pivot, so square roots are off the critical path.
    scratch[k] = 1.0 / pivot;
    Ok(())
}

/// Subtracts descendants from row `k`, of `N` entries, which stay in registers. Returns the last.
fn subtract_descendants<const N: usize>(factor: &mut TreeMatrix, k: usize, done: usize, reciprocal: &[f64]) -> f64 {
    let mut sum: [f64; N] = *factor.row(k).first_chunk().expect("a row of this length");
    for &(d, start) in &factor.pattern().descendants(k)[done..] {
        let x: &[f64; N] = factor.entries()[start..].first_chunk().expect("a row of a descendant is longer");
        let scale = x.last().unwrap_or(&0.0) * reciprocal[d];
        sum.iter_mut().zip(x).for_each(|(sum, x)| *sum -= scale * x);
    }
    factor.row_mut(k).1.copy_from_slice(&sum);
    *sum.last().unwrap_or(&0.0)
}

/// As [`subtract_descendants`], for a row of any length.
#[cold]
fn subtract_descendants_of_long_row(factor: &mut TreeMatrix, k: usize, done: usize, reciprocal: &[f64]) -> f64 {
    let last = factor.row(k).len() - 1;
    for i in done..factor.pattern().descendants(k).len() {
        let (d, start) = factor.pattern().descendants(k)[i];
        let scale = factor.entries()[start + last] * reciprocal[d];
        for e in 0..=last {
            let x = factor.entries()[start + e];
            factor.row_mut(k).1[e] -= scale * x;
        }
    }
    factor.row(k)[last]
}

/// Divides row `k` by the root of its pivot, of the given reciprocal. Its last entry becomes the
/// inverse of that root.
fn scale_row(factor: &mut TreeMatrix, k: usize, reciprocal: f64) {
    let (diagonal, row) = factor.row_mut(k).1.split_last_mut().expect("a row contains its diagonal");
    let inverse = diagonal.sqrt() * reciprocal;
    *diagonal = inverse;
    by_length!(row.len(), scale(row, inverse), row.iter_mut().for_each(|x| *x *= inverse));
}

/// Multiplies the first `N` entries of a row.
#[inline(always)]
fn scale<const N: usize>(row: &mut [f64], factor: f64) {
    row.first_chunk_mut::<N>().into_iter().flatten().for_each(|x| *x *= factor);
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

/// `x = M^-1 x` within the conditions of couplings and loops: the change of velocities by an impulse x.
pub fn solve_coupled(ws: &Workspace, x: &mut [f64]) {
    solve_lt(&ws.factor, x);
    ws.constraints.project(x);
    solve_l(&ws.factor, x);
}

/// First half: `x = L^-T x`, length nv.
pub fn solve_lt(factor: &TreeMatrix, x: &mut [f64]) {
    let base = factor.pattern().base();
    // What the joints subtract from the base stays in registers.
    let mut first = base_of(x, base);
    for (k, (chain, row)) in factor.rows().enumerate().skip(base).rev() {
        let (diagonal, row) = row.split_last().expect("a row contains its diagonal");
        let y = x[k] * diagonal;
        x[k] = y;
        let (head, tail) = split_base(row, base);
        first.iter_mut().zip(head).for_each(|(x, l)| *x -= l * y);
        let chain = &chain[base..];
        by_length!(tail.len(), scatter(chain, tail, y, x), chain.iter().zip(tail).for_each(|(&j, l)| x[j] -= l * y));
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
    solve_l_of_several(factor, x.as_chunks_mut::<1>().0);
}

/// As [`solve_l`], of `L` vectors at once, by velocity. Each has the same bits as alone.
pub fn solve_l_of_several<const L: usize>(factor: &TreeMatrix, x: &mut [[f64; L]]) {
    let base = factor.pattern().base();
    for k in 0..base {
        let row = factor.row(k);
        let sum = row[..k].iter().zip(&*x).fold(x[k], |sum, (l, x)| subtract(sum, *l, x));
        x[k] = sum.map(|sum| sum * row[k]);
    }
    let first: [[f64; L]; 6] = if base == 6 { *x.first_chunk().unwrap_or(&[[0.0; L]; 6]) } else { [[0.0; L]; 6] };
    for &k in factor.pattern().by_depth() {
        let (chain, row) = (factor.pattern().chain(k), factor.row(k));
        let (diagonal, row) = row.split_last().expect("a row contains its diagonal");
        let (head, tail) = split_base(row, base);
        let part = |i: usize, lane: usize| {
            head[i] * first[i][lane] + head[i + 2] * first[i + 2][lane] + head[i + 4] * first[i + 4][lane]
        };
        let (at, chain) = (x[k], &chain[base..]);
        let sum: [f64; L] = std::array::from_fn(|lane| at[lane] - (part(0, lane) + part(1, lane)));
        let sum = by_length!(
            tail.len(),
            gather<_>(chain, tail, sum, x),
            chain.iter().zip(tail).fold(sum, |sum, (&j, l)| subtract(sum, *l, &x[j]))
        );
        x[k] = sum.map(|sum| sum * diagonal);
    }
}

/// `sum - l x`.
#[inline(always)]
fn subtract<const L: usize>(sum: [f64; L], l: f64, x: &[f64; L]) -> [f64; L] {
    std::array::from_fn(|lane| sum[lane] - l * x[lane])
}

/// `x_j -= l_j y` over the first `N` entries of a row.
#[inline(always)]
fn scatter<const N: usize>(chain: &[usize], row: &[f64], y: f64, x: &mut [f64]) {
    if let (Some(chain), Some(row)) = (chain.first_chunk::<N>(), row.first_chunk::<N>()) {
        chain.iter().zip(row).for_each(|(&j, l)| x[j] -= l * y);
    }
}

/// `sum - l x` over the first `N` entries of a row, one after the other.
#[inline(always)]
fn gather<const N: usize, const L: usize>(chain: &[usize], row: &[f64], sum: [f64; L], x: &[[f64; L]]) -> [f64; L] {
    let (Some(chain), Some(row)) = (chain.first_chunk::<N>(), row.first_chunk::<N>()) else { return sum };
    chain.iter().zip(row).fold(sum, |sum, (&j, l)| subtract(sum, *l, &x[j]))
}
