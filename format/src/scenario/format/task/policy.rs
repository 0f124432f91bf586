//! `policy`.

use std::{borrow::Cow, collections::BTreeMap, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, SeqAccess, Visitor},
};

use crate::text::quantity::{angle, count, joint_positions, json, non_negative, some_non_negative, some_positive};

/// Commands joints by a neural network in an ONNX file. Only programs built with the feature
/// `policy` can run it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyTask {
    /// The network, an ONNX file (`.onnx`), relative to this file.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// How long it lasts, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
    /// The network is evaluated at every so many control ticks; its action is held between.
    #[serde(default = "one", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub decimation: u32,
    /// Name of a key of the MJCF file (`<keyframe>`) with the default posture; joints of `posture`
    /// are as given there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframe: Option<String>,
    /// The default posture by joint name, rad or m; joints left out are at the robot's home.
    #[serde(default, deserialize_with = "joint_positions", skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, json::Angle>")]
    pub posture: BTreeMap<String, f64>,
    /// The numbers that the network receives, in this order.
    #[schemars(length(min = 1))]
    pub observations: Vec<PolicyObservation>,
    /// Number of observations that the network receives: the present one and those of the
    /// evaluations before. At the start all are the first one.
    #[serde(default = "one", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub history: u32,
    /// True: the present observation is the first of the history, not the last.
    #[serde(default)]
    pub newest_first: bool,
    /// True: each term with its history, one after the other; false: whole observations.
    #[serde(default)]
    pub by_term: bool,
    /// The joints that the network commands.
    pub action: PolicyAction,
    /// Name of the network's input for observations; required if it has several, besides `state`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input: Option<String>,
    /// Name of the network's output for actions; required if it has several, besides `state`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<String>,
    /// States of a recurrent network.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub state: Vec<PolicyState>,
    /// New values of the term `command` at given times, ascending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub change: Vec<PolicyChange>,
}

/// A term of the observation. Its numbers are `scale * x + offset`, limited by `clip`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyObservation {
    /// The quantity.
    pub term: PolicyTerm,
    /// Joints of `joint-positions` and `joint-velocities`, in this order: names, or patterns in
    /// which `*` stands for any characters and `?` for one. Left out: those of `action`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<String>>,
    /// False: `joint-positions` are not relative to the default posture.
    #[serde(default = "crate::scenario::format::defaults::yes")]
    pub relative: bool,
    /// Soles of `sole-forces` and `contacts`, in this order; left out: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soles: Option<Vec<String>>,
    /// Least normal force of a sole in contact, N; left out: 1.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub threshold: Option<f64>,
    /// The numbers of `command`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<f64>,
    /// Period of `sine` and `cosine`, s.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub period: Option<f64>,
    /// Phase of `sine` and `cosine` at `start`, rad.
    #[serde(default, deserialize_with = "angle", skip_serializing_if = "crate::scenario::format::defaults::is_zero")]
    #[schemars(with = "json::Angle")]
    pub phase: f64,
    /// Factor: one for all numbers of the term, or a list.
    #[serde(default = "unit")]
    pub scale: PolicyNumbers,
    /// Summand: one for all numbers of the term, or a list.
    #[serde(default = "zero")]
    pub offset: PolicyNumbers,
    /// Greatest magnitude; left out: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub clip: Option<f64>,
}

/// Quantities that a network observes. The base is the root link; its motion is the estimated one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PolicyTerm {
    /// Velocity of the base's origin, base axes, m/s: 3 numbers.
    LinearVelocity,
    /// Angular velocity of the base, base axes, rad/s: 3 numbers.
    AngularVelocity,
    /// Direction of gravity, base axes: 3 numbers.
    Gravity,
    /// Orientation of the base in the world, a unit quaternion w, x, y, z with w at least 0: 4
    /// numbers.
    Orientation,
    /// Height of the base's origin above the floor plane, m: 1 number.
    Height,
    /// `values`, which `change` replaces.
    Command,
    /// Joint positions less those of the default posture, rad or m: a number for each joint.
    JointPositions,
    /// Joint velocities, rad/s or m/s: a number for each joint.
    JointVelocities,
    /// The last output of the network, limited by `action.clip`; at the start zeros.
    PreviousAction,
    /// Force on each sole, base axes, N: 3 numbers for each sole.
    SoleForces,
    /// 1 for each sole whose normal force is at least `threshold`, else 0.
    Contacts,
    /// `sin(2 pi t / period + phase)`, t from `start`: 1 number.
    Sine,
    /// The cosine of the same.
    Cosine,
}

/// The joints that a network commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyAction {
    /// The joints in the order of the output: names, or patterns as in `observations`.
    #[schemars(length(min = 1))]
    pub joints: Vec<String>,
    /// What is commanded.
    #[serde(default)]
    pub mode: PolicyMode,
    /// Factor of the output: one for all joints, or a list.
    #[serde(default = "unit")]
    pub scale: PolicyNumbers,
    /// Greatest magnitude of the output, before `scale`; left out: none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub clip: Option<f64>,
    /// Position gains of the drives from `start` on, N m/rad or N/m: one for all joints, or a
    /// list. Left out: those of the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kp: Option<PolicyNumbers>,
    /// Velocity gains of the drives from `start` on, N m s/rad or N s/m: one for all joints, or a
    /// list. Left out: those of the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kd: Option<PolicyNumbers>,
}

/// What a network commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PolicyMode {
    /// Positions: the default posture plus the scaled output, rad or m. The drives follow them
    /// with their gains.
    #[default]
    Position,
    /// Efforts: the scaled output, N m or N.
    Force,
}

/// A state of a recurrent network: zeros at the start, then the output of the evaluation before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyState {
    /// Name of the input.
    pub input: String,
    /// Name of the output.
    pub output: String,
}

/// New values of the term `command`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyChange {
    /// Simulated time, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// As many numbers as the term has.
    pub values: Vec<f64>,
}

/// One number for all entries, or one for each.
#[derive(Clone, Debug, PartialEq)]
pub enum PolicyNumbers {
    /// For all.
    All(f64),
    /// In order.
    Each(Vec<f64>),
}

impl PolicyNumbers {
    /// One for each of `count` entries; none if the list has another length.
    pub fn expand(&self, count: usize) -> Option<Vec<f64>> {
        match self {
            PolicyNumbers::All(number) => Some(vec![*number; count]),
            PolicyNumbers::Each(numbers) => (numbers.len() == count).then(|| numbers.clone()),
        }
    }
}

impl Serialize for PolicyNumbers {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        match self {
            PolicyNumbers::All(number) => number.serialize(s),
            PolicyNumbers::Each(numbers) => numbers.serialize(s),
        }
    }
}

struct NumbersVisitor;

impl<'de> Visitor<'de> for NumbersVisitor {
    type Value = PolicyNumbers;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list of numbers")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<PolicyNumbers, E> {
        Ok(PolicyNumbers::All(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<PolicyNumbers, E> {
        self.visit_f64(value as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<PolicyNumbers, A::Error> {
        let mut numbers = Vec::new();
        while let Some(number) = list.next_element()? {
            numbers.push(number);
        }
        Ok(PolicyNumbers::Each(numbers))
    }
}

impl<'de> Deserialize<'de> for PolicyNumbers {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_any(NumbersVisitor)
    }
}

impl JsonSchema for PolicyNumbers {
    fn schema_name() -> Cow<'static, str> {
        "PolicyNumbers".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]})
    }
}

fn one() -> u32 {
    1
}

fn unit() -> PolicyNumbers {
    PolicyNumbers::All(1.0)
}

fn zero() -> PolicyNumbers {
    PolicyNumbers::All(0.0)
}
