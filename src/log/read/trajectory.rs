//! What a log tells, as time series. World axes, SI units; entry `i` of every series belongs to `times[i]`.

use crate::log::messages::Residual;
use crate::log::read::estimate_series::EstimateSeries;
use crate::log::read::self_collision_series::SelfCollisionSeries;
use nalgebra::{UnitQuaternion, Vector3};

/// A run as its log tells it. A group of topics the scenario did not log (`log.topics`) is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// Which run this is.
    pub info: RunInfo,
    /// Did the run end by itself; false for one that was cancelled or broke down, whose series then end early.
    pub complete: bool,
    /// Scenario, robot file (if there is one), URDF, and other texts that the run was made of.
    pub attachments: Vec<Attachment>,
    /// Simulated times of the ticks, s, as they were logged: rising, mostly at the log's rate. Empty when the log holds
    /// neither `state` nor `contact`.
    pub times: Vec<f64>,
    /// The robot's motion; topic `state`.
    pub motion: Option<Motion>,
    /// The soles in the robot's order; topic `contact`.
    pub soles: Option<Vec<SoleSeries>>,
    /// What the contact laws miss, and the energy balance; topic `contact`. One entry per tick.
    pub residuals: Option<Vec<Residual>>,
    /// What the robot knew; where sensors or estimator do not tell the truth. One entry per tick.
    pub estimate: Option<EstimateSeries>,
    /// How near the robot is to touching itself; where the scenario asks. One entry per tick.
    pub self_collision: Option<SelfCollisionSeries>,
    /// What happened, in the order of time; not bound to ticks.
    pub events: Vec<LoggedEvent>,
}

/// Which run a log is of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunInfo {
    /// Name of the scenario.
    pub scenario: String,
    /// Key of the run.
    pub key: String,
    /// Contact method.
    pub method: String,
    /// Program and version that wrote the log.
    pub program: String,
    /// Name of the robot.
    pub robot: String,
}

/// A text in a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// File name.
    pub name: String,
    /// Media type.
    pub media_type: String,
    /// Contents.
    pub text: String,
}

/// Motion of the whole robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Origin of the root link's URDF frame, m.
    pub base_position: Vec<Vector3<f64>>,
    /// Orientation of the root link's URDF frame.
    pub base_orientation: Vec<UnitQuaternion<f64>>,
    /// Velocity of that origin, m/s.
    pub base_linear_velocity: Vec<Vector3<f64>>,
    /// Angular velocity of the root link, rad/s.
    pub base_angular_velocity: Vec<Vector3<f64>>,
    /// The joints in the robot's order.
    pub joints: Vec<JointSeries>,
    /// Centre of mass, m.
    pub com: Vec<Vector3<f64>>,
    /// Velocity of the centre of mass, m/s.
    pub com_velocity: Vec<Vector3<f64>>,
    /// Centre of pressure on the floor plane, m; `None` in flight.
    pub cop: Vec<Option<Vector3<f64>>>,
    /// Point of optimal stability of the support polygon, m; none in flight.
    pub stable_point: Vec<Option<Vector3<f64>>>,
    /// Convex hull of the touching vertices, m.
    pub support_polygon: Vec<Vec<Vector3<f64>>>,
    /// Points that tasks show.
    pub points: Vec<PointSeries>,
    /// External forces: points, m, and forces, N.
    pub external: Vec<Vec<(Vector3<f64>, Vector3<f64>)>>,
}

/// A point that a task shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointSeries {
    /// Its name.
    pub name: String,
    /// World, m; `None` while it is not shown.
    pub position: Vec<Option<Vector3<f64>>>,
}

/// One joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointSeries {
    /// Name in the URDF.
    pub name: String,
    /// Does it move along its axis (m, m/s, N); otherwise it turns about it (rad, rad/s, N m).
    pub prismatic: bool,
    /// Positions, rad or m.
    pub position: Vec<f64>,
    /// Velocities, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Desired positions.
    pub desired_position: Vec<f64>,
    /// Desired velocities.
    pub desired_velocity: Vec<f64>,
    /// Actuator efforts, N m or N.
    pub effort: Vec<f64>,
    /// Efforts that the drives ask for, before limits and lag; not a number where the log does not say.
    pub desired_effort: Vec<f64>,
}

/// One sole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoleSeries {
    /// Name in the robot file.
    pub name: String,
    /// `free`, or pattern and mode, such as `face-static`.
    pub state: Vec<String>,
    /// Sum of the floor's forces on the vertices, N.
    pub force: Vec<Vector3<f64>>,
    /// The vertices in the robot file's order.
    pub vertices: Vec<VertexSeries>,
}

/// One vertex of a sole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexSeries {
    /// Is it clamped to the floor.
    pub clamped: Vec<bool>,
    /// Positions, m.
    pub position: Vec<Vector3<f64>>,
    /// Velocities, m/s.
    pub velocity: Vec<Vector3<f64>>,
    /// Forces of the floor on it, N.
    pub force: Vec<Vector3<f64>>,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEvent {
    /// Simulated time, s.
    pub time: f64,
    /// Short kind, such as `touchdown`.
    pub kind: String,
    /// What it is about; may be empty.
    pub subject: String,
    /// Words for a person.
    pub message: String,
}

impl Trajectory {
    /// The resolved scenario, as TOML.
    pub fn scenario_text(&self) -> Option<&str> {
        self.toml(0)
    }

    /// The robot file; none when the scenario names a URDF.
    pub fn robot_text(&self) -> Option<&str> {
        self.toml(1)
    }

    /// The URDF.
    pub fn urdf_text(&self) -> Option<&str> {
        self.attachments.iter().find(|a| a.media_type == "application/xml").map(|a| a.text.as_str())
    }

    /// The scenario is attached first, the robot file after it.
    fn toml(&self, nth: usize) -> Option<&str> {
        let tomls = self.attachments.iter().filter(|a| a.media_type == "application/toml");
        tomls.map(|a| a.text.as_str()).nth(nth)
    }
}
