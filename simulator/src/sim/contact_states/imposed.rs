//! States imposed on soles by the scenario (`contact.forced`).
//!
//! An imposed state is not checked: it has no event functions, no impact stops the sole, and
//! violations do not count as inconsistent. The residuals show them: friction beyond its capacity,
//! penetration, tension.

use crate::contact::model::per_sole::PerSole;
use crate::contact::model::state::SoleState;
use crate::contact::search::judge::{Assessment, Faults};
use crate::sim::event_kind::EventKind;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

impl RunState {
    /// Imposed states at time `t`.
    pub(in crate::sim) fn forced(&self, t: f64) -> PerSole<Option<SoleState>> {
        let mut forced = PerSole::default();
        for f in self.contact.forced.iter().filter(|f| f.from <= t && t < f.to) {
            forced[f.sole] = Some(f.state);
        }
        forced
    }

    /// Is the state of sole `s` imposed at the present time?
    pub(in crate::sim) fn is_imposed(&self, s: usize) -> bool {
        let t = self.plant.state.time;
        self.contact.forced.iter().any(|f| f.sole == s && f.from <= t && t < f.to)
    }

    /// Do all faults of a assessment belong to soles with imposed states?
    pub(in crate::sim) fn all_imposed(&self, assessment: &Assessment) -> bool {
        let forced = self.forced(self.plant.state.time);
        (0..self.plant.problem.soles.len()).all(|s| forced[s].is_some() || assessment.faults[s] == Faults::default())
    }

    /// Reports the states that are imposed from now on, and those no longer imposed.
    pub(in crate::sim) fn report_imposed(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let t = self.plant.state.time;
        for i in 0..self.contact.forced.len() {
            let forced = self.contact.forced[i];
            let change = match t {
                _ if t == forced.from => "imposed",
                _ if t == forced.to => "no longer imposed",
                _ => continue,
            };
            let sole = self.plant.model.soles[forced.sole].name.clone();
            self.event(observer, EventKind::Forced, &sole, &format!("{} {change}", forced.state))?;
        }
        Ok(())
    }
}
