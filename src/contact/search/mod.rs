//! Search for a valid contact state: candidates, their validity, best-first order.

pub mod candidate;
pub mod judge;
pub mod regularized_modes;
pub mod select;
pub mod sliding_directions;
