//! Tests of the feature `policy`, in a program of their own: with it, the rest of the tests need not be compiled again.

// Expected values may come from the system's library: they have tolerances.
#![allow(clippy::disallowed_methods, clippy::disallowed_types)]

mod policy;
// Most of it serves other tests.
#[allow(dead_code)]
mod support;
