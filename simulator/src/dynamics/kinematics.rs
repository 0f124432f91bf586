//! Forward kinematics: poses, joint axes, world inertias, twists and velocity products of all
//! links.
//!
//! ```text
//! R_i = R_p(i) R_i0 Rz(q_i),   p_i = p_p(i) + R_p(i) d_i          (revolute; prismatic adds z_i q_i to p_i)
//! S_i = (p_i x z_i, z_i)  or  (z_i, 0)
//! V_i = V_p(i) + S_i q'_i,     D_i = D_p(i) + V_i x S_i q'_i
//! ```
//!
//! with p relative to O, V the twist and D the spatial acceleration at vdot = 0. The base has V =
//! (p', omega) and D = (-omega x p', 0), because vdot holds the classical p'' and the spatial
//! acceleration about the inertial point O is p'' - omega x p'. Source: [Featherstone 2008],
//! sections 2.9 to 2.11 and table 5.1.

use super::spatial::{Inertia, Motion};
use super::state::State;
use super::workspace::Workspace;
use crate::math;
use crate::robot::{JointKind, Model};
use nalgebra::{Matrix3, Vector3};

/// Updates the workspace to `state`: [`positions`], then [`velocities`].
pub fn update(model: &Model, state: &State, ws: &mut Workspace) {
    positions(model, state, ws);
    velocities(state, ws);
    super::conditions::update(model, state, ws);
}

/// Poses, joint axes and world inertias for the configuration of `state`.
pub fn positions(model: &Model, state: &State, ws: &mut Workspace) {
    ws.position = state.position;
    let root = &model.links[0];
    let rotation = state.rotation.to_rotation_matrix().into_inner();
    ws.links[0].rotation = rotation;
    ws.links[0].origin = Vector3::zeros();
    ws.links[0].inertia = Inertia::of_body(root.mass, &(rotation * root.com), &rotation, &root.inertia);

    let joints = model.joints.iter().zip(&state.joints);
    let links = model.links[1..].iter().zip(&ws.parent[1..]).zip(&mut ws.axes[ws.nb..]);
    for (i, ((joint, &q), ((link, &parent), axis))) in joints.zip(links).enumerate() {
        let (done, rest) = ws.links.split_at_mut(i + 1);
        let up = &done[parent];
        let turned = up.rotation * link.rotation;
        let z: Vector3<f64> = turned.column(2).into();
        let mut origin = up.origin + up.rotation * link.offset;
        let rotation = match joint.kind {
            JointKind::Revolute | JointKind::Continuous => {
                *axis = Motion::new(origin.cross(&z), z);
                let (s, c) = math::sin_cos(q);
                let (x, y) = (turned.column(0), turned.column(1));
                Matrix3::from_columns(&[x * c + y * s, y * c - x * s, z])
            }
            JointKind::Prismatic => {
                *axis = Motion::new(z, Vector3::zeros());
                origin += z * q;
                turned
            }
        };
        let here = &mut rest[0];
        here.inertia = Inertia::of_body(link.mass, &(origin + rotation * link.com), &rotation, &link.inertia);
        here.rotation = rotation;
        here.origin = origin;
    }
}

/// Twists, momenta and velocity products for the velocity of `state`, at the configuration last given to
/// [`positions`].
pub fn velocities(state: &State, ws: &mut Workspace) {
    ws.v.copy_from_slice(&state.v);
    if ws.nb == 6 {
        let base = Motion::from_slice(&state.v);
        ws.links[0].velocity = base;
        ws.links[0].momentum = ws.links[0].inertia.apply(&base);
        ws.links[0].drift = Motion::new(-base.angular.cross(&base.linear), Vector3::zeros());
    }
    let joints = ws.v[ws.nb..].iter().zip(&ws.axes[ws.nb..]).zip(&ws.parent[1..]);
    for (i, ((&rate, axis), &parent)) in joints.enumerate() {
        let (done, rest) = ws.links.split_at_mut(i + 1);
        let up = &done[parent];
        let step = axis.scaled(rate);
        rest[0].velocity = up.velocity + step;
        rest[0].momentum = rest[0].inertia.apply(&rest[0].velocity);
        // V_p x S = V_i x S since S x S = 0; the parent's twist is available first.
        rest[0].drift = up.drift + up.velocity.cross(&step);
    }
}

/// Spatial accelerations (without gravity) of all links for a given `vdot`, length nv, into
/// `LinkMotion::acceleration`.
pub fn accelerations(ws: &mut Workspace, vdot: &[f64]) {
    let base = if ws.nb == 6 { Motion::from_slice(vdot) } else { Motion::ZERO };
    ws.links[0].acceleration = ws.links[0].drift + base;
    let joints = vdot[ws.nb..].iter().zip(&ws.axes[ws.nb..]).zip(&ws.parent[1..]);
    for (i, ((&a, axis), &parent)) in joints.enumerate() {
        let (done, rest) = ws.links.split_at_mut(i + 1);
        let up = &done[parent];
        // vdot adds to the velocity products along the same axes. The difference of drifts is this
        // joint's own product.
        rest[0].acceleration = up.acceleration + axis.scaled(a) + (rest[0].drift - up.drift);
    }
}
