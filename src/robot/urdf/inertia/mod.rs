//! Inertia of links: checks of plausibility, repair, and joints without inertia. Called by the
//! construction of the moving tree.

mod movable;
mod plausible;
mod repair;

pub(super) use movable::without_inertia;
pub(super) use plausible::{FlawedPart, check_inertias, link_inertia};
