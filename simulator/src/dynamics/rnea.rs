//! Recursive Newton-Euler: `tau = M(q) vdot + h(q, v)`.
//!
//! ```text
//! f_i = I_i (A_i - g) + V_i x* I_i V_i,   tau_k = S_k . sum of f over the links that k moves
//! ```
//!
//! with A_i the spatial acceleration about O and g = (gravity, 0). In world axes about one point
//! the sums need no transforms. Joint armature adds `armature q''`, a transmission that couples joints
//! `A q''` with its reflected inertia A. Source: [Featherstone 2008], table 5.1.

use super::spatial::{Force, Motion};
use super::workspace::Workspace;
use crate::robot::Model;
use nalgebra::Vector3;

/// Bias h = tau at vdot = 0, into `ws.bias`. `gravity` in m/s^2, world axes. Needs
/// `kinematics::update`.
pub fn bias(ws: &mut Workspace, gravity: &Vector3<f64>) {
    for (force, link) in ws.forces.iter_mut().zip(&ws.links) {
        let acceleration = Motion::new(link.drift.linear - gravity, link.drift.angular);
        *force = link.inertia.apply(&acceleration) + link.velocity.cross_force(&link.momentum);
    }
    project(&ws.parent, &mut ws.forces, &ws.axes, ws.nb, &mut ws.bias);
}

/// Generalised force that makes the acceleration `vdot`; `vdot` and `tau` have length nv. Needs
/// `kinematics::update`. The link accelerations of `vdot` remain in the workspace.
pub fn inverse_dynamics(model: &Model, ws: &mut Workspace, vdot: &[f64], gravity: &Vector3<f64>, tau: &mut [f64]) {
    super::kinematics::accelerations(ws, vdot);
    for (force, link) in ws.forces.iter_mut().zip(&ws.links) {
        let acceleration = Motion::new(link.acceleration.linear - gravity, link.acceleration.angular);
        *force = link.inertia.apply(&acceleration) + link.velocity.cross_force(&link.momentum);
    }
    project(&ws.parent, &mut ws.forces, &ws.axes, ws.nb, tau);
    for ((tau, joint), a) in tau[ws.nb..].iter_mut().zip(&model.joints).zip(&vdot[ws.nb..]) {
        *tau += joint.armature * a;
    }
    let nb = ws.nb;
    for transmission in model.coupled_transmissions() {
        transmission.reflected_entries(|a, b, inertia| {
            tau[nb + a.0] += inertia * vdot[nb + b.0];
            if a != b {
                tau[nb + b.0] += inertia * vdot[nb + a.0];
            }
        });
    }
}

/// Sums link forces towards the root and computes their power along each velocity.
#[inline(always)]
fn project(parent: &[usize], forces: &mut [Force], axes: &[Motion], nb: usize, out: &mut [f64]) {
    let joints = axes[nb..].iter().zip(&mut out[nb..]).zip(&parent[1..]);
    for (i, ((axis, out), &parent)) in joints.enumerate().rev() {
        let (before, here) = forces.split_at_mut(i + 1);
        *out = axis.dot(&here[0]);
        before[parent] += here[0];
    }
    if nb == 6 {
        out[..6].copy_from_slice(&forces[0].to_array());
    }
}
