//! Contact laws at instants: located events, impacts, Painleve's paradox, projection of drift.
//!
//! Between events a contact state holds and its equations are smooth. Here is what happens where one state ends: event
//! functions, which event location takes to zero; the impact law; sliding without a finite force (a jam); and the projection
//! that keeps clamped vertices in place. All are functions of one reduced contact problem
//! ([`crate::contact::model::problem`]); applying their impulses to a robot is `sim`'s.

pub(crate) mod copositivity;
pub(crate) mod events;
pub(crate) mod impact;
pub(crate) mod painleve;
pub(crate) mod projection;
