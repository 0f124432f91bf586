//! Robots of `stiction`: robot files, URDF, MJCF and SDF to immutable models; diagnostics; the table of
//! metrics.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod input;
pub mod mesh;
pub mod metrics;
pub mod robot;
pub mod sdf;
pub mod text;

// The modules of numerics, under the same paths.
use stiction_numerics::{geometry, math};
