//! Requests of browsers to servers on loopback: bounded heads, permitted hosts and origins.
//!
//! Imports: no other room. Used by: `live`, `view`, `cli`.

mod local_access;
mod request_head;

pub use local_access::{AccessError, LocalAccess, is_origin};
pub use request_head::{HeadError, MAX_HEAD, RequestHead};
