//! States chosen for motion that is left: whether their loads are within the laws, and the choice for the present
//! velocities if not.

use crate::contact::model::residual;
use crate::contact::search::judge::{Rules, STILL};
use crate::sim::plant::Plant;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

/// Load beyond its limit, relative to the scale of loads, from which on states are chosen for motion that was not
/// stopped.
const EXCESS: f64 = 1e-8;

impl RunState {
    /// Whether a vertex slides so slowly that the states were chosen for one at rest. Its friction may have turned.
    pub(super) fn turns_slowly(&self) -> bool {
        let Plant { problem, states, .. } = &self.plant;
        problem.vertex_indices().any(|(s, i)| {
            let v = &problem.soles[s].vertices[i];
            let slides = states[s].is_dynamic() && states[s].clamps(i, problem.soles[s].vertices.len());
            slides && !v.moving && v.velocity.xy().norm() > STILL
        })
    }

    /// Whether the plant's forces are within the laws.
    pub(super) fn carries_loads(&mut self) -> bool {
        let plant = &mut self.plant;
        // The next choice begins with forces before they are shared.
        self.before_selection.copy_from(&plant.solution);
        plant.share_forces();
        let loads = residual::loads(&plant.problem, &plant.states, &plant.solution);
        plant.solution.copy_from(&self.before_selection);
        loads.excess() <= EXCESS * plant.problem.scale
    }

    /// Chooses the states again for the present velocities. Those before were chosen for slow motion to be
    /// stopped, but some of it is left, which gives friction other directions.
    pub(super) fn slide_on(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        self.plant.evaluate_free();
        self.plant.update_directions();
        let selection = self.select_by(Rules { stops: false, exhaustive: false, ..self.rules() }, observer)?;
        self.count(&selection);
        if selection.consistent {
            self.adopt(selection.states, observer)?;
        }
        self.plant.evaluate();
        Ok(())
    }
}
