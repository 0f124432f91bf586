//! Seeing runs: what the page is given is what the log holds, and who is given it.

mod command;
mod data;
mod page;
mod server;
