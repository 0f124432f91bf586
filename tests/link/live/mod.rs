//! `--live`: clients receive the messages of the log, and do not change the run.

mod access;
mod program;
mod server;
mod viewer;
