//! Generates reference pages in Markdown from a JSON Schema, and so from the types that read the files: every key with type,
//! default and meaning, and a section for each table.
//!
//! Imports nothing of this crate. Called by `cli` (`runner schema FORMAT --markdown`).

mod page_context;
mod reference_page;
mod schema_node;
mod section;
mod type_phrase;

pub use page_context::Notation;
pub use reference_page::page;
