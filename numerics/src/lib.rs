//! Numerics of `stiction`: elementary functions with the same bits on every processor, linear algebra,
//! plane geometry, integration, random numbers.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod geometry;
pub mod integrate;
pub mod linalg;
pub mod math;
pub mod random;
