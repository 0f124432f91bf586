//! Friction in joints.
//!
//! ```text
//! tau = -[c + (s - c) exp(-(qd / v_str)^2)] tanh(qd / v_s) - d qd
//! ```
//!
//! c Coulomb, s static, d viscous friction, v_str the Stribeck speed over which static friction
//! falls to Coulomb's, v_s the slip speed. Source: [Olsson 1998], equations 1 to 4, with the
//! hyperbolic tangent instead of the jump at rest. Below the slip speed a joint under the load tau
//! creeps at about `v_s atanh(tau / s)` instead of sticking. This is a regularized model, not the
//! floor's exact friction. Choose v_s small compared with the speeds of interest, and compared with
//! v_str if static friction is to reach its full value. Smaller values cost integration steps.

use crate::math;

/// Slip speed when none is given, rad/s or m/s.
pub const SLIP_SPEED: f64 = 0.05;
/// Stribeck speed when none is given, rad/s or m/s.
pub const STRIBECK_SPEED: f64 = 0.2;

/// Friction of one joint; speeds in rad/s or m/s, frictions in N m or N, viscous friction per
/// speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFrictionLaw {
    /// Coulomb friction c.
    pub coulomb: f64,
    /// Viscous friction d.
    pub viscous: f64,
    /// Static friction s; without effect unless greater than Coulomb friction.
    pub static_: f64,
    /// Stribeck speed v_str, above 0.
    pub stribeck_velocity: f64,
    /// Slip speed v_s, above 0.
    pub slip_velocity: f64,
}

impl Default for JointFrictionLaw {
    fn default() -> Self {
        JointFrictionLaw {
            coulomb: 0.0,
            viscous: 0.0,
            static_: 0.0,
            stribeck_velocity: STRIBECK_SPEED,
            slip_velocity: SLIP_SPEED,
        }
    }
}

impl JointFrictionLaw {
    /// Size of the dry friction at the joint velocity `qd`, before the hyperbolic tangent.
    fn dry(&self, qd: f64) -> f64 {
        if self.static_ > self.coulomb {
            self.coulomb + (self.static_ - self.coulomb) * math::exp(-math::powi(qd / self.stribeck_velocity, 2))
        } else {
            self.coulomb
        }
    }

    /// True with dry friction.
    pub fn is_dry(&self) -> bool {
        self.coulomb > 0.0 || self.static_ > 0.0
    }

    /// Effort at the joint velocity `qd`.
    pub fn effort(&self, qd: f64) -> f64 {
        let viscous = -(self.viscous * qd);
        if self.is_dry() { viscous + -self.dry(qd) * math::tanh(qd / self.slip_velocity) } else { viscous }
    }

    /// `-effort / qd`: the damping that replaces friction in a velocity-level step. Evaluated at
    /// the velocity at the step's end it never reverses the motion, however large friction is
    /// compared with inertia.
    pub fn secant(&self, qd: f64) -> f64 {
        if !self.is_dry() {
            return self.viscous;
        }
        let x = qd.abs() / self.slip_velocity;
        let steep = if x > 1e-8 { math::tanh(x) / x } else { 1.0 };
        self.viscous + self.dry(qd) * steep / self.slip_velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_has_its_limits() {
        let f =
            JointFrictionLaw { coulomb: 2.0, viscous: 0.5, static_: 3.0, stribeck_velocity: 0.3, slip_velocity: 1e-4 };
        // Just off rest all of the static friction, well above the Stribeck speed Coulomb's and the
        // viscous part.
        assert!((f.effort(2e-3) + 3.0).abs() < 2e-3 && (f.effort(-3.0) - 3.5).abs() < 1e-12);
        assert_eq!((f.effort(0.0), f.effort(-0.1)), (0.0, -f.effort(0.1)));
        for qd in [0.0, 1e-14, 1e-5, 0.1, -4.0] {
            assert!((f.secant(qd) * qd + f.effort(qd)).abs() < 1e-15 * 4.0, "{qd}");
        }
        assert_eq!(f.secant(0.0), 0.5 + 3.0 / 1e-4);
        // Without static friction the law is Coulomb's.
        let plain = JointFrictionLaw { static_: 0.0, ..f };
        assert!((plain.effort(0.01) + 2.005).abs() < 1e-12);
    }
}
