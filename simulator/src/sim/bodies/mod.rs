//! Bodies that touch each other: convex shapes on links, objects, terrain and the floor, and the patches
//! in which pairs of them touch.
//!
//! | module | content |
//! |---|---|
//! | [`body`] | a convex shape, its mechanism and its friction |
//! | [`pair_patch`] | the patch of a body with others in one plane, as a polygon of the contact problem |
//! | [`pairs`] | pairs that may touch, and their friction |
//!
//! The geometry is that of [`crate::patches`]. Soles and links of the robot touch the floor without it:
//! [`super::floor`].
//!
//! Imports patches and dynamics. Called by plant, contact_states and setup.

pub mod body;
pub mod pair_patch;
pub mod pair_rules;
pub mod pairs;

pub use body::{Body, FLOOR, FloorFriction, Friction, Host};
pub use pair_patch::{PairPatch, Part};
pub use pair_rules::{PairRule, PairRules};
pub use pairs::{Pair, PairFriction};
