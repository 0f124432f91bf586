//! The conditions of couplings and loops at a state: c, their rows of G, and g; the table of
//! [`super::constraints`] has the equations.

use super::constraints::Constraints;
use super::jacobian::classical;
use super::spatial::Motion;
use super::state::State;
use super::workspace::Workspace;
use crate::robot::{LinkId, LoopClosure, LoopKind, Model};
use nalgebra::{Isometry3, Matrix3, Vector3};

/// Evaluates c, G and g at the kinematics in the workspace, those of `state`.
pub(super) fn update(model: &Model, state: &State, ws: &mut Workspace) {
    if ws.constraints.number() == 0 {
        return;
    }
    let mut constraints = std::mem::take(&mut ws.constraints);
    let (nb, nv) = (ws.nb, constraints.nv);
    constraints.jacobian.fill(0.0);
    let mut i = 0;
    for coupling in &model.couplings {
        let (joint, leader) = (coupling.joint.0, coupling.leader.0);
        let (position, slope, curvature) = coupling.evaluate(state.joints[leader]);
        let row = &mut constraints.jacobian[i * nv..][..nv];
        row[nb + joint] += 1.0;
        row[nb + leader] -= slope;
        let rate = state.v[nb + leader];
        constraints.error[i] = state.joints[joint] - position;
        constraints.drift[i] = -curvature * rate * rate;
        i += 1;
    }
    for closure in &model.loops {
        let ends = [End::of_link(ws, closure.link, &closure.pose), End::second(ws, closure)];
        add_loop(ws, closure.kind, &ends, &mut i, &mut constraints);
    }
    ws.constraints = constraints;
}

/// Part of a coefficient, relative to its factors, that is rounding.
const ROUNDING: f64 = 1e-12;

/// One frame of a loop: link, position relative to O, axes and motion.
#[derive(Clone)]
struct End {
    link: Option<LinkId>,
    r: Vector3<f64>,
    axes: Matrix3<f64>,
    velocity: Motion,
    /// Classical acceleration without those of the velocities, and angular.
    drift: Motion,
}

impl End {
    fn of_link(ws: &Workspace, link: LinkId, pose: &Isometry3<f64>) -> End {
        let of = &ws.links[link.0];
        let r = of.origin + of.rotation * pose.translation.vector;
        let axes = of.rotation * pose.rotation.to_rotation_matrix().into_inner();
        let velocity = Motion::new(of.velocity.at(&r), of.velocity.angular);
        End { link: Some(link), r, axes, velocity, drift: classical(&of.drift, &of.velocity, &r) }
    }

    /// The motion of its link at another point.
    fn at(&self, ws: &Workspace, r: &Vector3<f64>) -> End {
        let Some(of) = self.link.map(|link| &ws.links[link.0]) else { return self.clone() };
        let velocity = Motion::new(of.velocity.at(r), of.velocity.angular);
        End { velocity, drift: classical(&of.drift, &of.velocity, r), ..self.clone() }
    }

    fn second(ws: &Workspace, closure: &LoopClosure) -> End {
        let pose = &closure.other_pose;
        if let Some(link) = closure.other {
            return End::of_link(ws, link, pose);
        }
        let axes = pose.rotation.to_rotation_matrix().into_inner();
        let r = pose.translation.vector - ws.position;
        End { link: None, r, axes, velocity: Motion::ZERO, drift: Motion::ZERO }
    }
}

fn add_loop(ws: &Workspace, kind: LoopKind, ends: &[End; 2], i: &mut usize, out: &mut Constraints) {
    let [a, b] = ends;
    let e = a.r - b.r;
    let (rate, drift) = (a.velocity.linear - b.velocity.linear, a.drift.linear - b.drift.linear);
    if let LoopKind::Rod(length) = kind {
        let direction = e / length;
        let error = (e.norm_squared() - length * length) / (2.0 * length);
        let drift = direction.dot(&drift) + rate.norm_squared() / length;
        add_row(ws, ends, (direction, Vector3::zeros()), (error, drift), i, out);
        return;
    }
    // Of the second link's point at p_1, in that link's axes: the base of both then has no part in it.
    let there = End { r: a.r, ..b.at(ws, &a.r) };
    let relative = a.velocity.linear - there.velocity.linear;
    let turning = 2.0 * b.velocity.angular.cross(&relative);
    let drift = a.drift.linear - there.drift.linear - turning;
    let at_first = [a.clone(), there];
    for unit in b.axes.column_iter() {
        let unit: Vector3<f64> = unit.into();
        add_row(ws, &at_first, (unit, Vector3::zeros()), (unit.dot(&e), unit.dot(&drift)), i, out);
    }
    let pairs: &[(usize, usize)] = match kind {
        LoopKind::Pin => &[(2, 0), (2, 1)],
        LoopKind::Weld => &[(0, 1), (1, 2), (2, 0)],
        LoopKind::Ball | LoopKind::Rod(_) => &[],
    };
    let (turn, spin) = (a.drift.angular - b.drift.angular, a.velocity.angular - b.velocity.angular);
    for &(first, second) in pairs {
        let (p, q): (Vector3<f64>, Vector3<f64>) = (a.axes.column(first).into(), b.axes.column(second).into());
        let normal = p.cross(&q);
        let change = a.velocity.angular.cross(&p).cross(&q) + p.cross(&b.velocity.angular.cross(&q));
        let drift = turn.dot(&normal) + spin.dot(&change);
        add_row(ws, ends, (Vector3::zeros(), normal), (p.dot(&q), drift), i, out);
    }
}

/// The row of the relative motion in a direction: linear, angular.
fn add_row(
    ws: &Workspace,
    ends: &[End; 2],
    (linear, angular): (Vector3<f64>, Vector3<f64>),
    (error, drift): (f64, f64),
    i: &mut usize,
    out: &mut Constraints,
) {
    let row = &mut out.jacobian[*i * out.nv..][..out.nv];
    for (end, sign) in ends.iter().zip([1.0, -1.0]) {
        for &k in end.link.map_or(&[][..], |link| ws.support(link)) {
            let axis = &ws.axes[k];
            let (moved, turned) = (axis.at(&end.r), axis.angular);
            let part = linear.dot(&moved) + angular.dot(&turned);
            // Of rows that only rounding makes, such as those across the plane of a planar mechanism.
            let scale = linear.norm() * moved.norm() + angular.norm() * turned.norm();
            if part.abs() > ROUNDING * scale {
                row[k] += sign * part;
            }
        }
    }
    (out.error[*i], out.drift[*i], out.directions[*i]) = (error, drift, [linear, angular]);
    *i += 1;
}
