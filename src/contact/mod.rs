//! Contact between soles and a plane floor, with Coulomb friction.
//!
//! Everything here speaks of one reduced problem ([`problem`]): motions of the sole frames that answer sole wrenches
//! through a small matrix W. [`candidate`] solves one contact state, [`implicit`] finds sliding directions that are not
//! known beforehand, [`judge`] says what is wrong with the result, [`select`] searches the states.

pub mod candidate;
pub mod capacity;
pub mod implicit;
pub mod judge;
pub mod linear;
pub mod pressure;
pub mod problem;
pub mod select;
pub mod state;
