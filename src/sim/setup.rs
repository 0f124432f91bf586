//! Everything one run needs, in plain physics terms. Built from a scenario by [`crate::assemble`].

use super::change::Change;
use super::commander::Commander;
use super::estimate::EstimatorSetup;
use super::imu::Imu;
use super::loads::Load;
use super::patch::Patch;
use super::self_contact::SelfContactSetup;
use super::sensors::SensorErrors;
use crate::contact::methods::contact_method::ContactMethod;
use crate::contact::model::problem::Tolerances;
use crate::contact::model::state::SoleState;
use crate::force::Force;
use crate::geometry::Plane;
use crate::integrate::Tableau;
use crate::robot::Model;
use crate::task::TaskServer;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// The floor plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Floor axes in the world; the third column is the upward normal.
    pub rotation: Matrix3<f64>,
    /// A point of the plane, m.
    pub point: Vector3<f64>,
    /// Static friction coefficient.
    pub mu_s: f64,
    /// Kinetic friction coefficient.
    pub mu_k: f64,
    /// Regions with friction of their own; where they overlap the last one counts.
    pub patches: Vec<Patch>,
}

impl Floor {
    /// The plane alone.
    pub fn plane(&self) -> Plane {
        Plane { rotation: self.rotation, point: self.point }
    }

    /// World vector in floor axes.
    pub fn to_floor(&self, v: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(v)
    }

    /// Height of a world point above the plane, m.
    pub fn height(&self, p: &Vector3<f64>) -> f64 {
        self.rotation.column(2).dot(&(p - self.point))
    }
}

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

/// How contact is treated.
#[derive(Debug)]
pub struct ContactSetup {
    /// The method: one of [`crate::contact::methods::registry::METHODS`], or another.
    pub method: Box<dyn ContactMethod>,
    /// Tolerances d, v_t, a_t and the rest speed.
    pub tolerances: Tolerances,
    /// Coefficient of restitution e for approach speeds above v_t.
    pub restitution: f64,
    /// Locate events inside steps, or look only at step ends.
    pub locate: bool,
    /// Imposed states.
    pub forced: Vec<Forced>,
}

/// How time is stepped.
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

/// Where the robot starts.
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
    /// Tasks.
    pub tasks: TaskServer,
    /// Who decides what the joints are asked, if not the tasks.
    pub commander: Option<Box<dyn Commander>>,
    /// External forces.
    pub forces: Vec<Box<dyn Force>>,
    /// Objects that links carry for a time.
    pub loads: Vec<Load>,
    /// Errors of the sensors; none: they tell the truth.
    pub sensors: Option<SensorErrors>,
    /// Where the IMU is.
    pub imu: Imu,
    /// Where tasks have the base's state from.
    pub estimator: EstimatorSetup,
    /// What is done about self-collision; none: nothing is known of it.
    pub self_contact: Option<SelfContactSetup>,
    /// Seed of all random numbers drawn while running.
    pub seed: u64,
    /// Events, in the order in which they happen.
    pub changes: Vec<Change>,
    /// How many states they save under different names.
    pub saved_states: usize,
    /// Simulated time, s.
    pub duration: f64,
    /// Snapshots per second, 0 for none but the last.
    pub log_rate: f64,
    /// End the run when the base is lower than this above the floor, m.
    pub fallen_below: Option<f64>,
    /// What else there is to tell a person.
    pub notes: Vec<String>,
}

impl Setup {
    /// Instants at which something jumps, s, ascending: steps end there.
    pub fn corners(&self) -> Vec<f64> {
        let mut corners: Vec<f64> = self.forces.iter().flat_map(|force| force.corners().to_vec()).collect();
        corners.extend(self.loads.iter().flat_map(|load| [load.from, load.to]));
        corners.extend(self.contact.forced.iter().flat_map(|f| [f.from, f.to]));
        for change in &self.changes {
            corners.push(change.at);
            corners.extend(change.forces.iter().flat_map(|(_, force)| force.corners().to_vec()));
        }
        corners.retain(|c| *c > 0.0 && *c < self.duration);
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        corners
    }
}
