//! Contact against closed forms (`contact.md` section 13).

mod block;
mod support;
