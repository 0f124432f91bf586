//! Running a run again from its record, and holding what comes of it against what it left, bit for bit.
//!
//! ```text
//! run.json -> resolved scenario -> one run, its files anew -> another run.json and log.mcap -> differences
//! ```
//!
//! A record holds the scenario with every value written out, and the hashes of the files it was made of, not the files: they
//! are read where they were then, and what changed since is told.

mod again;
mod changed;
mod difference;
mod error;
mod find;
mod log;
mod record;

pub use again::{Again, Prepared, prepare};
pub use changed::Change;
pub use difference::{Difference, compare};
pub use error::ReplayError;
pub use find::{Left, find};
