//! Choice of contact states at an instant: impacts first, then the states consistent with the
//! accelerations.

mod left_motion;

use super::drift_projection::anchor;
use crate::contact::hybrid::impact;
use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, SoleState, States};
use crate::contact::search::judge::Rules;
use crate::contact::search::select::Selection;
use crate::sim::event_kind::EventKind;
use crate::sim::report::{Observer, Outcome};
use crate::sim::run::{Deferral, RunState};
use crate::sim::run_error::RunError;
use nalgebra::Vector2;
use std::sync::atomic::Ordering;

/// Rounds of selection and velocity jumps at one instant.
const ROUNDS: usize = 8;
/// Change of a vertex's velocity, m/s, up to which a jump needs no other choice of states: rounding. A
/// jump from below the rest speed may turn the directions of other slow vertices, and with them loads.
const NO_CHANGE: f64 = 1e-12;
/// Impacts that may follow each other at one instant.
const CASCADE: usize = 32;
/// Impacts at one instant after which all slow touching vertices are stopped together.
const ALTERNATING: usize = 3;

/// Height, m, by which the work of impulses that stop slow motion of clamped vertices may at most lift all
/// bodies. Friction of sliding soles may add a little.
const GAIN: f64 = 1e-3;

/// Greatest number of times that patches follow the states at one choice.
const FOLLOWED: usize = 4;

/// Greatest number of turns of the rings of cylinders at one choice of states.
const TURNS: usize = 8;

/// Work of the impulses of a solution, J.
fn impulse_work(p: &Problem, solution: &Solution) -> f64 {
    let mean = p.b.iter().zip(&solution.motion).map(|(before, after)| 0.5 * (before + after));
    solution.wrench.iter().zip(mean).map(|(w, v)| w * v).sum()
}

impl RunState {
    /// Chooses the contact states at the plant's present state, with impacts where vertices hit the
    /// floor, and leaves the plant evaluated.
    pub(in crate::sim) fn choose_states(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        self.update_polygons(None);
        if self.plant.is_compliant() {
            self.plant.evaluate();
            return self.read_compliant_states(observer);
        }
        self.plant.evaluate_free();
        self.update_friction(observer)?;
        self.plant.update_directions();
        if self.plant.method.locates_events() && self.locates_events() {
            self.count_event()?;
        }
        self.choose_in_rounds(observer)?;
        // The load moves along with the ring.
        for _ in 0..TURNS {
            if !self.turn_rings() {
                break;
            }
            self.plant.evaluate_free();
            self.plant.update_directions();
            self.choose_in_rounds(observer)?;
        }
        Ok(())
    }

    /// Impacts, selections and velocity jumps in turn, until a selection needs no jump.
    fn choose_in_rounds(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let mut impacts = 0;
        let mut leaves_motion = false;
        for round in 1..=ROUNDS {
            // Vertices brought to rest may drive others into the floor.
            while self.plant.method.locates_events() && self.hits() {
                self.impact(observer)?;
                impacts += 1;
                if impacts == ALTERNATING {
                    self.stop_touching_vertices();
                }
                if impacts > CASCADE {
                    let t = self.plant.state.time;
                    return Err(RunError::new(
                        Outcome::Stalled,
                        format!("more than {CASCADE} impacts in a row at {t:.9} s"),
                    ));
                }
            }
            let mut selection = self.select(false, observer)?;
            self.count(&selection);
            let mut invalid = !selection.consistent && !self.all_imposed(&selection.assessment);
            // A jam is a solution only if a state is chosen after it. Its law finds out whether finite
            // forces exist, so that all states are searched only without a jam.
            if invalid && round < ROUNDS && self.resolve_jam(observer)? {
                continue;
            }
            if invalid && !selection.exhausted {
                if let Some(slip) = self.slow_jamming_slip(true, observer)? {
                    return self.choose_states_with_rest(slip, observer);
                }
                self.plant.evaluate_free();
                self.plant.solution.copy_from(&self.before_selection);
                if self.defers() {
                    self.deferral = Deferral::Due;
                    break;
                }
                selection = self.select(true, observer)?;
                self.count(&selection);
                invalid = !selection.consistent && !self.all_imposed(&selection.assessment);
            }
            if invalid && let Some(slip) = self.slow_jamming_slip(false, observer)? {
                return self.choose_states_with_rest(slip, observer);
            }
            if invalid {
                // The run continues with the states of least violation.
                let message = format!("no contact state is valid; least violations {:?}", selection.assessment.levels);
                self.report_inconsistent(observer, &message)?;
            }
            self.adopt(selection.states, observer)?;
            // Normal motion (below v_t) and slip (below the rest speed) that the new state does not
            // allow end here; the choice is then repeated with the consistent velocities.
            let change = self.stop_clamped_directions();
            leaves_motion = change.is_none();
            let change = change.unwrap_or(0.0);
            self.plant.evaluate_free();
            if change <= if self.locates_events() { NO_CHANGE } else { self.tolerances.rest } {
                break;
            }
            if round == ROUNDS && change > self.tolerances.rest && self.defers() {
                // The last states were chosen for other velocities.
                self.deferral = Deferral::Due;
            }
        }
        self.suspect.fill(0);
        // Confirmed states may hold other vertices.
        for _ in 0..FOLLOWED {
            if !self.follow_states() || self.deferral == Deferral::Due {
                break;
            }
            leaves_motion = self.confirm_states(observer)?;
        }
        self.plant.evaluate();
        if self.locates_events() && self.deferral != Deferral::Due && !self.carries_loads() {
            if leaves_motion || self.turns_slowly() {
                self.slide_on(observer)?;
            }
            if self.defers() && !self.carries_loads() {
                // The states hold for velocities or polygons that are no longer the present ones.
                self.plant.evaluate_free();
                self.deferral = Deferral::Due;
            }
        }
        Ok(())
    }

    /// Chooses the states again after patches have followed them: the new problem has no split of an indeterminate
    /// load yet. Returns whether motion is left that they do not allow.
    fn confirm_states(&mut self, observer: &mut dyn Observer) -> Result<bool, RunError> {
        let mut leaves_motion = false;
        for _ in 0..ROUNDS {
            self.plant.evaluate_free();
            self.plant.update_directions();
            let selection = self.select(false, observer)?;
            self.count(&selection);
            if !selection.consistent {
                break;
            }
            self.adopt(selection.states, observer)?;
            let change = self.stop_clamped_directions();
            leaves_motion = change.is_none();
            if change.is_none_or(|change| change <= NO_CHANGE) {
                break;
            }
        }
        self.plant.evaluate_free();
        Ok(leaves_motion)
    }

    /// As [`choose_states`](Self::choose_states), with vertices slower than `speed` (m/s) set to
    /// rest. The jump to rest changes velocities, and with them directions of friction and loads, so
    /// the states are then chosen again for these velocities.
    pub(in crate::sim) fn choose_states_with_rest(
        &mut self,
        speed: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let saved = (self.plant.rest, self.tolerances.rest);
        (self.plant.rest, self.tolerances.rest) = (saved.0.max(speed), saved.1.max(speed));
        let result = self.choose_states(observer);
        (self.plant.rest, self.tolerances.rest) = saved;
        result?;
        if speed > saved.1 && self.deferral != Deferral::Due {
            self.plant.evaluate_free();
            self.plant.update_directions();
            self.choose_in_rounds(observer)?;
        }
        Ok(())
    }

    /// May the choice of states be left to velocity-level steps?
    pub(in crate::sim) fn defers(&self) -> bool {
        let is_imposed = (0..self.plant.problem.soles.len()).any(|s| self.is_imposed(s));
        self.deferral != Deferral::Refused && self.locates_events() && !is_imposed
    }

    /// Does a vertex hit the floor?
    fn hits(&self) -> bool {
        let plant = &self.plant;
        impact::is_due(&plant.problem, &plant.states, &self.tolerances, |s| self.is_imposed(s))
    }

    /// Rules of the selection.
    pub(in crate::sim) fn rules(&self) -> Rules {
        let may_contradict = self.plant.may_contradict();
        let rules = Rules::new(self.tolerances, self.plant.states.clone());
        Rules { suspect: self.suspect.clone(), may_contradict, ..rules }
    }

    /// Selects states at the acceleration level, from all of them as a last resort if `exhaustive`.
    fn select(&mut self, exhaustive: bool, observer: &mut dyn Observer) -> Result<Selection, RunError> {
        self.select_by(Rules { exhaustive, ..self.rules() }, observer)
    }

    /// Selects states at the acceleration level, by these rules.
    fn select_by(&mut self, rules: Rules, observer: &mut dyn Observer) -> Result<Selection, RunError> {
        self.before_selection.copy_from(&self.plant.solution);
        let forced = self.forced(self.plant.state.time);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f == state);
        let cancel = self.cancel.clone();
        let input = SelectionInput { rules: &rules, event: true, allowed: &allowed, cancel: cancel.as_deref() };
        self.record_problem(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.select(&mut plant.problem, &input, &mut plant.solution);
        self.record_solution(observer, &selection)?;
        self.check_search(&selection, rules.exhaustive)?;
        Ok(selection)
    }

    /// Fails when a search ended early: cancelled, or, if it was `exhaustive`, before all states were
    /// tried.
    pub(in crate::sim) fn check_search(&self, selection: &Selection, exhaustive: bool) -> Result<(), RunError> {
        if self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
            return Err(RunError::new(Outcome::Cancelled, "interrupted"));
        }
        if !exhaustive || selection.consistent || selection.exhausted || self.all_imposed(&selection.assessment) {
            return Ok(());
        }
        let touching = self.plant.problem.soles.iter().filter(|s| s.vertices.iter().any(|v| v.height <= 0.0)).count();
        let message = format!(
            "no valid contact state among {} tested at {:.9} s, with {touching} soles and links on or below the floor",
            selection.tested, self.plant.state.time
        );
        Err(RunError::new(Outcome::Stalled, message))
    }

    /// Counts a selection.
    pub(in crate::sim) fn count(&mut self, selection: &Selection) {
        self.metrics.selections += 1;
        self.metrics.states_tested += selection.tested as u64;
        self.metrics.full_searches += u64::from(selection.full);
        self.metrics.states_tested_max = self.metrics.states_tested_max.max(selection.tested as u64);
    }

    /// Applies an impact.
    pub(in crate::sim) fn impact(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let rules = self.rules();
        let tol = self.tolerances;
        let forced = self.forced(self.plant.state.time);
        let plant = &mut self.plant;
        let fastest = impact::set_impact(&mut plant.problem, &plant.reduced.velocity, &tol, self.contact.restitution);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        let cancel = self.cancel.clone();
        let input = SelectionInput { rules: &rules, event: true, allowed: &allowed, cancel: cancel.as_deref() };
        self.record_problem(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.record_solution(observer, &selection)?;
        self.check_search(&selection, rules.exhaustive)?;
        let plant = &mut self.plant;
        let impulses = std::mem::take(&mut plant.solution.wrench);
        let jump = plant.apply_impulses(&impulses);
        plant.solution.wrench = impulses;
        let loss = -jump.contact;
        self.energy.add_jump(jump);
        self.metrics.impacts += 1;
        if fastest > tol.velocity {
            self.last_collision = self.plant.state.time;
        }
        let (t, after) = (self.plant.state.time, self.plant.kinetic_energy());
        self.milestones.record_impact(t, after, loss, &mut self.metrics);
        self.count(&selection);
        if !selection.consistent && !self.all_imposed(&selection.assessment) {
            self.report_inconsistent(observer, "no contact state is valid at an impact")?;
        }
        let message = format!("approach {fastest:.6} m/s, energy lost {loss:.6e} J");
        self.event(observer, EventKind::Impact, "", &message)?;
        self.adopt(selection.states, observer)?;
        self.plant.evaluate_free();
        Ok(())
    }

    /// Counts and reports a change of the state of sole `s`.
    pub(in crate::sim) fn report_change(
        &mut self,
        s: usize,
        old: SoleState,
        new: SoleState,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let kind = match (old, new) {
            (SoleState::FREE, _) => EventKind::Touchdown,
            (_, SoleState::FREE) => EventKind::Liftoff,
            _ if old.is_static() && new.is_dynamic() => EventKind::Slip,
            _ if old.is_dynamic() && new.is_static() => EventKind::Stick,
            _ => EventKind::State,
        };
        let first = match kind {
            EventKind::Touchdown => Some(&mut self.metrics.first_touchdown_s),
            EventKind::Liftoff => Some(&mut self.metrics.first_liftoff_s),
            EventKind::Slip => Some(&mut self.metrics.first_slip_s),
            EventKind::Stick => Some(&mut self.metrics.first_stick_s),
            _ => None,
        };
        if let Some(first) = first {
            first.get_or_insert(self.plant.state.time);
        }
        self.metrics.state_changes += 1;
        let subject = self.plant.polygons[s].name().to_owned();
        self.event(observer, kind, &subject, &format!("{old} to {new}"))
    }

    /// Reports that torsional or rolling friction of a contact that remains begins or ceases to hold.
    fn report_turning(
        &mut self,
        s: usize,
        old: SoleState,
        new: SoleState,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        let plant = &self.plant;
        let (Some(turning), Some(before)) = (plant.problem.soles[s].turning(), plant.turning.get(s)) else {
            return Ok(());
        };
        if !self.started || old == SoleState::FREE || new == SoleState::FREE {
            return Ok(());
        }
        let changes = [
            (turning.torsional > 0.0, before.holds_spin, turning.mode.holds_spin, ["spin begins", "spin ends"]),
            (turning.rolling > 0.0, before.holds_roll, turning.mode.holds_roll, ["roll begins", "roll ends"]),
        ];
        for (exists, was_held, is_held, message) in changes {
            if exists && was_held != is_held {
                let subject = self.plant.polygons[s].name().to_owned();
                self.event(observer, EventKind::Turning, &subject, message[usize::from(is_held)])?;
            }
        }
        Ok(())
    }

    /// Adopts the states: counts and reports changes, and anchors the vertices of soles that
    /// changed.
    pub(in crate::sim) fn adopt(&mut self, states: States, observer: &mut dyn Observer) -> Result<(), RunError> {
        for s in 0..self.plant.problem.soles.len() {
            let (old, new) = (self.plant.states[s], states[s]);
            for (d, v) in self.plant.directions[s].iter_mut().zip(&self.plant.problem.soles[s].vertices) {
                *d = v.direction;
            }
            self.report_turning(s, old, new, observer)?;
            if old == new {
                continue;
            }
            if !self.started {
                // The first choice is the initial state, not an event.
                anchor(self, s);
                continue;
            }
            self.report_change(s, old, new, observer)?;
            if new != SoleState::FREE {
                anchor(self, s);
            }
        }
        self.plant.states = states;
        self.plant.adopt_turning();
        Ok(())
    }

    /// Stops the slow normal motion of all touching vertices together, without sliding friction.
    ///
    /// A sole brought to rest may drive another into the floor, whose impact lifts the first: jumps
    /// below v_t alternate at one instant, and each loses little energy. This ends them.
    fn stop_touching_vertices(&mut self) {
        let tol = self.tolerances;
        let mut states = States::default();
        for (s, sole) in self.plant.problem.soles.iter().enumerate().filter(|(s, _)| !self.is_imposed(*s)) {
            let k = sole.vertices.len();
            let pattern = Pattern::covering(k, |i| sole.vertices[i].is_near(&tol));
            let state = SoleState::sliding(pattern);
            if pattern != Pattern::Free && (0..k).all(|i| !state.clamps(i, k) || sole.vertices[i].is_in_band(&tol)) {
                states[s] = state;
            }
        }
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let held = impact::set_rest(p, &plant.reduced.velocity, &states, &tol, 0.0);
        p.soles.iter_mut().flat_map(|sole| &mut sole.vertices).for_each(|v| v.direction = Vector2::zeros());
        p.free_turning();
        plant.method.respond(p, &held, &mut self.projection);
        p.set_directions(&plant.directions);
        p.set_turning_modes(&plant.turning);
        let jump = plant.apply_impulses(&self.projection.wrench);
        self.energy.add_jump(jump);
        self.plant.evaluate_free();
    }

    /// Brings the clamped directions of the adopted states to rest by a velocity jump. Returns the
    /// greatest change of a vertex's velocity, m/s; none if the motion is left, as the jump would be out of
    /// proportion to it.
    fn stop_clamped_directions(&mut self) -> Option<f64> {
        let tol = self.tolerances;
        // For a method without event location the impacts happen here.
        let bounce = if self.plant.method.locates_events() { 0.0 } else { self.contact.restitution };
        // A rest speed above rounding needs the least change of velocity, as drift does.
        let least = tol.rest > self.contact.tolerances.rest;
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let states = impact::set_rest(p, &plant.reduced.velocity, &plant.states, &tol, bounce);
        if least {
            // Friction impulses of soles that keep sliding would have either sign and could add
            // energy.
            let vertices = p.soles.iter_mut().flat_map(|sole| &mut sole.vertices);
            vertices.for_each(|v| v.direction = Vector2::zeros());
            p.clear_turning_directions();
        }
        plant.method.respond(p, &states, &mut self.projection);
        if !least && impulse_work(p, &self.projection) > GAIN * plant.problem.scale {
            // Normal impulses respond to friction almost without bound.
            let vertices = plant.problem.soles.iter_mut().flat_map(|sole| &mut sole.vertices);
            vertices.for_each(|v| v.direction = Vector2::zeros());
            plant.problem.clear_turning_directions();
            plant.method.respond(&plant.problem, &states, &mut self.projection);
            plant.problem.set_directions(&plant.directions);
            plant.problem.set_turning_modes(&plant.turning);
        }
        let p = &mut plant.problem;
        if least {
            p.set_directions(&plant.directions);
            p.set_turning_modes(&plant.turning);
        }
        if !self.is_projectable(self.velocity_error(&states)) {
            return None;
        }
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let change = impact::greatest_change(p, &self.projection.motion);
        let jump = plant.apply_impulses(&self.projection.wrench);
        self.energy.add_jump(jump);
        Some(change)
    }
}
