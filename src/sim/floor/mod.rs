//! The floor: a plane, patches with friction of their own, the friction region of each vertex, and
//! links that sink through the plane.
//!
//! Imports geometry. Called by `plant`, which holds the floor, and by `assemble`, which builds it
//! from a scenario.

pub mod friction_regions;
pub mod patch;
pub mod sunk_links;
pub mod vertex_region;

pub use friction_regions::Floor;
pub use patch::Patch;
pub use sunk_links::SunkLinks;
pub use vertex_region::VertexRegion;
