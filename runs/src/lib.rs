//! Runs of `stiction`: batches, records, tables, tasks in another process.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod batch;
pub mod remote;
pub mod results;

// The modules of the crates below, under the same paths.
use stiction_assembly::{assemble, convert, files, log, script};
use stiction_format::{scenario, search, statistics};
use stiction_models::{input, metrics, robot, text};
use stiction_numerics::{geometry, math, random};
use stiction_simulator::{contact, dynamics, sim, task, terrain};
