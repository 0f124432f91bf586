//! Contact laws of the hybrid system: events, impacts, Painleve's paradox, projection of drift.
//!
//! Between events a contact state holds and its equations are smooth. For the end of a state:
//!
//! - `events`: event functions, whose zeros event location finds,
//! - `impact`: the velocity jump,
//! - `painleve`: the end of sliding without a finite force (a *jam*), by the test of
//!   `copositivity`.
//!
//! `projection` removes drift of clamped vertices.
//!
//! All are functions of one reduced contact problem ([`crate::contact::model::problem`]) and import
//! `model`, `search` and `methods`. `sim` applies their impulses to the robot.

pub(crate) mod copositivity;
pub(crate) mod events;
pub(crate) mod impact;
pub(crate) mod painleve;
pub(crate) mod projection;
