//! Visual and collision shapes of links: primitives, and meshes from STL, OBJ and COLLADA files.
//!
//! Called by the construction of the moving tree.

mod collada;
mod link_shapes;
mod mesh;
mod package;

pub(super) use link_shapes::{Shapes, isometry};
