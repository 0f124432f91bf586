//! Tasks here, robot there: packets, sessions, the same bits over a link.

#[cfg(feature = "live")]
mod live;
#[cfg(not(feature = "live"))]
mod not_live;
mod session;
mod stranger;
mod wire;
