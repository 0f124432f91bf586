//! Positions and Jacobians of the soles.

use super::AugmentedData;
use crate::dynamics::jacobian;
use crate::robot::{Model, Sole};
use nalgebra::Vector3;

/// One sole. World axes.
#[derive(Clone, Debug)]
pub struct SoleData {
    /// Its reference point, the mean of its vertices, m ([`super::Needs::SOLES`]).
    pub position: Vector3<f64>,
    /// Its vertices in the model's order, m ([`super::Needs::SOLES`]).
    pub vertices: Vec<Vector3<f64>>,
    /// `(p', omega) = J v` of the reference point, 6 x nv ([`super::Needs::SOLE_JACOBIANS`]).
    pub jacobian: Vec<f64>,
    /// `p' = J v` of each vertex, 3 x nv ([`super::Needs::VERTEX_JACOBIANS`]).
    pub vertex_jacobians: Vec<Vec<f64>>,
    /// Force of the floor on each vertex, N ([`super::Needs::CONTACTS`]).
    pub vertex_forces: Vec<Vector3<f64>>,
}

impl SoleData {
    pub(super) fn new(sole: &Sole, nv: usize) -> Self {
        let zero = vec![Vector3::zeros(); sole.vertices.len()];
        SoleData {
            position: Vector3::zeros(),
            vertices: zero.clone(),
            jacobian: vec![0.0; 6 * nv],
            vertex_jacobians: vec![vec![0.0; 3 * nv]; sole.vertices.len()],
            vertex_forces: zero,
        }
    }
}

impl AugmentedData {
    pub(super) fn find_soles(&mut self, model: &Model) {
        for (data, sole) in self.soles.iter_mut().zip(&model.soles) {
            for (at, local) in data.vertices.iter_mut().zip(&sole.vertices) {
                *at = self.workspace.point(sole.link, local);
            }
            data.position = data.vertices.iter().sum::<Vector3<f64>>() / data.vertices.len().max(1) as f64;
        }
    }

    pub(super) fn find_sole_jacobians(&mut self, model: &Model) {
        for (data, sole) in self.soles.iter_mut().zip(&model.soles) {
            jacobian::frame(&self.workspace, sole.link, &data.position, &mut data.jacobian);
        }
    }

    pub(super) fn find_vertex_jacobians(&mut self, model: &Model) {
        let ws = &self.workspace;
        for (data, sole) in self.soles.iter_mut().zip(&model.soles) {
            for (at, out) in data.vertices.iter().zip(&mut data.vertex_jacobians) {
                out.fill(0.0);
                for &k in ws.support(sole.link) {
                    out[3 * k..3 * k + 3].copy_from_slice(jacobian::column(ws, k, at).linear.as_slice());
                }
            }
        }
    }
}
