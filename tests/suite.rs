//! The only integration test binary. Each folder is a module that tests one part or one property.

// Expected values may come from the system's library: they have tolerances.
#![allow(clippy::disallowed_methods, clippy::disallowed_types)]

mod actuation;
mod analytic;
mod batch;
mod claims;
mod cli;
mod collision;
mod console;
mod contact;
mod determinism;
mod faults;
mod fit;
mod force;
mod force_balance;
mod history;
mod identities;
mod library;
mod link;
mod motion;
mod oracles;
mod policy;
mod record;
mod regressions;
mod replay;
mod robot;
mod scenario;
mod script;
mod search;
mod structure;
#[cfg(unix)]
mod submit;
mod support;
mod task;
mod validation;
mod view;
