//! Objects that links carry for a time.
//!
//! While it is held an object is part of its link: `I = I_link + sum of the objects' inertias`. Taking one that moves
//! with the link changes no velocity, nor does letting go. One that comes with a velocity u of its own is caught in a
//! perfectly plastic impact, in which the generalised momentum of both stays what it was but for impulses of the floor:
//!
//! ```text
//! M+ v+ = M- v- + J^T m u + J_c^T Lambda
//! ```
//!
//! M- and M+ the mass matrices without and with the object, J the Jacobian of its centre of mass, J_c^T Lambda the impulses of
//! the contact method at the soles, found from the velocities that the first two terms would lead to. Kinematic joints keep
//! their motions. In the energy balance the energy that an object brings and takes
//! along counts as work of external forces, what the impact takes as an impact's loss.

use super::error::Stop;
use super::plant::Plant;
use super::prescribe::Jump;
use super::report::Observer;
use super::simulation::Simulation;
use crate::contact::model::state::SoleState;
use crate::dynamics::{self, crba, factor};
use crate::robot::{LinkId, Model, RigidInertia};
use nalgebra::Vector3;

/// An object and when it is carried.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name of the link, for messages.
    pub name: String,
    /// The link that carries it.
    pub link: LinkId,
    /// Its inertia in the link's internal frame.
    pub body: RigidInertia,
    /// Velocity it comes with, without turning, world, m/s; none: it moves with the link.
    pub velocity: Option<Vector3<f64>>,
    /// From, s.
    pub from: f64,
    /// To, s.
    pub to: f64,
}

/// The objects of a run and which of them are held.
pub struct Loads {
    loads: Vec<(Load, bool)>,
    /// Every link's inertia without them.
    bare: Vec<RigidInertia>,
}

impl Loads {
    /// None is held yet.
    pub fn new(model: &Model, loads: Vec<Load>) -> Self {
        let bare = model.links.iter().map(|l| l.body()).collect();
        Loads { loads: loads.into_iter().map(|load| (load, false)).collect(), bare }
    }

    /// Adds objects that are not held yet.
    pub fn add(&mut self, loads: impl Iterator<Item = Load>) {
        self.loads.extend(loads.map(|load| (load, false)));
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.loads.len()
    }

    /// The links themselves are others from now on.
    fn rebase(&mut self, model: &Model) {
        self.bare.iter_mut().zip(&model.links).for_each(|(bare, link)| *bare = link.body());
    }

    /// What a link is together with all it holds: summed anew, so that letting go leaves no rounding behind.
    fn sum(&self, link: LinkId) -> RigidInertia {
        let held = self.loads.iter().filter(|(load, held)| *held && load.link == link);
        held.fold(self.bare[link.0], |sum, (load, _)| sum.plus(&load.body))
    }
}

/// Energies of taking hold of an object, J.
struct Taken {
    /// What it brings along.
    brought: f64,
    /// What the drives of kinematic joints give to keep to their motions.
    drives: f64,
    /// What is lost.
    lost: f64,
}

impl Simulation {
    /// Takes and releases the objects whose time has come.
    pub(super) fn pass_loads(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let t = self.plant.state.time;
        for i in 0..self.loads.loads.len() {
            let (load, held) = &self.loads.loads[i];
            match *held {
                true if load.to <= t => self.release(i, observer)?,
                false if load.from <= t && t < load.to => self.take_hold(i, observer)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn take_hold(&mut self, i: usize, observer: &mut dyn Observer) -> Result<(), Stop> {
        let (load, held) = &mut self.loads.loads[i];
        *held = true;
        let load = load.clone();
        let taken =
            self.plant.take_hold(&load, &self.loads.sum(load.link)).map_err(|e| self.diverged(&e.to_string()))?;
        self.bring(taken.brought);
        self.take(Jump { contact: -taken.lost, drives: taken.drives });
        let lost = if load.velocity.is_some() { format!(", energy lost {:.6e} J", taken.lost) } else { String::new() };
        self.event(observer, "object", &load.name, &format!("{} kg taken{lost}", load.body.mass))?;
        if load.velocity.is_some() && self.started { self.shock(observer) } else { Ok(()) }
    }

    /// Another robot was put in place of the one that held its objects: it holds them too.
    pub(super) fn hold_on(&mut self) {
        self.loads.rebase(&self.plant.model);
        for (load, _) in self.loads.loads.iter().filter(|(_, held)| *held) {
            self.plant.set_body(load.link, &self.loads.sum(load.link));
        }
    }

    fn release(&mut self, i: usize, observer: &mut dyn Observer) -> Result<(), Stop> {
        let (load, held) = &mut self.loads.loads[i];
        *held = false;
        let load = load.clone();
        let change = self.plant.weigh(load.link, &self.loads.sum(load.link));
        self.bring(change);
        self.event(observer, "object", &load.name, &format!("{} kg released", load.body.mass))
    }

    /// Books energy that came with an object. What is held from the start on was there before anything happened.
    fn bring(&mut self, energy: f64) {
        self.marks.restart(false);
        if self.started { self.flows.bring(energy) } else { self.start_energy += energy }
    }

    /// Velocities have jumped: what the floor does about it in the same instant.
    fn shock(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let lies = self.plant.states.0.iter().any(|s| *s != SoleState::FREE);
        // Springs answer in time; a step at the velocity level holds the impulses of its instant anyway.
        if !lies || self.plant.is_compliant() || self.steps_velocities() {
            return Ok(());
        }
        if !self.plant.method.locates_events() {
            return self.decide(observer);
        }
        self.plant.evaluate_free();
        self.find_friction(observer)?;
        self.plant.point_directions();
        self.impact(observer)
    }
}

impl Plant {
    /// Gives a link another inertia. Returns the change of energy, J.
    fn weigh(&mut self, link: LinkId, body: &RigidInertia) -> f64 {
        self.move_links();
        let before = self.energy();
        self.set_body(link, body);
        self.energy() - before
    }

    /// Makes a load part of its link, which then is `whole`.
    fn take_hold(&mut self, load: &Load, whole: &RigidInertia) -> Result<Taken, dynamics::DynamicsError> {
        let Some(velocity) = load.velocity else {
            return Ok(Taken { brought: self.weigh(load.link, whole), drives: 0.0, lost: 0.0 });
        };
        self.move_links();
        let mass = load.body.mass;
        let place = self.ws.point(load.link, &load.body.com);
        let brought = mass * (0.5 * velocity.norm_squared() - self.gravity.dot(&place));
        let before = self.energy() + brought;
        // What both have more than the link with the object would have at the old velocity.
        let (mut excess, mut other) = (vec![0.0; self.model.nv()], vec![0.0; self.model.nv()]);
        crba::mass_matrix(&self.model, &mut self.ws);
        self.ws.mass.multiply(&self.state.v, &mut excess);
        let (momentum, none) = (velocity * mass, Vector3::zeros());
        dynamics::link_force::accumulate(&self.ws, load.link, &place, &momentum, &none, &mut excess);
        self.set_body(load.link, whole);
        crba::mass_matrix(&self.model, &mut self.ws);
        self.ws.mass.multiply(&self.state.v, &mut other);
        excess.iter_mut().zip(&other).for_each(|(e, o)| *e -= o);
        // M+ dv = excess, but kinematic joints keep their velocities.
        let prescribed = &self.reduced.prescribed;
        let mut dv = excess.clone();
        prescribed.iter().for_each(|k| dv[*k] = 0.0);
        factor::factorize_prescribed(&mut self.ws, &vec![0.0; dv.len()], prescribed)?;
        factor::solve(&self.ws, &mut dv);
        self.ws.mass.multiply(&dv, &mut other);
        let drives = prescribed.iter().map(|&k| self.state.v[k] * (other[k] - excess[k])).sum();
        self.state.v.iter_mut().zip(&dv).for_each(|(v, dv)| *v += dv);
        self.move_links();
        Ok(Taken { brought, drives, lost: before + drives - self.energy() })
    }
}
