//! A force model that acts on an object instead of the robot.

use super::{AppliedForces, Damper, Force, ForceContext, ForceError, ReportEvent, Slope};
use std::any::Any;

/// A force model of an object. Links and joints of the model are those of the object.
pub struct OnObject {
    /// Index of the object.
    pub object: usize,
    /// The model.
    pub force: Box<dyn Force>,
}

impl Force for OnObject {
    fn mechanism(&self) -> usize {
        self.object + 1
    }

    /// A model continues only on the same object.
    fn continue_from(&mut self, former: &dyn Any, time: f64) {
        if let Some(former) = former.downcast_ref::<OnObject>().filter(|former| former.object == self.object) {
            let former: &dyn Any = &*former.force;
            self.force.continue_from(former, time);
        }
    }

    fn arrows(&self) -> usize {
        self.force.arrows()
    }

    fn init(&mut self, context: &ForceContext) -> Result<(), ForceError> {
        self.force.init(context)
    }

    fn on_corner(&mut self, context: &ForceContext, report: &mut ReportEvent) {
        self.force.on_corner(context, report);
    }

    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        self.force.evaluate(context, applied);
    }

    fn damping(&self, context: &ForceContext, out: &mut [f64]) {
        self.force.damping(context, out);
    }

    fn dampers(&self, context: &ForceContext, damper: &mut dyn FnMut(Damper)) {
        self.force.dampers(context, damper);
    }

    fn slopes(&self, context: &ForceContext, each: &mut dyn FnMut(Slope)) {
        self.force.slopes(context, each);
    }

    fn corners(&self) -> &[f64] {
        self.force.corners()
    }

    fn failure(&self) -> Option<ForceError> {
        self.force.failure()
    }
}
