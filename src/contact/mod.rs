//! Contact between soles and a plane floor, with Coulomb friction.
//!
//! Everything here speaks of one reduced problem ([`problem`]): motions of the sole frames that answer sole wrenches
//! through a small matrix W. [`candidate`] solves one contact state, [`implicit`] finds sliding directions that are not
//! known beforehand, [`judge`] says what is wrong with the result, [`select`] searches the states. On these stand the methods behind [`method::Method`]: [`exact`] and
//! [`one_step`]. [`lcp`] and [`ncp`] step in time, point by point ([`points`]); [`penalty`] has springs and no states. [`residual`] judges any of them from outside; [`frozen`] writes a selection down.

pub mod hybrid;
pub mod methods;
pub mod model;
pub mod search;
pub mod selection_record;
