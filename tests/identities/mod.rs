//! Identities that hold for every robot and state, checked on seeded random trees.

pub mod allocations;
mod chain;
mod closed_forms;
mod conservation;
mod contact_reduction;
mod context;
mod equation_of_motion;
mod jacobians;
mod numeric;
pub mod random_tree;
mod stable_point;
mod stepping;
mod stepping_all;
mod transmissions;
