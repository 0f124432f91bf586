//! Tests of remote runs, with tasks and robot in different processes: packets, sessions, bit
//! equality.

#[cfg(feature = "live")]
mod live;
#[cfg(not(feature = "live"))]
mod not_live;
mod replayed;
mod session;
mod stranger;
mod wire;
