//! Shows a run: turns its log into a page on which the run plays in three dimensions. Reads logs
//! and changes nothing.
//!
//! ```text
//! log -> DrawnRun (times, frames, shapes, series) -> PackedRun (bytes) -> page, file or served
//! ```
//!
//! The page is `page/viewer.html` with style and scripts inserted; it loads nothing from other
//! hosts. It draws with three.js; `page/three.min.js` has the parts that it needs (see
//! `page/three/`).
//!
//! Imports: `input`, `files`, `web`, `log`, `results`. Used by: `cli`.

mod connections;
mod drawn_run;
mod http;
mod packed_run;
mod run_list_page;
mod view_error;
mod view_server;
mod viewable_runs;
mod viewer_page;

pub use connections::ConnectionLimits;
pub use drawn_run::DrawnRun;
pub use packed_run::{PackedRun, pack};
pub use view_error::ViewError;
pub use view_server::{ServerStopper, ViewServer};
pub use viewable_runs::{ViewableRun, ViewableRuns};
pub use viewer_page::{file_page, served_page, write_page};
