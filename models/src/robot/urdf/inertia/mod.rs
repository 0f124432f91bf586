//! Inertia of links: checks of plausibility and repair. Called by the construction of the moving
//! tree.

mod plausible;

pub(super) use plausible::{FlawedPart, check_inertias, link_inertia};
