//! One file per command of `runner`.

pub mod check;
pub mod compare;
pub mod completions;
pub mod console;
pub mod convert;
pub mod export;
pub mod fit;
pub mod inspect;
pub mod list;
pub mod man;
pub mod merge;
pub mod motor_server;
pub mod replay;
pub mod report;
pub mod run;
pub mod salvage;
pub mod schema;
pub mod submit;
pub mod view;
