//! The types of a scenario, one file per part, every field with its unit and default.

pub mod change;
pub mod compare;
pub mod contact;
pub mod control;
pub mod event;
pub mod expect;
pub mod floor;
pub mod force;
pub mod quantity;
pub mod random;
pub mod robot;
pub mod run;
pub mod self_collision;
pub mod sensors;
pub mod sweep;
pub mod tagged;
pub mod task;
