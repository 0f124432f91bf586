//! Tests of the command line: every test runs the real binary on real files.

mod bag;
mod bounds;
mod broken;
mod changes;
mod colour;
mod commands;
mod comparison;
mod convert;
mod exit_codes;
mod export;
mod filter;
mod inertia;
mod interrupt;
mod isolation;
mod junit;
mod many;
mod messages;
mod names;
pub mod object_models;
mod pages;
mod repetitions;
mod replaced;
mod report;
mod results;
mod schemas;
mod screen;
mod shells;
mod snapshots;
mod unwritten;

pub use crate::support::place::{Done, Place, Table};
