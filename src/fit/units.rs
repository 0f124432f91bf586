//! Units of scenario keys.

use crate::robot::{JointKind, Model};
use crate::scenario::KeyPath;

/// The unit of the number at a dotted key, of a robot; `1` without a dimension, empty where it is not
/// known.
pub fn unit(key: &str, model: &Model) -> &'static str {
    let path = KeyPath::internal(key);
    let segments: Vec<&str> = path.segments.iter().map(|(segment, _)| segment.as_str()).collect();
    match segments.as_slice() {
        ["robot", "joint", joint, rest @ ..] => {
            let joint = model.joints.iter().find(|known| known.name == *joint);
            joint.map_or("", |joint| joint_unit(rest, joint.kind == JointKind::Prismatic))
        }
        ["robot", "payload", _, "mass"] | ["object", _, "mass"] => "kg",
        ["robot", "payload", _, "position", _] => "m",
        ["robot", "payload", _, "inertia", _] => "kg m^2",
        ["robot", "base", "position", _] => "m",
        ["robot", "base", "rpy", _] => "rad",
        ["robot", "base", "linear_velocity", _] => "m/s",
        ["robot", "base", "angular_velocity", _] => "rad/s",
        ["gravity", _] => "m/s^2",
        ["force", _, "force", _] => "N",
        ["force", _, "moment", _] => "N m",
        ["force", _, "stiffness"] => "N/m",
        ["force", _, "damping" | "linear"] => "N s/m",
        ["force", _, "quadratic"] => "N s^2/m^2",
        ["force", _, "mass"] => "kg",
        ["force", _, "start" | "duration"] => "s",
        ["floor", "height"] => "m",
        ["floor", "rpy", _] => "rad",
        [.., "friction" | "restitution"] | [.., "friction", "static" | "kinetic"] => "1",
        [.., "friction", "viscous"] => "s/m",
        [.., "friction", "torsional" | "rolling"] => "m",
        _ => "",
    }
}

fn joint_unit(rest: &[&str], prismatic: bool) -> &'static str {
    let of = |revolute, linear| if prismatic { linear } else { revolute };
    match rest {
        ["kp"] | ["stop", "stiffness"] => of("N m/rad", "N/m"),
        ["kd"] | ["stop", "damping"] | ["friction", "viscous"] => of("N m s/rad", "N s/m"),
        ["friction", "coulomb" | "static"] | ["effort"] => of("N m", "N"),
        ["friction", "stribeck_velocity" | "slip_velocity"] | ["velocity"] => of("rad/s", "m/s"),
        ["armature"] => of("kg m^2", "kg"),
        ["lag"] => "s",
        _ => "",
    }
}
