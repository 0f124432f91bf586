//! Contact between soles and a plane floor, with exact Coulomb friction.
//!
//! Every method solves one reduced problem, `m = b + W w`: motions m of the sole frames for sole
//! wrenches w. A solution satisfies Signorini's complementarity (no penetration, no tension, no
//! force across a gap) and Coulomb's friction cone at every vertex, or reports its violations.
//!
//! | module | content |
//! |---|---|
//! | [`model`] | problem, states, solution, friction capacity, pressure rule, residuals; imports no other module of contact |
//! | [`search`] | candidate solve, sliding directions, judge, best-first selection; imports `model` |
//! | [`methods`] | `exact`, `one-step`, `penalty`, `lcp`, `ncp` behind one trait; imports `model`, `search` |
//! | [`hybrid`] | laws at events: event functions, impact law, Painleve's jam, copositivity, drift projection; imports `model`, `search`, `methods` |
//! | [`selection_record`] | problems as JSON, to repeat their selection; imports `model`, `search`, `methods` |
//!
//! Independent of robots, scenarios and time integration. `sim` assembles the problems and applies
//! the solutions. Rules and their proofs: `docs/contact.md`.
//!
//! Imports: `math`, `text`, `linalg`. Used by: `task`, `scenario`, `sim`, `log`, `assemble`,
//! `results`, `report`, `batch`.

pub mod hybrid;
pub mod methods;
pub mod model;
pub mod search;
pub mod selection_record;
