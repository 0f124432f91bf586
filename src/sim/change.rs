//! Events of the scenario: parameters that change while running, tasks that end, and states saved and restored.
//!
//! A change takes hold at its instant, between two steps; the contact states are then chosen anew. Nothing moves by it: the
//! energy that a new payload or another gravity adds is work from outside, and so is that of a restored state.

use super::error::Stop;
use super::plant::Plant;
use super::report::{Observer, Outcome};
use super::setup::Floor;
use super::simulation::Simulation;
use super::zones::Place;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{MAX_SOLES, States};
use crate::dynamics::State;
use crate::force::Force;
use crate::robot::Model;
use nalgebra::{Vector2, Vector3};
use std::any::Any;
use std::sync::Arc;

/// What one event does.
#[derive(Default)]
pub struct Change {
    /// When, s.
    pub at: f64,
    /// For the log.
    pub words: String,
    /// Numbers of the tasks that it ends.
    pub end_tasks: Vec<usize>,
    /// Number of the saved state that it overwrites.
    pub save: Option<usize>,
    /// Number of the saved state that it restores.
    pub restore: Option<usize>,
    /// The robot from then on; of the same structure.
    pub model: Option<Arc<Model>>,
    /// Gains from then on, by joint: kp, kd.
    pub gains: Vec<(usize, f64, f64)>,
    /// Gravity from then on, m/s^2.
    pub gravity: Option<Vector3<f64>>,
    /// The floor from then on: the same plane.
    pub floor: Option<Floor>,
    /// Coefficient of restitution from then on.
    pub restitution: Option<f64>,
    /// Force models that take the place of others, by number.
    pub forces: Vec<(usize, Box<dyn Force>)>,
}

/// A state of the robot that can be returned to: motion, actuators and contact.
#[derive(Clone)]
pub struct Saved {
    state: State,
    states: States,
    directions: Vec<Vec<Vector2<f64>>>,
    anchors: Vec<Vec<Vector3<f64>>>,
    suspect: [u8; MAX_SOLES],
    /// Forces of the floor, from which methods that do not search decide what comes next.
    solution: Solution,
}

impl Saved {
    /// Room for a state.
    pub fn new(plant: &Plant, anchors: &[Vec<Vector3<f64>>]) -> Self {
        Saved {
            state: plant.state.clone(),
            states: plant.states,
            directions: plant.directions.clone(),
            anchors: anchors.to_vec(),
            suspect: [0; MAX_SOLES],
            solution: Solution::new(&plant.problem),
        }
    }
}

fn copy<T: Copy>(to: &mut [Vec<T>], from: &[Vec<T>]) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}

impl Simulation {
    /// Lets the events happen whose time has come. True when there were any.
    pub(super) fn happen(&mut self, observer: &mut dyn Observer) -> Result<bool, Stop> {
        let mut any = false;
        while self.changes.get(self.happened).is_some_and(|c| c.at <= self.plant.state.time) {
            let mut change = std::mem::take(&mut self.changes[self.happened]);
            self.happened += 1;
            any = true;
            self.change(&mut change)?;
            self.changes[self.happened - 1].save = change.save;
            self.event(observer, "event", "", &change.words)?;
        }
        Ok(any)
    }

    fn change(&mut self, change: &mut Change) -> Result<(), Stop> {
        self.plant.refresh();
        let before = self.plant.energy();
        if let Some(slot) = change.save {
            self.save(slot);
        }
        if let Some(slot) = change.restore {
            self.restore(slot);
        }
        let another = change.model.is_some();
        self.plant.take_over(change).map_err(|m| Stop::new(Outcome::Error, m))?;
        if another {
            self.hold_on();
        }
        for command in [&mut self.tasks.command, &mut self.plant.command] {
            for &(j, kp, kd) in &change.gains {
                (command.kp[j], command.kd[j]) = (kp, kd);
            }
        }
        change.end_tasks.iter().for_each(|number| self.tasks.end(*number));
        self.contact.restitution = change.restitution.unwrap_or(self.contact.restitution);
        self.plant.refresh();
        self.plant.look_up_friction();
        self.flows.0[1] += self.plant.energy() - before;
        self.marks.restart(change.restore.is_some());
        Ok(())
    }

    /// Saves the present state.
    pub(super) fn save(&mut self, slot: usize) {
        let saved = &mut self.saved[slot];
        saved.state.copy_from(&self.plant.state);
        saved.states = self.plant.states;
        copy(&mut saved.directions, &self.plant.directions);
        copy(&mut saved.anchors, &self.anchors);
        saved.suspect = self.suspect;
        saved.solution.copy_from(&self.plant.solution);
    }

    /// Returns to a saved state at the present time. Kinematic joints stay on their commanded motion.
    fn restore(&mut self, slot: usize) {
        let saved = &self.saved[slot];
        let time = self.plant.state.time;
        self.plant.state.copy_from(&saved.state);
        self.plant.state.time = time;
        self.plant.follow();
        self.plant.states = saved.states;
        copy(&mut self.plant.directions, &saved.directions);
        copy(&mut self.anchors, &saved.anchors);
        self.suspect = saved.suspect;
        self.plant.solution.copy_from(&saved.solution);
        for (sole, directions) in self.plant.problem.soles.iter_mut().zip(&saved.directions) {
            sole.vertices.iter_mut().zip(directions).for_each(|(v, d)| v.direction = *d);
        }
        self.sensors.restart();
        self.estimator.restart();
    }
}

impl Plant {
    /// Takes the changed parameters on. New force models are initialised.
    fn take_over(&mut self, change: &mut Change) -> Result<(), String> {
        if let Some(model) = change.model.take() {
            self.model = model;
            self.displaced();
        }
        self.gravity = change.gravity.unwrap_or(self.gravity);
        if let Some(floor) = change.floor.take() {
            self.floor = floor;
        }
        for (i, mut force) in change.forces.drain(..) {
            let former: &dyn Any = &*self.forces[i];
            force.continue_from(former, self.state.time);
            self.forces[i] = force;
            self.init_force(i)?;
        }
        self.make_room();
        Ok(())
    }

    /// Gives every vertex the friction of the zone where it is, whatever it had before. Needs the vertices.
    fn look_up_friction(&mut self) {
        for s in 0..self.problem.soles.len() {
            for i in 0..self.problem.soles[s].vertices.len() {
                let zone = self.floor.zone(&self.seen_from_above(s, i));
                self.places[s][i] = Place::new(zone);
                let v = &mut self.problem.soles[s].vertices[i];
                (v.mu_s, v.mu_k) = self.floor.friction(zone);
            }
        }
    }
}
