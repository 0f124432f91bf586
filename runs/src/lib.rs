//! Runs of `stiction`: scripts and networks, assembly of simulations, logs, records, tables, reports,
//! links to other processes, and batches.
//!
//! The package `stiction` exports what programs need; use it through that package. The modules here
//! belong to it and may change at any time.

#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Unit tests compare with the functions of `f64`, which `clippy.toml` forbids elsewhere.
#![cfg_attr(test, allow(clippy::disallowed_methods, clippy::disallowed_types))]

pub mod assemble;
pub mod batch;
pub mod convert;
pub mod export;
pub mod files;
pub mod live;
pub mod log;
pub mod policy;
pub mod remote;
pub mod report;
pub mod results;
pub mod script;
pub mod web;

// The modules of the crates below, under the same paths.
use stiction_format::{scenario, search, statistics};
use stiction_models::{input, mesh, metrics, robot, text};
use stiction_numerics::{geometry, integrate, math, random};
use stiction_simulator::{collision, contact, dynamics, force, motion, patches, sim, task, terrain};
