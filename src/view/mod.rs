//! Seeing a run: its log as a page on which it plays in three dimensions. An observer: it reads logs and changes nothing.
//!
//! ```text
//! log -> Replay (what is drawn, from the topics) -> pack (bytes) -> page, in one file, or asked of the server
//! ```
//!
//! The page is `page/viewer.html` with its style and scripts put into it; it asks nothing of other hosts. What it draws
//! with is three.js, of which `page/three.min.js` holds the parts it needs (see `page/three/`).

mod http;
mod list;
mod pack;
mod page;
mod replay;
mod runs;
mod server;

pub use pack::{Packed, pack};
pub use page::{file_page, served_page, write_page};
pub use replay::{Replay, ViewError};
pub use runs::{Runs, ShownRun};
pub use server::{Server, Stopper};
