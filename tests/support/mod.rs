//! What tests of several parts share.

pub mod counting;
pub mod folder;
pub mod place;
pub mod runs;
pub mod same;
