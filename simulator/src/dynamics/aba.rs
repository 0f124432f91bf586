//! Articulated-body algorithm: `vdot = M^-1 (tau - h)` without forming M.
//!
//! Written for B, the part of the spatial acceleration that vdot causes: A = D + B, with D the
//! velocity products from `kinematics`. The velocity products enter only through the bias force f =
//! I (D - g) + V x* I V:
//!
//! ```text
//! U = IA S,  d = S.U + armature,  u = tau - S.p
//! IA_parent += IA - U U^T / d,    p_parent += p + U u / d
//! q'' = (u - U.B_parent) / d,     B = B_parent + S q''
//! ```
//!
//! and for a floating base IA_0 B_0 = (tau_base - p_0). Source: [Featherstone 2008], table 7.1.
//!
//! The inertia of rotors that couple joints belongs to no link: with such transmissions M is formed and
//! factorised instead.

use super::spatial::{Force, Inertia, Motion};
use super::workspace::Workspace;
use super::{DynamicsError, crba, factor, kinematics, rnea};
use crate::robot::Model;
use nalgebra::Vector3;

/// Symmetric 6x6 articulated inertia. All 36 numbers are stored: row operations run over contiguous
/// memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Articulated([[f64; 6]; 6]);

impl Articulated {
    pub(super) const ZERO: Articulated = Articulated([[0.0; 6]; 6]);

    #[inline(always)]
    fn of(i: &Inertia) -> Self {
        let m = i.mass;
        let (x, y, z) = (i.moment.x, i.moment.y, i.moment.z);
        let [a, b, c, d, e, f] = i.rotational;
        Articulated([
            [m, 0.0, 0.0, 0.0, z, -y],
            [0.0, m, 0.0, -z, 0.0, x],
            [0.0, 0.0, m, y, -x, 0.0],
            [0.0, -z, y, a, b, c],
            [z, 0.0, -x, b, d, e],
            [-y, x, 0.0, c, e, f],
        ])
    }

    /// Product with a motion, by columns (the matrix is symmetric).
    #[inline(always)]
    fn apply(&self, s: &Motion) -> [f64; 6] {
        let s = [s.linear.x, s.linear.y, s.linear.z, s.angular.x, s.angular.y, s.angular.z];
        let mut out = [0.0; 6];
        for (row, s) in self.0.iter().zip(s) {
            for (o, r) in out.iter_mut().zip(row) {
                *o += r * s;
            }
        }
        out
    }

    /// `self += other - u u^T / d`.
    #[inline(always)]
    fn add_reduced(&mut self, other: &Articulated, u: &[f64; 6], inverse_d: f64) {
        for ((row, o), &ui) in self.0.iter_mut().zip(&other.0).zip(u) {
            let s = ui * inverse_d;
            for ((r, o), uj) in row.iter_mut().zip(o).zip(u) {
                *r += o - s * uj;
            }
        }
    }

    /// Solves `self x = b` for the base by Cholesky; `Err` contains the failing row and its pivot.
    fn solve(&self, b: [f64; 6]) -> Result<[f64; 6], (usize, f64)> {
        let mut l = self.0;
        let mut x = b;
        for i in 0..6 {
            for j in 0..i {
                let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                l[i][j] = (l[i][j] - sum) / l[j][j];
            }
            let pivot = l[i][i] - (0..i).map(|k| l[i][k] * l[i][k]).sum::<f64>();
            if !(pivot > 16.0 * f64::EPSILON * self.0[i][i] && pivot < f64::INFINITY) {
                return Err((i, pivot));
            }
            l[i][i] = pivot.sqrt();
            x[i] = (x[i] - (0..i).map(|k| l[i][k] * x[k]).sum::<f64>()) / l[i][i];
        }
        for i in (0..6).rev() {
            x[i] = (x[i] - (i + 1..6).map(|k| l[k][i] * x[k]).sum::<f64>()) / l[i][i];
        }
        Ok(x)
    }
}

/// Acceleration `vdot` under the generalised force `tau`, both of length nv. Needs
/// `kinematics::update`; `gravity` in m/s^2, world axes.
///
/// # Errors
/// [`DynamicsError::Singular`] when a joint or the base moves no inertia. For redundant joints
/// rounding hides the zero pivot here; only [`super::factor::factorize`] detects them.
pub fn forward_dynamics(
    model: &Model,
    ws: &mut Workspace,
    tau: &[f64],
    gravity: &Vector3<f64>,
    vdot: &mut [f64],
) -> Result<(), DynamicsError> {
    if model.coupled_transmissions().next().is_some() {
        return by_mass_matrix(model, ws, tau, gravity, vdot);
    }
    let nb = ws.nb;
    for ((force, articulated), link) in ws.forces.iter_mut().zip(&mut ws.articulated).zip(&ws.links) {
        let momentum = link.inertia.apply(&link.velocity);
        let acceleration = Motion::new(link.drift.linear - gravity, link.drift.angular);
        *force = link.inertia.apply(&acceleration) + link.velocity.cross_force(&momentum);
        *articulated = Articulated::of(&link.inertia);
    }

    // Towards the root; `vdot` stores u / d for the outward pass.
    let joints = model.joints.iter().zip(&ws.axes[nb..]).zip(&ws.parent[1..]);
    for (i, ((joint, axis), &parent)) in joints.enumerate().rev() {
        let (before, here) = ws.articulated.split_at_mut(i + 1);
        let u = here[0].apply(axis);
        let momentum = Force::new(Vector3::new(u[0], u[1], u[2]), Vector3::new(u[3], u[4], u[5]));
        let d = axis.dot(&momentum) + joint.armature;
        if !(d > 0.0 && d < f64::INFINITY) {
            return Err(DynamicsError::Singular { dof: nb + i, pivot: d });
        }
        let inverse_d = 1.0 / d;
        before[parent].add_reduced(&here[0], &u, inverse_d);

        let (before, here) = ws.forces.split_at_mut(i + 1);
        let effort = tau[nb + i] - axis.dot(&here[0]);
        let scale = effort * inverse_d;
        before[parent] +=
            Force::new(here[0].linear + momentum.linear * scale, here[0].angular + momentum.angular * scale);
        // The link's own force is no longer needed; its entry stores U / d for the outward pass.
        here[0] = Force::new(momentum.linear * inverse_d, momentum.angular * inverse_d);
        vdot[nb + i] = scale;
    }

    // Towards the leaves; `acceleration` is B.
    ws.links[0].acceleration = Motion::ZERO;
    if nb == 6 {
        let p = ws.forces[0].to_array();
        let b = std::array::from_fn(|k| tau[k] - p[k]);
        let a = ws.articulated[0].solve(b).map_err(|(dof, pivot)| DynamicsError::Singular { dof, pivot })?;
        vdot[..6].copy_from_slice(&a);
        ws.links[0].acceleration = Motion::from_slice(&a);
    }
    for (i, (axis, &parent)) in ws.axes[nb..].iter().zip(&ws.parent[1..]).enumerate() {
        let (done, rest) = ws.links.split_at_mut(i + 1);
        let up = done[parent].acceleration;
        let a = vdot[nb + i] - up.dot(&ws.forces[i + 1]);
        vdot[nb + i] = a;
        rest[0].acceleration = up + axis.scaled(a);
    }
    for link in &mut ws.links {
        link.acceleration += link.drift;
    }
    Ok(())
}

/// As [`forward_dynamics`], with M.
fn by_mass_matrix(
    model: &Model,
    ws: &mut Workspace,
    tau: &[f64],
    gravity: &Vector3<f64>,
    vdot: &mut [f64],
) -> Result<(), DynamicsError> {
    rnea::bias(ws, gravity);
    crba::mass_matrix(model, ws);
    factor::factorize(ws)?;
    for ((a, tau), h) in vdot.iter_mut().zip(tau).zip(&ws.bias) {
        *a = tau - h;
    }
    factor::solve(ws, vdot);
    kinematics::accelerations(ws, vdot);
    Ok(())
}
