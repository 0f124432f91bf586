//! The floor: a plane, patches with friction of their own, and the friction region of each vertex.
//!
//! Imports geometry. Called by `plant`, which holds the floor, and by `assemble`, which builds it
//! from a scenario.

pub mod friction_regions;
pub mod patch;
pub mod vertex_region;

pub use friction_regions::Floor;
pub use patch::Patch;
pub use vertex_region::VertexRegion;
