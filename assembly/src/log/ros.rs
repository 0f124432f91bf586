//! The two ROS 2 messages that ROS viewers draw without configuration, in CDR (the encoding of the
//! ROS 2 bus).

use serde::{Deserialize, Serialize};

/// `builtin_interfaces/msg/Time`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// Remainder, ns.
    pub nanosec: u32,
}

impl Time {
    /// An instant in simulated time.
    pub fn from_nanoseconds(ns: u64) -> Self {
        Self { sec: i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX), nanosec: (ns % 1_000_000_000) as u32 }
    }
}

/// `std_msgs/msg/Header`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Simulated time.
    pub stamp: Time,
    /// The frame; empty for joint states, which belong to none.
    pub frame_id: String,
}

/// `sensor_msgs/msg/JointState`, topic `/joint_states`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Time and frame.
    pub header: Header,
    /// Joint names.
    pub name: Vec<String>,
    /// Positions, rad or m.
    pub position: Vec<f64>,
    /// Velocities, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Actuator efforts, N m or N.
    pub effort: Vec<f64>,
}

/// `std_msgs/msg/String`, topic `/robot_description`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// The URDF.
    pub data: String,
}

/// Definition of `sensor_msgs/msg/JointState` and its dependencies, schema encoding `ros2msg`.
pub const JOINT_STATE: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Definition of `std_msgs/msg/String`.
pub const STRING: &str = "string data\n";
