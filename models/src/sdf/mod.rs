//! SDFormat files as documents: models and worlds with the positions of their elements, and poses
//! resolved to the frame of their model.
//!
//! - `xml`, `vocabulary`: elements, their values, and what is known of the format.
//! - `document`: the types; `read_model`, `read_joint`, `geometry`, `includes`: their readers.
//! - `frames`: resolves `relative_to`, `attached_to` and placement frames.
//!
//! SDFormat 1.4 to 1.12. Errors and remarks have the position of their element. Nothing is refused
//! here that only a simulation cannot use, so that a world can leave out models.
//!
//! Imports: `text`, `input`. Used by: `robot`, `scenario`.

mod document;
mod frames;
mod geometry;
mod includes;
mod pose;
mod read_joint;
mod read_model;
mod remarks;
mod vocabulary;
mod xml;

pub use document::*;
pub use frames::{Resolved, ResolvedJoint, ResolvedLink, resolve, world_frames};
pub use includes::resolve_uri;
pub use pose::Pose;
pub use read_model::{read, read_selected};
pub use remarks::{Remark, Remarks};

/// True for files whose name ends as those of SDFormat do.
pub fn is_sdf_name(path: &std::path::Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["sdf", "world"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}
