//! `push` and `constant`: a force and a moment on a link.

use super::profile::Profile;
use super::{AppliedForces, Force, ForceContext};
use crate::robot::LinkId;
use nalgebra::{UnitQuaternion, Vector3};

/// A force at a point fixed in a link and a moment, scaled by a profile over time.
#[derive(Clone, Debug)]
pub struct Wrench {
    /// Link it acts on.
    pub link: LinkId,
    /// Point in the link's internal frame, m.
    pub point: Vector3<f64>,
    /// Force at full strength, N.
    pub force: Vector3<f64>,
    /// Moment at full strength, N m.
    pub moment: Vector3<f64>,
    /// Orientation in the link's internal frame of the axes of force and moment; none for world
    /// axes.
    pub axes: Option<UnitQuaternion<f64>>,
    /// Strength over time.
    pub profile: Profile,
}

impl Force for Wrench {
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        let strength = self.profile.factor(context.time, context.within);
        if strength == 0.0 {
            return;
        }
        let (rotation, origin) = context.frame(self.link);
        let to_world = |v: &Vector3<f64>| match &self.axes {
            Some(axes) => rotation * (axes * v),
            None => *v,
        };
        let (force, moment) = (to_world(&self.force) * strength, to_world(&self.moment) * strength);
        applied.wrench(context, self.link, &(origin + rotation * self.point), &force, &moment);
    }

    fn corners(&self) -> &[f64] {
        self.profile.corners()
    }
}
