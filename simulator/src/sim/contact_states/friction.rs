//! Friction regions of the vertices at an instant, with events at borders.

use crate::sim::event_kind::EventKind;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

impl RunState {
    /// Assigns every vertex the friction of its region. Needs the vertices at the present state.
    pub(in crate::sim) fn update_friction(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        if self.plant.floor.patches.is_empty() {
            return Ok(());
        }
        for s in 0..self.plant.problem.soles.len() {
            let k = self.plant.problem.soles[s].vertices.len();
            for i in 0..k {
                let changed = self.plant.update_friction(s, i);
                if changed && self.plant.states[s].clamps(i, k) {
                    let sole = self.plant.polygons[s].name().to_owned();
                    let onto = self.plant.region(s, i).map_or("the floor".to_owned(), |z| format!("patch {z}"));
                    self.event(observer, EventKind::Border, &sole, &format!("vertex {i} onto {onto}"))?;
                }
            }
        }
        Ok(())
    }
}
