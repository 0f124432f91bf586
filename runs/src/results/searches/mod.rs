//! Results of searches.
//!
//! - `search_result`: the result for one combination of swept values, with its runs.
//! - `searches_file`: `searches.json`, `searches.csv` and `boundary-lines.csv`.
//! - `search_table`: lines for the terminal.

mod search_result;
mod search_table;
mod searches_file;

pub use search_result::{Best, Interval, LinePoint, Probe, SearchKind, SearchResult, SearchVerdict};
pub use search_table::search_table;
pub use searches_file::{SEARCHES_SCHEMA, read_searches, write_searches};
