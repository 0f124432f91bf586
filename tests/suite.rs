//! The one integration test program; each folder is a kind of truth.

mod actuation;
mod analytic;
mod cli;
mod contact;
mod determinism;
mod force;
mod identities;
mod oracles;
mod record;
mod robot;
mod scenario;
mod task;
mod validation;
