//! Contact methods, which find states and forces.
//!
//! | file | method |
//! |---|---|
//! | [`exact`] | searches for states that satisfy Signorini and Coulomb exactly |
//! | [`one_step`] (with [`decision`]) | decides once per step, without trial states |
//! | [`penalty`] | springs and dampers, regularised friction |
//! | [`lcp`], [`ncp`] (on [`points`]) | time stepping on a polyhedral and on the round friction cone |
//!
//! [`islands`] splits a problem into those that do not act on each other.
//!
//! All implement the traits of [`contact_method`] and are listed in [`registry`]. Methods use
//! `contact::model`, `contact::search` and `linalg`. `sim` calls them through the traits; scenarios
//! and reports read the registry.

pub mod contact_method;
pub mod decision;
pub mod exact;
pub mod islands;
pub mod lcp;
pub mod ncp;
pub mod one_step;
pub mod penalty;
pub mod points;
pub mod registry;
mod turning_decision;
