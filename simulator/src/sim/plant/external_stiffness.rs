//! Stiffness of external forces, as part of the stiff part of a step.
//!
//! A spring pulls on a point with Jacobian J, whose displacement is `J E^-1 dx` ([`super::contact_stiffness`]); an
//! effort on joint j depends on its velocity:
//!
//! ```text
//! df = -K J E^-1 dx - c J dv + (f_t - c J' v) dt        dtau_j = -d dv_j
//! A  = -sum_k c_k e_k^T (K J E^-1, c J) - sum_j c_j d e_j^T + N
//! ```
//!
//! c_k are the accelerations and powers per unit force along axis k of the world, what the contacts react included.

use super::Plant;
use super::stiff_products::{Derivatives, Evaluation};
use crate::dynamics::jacobian;
use crate::force::{Damper, Slope};
use crate::integrate::StiffPart;

/// Test force relative to the mass of the mechanism, m/s^2.
const TEST: f64 = 1e-3;

/// The external forces of the stiff part.
#[derive(Clone, Debug, Default)]
pub(super) struct ExternalStiffness {
    /// Number of the force model, mechanism and slope at the present state.
    slopes: Vec<(usize, usize, Slope)>,
    /// Model and mechanism of those with responses.
    known: Vec<(usize, usize)>,
    /// Of a component of a force, and of the power.
    component: Derivatives,
    power: Derivatives,
}

impl ExternalStiffness {
    /// Finds the slopes of all forces. Returns whether there are others than before.
    pub fn find(&mut self, plant: &Plant) -> bool {
        self.slopes.clear();
        plant.force_slopes(&mut |number, mechanism, slope| self.slopes.push((number, mechanism, slope)));
        !self.slopes.iter().map(|(number, mechanism, _)| (*number, *mechanism)).eq(self.known.iter().copied())
    }

    /// Number of products for the slopes found.
    pub fn products(&self) -> usize {
        self.slopes.iter().map(|(_, _, slope)| components(slope)).sum()
    }

    /// Adds products with new responses for the slopes found.
    pub fn renew(&mut self, plant: &mut Plant, before: &Evaluation, out: &mut StiffPart) {
        self.known.clear();
        self.known.extend(self.slopes.iter().map(|(number, mechanism, _)| (*number, *mechanism)));
        for (_, m, slope) in &self.slopes {
            for k in 0..components(slope) {
                let Some((_, column)) = out.add() else { return };
                match slope {
                    Slope::Joint { joint, .. } => plant.respond_to_effort(*m, *joint, before, column),
                    Slope::Point { damper, .. } => plant.respond_to_force(*m, damper, k, before, column),
                }
                plant.kinematic_paths.joints().iter().for_each(|j| plant.layout.hold(*j, column));
            }
        }
    }

    /// Writes the rows of the products from `product` on, at the plant's last evaluation, and that of the power.
    /// Returns the next product.
    pub fn write(&mut self, plant: &Plant, mut product: usize, out: &mut StiffPart) -> usize {
        let nv = plant.acceleration.len();
        self.power.clear(nv);
        for (_, m, slope) in &self.slopes {
            for k in 0..components(slope) {
                self.component.clear(nv);
                let velocity = plant.differentiate(*m, slope, k, &mut self.component);
                for c in 0..nv {
                    let (x, v) = (self.component.by_displacement[c], self.component.by_velocity[c]);
                    self.power.add(c, x * velocity, v * velocity);
                }
                plant.write_derivatives(&mut self.component, product, out);
                product += 1;
            }
        }
        product
    }

    /// Adds the product of the power of external forces, after [`write`](Self::write).
    pub fn add_power(&mut self, plant: &Plant, out: &mut StiffPart) {
        if self.slopes.is_empty() {
            return;
        }
        let product = out.rank();
        let Some((_, column)) = out.add() else { return };
        column[plant.layout.controlled() + 1] = 1.0;
        for m in 0..=plant.objects.list.len() {
            let first = plant.layout.velocity_offset(m);
            for (c, force) in plant.external_efforts(m).iter().enumerate() {
                self.power.add(first + c, 0.0, *force);
            }
        }
        plant.write_derivatives(&mut self.power, product, out);
    }
}

/// Number of products of a slope.
fn components(slope: &Slope) -> usize {
    match slope {
        Slope::Joint { .. } => 1,
        Slope::Point { .. } => 3,
    }
}

impl Plant {
    fn external_efforts(&self, mechanism: usize) -> &[f64] {
        match mechanism {
            0 => &self.external,
            m => &self.objects.list[m - 1].external.tau,
        }
    }

    /// Change of accelerations and powers per unit force along world axis `k` at a point of mechanism `m`, contact
    /// states held, from the evaluation `before`. Leaves the evaluation changed.
    fn respond_to_force(&mut self, m: usize, at: &Damper, k: usize, before: &Evaluation, out: &mut [f64]) {
        let model = if m == 0 { &self.model } else { &self.objects.list[m - 1].model };
        let force = TEST * model.mass();
        self.point_jacobian(m, at, k, out);
        let first = self.layout.velocity_offset(m);
        let entries = out.iter().enumerate().take(self.acceleration.len()).filter(|(_, x)| **x != 0.0);
        self.respond_to_efforts(m, entries.map(|(c, x)| (c - first, force * x)), before);
        out.fill(0.0);
        before.write_change(self, force, out);
    }

    /// Row `k` of the Jacobian of a point of mechanism `m`, world axes, by all velocities, written to the first
    /// entries of `out`, the others of which it sets to zero.
    fn point_jacobian(&self, m: usize, at: &Damper, k: usize, out: &mut [f64]) {
        out.fill(0.0);
        let ws = self.objects.mechanisms(&self.ws).get(m);
        let (arm, first) = (at.point - ws.position, self.layout.velocity_offset(m));
        ws.support(at.link).iter().for_each(|&c| out[first + c] = ws.axes[c].at(&arm)[k]);
    }

    /// Adds the derivatives of component `k` of a force. Returns the velocity along which it does work.
    fn differentiate(&self, m: usize, slope: &Slope, k: usize, out: &mut Derivatives) -> f64 {
        let state = if m == 0 { &self.state } else { &self.objects.list[m - 1].state };
        let first = self.layout.velocity_offset(m);
        match slope {
            Slope::Joint { joint, damping } => {
                let nb = state.v.len() - state.joints.len();
                out.add(first + nb + joint, 0.0, -damping);
                state.v[nb + joint]
            }
            Slope::Point { damper, stiffness, by_time } => {
                let ws = self.objects.mechanisms(&self.ws).get(m);
                let (arm, mut velocity) = (damper.point - ws.position, 0.0);
                for &c in ws.support(damper.link) {
                    let j = ws.axes[c].at(&arm);
                    velocity += j[k] * state.v[c];
                    out.add(first + c, -(stiffness.row(k) * j)[0], -damper.coefficient * j[k]);
                }
                let drift = jacobian::point_drift(ws, damper.link, &damper.point);
                out.by_time = by_time[k] - damper.coefficient * drift[k];
                velocity
            }
        }
    }
}
