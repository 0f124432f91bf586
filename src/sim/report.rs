//! What a run tells the outside: snapshots, events, metrics and an outcome. Plain data, written by [`crate::sim`], read
//! by [`crate::results`]; nothing here steps or writes.

use super::ledger::Balance;
use crate::contact::model::frozen::Frozen;
use crate::contact::model::residual::Residual;
use crate::contact::model::state::SoleState;
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
    /// Efforts that the drives ask for, before limits and lag; in mode `kinematic` those of `effort`.
    pub effort_desired: Vec<f64>,
    /// Desired joint positions.
    pub q_desired: Vec<f64>,
    /// Desired joint velocities.
    pub qd_desired: Vec<f64>,
    /// Poses of the links' URDF frames in the world, in the model's link order.
    pub link_poses: Vec<Isometry3<f64>>,
    /// Centre of mass.
    pub com: Vector3<f64>,
    /// Velocity of the centre of mass.
    pub com_velocity: Vector3<f64>,
    /// Centre of pressure of all soles on the floor plane; none in flight.
    pub centre_of_pressure: Option<Vector3<f64>>,
    /// Convex hull of the touching vertices, in order; may be empty.
    pub support_polygon: Vec<Vector3<f64>>,
    /// Point of optimal stability of that hull on the floor plane, see [`crate::geometry::stable_point`]; none in flight.
    pub stable_point: Option<Vector3<f64>>,
    /// Points that tasks show, always the same ones.
    pub points: Vec<PointOfInterest>,
    /// One per sole, in the model's order.
    pub soles: Vec<SoleSnapshot>,
    /// External forces now acting: point, force.
    pub external: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// What the contact laws miss.
    pub residual: Residual,
    /// The energy balance since the start.
    pub energy: Balance,
    /// What the robot knew at its last control tick; none when sensors and estimator tell the truth.
    pub estimate: Option<EstimateSnapshot>,
    /// How near the robot is to touching itself; none when nobody asks.
    pub self_contact: Option<SelfContactSnapshot>,
}

/// How near the robot is to touching itself, and what is done about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfContactSnapshot {
    /// Names of the bodies of the watched pairs.
    pub pairs: Vec<[String; 2]>,
    /// Of the nearest pair: distance (below 0: depth of the overlap), m, its number in `pairs`, and the nearest points, world; none
    /// without pairs.
    pub nearest: Option<(f64, usize, Vector3<f64>, Vector3<f64>)>,
    /// Cycles of avoidance so far.
    pub cycles: u64,
    /// Postures tested in the last of them.
    pub tests: u64,
    /// For each joint: is it kept from where the tasks want it? Empty when collisions are only reported.
    pub frozen: Vec<bool>,
    /// Where the tasks want the joints, within their ranges, rad or m; empty in the same case.
    pub wanted: Vec<f64>,
}

/// Readings of the sensors and the estimated base at a control tick. World axes unless said, SI units.
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
    /// Joint positions read.
    pub q: Vec<f64>,
    /// Joint velocities read.
    pub qd: Vec<f64>,
    /// Joint loads read.
    pub load: Vec<f64>,
    /// Orientation read.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity of the IMU read, its axes.
    pub angular_velocity: Vector3<f64>,
    /// Specific force at the IMU read, its axes.
    pub specific_force: Vector3<f64>,
    /// Force and moment about the centroid read at each sole.
    pub soles: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// For each sole: is it taken to stand still? Empty when the estimator does not ask.
    pub static_soles: Vec<bool>,
}

/// Motion and contact at an instant of comparison. World axes, SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Which instant: `index / rate` seconds, and the run's end as the last.
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

/// Something that happened at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct SimEvent {
    /// Simulated time, s.
    pub time: f64,
    /// Short kind: `touchdown`, `liftoff`, `slip`, `stick`, `impact`, `jam`, `inconsistent`, `state`, `border`, `forced`, `fallen`, `task`, `event`, `self-collision`, ...
    pub kind: &'static str,
    /// What it is about (a sole, a joint, a task), may be empty.
    pub subject: String,
    /// Words for a person.
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
    /// A number left the representable or sensible range, or the step size collapsed.
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
    /// All there are.
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

    /// The word in the summary.
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
    /// In all, s.
    pub total_s: f64,
    /// Of this, in ticks with a cycle, s.
    pub cycles_s: f64,
}

/// What one run measured: the columns of the summary between `duration_s` and the marks, timings apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metrics {
    /// Was the robot somewhere else? What only a simulation knows is then not measured.
    pub elsewhere: bool,
    /// Simulated time reached, s.
    pub duration_s: f64,
    /// Accepted integration steps.
    pub steps: u64,
    /// Steps tried again with a smaller size.
    pub rejected_steps: u64,
    /// Right-hand sides evaluated.
    pub evaluations: u64,
    /// Events located.
    pub events: u64,
    /// Changes of the contact state of any sole.
    pub state_changes: u64,
    /// Selections of a contact state.
    pub selections: u64,
    /// Candidate states tested, over all selections.
    pub states_tested: u64,
    /// Steps whose watched events confirmed the states held: one candidate each.
    pub confirmed: u64,
    /// Most candidates tested in one selection.
    pub states_tested_max: u64,
    /// Impacts.
    pub impacts: u64,
    /// Painleve configurations resolved by an impulse.
    pub jams: u64,
    /// Selections in which no candidate was valid.
    pub inconsistent: u64,
    /// Base position at the end, m.
    pub final_base_position: [f64; 3],
    /// Base roll, pitch, yaw at the end, rad.
    pub final_base_rpy: [f64; 3],
    /// Base linear velocity at the end, m/s.
    pub final_base_velocity: [f64; 3],
    /// Deepest vertex below the floor, m.
    pub max_penetration_m: f64,
    /// Greatest drift of a static sole's clamped vertex from its anchor, m.
    pub max_static_creep_m: f64,
    /// Greatest drift projected out of the clamped directions after a step, m.
    pub max_projection_m: f64,
    /// Greatest height of the lowest sole vertex, m.
    pub max_lift_m: f64,
    /// Greatest excess of tangential force over mu N, N.
    pub max_cone_excess: f64,
    /// Error of the energy balance at the end, J: see [`Balance`].
    pub energy_error_j: f64,
    /// First marks, s.
    pub first_touchdown_s: Option<f64>,
    /// See `first_touchdown_s`.
    pub first_liftoff_s: Option<f64>,
    /// First change from static to sliding of any sole.
    pub first_slip_s: Option<f64>,
    /// First change from sliding to static of any sole.
    pub first_stick_s: Option<f64>,
    /// First time a stop rule held.
    pub first_fall_s: Option<f64>,
    /// Root mean squares weigh the value at the end of a step with its length.
    pub rms_penetration_m: f64,
    /// Greatest tension the floor exerted on a vertex, N.
    pub max_tension_n: f64,
    /// Its root mean square, N.
    pub rms_tension_n: f64,
    /// Greatest product of normal force and gap of a vertex, N m.
    pub max_signorini_nm: f64,
    /// Its root mean square, N m.
    pub rms_signorini_nm: f64,
    /// Root mean square of the greatest cone excess, N.
    pub rms_cone_excess_n: f64,
    /// Greatest lack of maximum dissipation of a sliding vertex, W.
    pub max_dissipation_gap_w: f64,
    /// Its root mean square, W.
    pub rms_dissipation_gap_w: f64,
    /// Greatest tangential speed of a static vertex, m/s.
    pub max_creep_speed_m_per_s: f64,
    /// Its root mean square, m/s.
    pub rms_creep_speed_m_per_s: f64,
    /// Greatest distance between a sole's vertex forces and its wrench, N.
    pub max_resultant_gap_n: f64,
    /// Times that a sole's force dropped to zero and returned while its gap stayed closed.
    pub force_flickers: u64,
    /// Greatest error of the energy balance, J.
    pub max_energy_error_j: f64,
    /// Its root mean square, J.
    pub rms_energy_error_j: f64,
    /// Kinetic and potential energy at the end less at the start, J.
    pub energy_change_j: f64,
    /// Work of the actuators, J.
    pub actuator_work_j: f64,
    /// Work of external forces, J.
    pub external_work_j: f64,
    /// Energy taken by damping, friction and stops of the joints, J.
    pub joint_loss_j: f64,
    /// Energy taken by friction at the soles, J.
    pub friction_loss_j: f64,
    /// Energy taken by impacts and other velocity jumps, J.
    pub impact_loss_j: f64,
    /// Base angular velocity at the end, world axes, rad/s.
    pub final_base_angular_velocity: [f64; 3],
    /// Centre of mass at the end, m.
    pub final_com_position: [f64; 3],
    /// Its velocity, m/s.
    pub final_com_velocity: [f64; 3],
    /// Distance of the base's origin from where it started, m.
    pub final_base_shift_m: f64,
    /// Distance of the base's origin at the end from the straight line of its initial velocity, m; none without one.
    pub final_base_sideways_m: Option<f64>,
    /// Sum of the normal forces at the end, N; none when the run did not reach it, or without soles.
    pub final_normal_force_n: Option<f64>,
    /// Distance of the centre of pressure from the point of the floor below the centre of mass (along gravity) at the
    /// end, m; none in flight.
    pub final_cop_offset_m: Option<f64>,
    /// First change of any sole from a pattern to a smaller one: from its face to an edge or vertex, from an edge to a
    /// vertex, s.
    pub first_tip_s: Option<f64>,
    /// Last impact, s.
    pub last_impact_s: Option<f64>,
    /// Square root of the kinetic energy after the first impact over that before.
    pub first_impact_speed_ratio: Option<f64>,
    /// Greatest distance of the centre of mass from the parabola it entered a flight on, m.
    pub max_flight_path_drift_m: f64,
    /// Greatest change of the angular momentum about the centre of mass during a flight, kg m^2/s.
    pub max_flight_spin_drift_nms: f64,
    /// Greatest distance of the estimated base from the true one at a control tick, m; none without an estimator.
    pub max_estimate_error_m: Option<f64>,
    /// Greatest angle between them, rad.
    pub max_estimate_error_rad: Option<f64>,
    /// The distance at the last tick, m.
    pub final_estimate_error_m: Option<f64>,
    /// The angle at the last tick, rad.
    pub final_estimate_error_rad: Option<f64>,
    /// Smallest distance of two watched bodies, m; below 0 the depth of their overlap; none without `[self_collision]`.
    pub min_self_distance_m: Option<f64>,
    /// Times that two watched bodies began to overlap.
    pub self_collisions: Option<u64>,
    /// Time in which two were nearer than the margin, s.
    pub self_near_s: Option<f64>,
    /// Cycles of avoidance; none when collisions are not avoided.
    pub avoidance_cycles: Option<u64>,
    /// Of these, those between the regular ones.
    pub avoidance_early_cycles: Option<u64>,
    /// Cycles in which a joint could not go where the tasks want it.
    pub avoidance_blocked_cycles: Option<u64>,
    /// Postures tested in a cycle, on average.
    pub avoidance_tests_mean: Option<f64>,
    /// The most.
    pub avoidance_tests_max: Option<u64>,
    /// Share of ticks and joints at which a joint was kept from where the tasks want it.
    pub avoidance_held_share: Option<f64>,
    /// Root mean square over ticks and joints of what is asked less what the tasks want, rad or m.
    pub avoidance_rms_deviation: Option<f64>,
    /// The greatest such difference.
    pub avoidance_max_deviation: Option<f64>,
}

impl Metrics {
    /// Candidates tested per selection, a step without an event counting as one selection that kept its states; none
    /// without any.
    pub fn states_tested_mean(&self) -> Option<f64> {
        let selections = self.selections + self.confirmed;
        (self.selections > 0).then(|| (self.states_tested + self.confirmed) as f64 / selections as f64)
    }
}

/// Receives what a run tells while it runs. `Err` ends the run with outcome `error` and that message.
pub trait Observer {
    /// Called at the log rate and once at the end.
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), String>;
    /// Called at once for every event, in time order.
    fn event(&mut self, event: &SimEvent) -> Result<(), String>;
    /// How many samples per simulated second it wants; the same answer throughout a run. 0: none.
    fn sample_rate(&self) -> f64 {
        0.0
    }
    /// Called with samples in time order: at `k / rate` before the end of the run, and there if it was reached. Unlike
    /// snapshots they stand at these instants exactly.
    fn sample(&mut self, _: &Sample) -> Result<(), String> {
        Ok(())
    }
    /// Which contact problems it wants to be told of; the same answer throughout a run.
    fn problems(&self) -> Problems {
        Problems::None
    }
    /// Called for every selection of the kind asked for, before the event that goes with it.
    fn problem(&mut self, _: &Frozen) -> Result<(), String> {
        Ok(())
    }
}

/// Selections of a contact state that an observer wants to see.
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
    fn snapshot(&mut self, _: &Snapshot) -> Result<(), String> {
        Ok(())
    }
    fn event(&mut self, _: &SimEvent) -> Result<(), String> {
        Ok(())
    }
}

/// An observer that looks away.
pub struct Blind;

impl Observer for Blind {
    fn snapshot(&mut self, _: &Snapshot) -> Result<(), String> {
        Ok(())
    }
    fn event(&mut self, _: &SimEvent) -> Result<(), String> {
        Ok(())
    }
}
