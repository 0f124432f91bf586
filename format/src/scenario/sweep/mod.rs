//! `[sweep]`: the dimensions of a sweep, their values, and the combination of values of each run.
//!
//! - `dimensions`: which keys advance together; `axis`: the values of one key; `random`: samples of
//!   distributions.
//! - `grid`: the combinations, by number.
//!
//! Called by the expansion of a scenario file.

mod axis;
mod dimensions;
mod grid;
mod random;

pub(super) use axis::decimal;
pub use grid::MAX_BATCH_RUNS;
pub(super) use grid::{Cell, Dimension, Grid, Key};
