//! The one integration test program; each folder is a kind of truth.

mod analytic;
mod cli;
mod contact;
mod determinism;
mod identities;
mod motion;
mod oracles;
mod record;
mod robot;
mod scenario;
mod validation;
