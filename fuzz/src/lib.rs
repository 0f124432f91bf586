//! What the fuzz targets do with their bytes: each takes them along the way that a user's file of that kind goes, up to where
//! a run would begin. An error is an answer; a panic, a hang or a heap without end is a finding.
//!
//! The library's own tests run the same functions on what was found (`tests/regressions`).

pub mod mesh;
pub mod motion;
pub mod robot_file;
pub mod scenario;
pub mod script;
pub mod tree;
pub mod urdf;
pub mod wire;
