//! `[robot]`: the robot, its initial state, and changes to its files.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{
    angles, angular_rates, joint_positions, joint_velocities, json, non_negative, positive, some_non_negative,
    some_positive,
};

/// The robot of a scenario.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Path of a robot file (`.toml`), a URDF, MJCF file or SDF, relative to the scenario file.
    pub model: String,
    /// Address of a robot that this run does not simulate: `udp://ADDRESS:PORT`, where a `runner
    /// motor-server` or a robot listens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<String>,
    /// File with the secret that both sides share, at least 16 bytes; required unless the address
    /// of `backend` is on loopback.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend_key: Option<String>,
    /// Pose and velocity of the root link's frame at the start.
    #[serde(default)]
    pub base: BaseSpec,
    /// Name of a key of the MJCF file (`<keyframe>`) whose posture is that of the start; joints of `posture` are as
    /// given there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframe: Option<String>,
    /// Initial joint positions by joint name, rad or m; joints left out start at the robot's home.
    #[serde(default, deserialize_with = "joint_positions")]
    #[schemars(with = "BTreeMap<String, json::Angle>")]
    pub posture: BTreeMap<String, f64>,
    /// Initial joint velocities by joint name, rad/s or m/s; joints left out start at rest.
    #[serde(default, deserialize_with = "joint_velocities")]
    #[schemars(with = "BTreeMap<String, json::AngularRate>")]
    pub velocity: BTreeMap<String, f64>,
    /// The drive of joints that no robot file configures.
    #[serde(default)]
    pub joint_default: JointDefault,
    /// Behaviour at a joint's position limits.
    #[serde(default)]
    pub joint_limits: JointLimits,
    /// Soles that replace the robot's; with an empty list only links touch the floor, unless `contact`
    /// is `"soles"`. Left out: the robot's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soles: Option<Vec<SoleSpec>>,
    /// What touches floor, terrain and objects.
    #[serde(default)]
    pub contact: TouchingParts,
    /// Whether links touch each other; not with `contact = "soles"`. Pairs that self-collision does not monitor,
    /// such as neighbours, do not touch, nor do those that overlap at the start.
    #[serde(default, skip_serializing_if = "is_false")]
    pub self_contact: bool,
    /// Treatment of inertias that no body can have. Left out: as in the robot file, else
    /// `"refuse"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<InertiaSpec>,
    /// Masses welded to links.
    #[serde(default)]
    pub payload: Vec<PayloadSpec>,
    /// Changes to single joints, by name.
    #[serde(default)]
    pub joint: BTreeMap<String, JointSpec>,
}

fn is_false(value: &bool) -> bool {
    !*value
}

/// Pose and velocity of the root link's frame in the world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BaseSpec {
    /// Origin, m. Left out: above the world's origin, as low as floor and terrain permit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Roll, pitch, yaw as in URDF (about fixed x, then y, then z), rad.
    #[serde(deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// Velocity of the origin in world axes, m/s.
    pub linear_velocity: [f64; 3],
    /// Angular velocity in world axes, rad/s.
    #[serde(deserialize_with = "angular_rates")]
    #[schemars(with = "[json::AngularRate; 3]")]
    pub angular_velocity: [f64; 3],
}

/// What a joint's drive follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointMode {
    /// No drive.
    Passive,
    /// A position, by `kp` and `kd`.
    Position,
    /// A force or torque, as commanded.
    Force,
    /// A velocity, by `kd`.
    Velocity,
    /// Its command exactly, without dynamics: a prescribed motion.
    Kinematic,
}

/// The drive of joints that no robot file configures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JointDefault {
    /// Drive mode.
    pub mode: JointMode,
    /// Position gain, N m/rad or N/m; only for `position`.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub kp: f64,
    /// Velocity gain, N m s/rad or N s/m; only for `position` and `velocity`.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub kd: f64,
}

impl Default for JointDefault {
    fn default() -> Self {
        JointDefault { mode: JointMode::Position, kp: 100.0, kd: 5.0 }
    }
}

/// The parts of a robot that touch floor, terrain and objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TouchingParts {
    /// The soles only.
    Soles,
    /// The soles, and all links: each ball, capsule and cylinder, and the convex hull of the other shapes of a link.
    /// A sole stands for what is within 1 cm of it on its link.
    #[default]
    Bodies,
}

/// Behaviour at a joint's position limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointLimits {
    /// A mechanical stop.
    #[default]
    Stop,
    /// Nothing.
    Ignore,
}

/// Treatment of inertias that no body can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InertiaSpec {
    /// The robot is refused with the name of the link.
    Refuse,
    /// The nearest physical tensor replaces it, with a notice.
    Repair,
}

/// A convex planar polygon that may touch the floor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SoleSpec {
    /// Name, unique in the robot.
    pub name: String,
    /// Carrying link.
    pub link: String,
    /// Vertices in the link's frame, m, in order around the polygon. One is a point foot, two a
    /// line foot.
    #[schemars(length(min = 1))]
    pub polygon: Vec<[f64; 3]>,
}

/// A mass welded to a link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PayloadSpec {
    /// Name for messages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Carrying link.
    pub link: String,
    /// Mass, kg.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// `[ixx, iyy, izz, ixy, ixz, iyz]` about the payload's centre of mass in the link's axes, kg
    /// m^2. Left out: a point mass.
    #[serde(default)]
    pub inertia: [f64; 6],
    /// Instead of `inertia`: edges of a homogeneous box along the link's axes, m; the box is also
    /// drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 3]>,
}

/// Changes to one joint; values left out are those of the robot's files.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JointSpec {
    /// Drive mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<JointMode>,
    /// Position gain, N m/rad or N/m.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub kp: Option<f64>,
    /// Velocity gain, N m s/rad or N s/m.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub kd: Option<f64>,
    /// Friction in the joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<JointFriction>,
    /// Greatest actuator effort, N m or N.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub effort: Option<f64>,
    /// Greatest speed of the actuator, rad/s or m/s.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub velocity: Option<f64>,
    /// Reflected rotor inertia, kg m^2 or kg.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub armature: Option<f64>,
    /// Time constant of the actuator, s: its effort follows the commanded one as a first-order lag.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub lag: Option<f64>,
    /// End stops. Left out: as stiff as lets the joint's own inertia swing at 300 rad/s, critically
    /// damped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stop: Option<JointStop>,
}

/// Friction in a joint: `tau = -[c + (s - c) exp(-(qd/v_str)^2)] tanh(qd/v_s) - d qd`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JointFriction {
    /// Coulomb friction, N m or N.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub coulomb: f64,
    /// Viscous friction, N m s/rad or N s/m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub viscous: f64,
    /// Static friction s, N m or N, not smaller than `coulomb`. Left out: as `coulomb`.
    #[serde(rename = "static", skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub static_: Option<f64>,
    /// Speed v_str over which friction falls from `static` to `coulomb`, rad/s or m/s. Left out:
    /// 0.2.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub stribeck_velocity: Option<f64>,
    /// Speed v_s below which friction is below its full size, rad/s or m/s. Left out: 0.05.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub slip_velocity: Option<f64>,
}

/// A joint's end stops: springs and dampers beyond its limits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointStop {
    /// N m/rad or N/m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub stiffness: f64,
    /// N m s/rad or N s/m.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub damping: f64,
}
