//! `joint-friction`: friction in joints, by the law of [`crate::robot::Friction`], added to what the robot has.

use super::{Applied, Force, Scene};
use crate::robot::Friction;

/// Friction of several joints, by their numbers.
#[derive(Clone, Debug)]
pub struct JointFriction {
    /// The joints.
    pub joints: Vec<(usize, Friction)>,
}

impl Force for JointFriction {
    fn arrows(&self) -> usize {
        0
    }

    fn evaluate(&mut self, scene: &Scene, applied: &mut Applied) {
        let nb = scene.model.nb();
        for (joint, friction) in &self.joints {
            applied.joint(scene.model, *joint, friction.effort(scene.state.v[nb + joint]));
        }
    }

    fn damping(&self, scene: &Scene, out: &mut [f64]) {
        let nb = scene.model.nb();
        for (joint, friction) in &self.joints {
            out[nb + joint] += friction.secant(scene.state.v[nb + joint]);
        }
    }
}
