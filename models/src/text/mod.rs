//! Text for users: diagnostics with excerpts of input files, TOML trees with positions, angles,
//! name patterns and suggestions for unknown names.
//!
//! - `source`: a text with line and column of each byte; `diagnostic`: severity, message, position,
//!   excerpt, help.
//! - `toml_tree`, `toml_syntax`: TOML values with their spans, and additions to the parser's
//!   messages.
//! - `angle`: numbers such as `"30 deg"`; `pattern`: names with `*` and `?`; `suggest`: "did you
//!   mean".
//! - `visible`: escapes control characters in names; `plural`: counts with nouns.
//! - `length_limit`: cuts the middle out of long messages.
//! - `text_table`: tables for terminals; `csv_line`: lines of CSV tables; `utc_date`: dates of files; `quantity`: numeric fields with ranges and units.
//! - `xml_syntax`: XML with positions; `xml_attributes`: limits the attributes of elements.
//!
//! Imports: nothing of this crate. Used by: `mesh`, `sdf`, `robot`, `motion`, `contact`, `sim`,
//! `scenario`, `script`, `assemble`, `results`, `batch`, `compare`, `report`, `export`, `cli`,
//! `console`, `fit`, `history`.

pub mod angle;
pub mod csv_line;
pub mod diagnostic;
pub mod excerpt;
pub mod length_limit;
pub mod pattern;
pub mod plural;
pub mod quantity;
pub mod source;
pub mod suggest;
pub mod text_table;
pub mod toml_syntax;
pub mod toml_tree;
pub mod utc_date;
pub mod visible;
pub mod xml_attributes;
pub mod xml_syntax;

pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use source::{Position, Source};
pub use suggest::help as suggest;
