//! `joint-friction`: Coulomb and viscous friction in joints.
//!
//! ```text
//! tau = -c tanh(qd / v_s) - d qd
//! ```
//!
//! The hyperbolic tangent replaces the jump at rest: below the slip speed v_s a loaded joint creeps at
//! `v_s atanh(tau / c)` instead of sticking. That is a model of its own, not the floor's exact friction; choose v_s
//! small against the speeds of interest (a smaller one costs integration steps).

use super::{Applied, Force, Scene};

/// Slip speed when none is given, rad/s or m/s.
pub const SLIP_SPEED: f64 = 0.05;

/// Friction of one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Index of the joint.
    pub joint: usize,
    /// Coulomb friction c, N m or N.
    pub coulomb: f64,
    /// Viscous friction d, N m s/rad or N s/m.
    pub viscous: f64,
}

/// Friction of several joints.
#[derive(Clone, Debug)]
pub struct JointFriction {
    /// The joints.
    pub joints: Vec<Joint>,
    /// Slip speed v_s.
    pub slip_speed: f64,
}

/// Effort of Coulomb friction at joint velocity `qd`.
pub fn coulomb(c: f64, qd: f64, slip_speed: f64) -> f64 {
    -c * (qd / slip_speed).tanh()
}

impl Force for JointFriction {
    fn evaluate(&mut self, scene: &Scene, applied: &mut Applied) {
        let nb = scene.model.nb();
        for j in &self.joints {
            let qd = scene.state.v[nb + j.joint];
            applied.joint(scene.model, j.joint, coulomb(j.coulomb, qd, self.slip_speed) - j.viscous * qd);
        }
    }
}
