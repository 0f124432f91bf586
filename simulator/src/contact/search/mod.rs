//! Search for a valid contact state.
//!
//! [`candidate`] solves the problem for one state of all soles, [`load_split`] chooses among the
//! solutions of an indeterminate one. [`sliding_directions`] finds the
//! directions of friction where no velocity gives them, from [`slips`] and with the static soles
//! [`condensed`]; [`regularized_modes`] finds which vertices stick and which slip. [`point_forces`]
//! solves the problem with every vertex as a point.
//! [`judge`] measures violations and margins, [`moves`] suggests neighbours, [`neighbour_screen`]
//! excludes those of a valid state, [`select`] runs the best-first search.
//!
//! Imports `contact::model` and `linalg`. Called by the methods `exact` and `one-step`. `sim` and
//! the tests of residuals read margins of [`judge`].

pub mod candidate;
pub mod condensed;
pub mod judge;
pub mod load_split;
pub mod moves;
pub mod neighbour_screen;
pub mod point_forces;
pub mod regularized_modes;
pub mod select;
pub mod sliding_directions;
pub mod slips;
pub mod static_loads;
mod turning_modes;

/// Number of soles and links above which smaller systems pay: the static soles condensed, points by themselves.
const MANY: usize = 4;
