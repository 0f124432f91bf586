//! Arguments that several commands share, and their values.

pub mod link;
pub mod live;
pub mod message_format;
pub mod numbers;
mod override_files;
pub mod run_options;
pub mod scenario_files;
pub mod selection;
