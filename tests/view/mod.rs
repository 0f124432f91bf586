//! Tests of the viewer: the encoded run, the page, the server and the command.

mod command;
mod data;
mod page;
mod server;
