//! Inertia of links: rigid-body arithmetic, checks that a body can have it, repair, and whether joints can be moved.
//!
//! Called by the construction of the moving tree; [`RigidInertia`] also serves payloads.

mod movable;
mod plausible;
mod repair;
mod rigid_inertia;

pub(super) use movable::without_inertia;
pub(super) use plausible::{FlawedPart, judge, link_inertia};
pub use rigid_inertia::RigidInertia;
pub(in crate::robot) use rigid_inertia::{Flaw, examine, moments_text};
