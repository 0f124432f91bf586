//! Scenario runner for legged-robot contact.
//!
//! Data flows one way: `scenario` files name a `robot`; `sim` couples `dynamics`, `contact`, `integrate`, `force` and
//! `task` into one run; `record` keeps what it tells; `batch` drives many runs; `cli` only translates.

pub mod batch;
pub mod collision;
pub mod contact;
pub mod dynamics;
mod excerpt;
pub mod force;
pub mod geometry;
mod input_file;
pub mod integrate;
pub mod link;
pub mod motion;
mod pattern;
pub mod random;
pub mod record;
pub mod replay;
pub mod robot;
pub mod scenario;
pub mod schema_page;
pub mod script;
pub mod sim;
pub mod submit;
pub mod task;
mod toml_words;
pub mod view;
pub mod visible;
