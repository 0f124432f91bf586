//! Quantities of the whole body: mass, centre of mass, momentum, energy. World axes.
//!
//! Momentum about O is the sum of I_i V_i; about the centre of mass it is `k_c = k_O - c x l`. The
//! root of a fixed base does not count. Joint armature is part of the kinetic energy,
//! `1/2 sum V.I V + 1/2 sum armature q'^2 + 1/2 sum J theta'^2 = 1/2 v^T M v`, with the rotors J of
//! transmissions that couple joints, not of the momentum: it is a reflected inertia without a position in space.

use super::spatial::{Force, Inertia};
use super::workspace::{LinkMotion, Workspace};
use crate::robot::Model;
use nalgebra::Vector3;

/// Linear momentum (kg m/s) and angular momentum about the centre of mass (kg m^2/s).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Momentum {
    /// Linear momentum.
    pub linear: Vector3<f64>,
    /// Angular momentum about the centre of mass.
    pub angular: Vector3<f64>,
}

/// Links that move: all but the root of a fixed base.
fn moving(ws: &Workspace) -> &[LinkMotion] {
    &ws.links[usize::from(ws.nb == 0)..]
}

/// Spatial inertia of the whole body about O. Needs `kinematics::positions`.
pub fn total_inertia(ws: &Workspace) -> Inertia {
    let mut sum = Inertia::ZERO;
    for link in moving(ws) {
        sum += link.inertia;
    }
    sum
}

/// Centre of mass in the world, m. Needs `kinematics::positions`.
pub fn center_of_mass(ws: &Workspace) -> Vector3<f64> {
    let whole = total_inertia(ws);
    ws.position + whole.moment / whole.mass
}

/// Velocity of the centre of mass, m/s. Needs `kinematics::update`.
pub fn center_of_mass_velocity(ws: &Workspace) -> Vector3<f64> {
    momentum_about_origin(ws).linear / total_inertia(ws).mass
}

/// Momentum of the whole body. Needs `kinematics::update`.
pub fn momentum(ws: &Workspace) -> Momentum {
    let whole = total_inertia(ws);
    let about_origin = momentum_about_origin(ws);
    let center = whole.moment / whole.mass;
    Momentum { linear: about_origin.linear, angular: about_origin.angular - center.cross(&about_origin.linear) }
}

fn momentum_about_origin(ws: &Workspace) -> Force {
    let mut sum = Force::ZERO;
    for link in moving(ws) {
        sum += link.momentum;
    }
    sum
}

/// Kinetic energy, J. Needs `kinematics::update`.
pub fn kinetic_energy(model: &Model, ws: &Workspace) -> f64 {
    let links: f64 = moving(ws).iter().map(|l| l.velocity.dot(&l.momentum)).sum();
    let rotors: f64 = model.joints.iter().zip(&ws.v[ws.nb..]).map(|(j, v)| j.armature * v * v).sum();
    let mut coupled = 0.0;
    for transmission in model.coupled_transmissions() {
        for (k, inertia) in transmission.rotor_inertia.iter().enumerate() {
            let speed = transmission.motor_speed(k, &ws.v[ws.nb..]);
            coupled += inertia * speed * speed;
        }
    }
    0.5 * (links + rotors + coupled)
}

/// Potential energy in the field `gravity` (m/s^2), J, zero when the centre of mass is at the
/// world's origin. Needs `kinematics::positions`.
pub fn potential_energy(ws: &Workspace, gravity: &Vector3<f64>) -> f64 {
    let whole = total_inertia(ws);
    -gravity.dot(&(whole.moment + ws.position * whole.mass))
}
