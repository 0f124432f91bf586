//! The simulator of `stiction`: dynamics, contact with exact Coulomb friction, tasks and force models.
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
pub mod motion;
pub mod patches;
pub mod sim;
pub mod task;
pub mod terrain;

// The modules of numerics and models, under the same paths.
use stiction_models::{input, metrics, robot, text};
use stiction_numerics::{geometry, integrate, linalg, math, random};
