//! Where the links are, and where they will be.

mod extrapolate;
mod place;

pub(crate) use extrapolate::capped_travel;
pub use extrapolate::extrapolate;
pub(crate) use place::place_link;
pub use place::{LinkPose, place};
