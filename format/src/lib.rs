//! The scenario format of `stiction`: loading, checks, sweeps, searches, claims, schema.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod scenario;
pub mod search;
pub mod statistics;

// The modules of the crates below, under the same paths.
use stiction_models::{input, metrics, robot, sdf, text};
use stiction_numerics::{geometry, math, random};
use stiction_simulator::contact;
