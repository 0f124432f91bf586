//! Mass matrix of a robot at a posture, base at the origin: `M = sum_i m_i Jv_i^T Jv_i + Jw_i^T I_i
//! Jw_i` over the links, plus armatures and rotors of transmissions ([Featherstone 2008], chapter 6, in
//! Jacobian form). For loading and output; simulations use `dynamics`.

// Storage and a factorization; products are written out.
#![allow(clippy::disallowed_types)]

use nalgebra::{DMatrix, Vector3};

use super::link_poses::link_poses;
use super::model::{Base, JointKind, Model};

/// The mass matrix for the velocities of [`super::model`]; `q` has one number per joint.
pub(super) fn mass_matrix(model: &Model, q: &[f64]) -> DMatrix<f64> {
    let (nb, nv) = (model.nb(), model.nv());
    let poses = link_poses(model, q);
    let mut mass = DMatrix::zeros(nv, nv);
    for (i, link) in model.links.iter().enumerate().skip(usize::from(model.base == Base::Fixed)) {
        let rotation = poses[i].rotation.to_rotation_matrix().into_inner();
        let inertia = rotation * link.inertia * rotation.transpose();
        let com = poses[i].translation.vector + rotation * link.com;
        // Columns (index, linear, angular) of the velocities that move this link.
        let mut columns: Vec<(usize, Vector3<f64>, Vector3<f64>)> = Vec::new();
        for axis in 0..nb.min(3) {
            let e = Vector3::ith(axis, 1.0);
            columns.push((axis, e, Vector3::zeros()));
            columns.push((3 + axis, e.cross(&com), e));
        }
        let mut at = i;
        while let Some(parent) = model.links[at].parent {
            let axis = poses[at].rotation * Vector3::z();
            let arm = com - poses[at].translation.vector;
            columns.push(match model.joints[at - 1].kind {
                JointKind::Prismatic => (nb + at - 1, axis, Vector3::zeros()),
                _ => (nb + at - 1, axis.cross(&arm), axis),
            });
            at = parent.0;
        }
        for (a, linear, angular) in &columns {
            let (force, moment) = (link.mass * linear, inertia * angular);
            for (b, other_linear, other_angular) in &columns {
                mass[(*a, *b)] += force.dot(other_linear) + moment.dot(other_angular);
            }
        }
    }
    for (j, joint) in model.joints.iter().enumerate() {
        mass[(nb + j, nb + j)] += joint.armature;
    }
    for transmission in model.transmissions.iter().filter(|t| t.is_coupled()) {
        transmission.reflected_entries(|i, j, value| {
            mass[(nb + i.0, nb + j.0)] += value;
            if i != j {
                mass[(nb + j.0, nb + i.0)] += value;
            }
        });
    }
    mass
}
