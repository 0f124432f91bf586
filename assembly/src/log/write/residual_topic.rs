//! Writes `/residual`: residuals of the contact laws and the energy balance.

use crate::files::RecordError;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::sim::Snapshot;
use std::collections::BTreeMap;

pub(super) struct ResidualTopic(Channel);

impl ResidualTopic {
    pub fn open(output: &mut LogOutput) -> Result<Self, RecordError> {
        Ok(Self(output.stiction("/residual", "Residual", BTreeMap::new())?))
    }
}

impl Topic for ResidualTopic {
    /// Fields as in [`Residual`](crate::log::messages::Residual).
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let (r, e) = (&s.residual, &s.energy);
        output.send_fields(&mut self.0, time, |to| {
            to.double(1, s.time);
            to.double(2, r.penetration);
            to.double(3, r.tension);
            to.double(4, r.signorini);
            to.double(5, r.cone_excess);
            to.double(6, r.dissipation_gap);
            to.double(7, r.creep_speed);
            to.double(8, r.resultant_gap);
            to.double(9, e.change);
            to.double(10, e.actuators);
            to.double(11, e.external);
            to.double(12, e.joint_loss);
            to.double(13, e.friction_loss);
            to.double(14, e.impact_loss);
            to.double(15, e.error());
        })
    }
}
