//! Writes `/residual`: residuals of the contact laws and the energy balance.

use crate::files::RecordError;
use crate::log::messages::Residual;
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
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        let (r, e) = (&s.residual, &s.energy);
        let message = Residual {
            time: s.time,
            penetration: r.penetration,
            tension: r.tension,
            signorini: r.signorini,
            cone_excess: r.cone_excess,
            dissipation_gap: r.dissipation_gap,
            creep_speed: r.creep_speed,
            resultant_gap: r.resultant_gap,
            energy_change: e.change,
            actuator_work: e.actuators,
            external_work: e.external,
            joint_loss: e.joint_loss,
            friction_loss: e.friction_loss,
            impact_loss: e.impact_loss,
            energy_error: e.error(),
        };
        output.send(&mut self.0, time, &message)
    }
}
