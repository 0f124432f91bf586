//! Describes the messages of a log to foreign readers: a serialised `FileDescriptorSet`, MCAP's
//! schema encoding `protobuf`.

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

/// Type of a field: a scalar, or a message of this package.
enum FieldType {
    Scalar(Type),
    Message(&'static str),
}

const DOUBLE: FieldType = FieldType::Scalar(Type::Double);
const UINT64: FieldType = FieldType::Scalar(Type::Uint64);
const BOOL: FieldType = FieldType::Scalar(Type::Bool);
const STRING: FieldType = FieldType::Scalar(Type::String);
const VECTOR3: FieldType = FieldType::Message("Vector3");

/// The descriptor set of all messages, in proto3, so repeated numbers are packed.
pub(super) fn file_descriptor_set() -> Vec<u8> {
    let file = FileDescriptorProto {
        name: Some("stiction.proto".into()),
        package: Some("stiction".into()),
        syntax: Some("proto3".into()),
        message_type: messages(),
        ..Default::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

fn messages() -> Vec<DescriptorProto> {
    vec![
        message("Vector3", [one(1, "x", DOUBLE), one(2, "y", DOUBLE), one(3, "z", DOUBLE)]),
        message("Quaternion", [one(1, "w", DOUBLE), one(2, "x", DOUBLE), one(3, "y", DOUBLE), one(4, "z", DOUBLE)]),
        message("Force", [one(1, "point", VECTOR3), one(2, "force", VECTOR3)]),
        message("Point", [one(1, "name", STRING), one(2, "position", VECTOR3)]),
        message(
            "State",
            [
                one(1, "time", DOUBLE),
                one(2, "base_position", VECTOR3),
                one(3, "base_orientation", FieldType::Message("Quaternion")),
                one(4, "base_linear_velocity", VECTOR3),
                one(5, "base_angular_velocity", VECTOR3),
                many(6, "q", DOUBLE),
                many(7, "qd", DOUBLE),
                many(8, "q_desired", DOUBLE),
                many(9, "qd_desired", DOUBLE),
                many(10, "effort", DOUBLE),
                one(11, "com", VECTOR3),
                one(12, "com_velocity", VECTOR3),
                one(13, "cop", VECTOR3),
                many(14, "support_polygon", VECTOR3),
                many(15, "external", FieldType::Message("Force")),
                one(16, "stable_point", VECTOR3),
                many(17, "effort_desired", DOUBLE),
                many(18, "points", FieldType::Message("Point")),
            ],
        ),
        message("Objects", [one(1, "time", DOUBLE), many(2, "poses", DOUBLE)]),
        message(
            "Loops",
            [
                one(1, "time", DOUBLE),
                many(2, "forces", VECTOR3),
                many(3, "moments", VECTOR3),
                many(4, "errors", DOUBLE),
                many(5, "coupling_efforts", DOUBLE),
                many(6, "coupling_errors", DOUBLE),
            ],
        ),
        message(
            "Sole",
            [
                one(1, "name", STRING),
                one(2, "state", STRING),
                many(3, "clamped", BOOL),
                many(4, "positions", VECTOR3),
                many(5, "velocities", VECTOR3),
                many(6, "forces", VECTOR3),
                one(7, "force", VECTOR3),
            ],
        ),
        message(
            "Contact",
            [
                one(1, "time", DOUBLE),
                many(2, "soles", FieldType::Message("Sole")),
                many(3, "links", FieldType::Message("Sole")),
            ],
        ),
        message(
            "Residual",
            [
                one(1, "time", DOUBLE),
                one(2, "penetration", DOUBLE),
                one(3, "tension", DOUBLE),
                one(4, "signorini", DOUBLE),
                one(5, "cone_excess", DOUBLE),
                one(6, "dissipation_gap", DOUBLE),
                one(7, "creep_speed", DOUBLE),
                one(8, "resultant_gap", DOUBLE),
                one(9, "energy_change", DOUBLE),
                one(10, "actuator_work", DOUBLE),
                one(11, "external_work", DOUBLE),
                one(12, "joint_loss", DOUBLE),
                one(13, "friction_loss", DOUBLE),
                one(14, "impact_loss", DOUBLE),
                one(15, "energy_error", DOUBLE),
            ],
        ),
        message("Wrench", [one(1, "force", VECTOR3), one(2, "moment", VECTOR3)]),
        message(
            "Estimate",
            [
                one(1, "time", DOUBLE),
                one(2, "tick", DOUBLE),
                one(3, "base_position", VECTOR3),
                one(4, "base_orientation", FieldType::Message("Quaternion")),
                one(5, "base_linear_velocity", VECTOR3),
                one(6, "base_angular_velocity", VECTOR3),
                many(7, "q", DOUBLE),
                many(8, "qd", DOUBLE),
                many(9, "load", DOUBLE),
                one(10, "orientation", FieldType::Message("Quaternion")),
                one(11, "angular_velocity", VECTOR3),
                one(12, "specific_force", VECTOR3),
                many(13, "soles", FieldType::Message("Wrench")),
                many(14, "static_soles", BOOL),
            ],
        ),
        message(
            "SelfCollision",
            [
                one(1, "time", DOUBLE),
                one(2, "distance", DOUBLE),
                one(3, "first", STRING),
                one(4, "second", STRING),
                one(5, "on_first", VECTOR3),
                one(6, "on_second", VECTOR3),
                one(7, "cycles", UINT64),
                one(8, "tests", UINT64),
                many(9, "frozen", BOOL),
                many(10, "wanted", DOUBLE),
            ],
        ),
        message(
            "Event",
            [one(1, "time", DOUBLE), one(2, "kind", STRING), one(3, "subject", STRING), one(4, "message", STRING)],
        ),
    ]
}

fn message<const N: usize>(name: &str, fields: [FieldDescriptorProto; N]) -> DescriptorProto {
    DescriptorProto { name: Some(name.into()), field: fields.into(), ..Default::default() }
}

fn one(number: i32, name: &str, of: FieldType) -> FieldDescriptorProto {
    field(number, name, of, Label::Optional)
}

fn many(number: i32, name: &str, of: FieldType) -> FieldDescriptorProto {
    field(number, name, of, Label::Repeated)
}

fn field(number: i32, name: &str, of: FieldType, label: Label) -> FieldDescriptorProto {
    let (kind, type_name) = match of {
        FieldType::Scalar(kind) => (kind, None),
        FieldType::Message(name) => (Type::Message, Some(format!(".stiction.{name}"))),
    };
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(label.into()),
        r#type: Some(kind.into()),
        type_name,
        ..Default::default()
    }
}
