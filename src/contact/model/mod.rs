//! The contact problem, and what its solutions must satisfy.
//!
//! [`problem`] has the equation, [`state`] the contact states of a sole, [`solution`] the unknowns.
//! The optimality conditions are those of [`friction_capacity`] (friction cone of a vertex, edge or
//! face), [`sole_group`] (several soles on one body) and [`pressure`] (least-norm load sharing).
//! [`residual`] evaluates the contact laws for any solution, whichever method gave it.
//!
//! Imports no other room. `search`, `methods` and `sim` build on it.

pub mod friction_capacity;
pub mod pressure;
pub mod problem;
pub mod residual;
pub mod sole_group;
pub mod solution;
pub mod state;
