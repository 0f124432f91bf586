//! What drives many runs, without running them.

mod filter;
