//! The simulator of `stiction`: robots, dynamics, contact with exact Coulomb friction, integration,
//! tasks and force models.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod collision;
pub mod contact;
pub mod dynamics;
pub mod force;
pub mod geometry;
pub mod input;
pub mod integrate;
pub mod linalg;
pub mod math;
pub mod mesh;
pub mod metrics;
pub mod motion;
pub mod patches;
pub mod random;
pub mod robot;
pub mod sdf;
pub mod sim;
pub mod task;
pub mod terrain;
pub mod text;
