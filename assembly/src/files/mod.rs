//! Writing files safely: writes that appear whole or not at all, paths that stay inside a folder of
//! results, checksums.
//!
//! Imports: nothing of this crate. Used by: `policy`, `log`, `results`, `batch`, `merge`,
//! `compare`, `report`, `export`, `replay`, `view`, `cli`, `console`, `submit`, `fit`, `history`.

pub mod atomic;
pub mod checksum;
pub mod confined;
pub mod durability;
pub mod json;
mod key_levels;
mod lock;
pub mod names;
mod panic_capture;
mod record_error;

pub use atomic::{OutputKind, SESSION, check_replaceable, if_present, is_abandoned, modified};
pub use atomic::{remove_partial, write_named};
pub use durability::make_durable;
pub use key_levels::{KeyLevels, run_folders};
pub use lock::FileLock;
pub use panic_capture::catch_panic;
pub use record_error::RecordError;
