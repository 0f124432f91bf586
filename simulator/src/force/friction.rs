//! `joint-friction`: friction in joints, by the law of [`crate::robot::JointFrictionLaw`], added to
//! the robot's own.

use super::{AppliedForces, Force, ForceContext, Slope};
use crate::robot::JointFrictionLaw;

/// Change of a velocity in a difference quotient of an effort.
const SPAN: f64 = 1e-6;

/// Additional friction of several joints.
#[derive(Clone, Debug)]
pub struct JointFriction {
    /// The joints.
    pub joints: Vec<(usize, JointFrictionLaw)>,
}

impl Force for JointFriction {
    fn arrows(&self) -> usize {
        0
    }

    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        let nb = context.model.nb();
        for (joint, friction) in &self.joints {
            applied.joint(context.model, *joint, friction.effort(context.state.v[nb + joint]));
        }
    }

    fn damping(&self, context: &ForceContext, out: &mut [f64]) {
        let nb = context.model.nb();
        for (joint, friction) in &self.joints {
            out[nb + joint] += friction.secant(context.state.v[nb + joint]);
        }
    }

    fn slopes(&self, context: &ForceContext, each: &mut dyn FnMut(Slope)) {
        let nb = context.model.nb();
        for (joint, friction) in &self.joints {
            let v = context.state.v[nb + joint];
            let damping = (friction.effort(v) - friction.effort(v + SPAN)) / SPAN;
            each(Slope::Joint { joint: *joint, damping });
        }
    }
}
