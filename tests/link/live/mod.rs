//! `--live`: what a client is shown is what the log holds, and nobody who looks on changes the run.

mod program;
mod server;
mod viewer;
