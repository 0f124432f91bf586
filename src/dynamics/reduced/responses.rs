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
            if ws.support(side.body.link).binary_search(&k).is_ok() {
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
    let range = reduced.offsets[m]..reduced.offsets[m + 1];
    reduced.half.fill(0.0);
    efforts.for_each(|(k, effort)| reduced.half[range.start + k] += effort);
    factor::solve_lt(&ws.get(m).factor, &mut reduced.half[range.clone()]);
    ws.get(m).constraints.project(&mut reduced.half[range.clone()]);
    for s in 0..reduced.n {
        for side in reduced.sides[reduced.sides(s)].iter().filter(|side| side.body.mechanism == m) {
            let y = &reduced.y[side.start..side.start + side.length];
            for (y, &k) in y.iter().zip(ws.get(m).coupled(side.body.link)) {
                let half = reduced.half[side.offset + k];
                motion[6 * s..6 * s + 6].iter_mut().zip(y).for_each(|(a, y)| *a += y * half);
            }
        }
    }
    factor::solve_l(&ws.get(m).factor, &mut reduced.half[range.clone()]);
    free[range.clone()].iter_mut().zip(&reduced.half[range]).for_each(|(a, x)| *a += x);
}

/// Adds `M^-1 J^T w` to `out`, of all mechanisms: accelerations for wrenches `w`, velocity jumps for
/// impulses. `w` has length 6F. Needs [`super::assemble`].
pub fn apply<'a>(ws: impl Into<Mechanisms<'a>>, reduced: &mut Reduced, w: &[f64], out: &mut [f64]) {
    let ws = ws.into();
    reduced.half.fill(0.0);
    for s in 0..reduced.n {
        let w = &w[6 * s..6 * s + 6];
        for side in &reduced.sides[reduced.side_start[s]..reduced.side_start[s + 1]] {
            let y = &reduced.y[side.start..side.start + side.length];
            for (y, &k) in y.iter().zip(ws.get(side.body.mechanism).coupled(side.body.link)) {
                reduced.half[side.offset + k] += y.iter().zip(w).map(|(y, w)| y * w).sum::<f64>();
            }
        }
    }
    for m in 0..ws.number() {
        factor::solve_l(&ws.get(m).factor, &mut reduced.half[reduced.offsets[m]..reduced.offsets[m + 1]]);
    }
    for (out, x) in out.iter_mut().zip(&reduced.half) {
        *out += x;
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
