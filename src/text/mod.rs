//! Text for people: excerpts of input files, TOML syntax errors, name patterns, suggestions for unknown names, and control
//! characters made visible.
//!
//! Imports nothing of this crate. Every room that reports errors or reads names calls it.

pub(crate) mod excerpt;
pub(crate) mod pattern;
pub mod suggest;
pub(crate) mod toml_syntax;
pub mod visible;

pub use suggest::help as suggest;
