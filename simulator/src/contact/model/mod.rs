//! The contact problem and the conditions on its solutions.
//!
//! [`problem`] has the equation, [`state`] the contact states of a sole, [`solution`] the unknowns.
//! The optimality conditions are those of [`friction_capacity`] (friction cone of a vertex, edge or
//! face), [`sole_group`] (several soles on one body) and [`pressure`] (least-norm load sharing).
//! [`turning`] has the torsional and rolling friction of point contacts.
//! [`residual`] evaluates the contact laws for the solution of any method. [`per_sole`] holds a
//! value of each sole.
//!
//! Imports no other module of contact. `search`, `methods` and `sim` build on it.

pub mod friction_capacity;
pub mod per_sole;
pub mod pressure;
pub mod problem;
pub mod residual;
pub mod sole_group;
pub mod solution;
pub mod state;
pub mod turning;
