//! Writing files safely: writes that appear whole or not at all, paths that stay inside a folder of
//! results, checksums.
//!
//! Imports: no other room. Used by: `policy`, `log`, `results`, `report`, `export`,
//! `batch`, `replay`, `view`, `cli`, `console`, `submit`, `fit`.

pub mod atomic;
pub(crate) mod checksum;
pub mod confined;
pub(crate) mod durability;
pub(crate) mod json;
mod key_levels;
mod lock;
pub mod names;
mod panic_capture;
mod record_error;

pub use atomic::{OutputKind, check_replaceable, remove_partial};
pub(crate) use atomic::{SESSION, if_present, is_abandoned, modified, write_named};
pub use durability::make_durable;
pub use key_levels::KeyLevels;
pub(crate) use key_levels::run_folders;
pub(crate) use lock::FileLock;
pub(crate) use panic_capture::catch_panic;
pub use record_error::RecordError;
