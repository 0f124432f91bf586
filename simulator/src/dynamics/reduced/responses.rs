//! Responses of an assembled problem: to contact wrenches and efforts, and their generalised forces.

use super::{Mechanisms, Reduced};
use crate::dynamics::factor;
use crate::dynamics::workspace::Workspace;
use nalgebra::Vector3;

/// Generalised force of contact wrenches on the robot's velocity `k`, `(J^T w)_k`; `w` has length 6F.
/// Needs [`super::geometry`].
pub fn load(ws: &Workspace, reduced: &Reduced, w: &[f64], k: usize) -> f64 {
    let mut sum = 0.0;
    for s in 0..reduced.n {
        for side in reduced.sides[reduced.sides(s)].iter().filter(|side| side.body.mechanism == 0) {
            if ws.support(side.body.link).last().is_some_and(|&last| ws.mass.pattern().is_below(last, k)) {
                let axes = &reduced.axes[s];
                let vector = |at: usize| axes * Vector3::new(w[6 * s + at], w[6 * s + at + 1], w[6 * s + at + 2]);
                let axis = &ws.axes[k];
                let r = reduced.reference[s] - ws.position;
                sum += side.sign * (axis.at(&r).dot(&vector(0)) + axis.angular.dot(&vector(3)));
            }
        }
    }
    sum
}

/// Adds the row `g^T J` of a contact's point to `out`, of all velocities: g is a vector in the world,
/// `point` a world position. Needs `kinematics::update`.
pub fn add_point_row(
    ws: Mechanisms,
    reduced: &Reduced,
    s: usize,
    point: &Vector3<f64>,
    g: &Vector3<f64>,
    out: &mut [f64],
) {
    for side in &reduced.sides[reduced.sides(s)] {
        let of = ws.get(side.body.mechanism);
        let r = point - of.position;
        for &k in of.support(side.body.link) {
            out[side.offset + k] += side.sign * g.dot(&of.axes[k].at(&r));
        }
    }
}

/// Adds the effect of a generalised force on mechanism `m`, given as velocities and efforts: to `free`, the
/// accelerations of all mechanisms, and to `motion`, those of the contacts, 6F. Needs [`super::assemble`].
pub fn add_efforts<'a>(
    ws: impl Into<Mechanisms<'a>>,
    reduced: &mut Reduced,
    m: usize,
    efforts: impl Iterator<Item = (usize, f64)>,
    (free, motion): (&mut [f64], &mut [f64]),
) {
    let ws = ws.into();
    let range = reduced.mechanism(m);
    let half = &mut reduced.scratch[range.clone()];
    half.fill(0.0);
    efforts.for_each(|(k, effort)| half[k] += effort);
    factor::solve_lt(&ws.get(m).factor, half);
    ws.get(m).constraints.project(half);
    for s in 0..reduced.n {
        let sides = reduced.side_start[s]..reduced.side_start[s + 1];
        for side in reduced.sides[sides].iter().filter(|side| side.body.mechanism == m) {
            let y = &reduced.y[side.start..side.start + side.length];
            for (y, &k) in y.iter().zip(ws.get(m).coupled(side.body.link)) {
                motion[6 * s..6 * s + 6].iter_mut().zip(y).for_each(|(a, y)| *a += y * half[k]);
            }
        }
    }
    factor::solve_l(&ws.get(m).factor, half);
    free[range].iter_mut().zip(&*half).for_each(|(a, x)| *a += x);
}

/// `out = M^-1 (tau - h)`, the accelerations of all mechanisms without contact. Needs [`super::assemble`].
pub fn free<'a>(ws: impl Into<Mechanisms<'a>>, reduced: &Reduced, out: &mut [f64]) {
    let ws = ws.into();
    out.copy_from_slice(&reduced.half);
    for m in 0..ws.number() {
        factor::solve_l(&ws.get(m).factor, &mut out[reduced.mechanism(m)]);
    }
}

/// `out = dt M^-1 (tau - h) + M^-1 J^T w`, of all mechanisms: the change of velocities in a time dt by contact
/// impulses `w`, and accelerations for wrenches `w` with dt = 1. `w` has length 6F. Needs [`super::assemble`].
pub fn advance<'a>(ws: impl Into<Mechanisms<'a>>, reduced: &mut Reduced, dt: f64, w: &[f64], out: &mut [f64]) {
    respond(ws.into(), reduced, w);
    out.iter_mut().zip(&reduced.pair).for_each(|(out, [free, loaded])| *out = dt * free + loaded);
}

/// `out = M^-1 J^T w`, of all mechanisms: accelerations for wrenches `w`, velocity jumps for impulses.
/// `w` has length 6F. Needs [`super::assemble`].
pub fn apply<'a>(ws: impl Into<Mechanisms<'a>>, reduced: &mut Reduced, w: &[f64], out: &mut [f64]) {
    respond(ws.into(), reduced, w);
    out.iter_mut().zip(&reduced.pair).for_each(|(out, [_, loaded])| *out = *loaded);
}

/// Computes `M^-1 (tau - h)` and `M^-1 J^T w` in `reduced.pair`; both cost as much as one.
fn respond(ws: Mechanisms, reduced: &mut Reduced, w: &[f64]) {
    reduced.pair.iter_mut().zip(&reduced.half).for_each(|(pair, half)| *pair = [*half, 0.0]);
    for (s, w) in w.as_chunks::<6>().0.iter().enumerate() {
        for side in &reduced.sides[reduced.side_start[s]..reduced.side_start[s + 1]] {
            let y = &reduced.y[side.start..side.start + side.length];
            let pair = &mut reduced.pair[side.offset..];
            for (y, &k) in y.iter().zip(ws.get(side.body.mechanism).coupled(side.body.link)) {
                pair[k][1] += y.iter().zip(w).map(|(y, w)| y * w).sum::<f64>();
            }
        }
    }
    for m in 0..ws.number() {
        let range = reduced.mechanism(m);
        factor::solve_l_of_several(&ws.get(m).factor, &mut reduced.pair[range]);
    }
}

/// The multipliers of least norm of the couplings and loops of mechanism `m`: forces on the conditions, N or
/// N m, for contact wrenches `w`, 6F. Needs [`super::assemble`].
pub fn multipliers<'a>(ws: impl Into<Mechanisms<'a>>, reduced: &mut Reduced, m: usize, w: &[f64], lambda: &mut [f64]) {
    let of = ws.into().get(m);
    let Reduced { conditions, sides, side_start, n, .. } = reduced;
    let loads = (0..*n).flat_map(|s| (side_start[s]..side_start[s + 1]).map(move |side| (side, &w[6 * s..6 * s + 6])));
    conditions.multipliers(m, &of.constraints, loads.filter(|(side, _)| sides[*side].body.mechanism == m), lambda);
}
