//! Simulations of `stiction` from scenarios: scripts and networks, assembly, logs.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod assemble;
pub mod convert;
pub mod files;
pub mod log;
pub mod policy;
pub mod script;

// The modules of the crates below, under the same paths.
use stiction_format::scenario;
use stiction_models::{input, mesh, robot, text};
use stiction_numerics::{geometry, integrate, math, random};
use stiction_simulator::{collision, contact, dynamics, force, motion, patches, sim, task, terrain};
