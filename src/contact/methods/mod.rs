//! Contact methods behind one trait ([`contact_method::ContactMethod`]).

pub mod contact_method;
pub mod decision;
pub mod exact;
pub mod lcp;
pub mod ncp;
pub mod one_step;
pub mod penalty;
pub mod points;
pub mod registry;
