//! Generates reference pages in Markdown from the JSON Schema of a file format: every key with
//! type, default and meaning, and a section for each table.
//!
//! It serves `runner schema FORMAT --markdown`.
//!
//! Imports: no other room. Used by: `cli`.

mod page_context;
mod reference_page;
mod schema_node;
mod section;
mod type_phrase;

pub use page_context::Notation;
pub use reference_page::page;
