//! `[[object]]`: bodies besides the robot.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::scenario::format::floor::Friction;
use crate::scenario::format::robot::JointLimits;
use crate::scenario::format::tagged::tagged;
use crate::text::quantity::{angles, angular_rates, joint_positions, joint_velocities, json, non_negative, positive};

tagged! {
    /// One body besides the robot.
    ObjectSpec, "object" {
        /// A homogeneous box.
        "box" => Box(BoxObject),
        /// A homogeneous ball.
        "sphere" => Sphere(SphereObject),
        /// A homogeneous cylinder with hemispherical ends.
        "capsule" => Capsule(CapsuleObject),
        /// A homogeneous cylinder with flat ends.
        "cylinder" => Cylinder(CylinderObject),
        /// The homogeneous convex hull of a mesh file.
        "mesh" => Mesh(MeshObject),
        /// A mechanism: a robot file or URDF.
        "model" => Model(ModelObject),
    }
}

/// Declares a type of object: its own keys, and those that all types have.
macro_rules! object {
    ($(#[$doc:meta])* $name:ident { $($fields:tt)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// Name, which no other object has. Left out: `object.N`, N its index from 0.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub name: Option<String>,
            /// Origin of its frame at the start, world, m.
            #[serde(default)]
            pub position: [f64; 3],
            /// Roll, pitch, yaw at the start as in URDF, rad.
            #[serde(default, deserialize_with = "angles")]
            #[schemars(with = "[json::Angle; 3]")]
            pub rpy: [f64; 3],
            /// Velocity of the origin at the start, world axes, m/s.
            #[serde(default)]
            pub linear_velocity: [f64; 3],
            /// Angular velocity at the start, world axes, rad/s.
            #[serde(default, deserialize_with = "angular_rates")]
            #[schemars(with = "[json::AngularRate; 3]")]
            pub angular_velocity: [f64; 3],
            /// Coulomb friction: one number, or static and kinetic. Of two bodies the smaller coefficients
            /// count. Left out: that of what it touches.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub friction: Option<Friction>,
            $($fields)*
        }

        impl $name {
            fn entry(&self) -> ObjectEntry<'_> {
                ObjectEntry {
                    name: self.name.as_deref(),
                    position: self.position,
                    rpy: self.rpy,
                    linear_velocity: self.linear_velocity,
                    angular_velocity: self.angular_velocity,
                    friction: self.friction,
                }
            }
        }
    };
}

object! {
    /// A homogeneous box; its frame is at its centre.
    BoxObject {
        /// Edges along its axes x, y, z, m.
        #[schemars(with = "[json::Positive; 3]")]
        pub size: [f64; 3],
        /// Mass, kg.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub mass: f64,
    }
}

object! {
    /// A homogeneous ball; its frame is at its centre.
    SphereObject {
        /// Radius, m.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub radius: f64,
        /// Mass, kg.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub mass: f64,
    }
}

object! {
    /// A homogeneous cylinder with hemispherical ends, along its axis z; its frame is at its centre.
    CapsuleObject {
        /// Radius, m.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub radius: f64,
        /// Length of the cylindrical part, m.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub length: f64,
        /// Mass, kg.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub mass: f64,
    }
}

object! {
    /// A homogeneous cylinder with flat ends, along its axis z; its frame is at its centre.
    CylinderObject {
        /// Radius, m.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub radius: f64,
        /// Length from end to end, m.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub length: f64,
        /// Mass, kg.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub mass: f64,
    }
}

object! {
    /// The homogeneous convex hull of a mesh; its frame is that of the file.
    MeshObject {
        /// Mesh: `.stl`, `.obj` or `.dae`.
        pub file: String,
        /// Metres to a unit of the file.
        #[serde(default = "defaults::one", deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub scale: f64,
        /// Mass, kg.
        #[serde(deserialize_with = "positive")]
        #[schemars(with = "json::Positive")]
        pub mass: f64,
    }
}

object! {
    /// A mechanism, free or fixed to the world as its file says; its frame is that of its root link.
    ModelObject {
        /// Path of a robot file (`.toml`), a URDF, MJCF file or SDF, relative to the scenario file.
        pub model: String,
        /// Name of a key of the MJCF file (`<keyframe>`) whose posture is that of the start; joints of `posture`
        /// are as given there.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub keyframe: Option<String>,
        /// Initial joint positions by joint name, rad or m; joints left out start at the model's home.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "joint_positions")]
        #[schemars(with = "BTreeMap<String, json::Angle>")]
        pub posture: BTreeMap<String, f64>,
        /// Initial joint velocities by joint name, rad/s or m/s; joints left out start at rest.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "joint_velocities")]
        #[schemars(with = "BTreeMap<String, json::AngularRate>")]
        pub velocity: BTreeMap<String, f64>,
        /// Servos that hold joints, of which the last one that names a joint counts. Other joints have the
        /// drives of the robot file, or none.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub servo: Vec<ServoSpec>,
        /// Positions that servos hold, by joint name, rad or m; joints left out are held at their initial
        /// positions.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "joint_positions")]
        #[schemars(with = "BTreeMap<String, json::Angle>")]
        pub target: BTreeMap<String, f64>,
        /// Behaviour at a joint's position limits.
        #[serde(default)]
        pub joint_limits: JointLimits,
    }
}

/// A spring and damper that holds joints of an object, within the effort limits of its model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServoSpec {
    /// Name of a joint, or a pattern in which `*` stands for any characters and `?` for one. Left out: all
    /// joints.
    #[serde(default = "any")]
    pub joints: String,
    /// Stiffness, N m/rad or N/m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub stiffness: f64,
    /// Damping, N m s/rad or N s/m.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub damping: f64,
}

fn any() -> String {
    "*".into()
}

/// Keys that all types have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectEntry<'a> {
    /// Given name.
    pub name: Option<&'a str>,
    /// Position, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rpy: [f64; 3],
    /// Velocity of the origin, m/s.
    pub linear_velocity: [f64; 3],
    /// Angular velocity, rad/s.
    pub angular_velocity: [f64; 3],
    /// Own friction.
    pub friction: Option<Friction>,
}

impl ObjectSpec {
    /// The keys that all types have.
    pub fn entry(&self) -> ObjectEntry<'_> {
        match self {
            ObjectSpec::Box(spec) => spec.entry(),
            ObjectSpec::Sphere(spec) => spec.entry(),
            ObjectSpec::Capsule(spec) => spec.entry(),
            ObjectSpec::Cylinder(spec) => spec.entry(),
            ObjectSpec::Mesh(spec) => spec.entry(),
            ObjectSpec::Model(spec) => spec.entry(),
        }
    }

    /// The name of the entry with this index.
    pub fn name(&self, index: usize) -> String {
        self.entry().name.map_or_else(|| format!("object.{index}"), str::to_owned)
    }

    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            ObjectSpec::Mesh(mesh) => Some(&mesh.file),
            _ => None,
        }
    }

    /// The robot file or URDF that the key `model` names, if the type has that key.
    pub fn model(&self) -> Option<&str> {
        match self {
            ObjectSpec::Model(model) => Some(&model.model),
            _ => None,
        }
    }
}
