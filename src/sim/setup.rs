//! Description of one run in physical terms. [`crate::assemble`] builds it from a scenario.

use super::carried_object::CarriedObject;
use super::command_source::CommandSource;
use super::floor::Floor;
use super::scenario_event::ScenarioEvent;
use super::self_collision::SelfCollisionSetup;
use super::sensing::{EstimatorSetup, Imu, SensorErrors};
use crate::contact::methods::contact_method::ContactMethod;
use crate::contact::model::problem::Tolerances;
use crate::contact::model::state::SoleState;
use crate::force::Force;
use crate::integrate::Tableau;
use crate::robot::Model;
use crate::task::TaskServer;
use nalgebra::Vector3;
use std::sync::Arc;

/// A state imposed on a sole for a span of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forced {
    /// Index of the sole.
    pub sole: usize,
    /// The state.
    pub state: SoleState,
    /// From, s.
    pub from: f64,
    /// To, s.
    pub to: f64,
}

/// Contact method and parameters.
#[derive(Debug)]
pub struct ContactSetup {
    /// The method: one of [`crate::contact::methods::registry::METHODS`], or another.
    pub method: Box<dyn ContactMethod>,
    /// Tolerances d, v_t, a_t and the rest speed.
    pub tolerances: Tolerances,
    /// Coefficient of restitution e for approach speeds above v_t.
    pub restitution: f64,
    /// Locate events inside steps, or check only step ends.
    pub locate: bool,
    /// Imposed states.
    pub forced: Vec<Forced>,
}

/// Time integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IntegratorSetup {
    /// An embedded Runge-Kutta pair with error control.
    Controlled {
        /// The pair.
        pair: &'static Tableau,
        /// Relative tolerance.
        relative: f64,
        /// Absolute tolerance.
        absolute: f64,
        /// Largest step, s.
        max_step: f64,
    },
    /// A Runge-Kutta method in fixed steps, shortened where they end at an event.
    Stepped {
        /// The method.
        method: &'static Tableau,
        /// Step, s.
        step: f64,
    },
    /// Semi-implicit Euler at the velocity level, joint damping and servo gains implicit.
    SemiImplicit {
        /// Step, s.
        step: f64,
    },
}

/// Initial state of the robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Base position, world, m.
    pub position: Vector3<f64>,
    /// Base orientation.
    pub rotation: nalgebra::UnitQuaternion<f64>,
    /// Joint positions.
    pub joints: Vec<f64>,
    /// Generalised velocity, see [`crate::robot::model`].
    pub v: Vec<f64>,
}

/// One run.
pub struct Setup {
    /// The robot, with the scenario's changes.
    pub model: Arc<Model>,
    /// Gravity, world, m/s^2.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Floor,
    /// Contact.
    pub contact: ContactSetup,
    /// Integrator.
    pub integrator: IntegratorSetup,
    /// Initial state.
    pub start: Start,
    /// Do joint limits stop the joints?
    pub joint_stops: bool,
    /// Tasks, which compute joint commands.
    pub tasks: TaskServer,
    /// Source of joint commands, if not the tasks.
    pub command_source: Option<Box<dyn CommandSource>>,
    /// External forces.
    pub forces: Vec<Box<dyn Force>>,
    /// Objects that links carry for a time.
    pub carried_objects: Vec<CarriedObject>,
    /// Errors of the sensors; none: all readings are exact.
    pub sensors: Option<SensorErrors>,
    /// Mounting of the IMU.
    pub imu: Imu,
    /// Source of the base's state for tasks.
    pub estimator: EstimatorSetup,
    /// Monitoring and avoidance of self-collision; none: not monitored.
    pub self_collision: Option<SelfCollisionSetup>,
    /// Seed of all random numbers drawn while running.
    pub seed: u64,
    /// Events, in the order in which they happen.
    pub events: Vec<ScenarioEvent>,
    /// Number of different states that they save.
    pub saved_states: usize,
    /// Simulated time, s.
    pub duration: f64,
    /// Snapshots per second, 0 for none but the last.
    pub log_rate: f64,
    /// End the run when the base is lower than this above the floor, m.
    pub fallen_below: Option<f64>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl Setup {
    /// Instants at which something jumps, s, ascending: steps end there.
    pub fn corners(&self) -> Vec<f64> {
        let mut corners: Vec<f64> = self.forces.iter().flat_map(|force| force.corners().to_vec()).collect();
        corners.extend(self.carried_objects.iter().flat_map(|object| [object.from, object.to]));
        corners.extend(self.contact.forced.iter().flat_map(|f| [f.from, f.to]));
        for event in &self.events {
            corners.push(event.at);
            corners.extend(event.forces.iter().flat_map(|(_, force)| force.corners().to_vec()));
        }
        corners.retain(|c| *c > 0.0 && *c < self.duration);
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        corners
    }
}
