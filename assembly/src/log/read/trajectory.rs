//! A log as time series. World axes, SI units; entry `i` of every series belongs to `times[i]`.

use crate::log::messages::Residual;
use crate::log::read::estimate_series::EstimateSeries;
use crate::log::read::object_series::ObjectSeries;
use crate::log::read::self_collision_series::SelfCollisionSeries;
use nalgebra::{UnitQuaternion, Vector3};

/// A run, read from its log. A group of topics that the scenario did not log (`log.topics`) is
/// `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    /// Identity of the run.
    pub info: RunInfo,
    /// True if the run ended by itself; false for a cancelled or failed run, whose series end
    /// early.
    pub complete: bool,
    /// Scenario, robot file (if there is one), URDF, and other input files of the run.
    pub attachments: Vec<Attachment>,
    /// Simulated times of the ticks, s, as they were logged: rising, mostly at the log's rate.
    /// Empty when the log has neither `state` nor `contact`.
    pub times: Vec<f64>,
    /// The robot's motion; topic `state`.
    pub motion: Option<Motion>,
    /// The soles in the robot's order; topic `contact`.
    pub soles: Option<Vec<SoleSeries>>,
    /// Residuals of the contact laws and energy balance; topic `contact`. One entry per tick.
    pub residuals: Option<Vec<Residual>>,
    /// Sensor readings and state estimate, if they can differ from the true state. One entry per
    /// tick.
    pub estimate: Option<EstimateSeries>,
    /// Distances between bodies of the robot, if the scenario has `[self_collision]`. One entry per
    /// tick.
    pub self_collision: Option<SelfCollisionSeries>,
    /// Poses of the links of objects; topic `scene`, with `state` or `contact`.
    pub objects: Vec<ObjectSeries>,
    /// Events in order of time, at their own instants.
    pub events: Vec<LoggedEvent>,
}

/// Identity of the run of a log.
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
    /// Name of the frame in which the robot moves.
    pub world_frame: String,
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
    /// Points shown by tasks.
    pub points: Vec<PointSeries>,
    /// External forces: points, m, and forces, N.
    pub external: Vec<Vec<(Vector3<f64>, Vector3<f64>)>>,
}

/// A point shown by a task.
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
    /// True for a prismatic joint (m, m/s, N), false for a revolute one (rad, rad/s, N m).
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
    /// Efforts commanded by the drives, before limits and lag; NaN if the log lacks them.
    pub desired_effort: Vec<f64>,
}

/// One sole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoleSeries {
    /// Name in the robot file.
    pub name: String,
    /// Another contact, not a sole. It has `points` instead of vertices, as they change.
    pub is_link: bool,
    /// `free`, or pattern and mode, such as `face-static`.
    pub state: Vec<String>,
    /// Sum of the floor's forces on the vertices, N.
    pub force: Vec<Vector3<f64>>,
    /// The vertices in the robot file's order.
    pub vertices: Vec<VertexSeries>,
    /// The vertices of another contact, by tick; empty for soles.
    pub points: Vec<Vec<ContactPoint>>,
}

/// A vertex of a contact at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Whether it touches and is clamped.
    pub clamped: bool,
    /// Position, world, m.
    pub position: Vector3<f64>,
    /// Force on it, world, N.
    pub force: Vector3<f64>,
}

/// One vertex of a sole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexSeries {
    /// True where it is clamped to the floor.
    pub clamped: Vec<bool>,
    /// Positions, m.
    pub position: Vec<Vector3<f64>>,
    /// Velocities, m/s.
    pub velocity: Vec<Vector3<f64>>,
    /// Forces of the floor on it, N.
    pub force: Vec<Vector3<f64>>,
}

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedEvent {
    /// Simulated time, s.
    pub time: f64,
    /// Short kind, such as `touchdown`.
    pub kind: String,
    /// Its subject, such as a sole; may be empty.
    pub subject: String,
    /// Its description as text.
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

    /// The scenario is the first TOML attachment, the robot file the second.
    fn toml(&self, nth: usize) -> Option<&str> {
        let tomls = self.attachments.iter().filter(|a| a.media_type == "application/toml");
        tomls.map(|a| a.text.as_str()).nth(nth)
    }
}
