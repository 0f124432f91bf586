//! The types of the robot file (`robots/<name>/<name>.toml`), and its reader.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::robot_error::{FileError, RobotError};
use super::urdf::InertiaPolicy;
use crate::text::angle::Angle;
use crate::text::source::Source;
use crate::text::suggest::nearest;
use crate::text::toml_syntax::TomlError;

/// A robot file.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    /// The robot's URDF, MJCF file or SDF, relative to this file; required unless `urdf` is given.
    #[schemars(with = "Option<String>")]
    pub model: Option<Spanned<String>>,
    /// Other name of `model`; one of both is required.
    #[schemars(with = "Option<String>")]
    pub urdf: Option<Spanned<String>>,
    /// Whether the root link is fixed or floats; by default fixed when the URDF's root link is
    /// called `world`, else floating.
    #[schemars(with = "Option<BaseWord>")]
    pub base: Option<Spanned<BaseWord>>,
    /// Treatment of inertias that no body can have; a scenario may override it.
    pub inertia: Option<InertiaWord>,
    /// Joint positions of the home posture; other joints are at 0, or at the limit nearest to 0.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, Angle>")]
    pub home: BTreeMap<Spanned<String>, Spanned<Angle>>,
    /// Convex polygons that may touch the floor; detected from the collision shapes when none are
    /// given.
    #[schemars(with = "Option<Vec<SoleEntry>>")]
    pub sole: Option<Vec<Spanned<SoleEntry>>>,
    /// Drives by joint name.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, JointEntry>")]
    pub joint: BTreeMap<Spanned<String>, Spanned<JointEntry>>,
    /// Values that a joint's own table leaves out.
    #[schemars(with = "Option<JointEntry>")]
    pub joint_default: Option<Spanned<JointEntry>>,
    /// Loads welded to links.
    #[serde(default)]
    #[schemars(with = "Vec<PayloadEntry>")]
    pub payload: Vec<Spanned<PayloadEntry>>,
    /// Joints that follow their command exactly, without dynamics (mode `kinematic`): names in
    /// which `*` matches any characters and `?` one.
    #[schemars(with = "Option<Vec<String>>")]
    pub kinematic: Option<Vec<Spanned<String>>>,
    /// Closed loops.
    #[serde(default, rename = "loop")]
    #[schemars(with = "Vec<LoopEntry>")]
    pub loops: Vec<Spanned<LoopEntry>>,
    /// Motors that drive joints through gears.
    #[serde(default)]
    #[schemars(with = "Vec<TransmissionEntry>")]
    pub transmission: Vec<Spanned<TransmissionEntry>>,
    /// Frames of interest.
    #[serde(default)]
    #[schemars(with = "Vec<Frame>")]
    pub end_effector: Vec<Spanned<Frame>>,
    /// Sensors.
    #[schemars(with = "Option<Sensors>")]
    pub sensors: Option<Spanned<Sensors>>,
    /// Bodies that must not touch each other.
    #[schemars(with = "Option<SelfCollision>")]
    pub self_collision: Option<Spanned<SelfCollision>>,
}

/// Whether the root link is fixed or floats.
#[derive(Deserialize, JsonSchema, Clone, Copy, Debug)]
#[serde(rename_all = "kebab-case")]
pub enum BaseWord {
    /// Fixed to the world.
    Fixed,
    /// Free in space.
    Floating,
}

/// Treatment of inertias that no body can have.
#[derive(Deserialize, JsonSchema, Clone, Copy, Debug)]
#[serde(rename_all = "kebab-case")]
pub enum InertiaWord {
    /// The robot is refused with the name of the link.
    Refuse,
    /// The nearest physical tensor replaces it, with a notice.
    Repair,
}

impl From<InertiaWord> for InertiaPolicy {
    fn from(word: InertiaWord) -> Self {
        match word {
            InertiaWord::Refuse => InertiaPolicy::Refuse,
            InertiaWord::Repair => InertiaPolicy::Repair,
        }
    }
}

/// One sole.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct SoleEntry {
    /// Name, unique in the robot.
    pub name: String,
    /// Link whose URDF frame the polygon is given in.
    #[schemars(with = "String")]
    pub link: Spanned<String>,
    /// Vertices in order around a convex planar polygon, m; one is a point foot, two a line foot.
    #[schemars(with = "Vec<[f64; 3]>")]
    pub polygon: Spanned<Vec<[f64; 3]>>,
}

/// A load welded to a link.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct PayloadEntry {
    /// Name, for messages.
    pub name: String,
    /// Carrying link.
    #[schemars(with = "String")]
    pub link: Spanned<String>,
    /// Mass, kg, above 0.
    #[schemars(with = "f64", extend("exclusiveMinimum" = 0))]
    pub mass: Spanned<f64>,
    /// Centre of mass in the link's URDF frame, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub position: Option<Spanned<[f64; 3]>>,
    /// `[ixx, iyy, izz, ixy, ixz, iyz]` about that centre in the link's axes, kg m^2. Without
    /// `inertia` and `size` it is a point mass.
    #[schemars(with = "Option<[f64; 6]>")]
    pub inertia: Option<Spanned<[f64; 6]>>,
    /// Instead of `inertia`: edges of a homogeneous box along the link's axes, m; the box is also
    /// drawn.
    #[schemars(with = "Option<[f64; 3]>")]
    pub size: Option<Spanned<[f64; 3]>>,
}

/// Drive mode of a joint.
#[derive(Deserialize, JsonSchema, Clone, Copy, PartialEq, Debug)]
#[serde(rename_all = "kebab-case")]
pub enum ModeWord {
    /// Proportional-derivative position control.
    Position,
    /// Commanded effort.
    Force,
    /// A velocity, by `kd`.
    Velocity,
    /// Follows its command exactly, without dynamics.
    Kinematic,
    /// No actuator.
    Passive,
}

/// Drive and friction of one joint; values left out come from `joint_default`, then from the URDF.
#[derive(Deserialize, JsonSchema, Clone, Default, Debug)]
#[serde(deny_unknown_fields)]
pub struct JointEntry {
    /// Drive mode; `position` when gains are given.
    #[schemars(with = "Option<ModeWord>")]
    pub mode: Option<Spanned<ModeWord>>,
    /// Position gain, N m/rad or N/m.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub kp: Option<Spanned<f64>>,
    /// Velocity gain, N m s/rad or N s/m.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub kd: Option<Spanned<f64>>,
    /// Greatest effort, N m or N.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub effort: Option<Spanned<f64>>,
    /// Greatest speed, rad/s or m/s.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub velocity: Option<Spanned<f64>>,
    /// Joint friction.
    pub friction: Option<Friction>,
    /// Reflected rotor inertia, kg m^2 or kg.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub armature: Option<Spanned<f64>>,
    /// Time constant of the actuator, s: its effort follows the commanded one as a first-order lag.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub lag: Option<Spanned<f64>>,
    /// End stops; left out: as stiff as lets the joint's own inertia swing at 300 rad/s, critically
    /// damped.
    pub stop: Option<StopEntry>,
}

/// Joint friction.
#[derive(Deserialize, JsonSchema, Clone, Default, Debug)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Independent of speed, N m or N.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub coulomb: Option<Spanned<f64>>,
    /// Proportional to speed, N m s/rad or N s/m.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub viscous: Option<Spanned<f64>>,
    /// At rest, N m or N, not smaller than `coulomb`; left out: as `coulomb`.
    #[serde(rename = "static")]
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub static_: Option<Spanned<f64>>,
    /// Speed over which friction falls from `static` to `coulomb`, rad/s or m/s; 0.2.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub stribeck_velocity: Option<Spanned<f64>>,
    /// Speed below which friction is below its full size, rad/s or m/s; 0.05.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub slip_velocity: Option<Spanned<f64>>,
}

/// A joint's end stops: springs and dampers beyond its limits.
#[derive(Deserialize, JsonSchema, Clone, Debug)]
#[serde(deny_unknown_fields)]
pub struct StopEntry {
    /// N m/rad or N/m.
    #[schemars(with = "f64", range(min = 0.0))]
    pub stiffness: Spanned<f64>,
    /// N m s/rad or N s/m; 0.
    #[schemars(with = "Option<f64>", range(min = 0.0))]
    pub damping: Option<Spanned<f64>>,
}

/// What a loop holds.
#[derive(Deserialize, JsonSchema, Clone, Copy, PartialEq, Debug)]
#[serde(rename_all = "kebab-case")]
pub enum LoopWord {
    /// The points of both sides coincide.
    #[serde(alias = "point")]
    Ball,
    /// The points coincide and the axes are parallel: a hinge.
    Pin,
    /// Both frames coincide.
    Weld,
    /// The points keep a distance: a massless rod with ball joints at both ends.
    Rod,
}

/// A closed loop: two links, or a link and the world, held together.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct LoopEntry {
    /// Name, unique among the loops.
    pub name: String,
    /// What is held; `"point"` is `"ball"`.
    #[serde(rename = "type")]
    pub kind: LoopWord,
    /// The first link.
    #[schemars(with = "String")]
    pub link: Spanned<String>,
    /// The second link, or `"world"`.
    #[schemars(with = "String")]
    pub to: Spanned<String>,
    /// Point in the first link's URDF frame, m; 0 0 0.
    #[schemars(with = "Option<[f64; 3]>")]
    pub position: Option<Spanned<[f64; 3]>>,
    /// Point in the second link's URDF frame, or in the world, m; left out: where the first one is in the home
    /// posture, with the root at the world's origin.
    #[schemars(with = "Option<[f64; 3]>")]
    pub to_position: Option<Spanned<[f64; 3]>>,
    /// Of a pin: axis in the first link's URDF frame; z.
    #[schemars(with = "Option<[f64; 3]>")]
    pub axis: Option<Spanned<[f64; 3]>>,
    /// Of a pin: axis in the second link's URDF frame, or in the world; left out: as at home.
    #[schemars(with = "Option<[f64; 3]>")]
    pub to_axis: Option<Spanned<[f64; 3]>>,
    /// Of a weld: roll, pitch, yaw of the frame on the first link; 0 0 0.
    #[schemars(with = "Option<[Angle; 3]>")]
    pub rpy: Option<Spanned<[Angle; 3]>>,
    /// Of a weld: those of the frame on the second link, or in the world; left out: as at home.
    #[schemars(with = "Option<[Angle; 3]>")]
    pub to_rpy: Option<Spanned<[Angle; 3]>>,
    /// Of a rod: length, m, above 0; left out: the distance of the points at home.
    #[schemars(with = "Option<f64>", extend("exclusiveMinimum" = 0))]
    pub length: Option<Spanned<f64>>,
}

/// One number for all motors of a transmission, or a list with one for each.
#[derive(Deserialize, JsonSchema, Clone, PartialEq, Debug)]
#[serde(untagged, expecting = "expected a number, or a list of numbers with one per motor")]
pub enum PerMotor {
    /// The same for all.
    All(f64),
    /// One for each.
    Each(Vec<f64>),
}

/// Motors that drive joints through gears. With speeds of the motors `theta' = T q'`, T = `gear_ratio` times
/// `matrix`, efforts of the joints are `T^T m`, m the torques of the motors.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct TransmissionEntry {
    /// Name, unique among the transmissions.
    pub name: String,
    /// Joints that the motors drive, as many as motors.
    #[schemars(with = "Vec<String>")]
    pub joints: Spanned<Vec<Spanned<String>>>,
    /// A row per motor, a column per joint: speed of the motor, before its gear, by that of the joint. Left out
    /// for one joint: 1.
    #[schemars(with = "Option<Vec<Vec<f64>>>")]
    pub matrix: Option<Spanned<Vec<Vec<f64>>>>,
    /// Turns of the motor per turn of its row, above 0 (`mechanicalReduction` of URDF); 1.
    #[schemars(with = "Option<PerMotor>")]
    pub gear_ratio: Option<Spanned<PerMotor>>,
    /// Inertia of the rotor about its axis, kg m^2; 0.
    #[schemars(with = "Option<PerMotor>")]
    pub rotor_inertia: Option<Spanned<PerMotor>>,
    /// Greatest torque of the motor, N m, instead of the joints' greatest efforts.
    #[schemars(with = "Option<PerMotor>")]
    pub effort: Option<Spanned<PerMotor>>,
    /// Greatest speed of the motor, rad/s, instead of the joints' greatest speeds.
    #[schemars(with = "Option<PerMotor>")]
    pub velocity: Option<Spanned<PerMotor>>,
    /// Friction of each motor, N m by rad/s, instead of that of the joints. `stribeck_velocity` and
    /// `slip_velocity` are by default 0.2 and 0.05 times the gear ratio.
    #[schemars(with = "Option<Friction>")]
    pub friction: Option<Spanned<Friction>>,
}

/// A frame fixed to a link.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// Name.
    pub name: String,
    /// Carrying link.
    #[schemars(with = "String")]
    pub link: Spanned<String>,
    /// Origin in the link's URDF frame, m.
    #[schemars(with = "Option<[f64; 3]>")]
    pub position: Option<Spanned<[f64; 3]>>,
    /// Roll, pitch, yaw in the link's URDF frame.
    pub rpy: Option<[Angle; 3]>,
}

/// Sensors of the robot.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct Sensors {
    /// Inertial measurement units; a scenario reads the first one unless it names another.
    #[serde(default)]
    #[schemars(with = "Vec<Frame>")]
    pub imu: Vec<Spanned<Frame>>,
    /// Force and torque sensors; those on a link with a sole are read.
    #[serde(default)]
    #[schemars(with = "Vec<Frame>")]
    pub force: Vec<Spanned<Frame>>,
}

/// Links that are checked for collisions with each other.
#[derive(Deserialize, JsonSchema, Debug)]
#[serde(deny_unknown_fields)]
pub struct SelfCollision {
    /// Checked links; left out: all, except those always inside another one.
    #[schemars(with = "Option<Vec<String>>")]
    pub bodies: Option<Vec<Spanned<String>>>,
    /// Pairs that are not checked.
    #[serde(default)]
    #[schemars(with = "Vec<[String; 2]>")]
    pub ignore: Vec<[Spanned<String>; 2]>,
    /// Pairs that are always checked, even if they are adjacent, overlap at home or never meet.
    #[serde(default)]
    #[schemars(with = "Vec<[String; 2]>")]
    pub watch: Vec<[Spanned<String>; 2]>,
    /// Corners of the polygon around a circle of a cylinder, capsule or sphere, 8 to 128; 16.
    #[schemars(with = "Option<u32>", range(min = 8, max = 128))]
    pub resolution: Option<Spanned<u32>>,
}

/// The JSON Schema of a robot file.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(RobotFile).into()
}

impl RobotFile {
    /// The key that names the robot's model, and its value.
    ///
    /// # Errors
    /// Neither or both of `model` and `urdf`.
    pub(super) fn model_path(&self, source: &Source) -> Result<(&'static str, &Spanned<String>), RobotError> {
        match (&self.model, &self.urdf) {
            (Some(model), None) => Ok(("model", model)),
            (None, Some(urdf)) => Ok(("urdf", urdf)),
            (Some(model), Some(_)) => {
                let fault = FileError::new(source, model.span(), "`model` and `urdf` exclude each other");
                Err(fault.element("model").expected("one of them").invalid())
            }
            (None, None) => {
                let end = source.text().find('\n').unwrap_or(source.text().len());
                let fault = FileError::new(source, 0..end, "the robot file names no model").element("robot file");
                Err(fault.expected("model = \"...\", the path of a URDF, MJCF or SDF file").invalid())
            }
        }
    }
}

/// Parses a robot file. Errors have the parser's position, and a suggestion for unknown keys.
pub(super) fn parse(source: &Source) -> Result<RobotFile, RobotError> {
    toml::from_str(source.text()).map_err(|error| {
        let TomlError { span, message, help } = TomlError::new(&error, source.text(), true);
        let is_syntax = toml::from_str::<toml::Table>(source.text()).is_err();
        // serde's sentence: unknown field `x`, expected one of `a`, `b`, ...
        let mut quoted = message.split('`').skip(1).step_by(2);
        let suggestion = match message.starts_with("unknown ") {
            true => quoted.next().and_then(|name| nearest(name, quoted)).map(str::to_owned),
            false => None,
        };
        let mut fault = FileError::new(source, span, message).element("robot file");
        if let Some(help) = help {
            fault = fault.help(help);
        }
        if let Some(near) = suggestion {
            fault = fault.help(format!("did you mean `{near}`?"));
        }
        if is_syntax { fault.syntax() } else { fault.invalid() }
    })
}
