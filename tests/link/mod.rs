//! Tasks here, robot there: packets, sessions, the same bits over a link.

mod session;
mod stranger;
mod wire;
