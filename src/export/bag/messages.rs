//! The ROS 2 messages of a bag, with the fields of Humble to Jazzy.

use crate::log::ros::{Header, JointState, Text, Time};
use nalgebra::{UnitQuaternion, Vector3 as Vector};
use serde::{Deserialize, Serialize};

/// A message that a topic can have.
pub trait RosMessage: Serialize {
    /// Its type, such as `std_msgs/msg/String`.
    const TYPE: &'static str;
}

/// `geometry_msgs/msg/Vector3`, and `Point`, which has the same fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

impl From<Vector<f64>> for Vector3 {
    fn from(v: Vector<f64>) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

/// `geometry_msgs/msg/Quaternion`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// First imaginary part.
    pub x: f64,
    /// Second imaginary part.
    pub y: f64,
    /// Third imaginary part.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

impl From<UnitQuaternion<f64>> for Quaternion {
    fn from(q: UnitQuaternion<f64>) -> Self {
        Self { x: q.i, y: q.j, z: q.k, w: q.w }
    }
}

impl Default for Quaternion {
    fn default() -> Self {
        UnitQuaternion::identity().into()
    }
}

/// `geometry_msgs/msg/Transform`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Origin of the child in the parent, m.
    pub translation: Vector3,
    /// Orientation of the child in the parent.
    pub rotation: Quaternion,
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Time, and the parent frame.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// Pose of the child in the parent.
    pub transform: Transform,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    /// The frames.
    pub transforms: Vec<TransformStamped>,
}

/// `geometry_msgs/msg/Wrench`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3,
    /// Moment, N m.
    pub torque: Vector3,
}

/// `geometry_msgs/msg/WrenchStamped`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WrenchStamped {
    /// Time, and the frame of force and moment.
    pub header: Header,
    /// Force and moment about the origin of the frame.
    pub wrench: Wrench,
}

/// `rosgraph_msgs/msg/Clock`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Simulated time.
    pub clock: Time,
}

/// `geometry_msgs/msg/Pose`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position, m.
    pub position: Vector3,
    /// Orientation.
    pub orientation: Quaternion,
}

/// `std_msgs/msg/ColorRGBA`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Colour {
    /// Red, 0 to 1.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity.
    pub a: f32,
}

/// `visualization_msgs/msg/UVCoordinate`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TextureCoordinate {
    /// Along the width.
    pub u: f32,
    /// Along the height.
    pub v: f32,
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Time and frame.
    pub header: Header,
    /// Format of the data.
    pub format: String,
    /// The image.
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/MeshFile`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Name of the file.
    pub filename: String,
    /// Its contents.
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/Marker`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Time and frame.
    pub header: Header,
    /// With `id` the name of the marker.
    pub ns: String,
    /// Number in its namespace.
    pub id: i32,
    /// Shape.
    pub r#type: i32,
    /// What happens to the marker.
    pub action: i32,
    /// Pose in the frame.
    pub pose: Pose,
    /// Size, m; its meaning depends on the shape.
    pub scale: Vector3,
    /// Colour.
    pub color: Colour,
    /// Time until it vanishes; 0 for never.
    pub lifetime: Time,
    /// True if it follows its frame.
    pub frame_locked: bool,
    /// Points of lines, triangles and arrows, m.
    pub points: Vec<Vector3>,
    /// Colours of the points; none if they have that of the marker.
    pub colors: Vec<Colour>,
    /// Texture; not used, like the following fields.
    pub texture_resource: String,
    /// Image of the texture.
    pub texture: CompressedImage,
    /// Its coordinates.
    pub uv_coordinates: Vec<TextureCoordinate>,
    /// Text.
    pub text: String,
    /// Address of a mesh.
    pub mesh_resource: String,
    /// A mesh.
    pub mesh_file: MeshFile,
    /// True if the mesh has colours.
    pub mesh_use_embedded_materials: bool,
}

/// `visualization_msgs/msg/MarkerArray`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers.
    pub markers: Vec<Marker>,
}

impl RosMessage for TfMessage {
    const TYPE: &'static str = "tf2_msgs/msg/TFMessage";
}

impl RosMessage for WrenchStamped {
    const TYPE: &'static str = "geometry_msgs/msg/WrenchStamped";
}

impl RosMessage for Clock {
    const TYPE: &'static str = "rosgraph_msgs/msg/Clock";
}

impl RosMessage for MarkerArray {
    const TYPE: &'static str = "visualization_msgs/msg/MarkerArray";
}

impl RosMessage for JointState {
    const TYPE: &'static str = "sensor_msgs/msg/JointState";
}

impl RosMessage for Text {
    const TYPE: &'static str = "std_msgs/msg/String";
}
