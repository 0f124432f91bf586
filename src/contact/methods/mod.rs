//! Contact methods behind one trait ([`method::Method`]).

pub mod decision;
pub mod exact;
pub mod lcp;
pub mod method;
pub mod ncp;
pub mod one_step;
pub mod penalty;
pub mod points;
