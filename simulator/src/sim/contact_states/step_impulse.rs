//! Contact states and impulses of a velocity-level step.

use super::drift_projection::anchor;
use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::select::Selection;
use crate::sim::report::Observer;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;

impl RunState {
    /// Chooses states and impulses of this step.
    pub(in crate::sim) fn choose_impulse(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let selection = self.solve_impulse(observer)?;
        self.adopt(selection.states, observer)
    }

    /// Chooses the impulses of a step of a sliding mode. The contact laws hold for every vertex as a
    /// point, so that no state must be valid. Changes of states are neither events nor new anchors.
    pub(in crate::sim) fn choose_unreported_impulse(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let is_imposed = (0..self.plant.problem.soles.len()).any(|s| self.is_imposed(s));
        let plant = &mut self.plant;
        let points = if is_imposed { None } else { plant.method.point_impulse(&plant.problem, &mut plant.solution) };
        plant.has_point_forces = points.is_some();
        if let Some(states) = points {
            plant.states = states;
            for (s, directions) in plant.directions.iter_mut().enumerate() {
                for (i, d) in directions.iter_mut().enumerate() {
                    let t = plant.problem.vertex_motion(&plant.solution.motion, s, i).xy();
                    *d = t.try_normalize(0.0).unwrap_or_default();
                }
            }
            return Ok(());
        }
        self.plant.states = self.solve_impulse(observer)?.states;
        for (directions, sole) in self.plant.directions.iter_mut().zip(&self.plant.problem.soles) {
            directions.iter_mut().zip(&sole.vertices).for_each(|(d, v)| *d = v.direction);
        }
        self.plant.adopt_turning();
        Ok(())
    }

    /// Anchors the soles whose states differ from those `before` a step of a sliding mode: their
    /// vertices on the floor, except under imposed states.
    pub(in crate::sim) fn anchor_changed(&mut self, before: &States) {
        for s in 0..self.plant.problem.soles.len() {
            let state = self.plant.states[s];
            if state == before[s] || state == SoleState::FREE || self.is_imposed(s) {
                continue;
            }
            anchor(self, s);
            let k = self.anchors[s].len();
            let clamped = self.anchors[s].iter_mut().enumerate().filter(|(i, _)| state.clamps(*i, k));
            clamped.for_each(|(_, anchor)| anchor.z = 0.0);
        }
    }

    fn solve_impulse(&mut self, observer: &mut dyn Observer) -> Result<Selection, RunError> {
        let rules = self.rules();
        let forced = self.forced(self.plant.state.time);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        let cancel = self.cancel.clone();
        let input = SelectionInput { rules: &rules, event: false, allowed: &allowed, cancel: cancel.as_deref() };
        self.record_problem(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.record_solution(observer, &selection)?;
        self.check_search(&selection, true)?;
        self.count(&selection);
        if !selection.consistent && !self.all_imposed(&selection.assessment) {
            let message = format!("no contact state is valid; least violations {:?}", selection.assessment.levels);
            self.report_inconsistent(observer, &message)?;
        }
        Ok(selection)
    }
}
