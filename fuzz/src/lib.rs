//! Entry points of the fuzz targets. Each processes its bytes like a user's file of that kind, up
//! to the start of a run. An error is a valid result; a panic, a hang or unbounded memory is a
//! finding.
//!
//! `tests/regressions` runs the same functions on previous findings.

#![forbid(unsafe_code)]

pub mod console;
pub mod filter;
pub mod fit;
pub mod http;
pub mod live;
pub mod log;
pub mod mesh;
pub mod mjcf;
pub mod motion;
pub mod results;
pub mod robot_file;
pub mod samples;
pub mod scenario;
pub mod scratch;
pub mod script;
pub mod sdf;
pub mod terrain;
pub mod tree;
pub mod urdf;
pub mod wire;
pub mod world;
