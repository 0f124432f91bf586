//! The types of the scenario format, one file per section, each field with its unit and default.
//!
//! Doc comments of these types are the descriptions of the JSON Schema and of the reference page.

pub mod change;
pub mod claim;
pub mod compare;
pub mod contact;
pub mod contact_pair;
pub mod control;
mod defaults;
pub mod event;
pub mod expect;
pub mod floor;
pub mod force;
pub mod object;
pub mod random;
pub mod robot;
pub mod run;
pub mod search;
pub mod self_collision;
pub mod sensors;
pub mod sweep;
pub mod tagged;
pub mod task;
pub mod terrain;
pub mod world;
