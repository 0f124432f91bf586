//! Visual and collision shapes of links: primitives and meshes.
//!
//! Called by the construction of the moving tree.

mod capsules;
mod link_shapes;
mod package;

pub(super) use link_shapes::{Shapes, isometry};
