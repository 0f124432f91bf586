//! `[search]`: reads the search of a file, and gives its values and the order of its cells.
//!
//! - `read`: decodes and checks the search against the sweep.
//! - `planned`: cells, their neighbours, and the values at which they are run.

mod planned;
mod read;

pub use planned::{FollowedCell, PlannedSearch, SearchAxis};
pub(super) use read::read;
