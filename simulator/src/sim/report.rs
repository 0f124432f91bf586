//! Output of a run: snapshots, events, samples, metrics and an outcome. Plain data, written by
//! [`crate::sim`], read by `results`.

use super::event_kind::EventKind;
use super::measure::energy_balance::EnergyBalance;
use crate::contact::model::residual::Residual;
use crate::contact::model::state::SoleState;
use crate::contact::selection_record::SelectionRecord;
pub use crate::metrics::Metrics;
use crate::task::PointOfInterest;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// The state of a run at one logged instant. World axes, SI units.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Simulated time, s.
    pub time: f64,
    /// Pose of the root link's URDF frame.
    pub base_pose: Isometry3<f64>,
    /// Velocity of the root's origin.
    pub base_linear_velocity: Vector3<f64>,
    /// Angular velocity of the root.
    pub base_angular_velocity: Vector3<f64>,
    /// Joint positions.
    pub q: Vec<f64>,
    /// Joint velocities.
    pub qd: Vec<f64>,
    /// Actuator efforts (friction and stops not included).
    pub effort: Vec<f64>,
    /// Desired efforts of the drives, before limits and lag; those of `effort` in mode `kinematic` and where
    /// both differ by rounding only.
    pub effort_desired: Vec<f64>,
    /// Desired joint positions.
    pub q_desired: Vec<f64>,
    /// Desired joint velocities.
    pub qd_desired: Vec<f64>,
    /// Poses of the links of all objects in the world.
    pub object_poses: Vec<Isometry3<f64>>,
    /// Of each closed loop: force and moment on its first link at its first frame, world, and the greatest error
    /// of its conditions, m or rad.
    pub loops: Vec<([Vector3<f64>; 2], f64)>,
    /// Of each coupling: effort on the following joint, and error of its position, rad or m.
    pub couplings: Vec<(f64, f64)>,
    /// Centre of mass.
    pub com: Vector3<f64>,
    /// Velocity of the centre of mass.
    pub com_velocity: Vector3<f64>,
    /// Centre of pressure of all soles on the floor plane; none in flight.
    pub centre_of_pressure: Option<Vector3<f64>>,
    /// Convex hull of the clamped vertices on the floor plane, in order; may be empty.
    pub support_polygon: Vec<Vector3<f64>>,
    /// Point of optimal stability of that hull on the floor plane, see
    /// [`mod@crate::geometry::stable_point`]; none in flight.
    pub stable_point: Option<Vector3<f64>>,
    /// Named points of the tasks, always the same ones.
    pub points: Vec<PointOfInterest>,
    /// One per sole, in the model's order.
    pub soles: Vec<SoleSnapshot>,
    /// Other contacts, closed or about to close: of links with the floor (name of the link, a face of its
    /// hull), then of pairs of bodies (names of both, the corners of the patch).
    pub links: Vec<(String, SoleSnapshot)>,
    /// External forces now acting: point, force.
    pub external: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Residuals of the contact laws.
    pub residual: Residual,
    /// The energy balance since the start.
    pub energy: EnergyBalance,
    /// Readings and estimate at the last control tick; none when sensors and estimator are exact.
    pub estimate: Option<EstimateSnapshot>,
    /// Self-collision of the robot; none when it is not monitored.
    pub self_contact: Option<SelfContactSnapshot>,
}

/// Distance of the robot from self-collision, and its avoidance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfContactSnapshot {
    /// Names of the bodies of the monitored pairs.
    pub pairs: Vec<[String; 2]>,
    /// Of the nearest pair: distance (below 0: depth of the overlap), m, its number in `pairs`, and
    /// the nearest points, world; none without pairs.
    pub nearest: Option<(f64, usize, Vector3<f64>, Vector3<f64>)>,
    /// Cycles of avoidance so far.
    pub cycles: u64,
    /// Postures tested in the last of them.
    pub tests: u64,
    /// For each joint: does avoidance stop it? Empty without avoidance.
    pub frozen: Vec<bool>,
    /// Joint positions that the tasks command, within their ranges, rad or m; empty without
    /// avoidance.
    pub desired: Vec<f64>,
}

/// Readings of the sensors and the estimated base at a control tick. World axes unless stated
/// otherwise, SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EstimateSnapshot {
    /// The tick, s.
    pub time: f64,
    /// Estimated pose of the root link's URDF frame.
    pub base_pose: Isometry3<f64>,
    /// Estimated velocity of its origin.
    pub base_linear_velocity: Vector3<f64>,
    /// Estimated angular velocity of the root.
    pub base_angular_velocity: Vector3<f64>,
    /// Measured joint positions.
    pub q: Vec<f64>,
    /// Measured joint velocities.
    pub qd: Vec<f64>,
    /// Measured joint loads.
    pub load: Vec<f64>,
    /// Measured orientation.
    pub orientation: UnitQuaternion<f64>,
    /// Measured angular velocity of the IMU, its axes.
    pub angular_velocity: Vector3<f64>,
    /// Measured specific force at the IMU, its axes.
    pub specific_force: Vector3<f64>,
    /// Measured force and moment about the centroid of each sole.
    pub soles: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// For each sole: does the estimator take it as static? Empty for other estimators.
    pub static_soles: Vec<bool>,
}

/// Motion and contact at an instant of comparison. World axes, SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Number of the instant, at `index / rate` seconds; the last is the run's end.
    pub index: usize,
    /// Simulated time, s.
    pub time: f64,
    /// Origin of the root link's frame, m.
    pub position: Vector3<f64>,
    /// Its orientation.
    pub rotation: UnitQuaternion<f64>,
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// Force of the floor on each sole, N.
    pub forces: Vec<Vector3<f64>>,
    /// Contact state of each sole.
    pub states: Vec<SoleState>,
    /// Origin of the root link's frame of each object, m.
    pub objects: Vec<Vector3<f64>>,
    /// Joint positions of all objects, rad or m.
    pub object_joints: Vec<f64>,
}

/// One sole at one instant.
#[derive(Clone, Debug, Default)]
pub struct SoleSnapshot {
    /// `free`, or pattern and mode, such as `face-static`, `edge-1-dynamic`, `vertex-0-static`.
    pub state: String,
    /// For each vertex: is it clamped to the floor.
    pub clamped: Vec<bool>,
    /// Vertex positions.
    pub positions: Vec<Vector3<f64>>,
    /// Vertex velocities.
    pub velocities: Vec<Vector3<f64>>,
    /// Force of the floor on each vertex.
    pub forces: Vec<Vector3<f64>>,
}

/// An event at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct SimEvent {
    /// Simulated time, s.
    pub time: f64,
    /// Kind of event.
    pub kind: EventKind,
    /// The sole, joint, task or object it belongs to; may be empty.
    pub subject: String,
    /// Message for the user.
    pub message: String,
}

/// How a run ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// Reached its end, every expectation held.
    Passed,
    /// Reached its end, an expectation did not hold.
    Failed,
    /// A stop rule ended it.
    Fallen,
    /// A number left the representable or plausible range, or the step size collapsed.
    Diverged,
    /// Too many events per simulated second.
    Stalled,
    /// Wall-clock limit.
    TimedOut,
    /// A panic or an internal error.
    Error,
    /// Interrupted.
    Cancelled,
}

impl Outcome {
    /// All outcomes.
    pub const ALL: [Outcome; 8] = [
        Outcome::Passed,
        Outcome::Failed,
        Outcome::Fallen,
        Outcome::Diverged,
        Outcome::Stalled,
        Outcome::TimedOut,
        Outcome::Error,
        Outcome::Cancelled,
    ];

    /// The outcome in the summary.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Passed => "passed",
            Outcome::Failed => "failed",
            Outcome::Fallen => "fallen",
            Outcome::Diverged => "diverged",
            Outcome::Stalled => "stalled",
            Outcome::TimedOut => "timed-out",
            Outcome::Error => "error",
            Outcome::Cancelled => "cancelled",
        }
    }
}

/// Processor time of avoidance.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AvoidanceTime {
    /// Total, s.
    pub total_s: f64,
    /// The part of it in ticks with a cycle, s.
    pub cycles_s: f64,
}

/// Why an observer cannot continue.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ObserverError(Box<dyn std::error::Error + Send + Sync>);

impl ObserverError {
    /// Wraps the error of an observer.
    pub fn new(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        ObserverError(error.into())
    }

    /// The error of the observer, if it is of this type.
    pub fn downcast_ref<E: std::error::Error + 'static>(&self) -> Option<&E> {
        self.0.downcast_ref()
    }
}

/// Receives the output of a run while it runs. `Err` ends the run with outcome `error` and the
/// error's message.
pub trait Observer {
    /// Called at the log rate and once at the end.
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), ObserverError>;
    /// Called for every event when it happens, in time order.
    fn event(&mut self, event: &SimEvent) -> Result<(), ObserverError>;
    /// Samples per simulated second that it receives; constant throughout a run. 0: none.
    fn sample_rate(&self) -> f64 {
        0.0
    }
    /// Called with samples in time order: at `k / rate` before the end of the run, and at the end
    /// if it was reached. Unlike snapshots they are exactly at these instants.
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }
    /// Contact problems that it receives; constant throughout a run.
    fn problems(&self) -> Problems {
        Problems::None
    }
    /// Called for every selection of the requested kind, before the event that belongs to it.
    fn problem(&mut self, _: &SelectionRecord) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// Selections of a contact state that an observer receives.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Problems {
    /// None.
    #[default]
    None,
    /// Those counted in [`Metrics::inconsistent`].
    Inconsistent,
    /// Every one.
    All,
}

/// Ignores everything a run reports.
impl Observer for () {
    fn snapshot(&mut self, _: &Snapshot) -> Result<(), ObserverError> {
        Ok(())
    }
    fn event(&mut self, _: &SimEvent) -> Result<(), ObserverError> {
        Ok(())
    }
}

/// An observer that ignores everything.
pub struct NullObserver;

impl Observer for NullObserver {
    fn snapshot(&mut self, _: &Snapshot) -> Result<(), ObserverError> {
        Ok(())
    }
    fn event(&mut self, _: &SimEvent) -> Result<(), ObserverError> {
        Ok(())
    }
}
