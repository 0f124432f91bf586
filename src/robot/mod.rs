//! Robot files and URDFs in, an immutable [`Model`] out.
//!
//! `load` reads a robot file (TOML) or a URDF, checks all that can be checked without simulating, and keeps the bytes of
//! the files it used. It reports what it ignored, assumed or found as notes and warnings, and what cannot be simulated as a
//! [`RobotError`] with its position. [`adjustments`] changes a loaded model as scenarios require.
//!
//! Imports `text`, `files` and `geometry`. `assemble` and `batch` load robots; all rooms of the simulation read [`Model`].

pub mod adjustments;
mod apply_robot_file;
mod error;
mod friction;
mod inspect;
mod link_poses;
mod load;
mod mesh_simplification;
pub mod model;
mod notices;
mod payload;
mod robot_file;
mod self_collision;
mod sole_detection;
mod urdf;

pub use error::{FileError, RobotError};
pub use friction::Friction;
pub use inspect::inspect;
pub use load::{Robot, load, load_with, parse};
pub use model::*;
pub use payload::add_box;
pub use robot_file::schema;
pub use self_collision::SelfCollision;
pub use urdf::{InertiaPolicy, RigidInertia};
