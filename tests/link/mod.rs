//! Tests of remote runs, with tasks and robot in different processes: packets, sessions, bit
//! equality.

mod live;
mod replayed;
mod session;
mod stranger;
mod wire;
