//! Definitions of the messages of a bag, MCAP's schema encoding `ros2msg`: the fields of a type,
//! then those of every type in it.

/// Types without `/msg`, and their fields. A type in a field has its package.
const FIELDS: [(&str, &str); 21] = [
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n"),
    ("geometry_msgs/WrenchStamped", "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n"),
    ("rosgraph_msgs/Clock", "builtin_interfaces/Time clock\n"),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    ),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/String", "string data\n"),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    ("visualization_msgs/Marker", MARKER),
    ("visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
];

/// Fields and constants of `visualization_msgs/msg/Marker` that Humble and Jazzy share.
const MARKER: &str = "\
int32 ARROW=0
int32 CUBE=1
int32 SPHERE=2
int32 CYLINDER=3
int32 LINE_STRIP=4
int32 LINE_LIST=5
int32 CUBE_LIST=6
int32 SPHERE_LIST=7
int32 POINTS=8
int32 TEXT_VIEW_FACING=9
int32 MESH_RESOURCE=10
int32 TRIANGLE_LIST=11
int32 ADD=0
int32 MODIFY=0
int32 DELETE=2
int32 DELETEALL=3
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
visualization_msgs/UVCoordinate[] uv_coordinates
string text
string mesh_resource
visualization_msgs/MeshFile mesh_file
bool mesh_use_embedded_materials
";

/// The definition of a type such as `std_msgs/msg/String`, with those of all types in it.
pub(super) fn definition(message: &str) -> String {
    let name = message.replace("/msg/", "/");
    let mut types = Vec::new();
    collect(&name, &mut types);
    let mut text = String::new();
    for (name, fields) in types {
        if !text.is_empty() {
            text.push_str(&format!("{}\nMSG: {name}\n", "=".repeat(80)));
        }
        text.push_str(fields);
    }
    text
}

/// Appends a type and the types of its fields, each once.
fn collect(name: &str, types: &mut Vec<(&'static str, &'static str)>) {
    let Some(found) = FIELDS.iter().find(|(known, _)| *known == name) else { return };
    if types.contains(found) {
        return;
    }
    types.push(*found);
    for field in found.1.lines() {
        let of_field = field.split(' ').next().unwrap_or_default();
        collect(of_field.trim_end_matches("[]"), types);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::ros;

    #[test]
    fn definitions_of_messages_that_logs_have_are_the_same() {
        assert_eq!(definition("sensor_msgs/msg/JointState"), ros::JOINT_STATE);
        assert_eq!(definition("std_msgs/msg/String"), ros::STRING);
    }

    #[test]
    fn a_definition_has_every_type_once() {
        for (name, _) in FIELDS {
            let text = definition(name);
            let defined: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
            let mut unique = defined.clone();
            unique.sort_unstable();
            unique.dedup();
            assert_eq!(unique.len(), defined.len(), "{name}");
            for field in text.lines().filter(|line| !line.starts_with("MSG: ")) {
                let of_field = field.split(' ').next().unwrap().trim_end_matches("[]");
                assert!(!of_field.contains('/') || defined.contains(&of_field), "{name}: {field}");
            }
        }
    }
}
