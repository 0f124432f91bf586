//! Joint efforts: drives with their limits and lag, motors that drive several joints, passive friction, end
//! stops, paths of kinematic joints.
//!
//! Everything here is a function of model, joint state and command; see `docs/actuation.md`.
//!
//! Imports robot, dynamics (the state) and task (the command). Called by `plant` and, for the
//! desired efforts of a snapshot, by `measure`.

pub mod coupled_motors;
pub mod drives;
pub mod effort_limits;
pub mod effort_slopes;
pub mod joint_efforts;
pub mod kinematic_paths;
pub mod lag;

pub use drives::Drives;
