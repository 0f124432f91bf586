//! Loads robot files, URDFs, MJCF files and SDFormat models to an immutable [`Model`].
//!
//! `load` reads a robot file (TOML), a URDF, an MJCF file or an SDF, performs all checks that need no
//! simulation, and keeps the bytes of the files it used. Ignored elements, assumptions and detected soles are
//! reported as notes and warnings, and a robot that cannot be simulated as a [`RobotError`] with
//! its position. [`adjustments`] changes a loaded model as scenarios require.
//!
//! `assemble` and `batch` load robots; all rooms of the simulation read [`Model`]. The vertices of
//! soles come from shapes (`sole_detection`), from `[[sole]]` of the robot file, or from the
//! scenario.
//!
//! Imports: `math`, `text`, `geometry`, `input`, `mesh`, `sdf`. Used by: `dynamics`, `task`,
//! `force`, `sim`, `scenario`, `convert`, `script`, `policy`, `log`, `assemble`, `remote`, `batch`,
//! `api`, `cli`, `console`, `collision`, `fit`.

pub mod adjustments;
mod apply_robot_file;
mod closure;
mod coupled_joints;
mod friction;
mod inertia_repair;
mod inspect;
mod inspect_json;
mod joint_names;
mod link_poses;
mod load;
mod loop_entries;
mod mass_matrix;
mod mesh_simplification;
mod mesh_store;
mod mjcf;
pub mod model;
mod movable_links;
mod moving_links;
mod notices;
mod payload;
mod rigid_inertia;
mod robot_error;
mod robot_file;
mod sdf;
mod self_collision;
mod sole_detection;
mod transmission;
mod transmission_entries;
mod urdf;
mod xml_syntax;

pub use closure::{Coupling, LoopClosure, LoopKind};
pub use friction::JointFrictionLaw;
pub use inspect::inspect;
pub use inspect_json::inspect_json;
pub use link_poses::link_poses;
pub use load::{Robot, load, load_with, parse};
pub use mjcf::{is_mjcf_name, read_world as read_mjcf_world};
pub use model::*;
pub use movable_links::link_held_by_armature;
pub use moving_links::NO_LIMIT;
pub use payload::add_box;
pub use rigid_inertia::RigidInertia;
pub use robot_error::{FileError, RobotError};
pub use robot_file::schema;
pub use self_collision::SelfCollision;
pub use transmission::Transmission;
pub use urdf::InertiaPolicy;
