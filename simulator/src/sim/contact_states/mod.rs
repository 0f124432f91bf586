//! Choice of contact states at an instant: links that touch, impacts, imposed states, compliant
//! floors, problem reports.
//!
//! The laws are pure functions of contact problems in [`crate::contact`]. This module applies them
//! to the plant of a run, counts selections, and reports events.
//!
//! Imports plant, measure and contact. Called by the steppers.

mod compliant;
mod drift_projection;
pub mod event_functions;
mod friction;
mod imposed;
pub mod link_contacts;
mod painleve;
pub mod pair_contacts;
mod patch_planes;
mod placements;
mod polygon_changes;
mod problem_report;
mod rest_detection;
mod selection;
mod step_impulse;
pub mod terrain_pairs;
