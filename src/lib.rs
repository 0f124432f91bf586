//! Scenario runner for legged-robot contact.
//!
//! Data flows one way: `scenario` files name a `robot`; `assemble` joins the two; `sim` couples `dynamics`, `contact`,
//! `integrate`, `force` and `task` into one run; `log` and `results` write its files; `batch` drives many runs; the
//! program's `cli` only translates.

pub mod assemble;
pub mod batch;
pub mod collision;
pub mod console;
pub mod contact;
pub mod dynamics;
pub mod export;
pub mod files;
pub mod force;
pub mod geometry;
pub mod integrate;
pub mod linalg;
#[cfg(feature = "live")]
pub mod live;
pub mod log;
pub mod motion;
pub mod random;
pub mod remote;
pub mod replay;
pub mod report;
pub mod results;
pub mod robot;
pub mod scenario;
pub mod schema_page;
pub mod script;
pub mod sim;
pub mod submit;
pub mod task;
pub mod text;
pub mod view;
