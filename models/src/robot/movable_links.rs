//! Finds joints and bases without inertia, which no force could accelerate finitely.
//!
//! The articulated inertia of a link is its apparent inertia when all joints below it move freely:
//! from the leaves, `IA = I + sum over children of X^T (IA_c - U U^T / d) X` with
//! `U = IA_c S`, `d = S . U` ([Featherstone 2008], section 7.2). The mass matrix is regular exactly
//! when every d is above 0 and the base's IA is positive definite. So a link without mass is fine
//! on a chain of crossing axes that ends in a body, and a point mass is fine off its axis.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::model::{Base, Joint, JointKind, Link, Model};

/// Inertia below this fraction of the inertia with all joints below locked is rounding.
const TOLERANCE: f64 = 1e-10;

/// The links, at joint positions 0, that would be accelerated without limit, in order. A joint
/// without inertia counts as locked for those above it. Velocities are (linear, angular).
pub(super) fn without_inertia(links: &[Link], joints: &[Joint], base: Base) -> Vec<usize> {
    let mut articulated: Vec<Matrix6<f64>> = links.iter().map(spatial).collect();
    let mut locked = articulated.clone();
    let mut found = Vec::new();
    for i in (1..links.len()).rev() {
        let Some(parent) = links[i].parent else { continue };
        let axis = if joints[i - 1].kind == JointKind::Prismatic { 2 } else { 5 };
        let x = to_child(&links[i]);
        let u: Vector6<f64> = articulated[i].column(axis).into();
        let d = u[axis];
        let armature = joints[i - 1].armature;
        let has_inertia = d + armature > TOLERANCE * (locked[i][(axis, axis)] + armature);
        let remaining = if has_inertia { articulated[i] - u * u.transpose() / (d + armature) } else { articulated[i] };
        if !has_inertia {
            found.push(i);
        }
        articulated[parent.0] += x.transpose() * remaining * x;
        let all = x.transpose() * locked[i] * x;
        locked[parent.0] += all;
    }
    if base == Base::Floating && !is_definite(&articulated[0]) {
        found.push(0);
    }
    found.reverse();
    found
}

/// The deepest link that would be accelerated without limit if no joint had an armature.
pub fn link_held_by_armature(model: &Model) -> Option<usize> {
    let mut joints = model.joints.clone();
    joints.iter_mut().for_each(|joint| joint.armature = 0.0);
    without_inertia(&model.links, &joints, model.base).last().copied()
}

/// Spatial inertia about the frame's origin.
fn spatial(link: &Link) -> Matrix6<f64> {
    let c = link.com.cross_matrix();
    let mut inertia = Matrix6::zeros();
    inertia.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * link.mass));
    inertia.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-link.mass * c));
    inertia.fixed_view_mut::<3, 3>(3, 0).copy_from(&(link.mass * c));
    inertia.fixed_view_mut::<3, 3>(3, 3).copy_from(&(link.inertia - link.mass * c * c));
    inertia
}

/// Transforms velocities from the parent's origin and axes to the child's.
fn to_child(link: &Link) -> Matrix6<f64> {
    let rotation: Matrix3<f64> = link.rotation.transpose();
    let offset: Vector3<f64> = link.offset;
    let mut x = Matrix6::zeros();
    x.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    x.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-rotation * offset.cross_matrix()));
    x.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    x
}

/// Cholesky with pivots that are more than rounding of their diagonal entries.
fn is_definite(a: &Matrix6<f64>) -> bool {
    let mut l = *a;
    for i in 0..6 {
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
            l[(i, j)] = (l[(i, j)] - sum) / l[(j, j)];
        }
        let pivot = l[(i, i)] - (0..i).map(|k| l[(i, k)] * l[(i, k)]).sum::<f64>();
        if !(pivot > TOLERANCE * a[(i, i)]) {
            return false;
        }
        l[(i, i)] = pivot.sqrt();
    }
    true
}
