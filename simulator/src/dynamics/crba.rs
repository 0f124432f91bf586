//! Composite-rigid-body algorithm: the mass matrix M(q), symmetric, nv x nv.
//!
//! ```text
//! Ic_i = I_i + sum of Ic over children,   M_kj = S_j . Ic_k S_k   for j on the path from the root to k
//! ```
//!
//! and `armature` on the diagonal of joints, `A = T^T J T` on the entries of joints that a transmission
//! couples ([`crate::robot::Transmission`]). Source: [Featherstone 2008], table 6.2, without its
//! transforms because all inertias are about O.

use super::spatial::Inertia;
use super::tree_matrix::TreeMatrix;
use super::workspace::Workspace;
use crate::robot::{LinkId, Model};
use nalgebra::{Matrix3, Vector3};

/// Writes M into `ws.mass`. Needs `kinematics::positions`.
pub fn mass_matrix(model: &Model, ws: &mut Workspace) {
    for (composite, link) in ws.composite.iter_mut().zip(&ws.links) {
        *composite = link.inertia;
    }
    let nb = ws.nb;
    for (i, (joint, &parent)) in model.joints.iter().zip(&ws.parent[1..]).enumerate().rev() {
        // A copy stays in registers.
        let composite: Inertia = ws.composite[i + 1];
        ws.composite[parent] += composite;

        let momentum = composite.apply(&ws.axes[nb + i]);
        let (chain, row) = ws.mass.row_mut(nb + i);
        // The base's axes are the unit vectors, so its columns are the momentum itself.
        if let (6, Some(first)) = (nb, row.first_chunk_mut()) {
            *first = momentum.to_array();
        }
        for (entry, &j) in row[nb..].iter_mut().zip(&chain[nb..]) {
            *entry = ws.axes[j].dot(&momentum);
        }
        *row.last_mut().expect("a row contains its diagonal") += joint.armature;
    }
    for k in 0..nb {
        let momentum = ws.composite[0].apply(&ws.axes[k]).to_array();
        ws.mass.row_mut(k).1.copy_from_slice(&momentum[..=k]);
    }
    for transmission in model.coupled_transmissions() {
        transmission.reflected_entries(|a, b, inertia| ws.mass.add_entry(nb + a.0, nb + b.0, inertia));
    }
}

/// Writes the mass matrix of point masses, `sum m J^T J` with the Jacobians of the points, into
/// `out`, which has the pattern of M. Each point has a link, a world position (m) and a mass (kg).
/// Needs `kinematics::positions`.
pub fn point_masses(ws: &mut Workspace, points: &[(LinkId, Vector3<f64>, f64)], out: &mut TreeMatrix) {
    ws.composite.fill(Inertia::ZERO);
    for &(link, point, mass) in points {
        let about = point - ws.position;
        ws.composite[link.0] += Inertia::of_body(mass, &about, &Matrix3::identity(), &Matrix3::zeros());
    }
    let nb = ws.nb;
    for (i, &parent) in ws.parent[1..].iter().enumerate().rev() {
        let (before, here) = ws.composite.split_at_mut(i + 1);
        before[parent] += here[0];
        let momentum = here[0].apply(&ws.axes[nb + i]);
        let (chain, row) = out.row_mut(nb + i);
        for (entry, &j) in row.iter_mut().zip(chain) {
            *entry = ws.axes[j].dot(&momentum);
        }
    }
    for k in 0..nb {
        let momentum = ws.composite[0].apply(&ws.axes[k]).to_array();
        out.row_mut(k).1.copy_from_slice(&momentum[..=k]);
    }
}
