//! One run: state, coupling of the physics rooms, outcome.

pub mod report;

pub use report::*;
