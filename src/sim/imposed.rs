//! States imposed on soles by the scenario (`contact.forced`).
//!
//! A sole that is told its state is not asked whether it could hold it: nothing of it is watched, no impact stops it, and
//! what its state violates is not counted as inconsistent. The residuals show it: friction beyond its capacity,
//! penetration, tension.

use super::error::Stop;
use super::report::Observer;
use super::simulation::Simulation;
use crate::contact::search::judge::{Faults, Verdict};

impl Simulation {
    /// Is the state of sole `s` imposed at the present time?
    pub(super) fn is_imposed(&self, s: usize) -> bool {
        self.forced(self.plant.state.time)[s].is_some()
    }

    /// Is all that a verdict finds fault with imposed?
    pub(super) fn all_imposed(&self, verdict: &Verdict) -> bool {
        let forced = self.forced(self.plant.state.time);
        forced.iter().zip(&verdict.faults).all(|(forced, faults)| forced.is_some() || *faults == Faults::default())
    }

    /// Tells what is imposed from now on, and what no longer.
    pub(super) fn tell_imposed(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let t = self.plant.state.time;
        for i in 0..self.contact.forced.len() {
            let forced = self.contact.forced[i];
            let what = match t {
                _ if t == forced.from => "imposed",
                _ if t == forced.to => "no longer imposed",
                _ => continue,
            };
            let sole = self.plant.model.soles[forced.sole].name.clone();
            self.event(observer, "forced", &sole, &format!("{} {what}", forced.state))?;
        }
        Ok(())
    }
}
