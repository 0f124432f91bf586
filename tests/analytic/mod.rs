//! Contact against closed forms (`contact.md` section 13).

mod block;
mod scratch;
mod scratch2;
mod support;
