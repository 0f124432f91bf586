//! Text for users: diagnostics with excerpts of input files, TOML trees with positions, angles, name patterns and
//! suggestions for unknown names.
//!
//! - `source`: a text with line and column of each byte; `diagnostic`: severity, message, position, excerpt, help.
//! - `toml_tree`, `toml_syntax`: TOML values with their spans, and what the parser's messages lack.
//! - `angle`: numbers such as `"30 deg"`; `pattern`: names with `*` and `?`; `suggest`: "did you mean".
//! - `visible`: control characters of foreign names, written out.
//!
//! Imports nothing of this crate. Every room that reports errors or reads names calls it.

pub mod angle;
pub mod diagnostic;
pub(crate) mod excerpt;
pub(crate) mod pattern;
pub mod quantity;
pub mod source;
pub mod suggest;
pub mod text_table;
pub(crate) mod toml_syntax;
pub(crate) mod toml_tree;
pub mod visible;

pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use source::{Position, Source};
pub use suggest::help as suggest;
