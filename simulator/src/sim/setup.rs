//! Description of one run in physical terms. `assemble` builds it from a scenario.

use super::actuation::kinematic_paths::Interpolation;
use super::bodies::{Body, Pair, PairRules};
use super::carried_object::CarriedObject;
use super::command_source::CommandSource;
use super::floor::{Floor, LinkHull};
use super::plant::{ObjectSetup, PlantSetup};
use super::scenario_event::ScenarioEvent;
use super::self_collision::SelfCollisionSetup;
use super::sensing::{EstimatorSetup, Imu, SensorErrors};
use crate::contact::methods::contact_method::ContactMethod;
use crate::contact::methods::registry::{METHODS, MethodParameters};
use crate::contact::model::problem::Tolerances;
use crate::contact::model::state::SoleState;
use crate::dynamics::State;
use crate::force::Force;
use crate::integrate::{DOPRI5, Tableau};
use crate::robot::Model;
use crate::task::{Command, TaskServer};
use crate::terrain::{ExtraFriction, Terrain};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::sync::Arc;

/// A state imposed on a sole for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forced {
    /// Index of the sole.
    pub sole: usize,
    /// The state.
    pub state: SoleState,
    /// Start, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
}

/// Contact method and parameters.
#[derive(Debug)]
pub struct ContactSetup {
    /// The method: one of [`crate::contact::methods::registry::METHODS`], or a caller's own.
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

/// When drives, joint friction and stops, springs and dampers are integrated implicitly.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ImplicitSteps {
    /// Never.
    Never,
    /// While they limit the steps of the explicit method, as with `Bdf`.
    Auto,
    /// Always, by a Rosenbrock method.
    Rosenbrock,
    /// Always, by backward differentiation formulas where the motion is smooth, otherwise by a Rosenbrock method.
    Bdf,
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
        /// When other methods take steps with implicit forces instead.
        implicit: ImplicitSteps,
    },
    /// A Runge-Kutta method in fixed steps, shortened only to end at an event.
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
    pub rotation: UnitQuaternion<f64>,
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
    /// Fixed bodies besides the floor.
    pub terrain: Arc<Terrain>,
    /// Contact.
    pub contact: ContactSetup,
    /// Integrator.
    pub integrator: IntegratorSetup,
    /// Initial state.
    pub start: Start,
    /// Do joint limits stop the joints?
    pub joint_stops: bool,
    /// What position servos follow between two commands.
    pub interpolation: Interpolation,
    /// Tasks, which compute joint commands.
    pub tasks: TaskServer,
    /// Source of joint commands, if not the tasks.
    pub command_source: Option<Box<dyn CommandSource>>,
    /// External forces.
    pub forces: Vec<Box<dyn Force>>,
    /// Objects besides the robot.
    pub objects: Vec<ObjectSetup>,
    /// Bodies that touch each other, and their pairs.
    pub bodies: (Vec<Body>, Vec<Pair>),
    /// Rules for pairs of bodies.
    pub pair_rules: PairRules,
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
    /// Snapshots per second; 0: only the last.
    pub log_rate: f64,
    /// Instants of snapshots instead of `log_rate`, s, ascending; empty: those of the rate.
    pub log_instants: Vec<f64>,
    /// End the run when the base is lower than this above the floor, m.
    pub fallen_below: Option<f64>,
    /// Links that touch the floor besides the soles; none: only soles do.
    pub touching_links: Option<Vec<LinkHull>>,
    /// End the run when a link of a robot with a floating base has sunk through the floor.
    pub ends_when_sunk: bool,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl Setup {
    /// A run of a robot with the defaults of a scenario file: gravity 9.81 m/s^2 along -z, a level
    /// floor at height 0 with friction 0.8 (static) and 0.6 (kinetic), contact method `exact` with
    /// located events, integrator `dopri5` with tolerances 1e-6 (relative) and 1e-8 (absolute),
    /// joints held in the home posture, control ticks of 1 kHz.
    ///
    /// The robot starts at rest with its base at the origin. The run lasts 1 s and logs only its
    /// end. There are no tasks, forces, events, sensor errors, estimators and terrain. All fields
    /// can be changed before [`Simulation::new`](super::Simulation::new).
    pub fn new(model: Arc<Model>) -> Self {
        let command = Command::hold(&model, &model.home);
        Setup {
            gravity: Vector3::new(0.0, 0.0, -9.81),
            floor: Floor {
                rotation: Matrix3::identity(),
                point: Vector3::zeros(),
                mu_s: 0.8,
                mu_k: 0.6,
                extra: ExtraFriction::default(),
                patches: Vec::new(),
                is_absent: false,
            },
            terrain: Arc::default(),
            contact: ContactSetup {
                method: METHODS[0].with(MethodParameters::default()),
                tolerances: Tolerances::default(),
                restitution: 0.0,
                locate: true,
                forced: Vec::new(),
            },
            integrator: IntegratorSetup::Controlled {
                pair: &DOPRI5,
                relative: 1e-6,
                absolute: 1e-8,
                max_step: 0.01,
                implicit: ImplicitSteps::Never,
            },
            start: Start {
                position: Vector3::zeros(),
                rotation: UnitQuaternion::identity(),
                joints: model.home.clone(),
                v: vec![0.0; model.nv()],
            },
            joint_stops: true,
            interpolation: Interpolation::Hold,
            tasks: TaskServer::new(1000.0, &model, command),
            command_source: None,
            forces: Vec::new(),
            objects: Vec::new(),
            bodies: (Vec::new(), Vec::new()),
            pair_rules: PairRules::default(),
            carried_objects: Vec::new(),
            sensors: None,
            imu: Imu::default(),
            estimator: EstimatorSetup::Truth,
            self_collision: None,
            seed: 1,
            events: Vec::new(),
            saved_states: 0,
            duration: 1.0,
            log_rate: 0.0,
            log_instants: Vec::new(),
            fallen_below: None,
            touching_links: None,
            ends_when_sunk: true,
            notes: Vec::new(),
            model,
        }
    }

    /// The initial state of the robot.
    pub fn initial_state(&self) -> State {
        let mut state = State::home(&self.model);
        (state.position, state.rotation) = (self.start.position, self.start.rotation);
        state.joints.copy_from_slice(&self.start.joints);
        state.v.copy_from_slice(&self.start.v);
        state
    }

    /// The plant's part of the setup. Takes the forces out of the setup.
    pub fn plant(&mut self) -> PlantSetup {
        PlantSetup {
            model: self.model.clone(),
            gravity: self.gravity,
            floor: self.floor.clone(),
            state: self.initial_state(),
            objects: std::mem::take(&mut self.objects),
            bodies: std::mem::take(&mut self.bodies.0),
            pair_rules: std::mem::take(&mut self.pair_rules),
            terrain: self.terrain.clone(),
            joint_stops: self.joint_stops,
            interpolation: self.interpolation,
            forces: std::mem::take(&mut self.forces),
            command: self.tasks.command.clone(),
            rest: self.contact.tolerances.rest,
            step_error: match self.integrator {
                IntegratorSetup::Controlled { relative, absolute, .. } if self.contact.locate => (absolute, relative),
                _ => (0.0, 0.0),
            },
        }
    }

    /// Instants at which forces, masses or settings change abruptly, s, ascending. Steps end there.
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
