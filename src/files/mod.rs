//! Reading and writing files safely: bounded reads of regular files, writes that appear whole or not at all, and paths
//! that stay inside a folder of results.
//!
//! Imports nothing of this crate but `text`. Every room that reads or writes files calls it.

pub mod atomic;
pub mod confined;
mod error;
pub mod input;
pub mod names;

pub use atomic::{Made, may_replace};
pub(crate) use atomic::{SESSION, remove_partial, write_named};
pub use error::RecordError;
