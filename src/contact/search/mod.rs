//! Search for a valid contact state: candidates, their validity, best-first order.

pub mod candidate;
pub mod implicit;
pub mod judge;
pub mod select;
pub mod settle;
