//! Scenario runner for legged-robot contact.
//!
//! Data flows one way: `scenario` files name a `robot`; `sim` couples `dynamics`, `contact`, `integrate`, `force` and
//! `task` into one run; `record` keeps what it tells; `batch` drives many runs; `cli` only translates.

pub mod dynamics;
pub mod robot;
pub mod sim;
