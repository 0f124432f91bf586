//! Loads robot files and URDFs to an immutable [`Model`].
//!
//! `load` reads a robot file (TOML) or a URDF, performs all checks that need no simulation, and
//! keeps the bytes of the files it used. Ignored elements, assumptions and detected soles are
//! reported as notes and warnings, and a robot that cannot be simulated as a [`RobotError`] with
//! its position. [`adjustments`] changes a loaded model as scenarios require.
//!
//! `assemble` and `batch` load robots; all rooms of the simulation read [`Model`]. The vertices of
//! soles come from shapes (`sole_detection`), from `[[sole]]` of the robot file, or from the
//! scenario.
//!
//! Imports: `math`, `text`, `geometry`, `files`, `mesh`. Used by: `dynamics`, `collision`, `task`, `force`,
//! `script`, `sim`, `log`, `assemble`, `remote`, `batch`, `console`, `api`, `cli`.

pub mod adjustments;
mod apply_robot_file;
mod closure;
mod coupled_joints;
mod friction;
mod inspect;
mod link_poses;
mod load;
mod loop_entries;
mod mesh_simplification;
pub mod model;
mod notices;
mod payload;
mod rigid_inertia;
mod robot_error;
mod robot_file;
mod self_collision;
mod sole_detection;
mod urdf;

pub use closure::{Coupling, LoopClosure, LoopKind};
pub use friction::JointFrictionLaw;
pub use inspect::inspect;
pub use load::{Robot, load, load_with, parse};
pub use model::*;
pub use payload::add_box;
pub use rigid_inertia::RigidInertia;
pub use robot_error::{FileError, RobotError};
pub use robot_file::schema;
pub use self_collision::SelfCollision;
pub use urdf::InertiaPolicy;
