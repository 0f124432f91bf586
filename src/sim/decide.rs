//! Choosing contact states at an instant: impacts first, then the state that the accelerations call for.

use super::direction::DIRECTION_SPEED;
use super::error::Stop;
use super::project::anchor;
use super::report::{Observer, Outcome};
use super::simulation::Simulation;
use crate::contact::hybrid::impact;
use crate::contact::methods::contact_method::SelectionInput;
use crate::contact::model::state::{MAX_SOLES, Mode, SoleState, States};
use crate::contact::search::judge::Rules;
use crate::contact::search::select::Selection;
use nalgebra::Vector2;

/// Rounds of choosing and settling at one instant.
const SETTLE: usize = 4;
/// How far from zero a slowing vertex may be led past it, relative to the speed up to which its direction is held.
const MISS: f64 = 0.1;
/// Acceleration, relative to gravity, from which on it may be friction's; less is that of motions, however slow.
const QUICK: f64 = 0.05;
/// Impacts that may follow each other at one instant.
const CASCADE: usize = 32;

impl Simulation {
    /// Chooses the contact states at the plant's present state, with impacts where something hits the floor, and leaves
    /// the plant evaluated.
    pub(super) fn decide(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        if self.plant.is_compliant() {
            self.plant.evaluate();
            return self.comply(observer);
        }
        self.plant.evaluate_free();
        self.find_friction(observer)?;
        self.plant.point_directions();
        if self.plant.method.locates_events() && self.locates() {
            self.count_event()?;
        }
        let mut impacts = 0;
        for round in 1..=SETTLE {
            // What has just been brought to rest may have thrown something else onto the floor.
            while self.plant.method.locates_events() && self.hits() {
                self.impact(observer)?;
                impacts += 1;
                if impacts > CASCADE {
                    let t = self.plant.state.time;
                    return Err(Stop::new(Outcome::Stalled, format!("{CASCADE} impacts in a row at {t:.9} s")));
                }
            }
            let selection = self.choose(observer)?;
            self.count(&selection);
            let lost = !selection.consistent && !self.all_imposed(&selection.verdict);
            // A jam is only an answer if a state is chosen after it.
            if lost && round < SETTLE && self.jam(observer)? {
                continue;
            }
            if lost {
                // Whatever comes of it: the state adopted now is none.
                let message = format!("no contact state is valid; least violations {:?}", selection.verdict.levels);
                self.inconsistent(observer, &message)?;
            }
            self.adopt(selection.states, observer)?;
            // What little normal motion (below v_t) and slip (below the rest speed) the new state does not allow ends
            // here; the choice is then made once more with the velocities that go with it.
            let change = self.settle();
            self.plant.evaluate_free();
            if change <= self.tolerances.rest {
                break;
            }
        }
        self.suspect = [0; MAX_SOLES];
        self.plant.evaluate();
        Ok(())
    }

    /// As [`decide`](Self::decide), but what is slower than `speed` (m/s) rests.
    pub(super) fn decide_with_rest(&mut self, speed: f64, observer: &mut dyn Observer) -> Result<(), Stop> {
        let kept = (self.plant.rest, self.tolerances.rest);
        (self.plant.rest, self.tolerances.rest) = (kept.0.max(speed), kept.1.max(speed));
        let decided = self.decide(observer);
        (self.plant.rest, self.tolerances.rest) = kept;
        decided
    }

    /// Does a vertex slide slower than `speed`, m/s?
    pub(super) fn crawls(&self, speed: f64) -> bool {
        self.plant.problem.soles.iter().enumerate().any(|(s, sole)| {
            let (state, k) = (self.plant.states[s], sole.vertices.len());
            let slow = |i: usize| sole.vertices[i].velocity.xy().norm() <= speed;
            state.is_dynamic() && (0..k).any(|i| state.clamps(i, k) && slow(i))
        })
    }

    /// Speed, m/s, up to which vertices are to rest because steps do not resolve how they come to it; 0 if they do.
    ///
    /// Where friction of one vertex answers that of others its sliding direction is stiff near zero: it turns at a rate of
    /// many times acceleration over speed. Explicit steps follow it, each to some part of the speed at which it began, down
    /// to the speed that is their own error (`Plant::direction_speed`). There it is held, and may be that of the error. If the
    /// vertex slows down then as fast as friction makes it, and is led past zero, it is at rest as far as can be told.
    pub(super) fn slow_to_rest(&self) -> f64 {
        let plant = &self.plant;
        let quick = QUICK * plant.gravity.norm();
        let of_sole = |s: usize| {
            let (state, vertices) = (plant.states[s], &plant.problem.soles[s].vertices);
            let slow = plant.direction_speed(s);
            let past = |i: usize| {
                let v = vertices[i].velocity.xy();
                let a = plant.problem.vertex_motion(&plant.solution.motion, s, i).xy();
                v.norm() <= slow && a.norm() > quick && v.dot(&a) < 0.0 && v.perp(&a).abs() > MISS * slow * a.norm()
            };
            let slides = |i: usize| state.clamps(i, vertices.len()) && state.mode != Mode::Pivoting(i as u8);
            let held = self.locates() && state.is_dynamic() && slow > DIRECTION_SPEED;
            if held && (0..vertices.len()).any(|i| slides(i) && past(i)) { slow } else { 0.0 }
        };
        (0..plant.problem.soles.len()).map(of_sole).fold(0.0, f64::max)
    }

    /// Does a vertex hit the floor?
    fn hits(&self) -> bool {
        let plant = &self.plant;
        impact::is_due(&plant.problem, &plant.states, &self.tolerances, |s| self.is_imposed(s))
    }

    pub(super) fn rules(&self) -> Rules {
        Rules { tolerances: self.tolerances, previous: self.plant.states, suspect: self.suspect, hops: false }
    }

    /// The acceleration-level choice at the present state.
    fn choose(&mut self, observer: &mut dyn Observer) -> Result<Selection, Stop> {
        let rules = self.rules();
        let forced = self.forced(self.plant.state.time);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f == state);
        let input = SelectionInput { rules: &rules, event: true, allowed: &allowed };
        self.freeze(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.select(&mut plant.problem, &input, &mut plant.solution);
        self.freeze_answer(observer, &selection)?;
        Ok(selection)
    }

    /// Imposed states at time `t`.
    pub(super) fn forced(&self, t: f64) -> [Option<SoleState>; MAX_SOLES] {
        let mut forced = [None; MAX_SOLES];
        for f in self.contact.forced.iter().filter(|f| f.from <= t && t < f.to) {
            forced[f.sole] = Some(f.state);
        }
        forced
    }

    pub(super) fn count(&mut self, selection: &Selection) {
        self.metrics.selections += 1;
        self.metrics.states_tested += selection.tested as u64;
        self.metrics.states_tested_max = self.metrics.states_tested_max.max(selection.tested as u64);
    }

    /// Velocity jump of an impact.
    pub(super) fn impact(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let rules = self.rules();
        let tol = self.tolerances;
        let forced = self.forced(self.plant.state.time);
        let plant = &mut self.plant;
        let fastest = impact::set_impact(&mut plant.problem, &plant.reduced.velocity, &tol, self.contact.restitution);
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        let input = SelectionInput { rules: &rules, event: true, allowed: &allowed };
        self.freeze(observer, &input, &forced);
        let plant = &mut self.plant;
        let selection = plant.method.impulse(&mut plant.problem, &input, &mut plant.solution);
        self.freeze_answer(observer, &selection)?;
        let plant = &mut self.plant;
        let impulses = std::mem::take(&mut plant.solution.wrench);
        let jump = plant.kick(&impulses);
        plant.solution.wrench = impulses;
        let loss = -jump.contact;
        self.take(jump);
        self.metrics.impacts += 1;
        self.mark_impact(loss);
        self.count(&selection);
        if !selection.consistent && !self.all_imposed(&selection.verdict) {
            self.inconsistent(observer, "no contact state is valid at an impact")?;
        }
        let message = format!("approach {fastest:.6} m/s, energy lost {loss:.6e} J");
        self.event(observer, "impact", "", &message)?;
        self.adopt(selection.states, observer)?;
        self.plant.evaluate_free();
        Ok(())
    }

    /// Takes the states on: counts and reports what changed, ties static soles to their places.
    pub(super) fn adopt(&mut self, states: States, observer: &mut dyn Observer) -> Result<(), Stop> {
        let t = self.plant.state.time;
        for s in 0..self.plant.problem.soles.len() {
            let (old, new) = (self.plant.states[s], states[s]);
            for (d, v) in self.plant.directions[s].iter_mut().zip(&self.plant.problem.soles[s].vertices) {
                *d = v.direction;
            }
            if old == new {
                continue;
            }
            if !self.started {
                // The first choice is where the run starts, not something that happened.
                anchor(self, s);
                continue;
            }
            let kind = match (old, new) {
                (SoleState::FREE, _) => "touchdown",
                (_, SoleState::FREE) => "liftoff",
                _ if old.is_static() && new.is_dynamic() => "slip",
                _ if old.is_dynamic() && new.is_static() => "stick",
                _ => "state",
            };
            let mark = match kind {
                "touchdown" => Some(&mut self.metrics.first_touchdown_s),
                "liftoff" => Some(&mut self.metrics.first_liftoff_s),
                "slip" => Some(&mut self.metrics.first_slip_s),
                "stick" => Some(&mut self.metrics.first_stick_s),
                _ => None,
            };
            if let Some(mark) = mark {
                mark.get_or_insert(t);
            }
            self.metrics.state_changes += 1;
            let subject = self.plant.model.soles[s].name.clone();
            self.event(observer, kind, &subject, &format!("{old} to {new}"))?;
            if new != SoleState::FREE {
                anchor(self, s);
            }
        }
        self.plant.states = states;
        Ok(())
    }

    /// Velocity jump that brings the clamped directions to rest in the states just adopted. Returns the greatest change
    /// of a vertex's velocity, m/s.
    fn settle(&mut self) -> f64 {
        let tol = self.tolerances;
        // A method that does not look for impacts meets them here.
        let bounce = if self.plant.method.locates_events() { 0.0 } else { self.contact.restitution };
        // Where more is taken for rest than rounding leaves it is the least change, as for drift.
        let least = tol.rest > self.contact.tolerances.rest;
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let states = impact::set_rest(p, &plant.reduced.velocity, &plant.states, &tol, bounce);
        if least {
            // Friction of feet that slide on would be that of impulses of either sign, and could give energy.
            let vertices = p.soles.iter_mut().flat_map(|sole| &mut sole.vertices);
            vertices.for_each(|v| v.direction = Vector2::zeros());
        }
        plant.method.respond(p, &states, &mut self.projection);
        if least {
            for (sole, directions) in p.soles.iter_mut().zip(&plant.directions) {
                sole.vertices.iter_mut().zip(directions).for_each(|(v, d)| v.direction = *d);
            }
        }
        let change = impact::greatest_change(p, &self.projection.motion);
        let jump = plant.kick(&self.projection.wrench);
        self.take(jump);
        change
    }
}
