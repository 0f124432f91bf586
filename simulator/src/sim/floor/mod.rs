//! The floor: a plane, patches with friction of their own, the friction region of each vertex,
//! links as convex hulls that touch the plane, and links that sink through it.
//!
//! Imports geometry, collision shapes and dynamics. Called by `plant`, which holds the floor, and by `assemble`, which builds it
//! from a scenario.

pub mod friction_regions;
pub mod link_hull;
pub mod patch;
pub mod sunk_links;
pub mod vertex_region;

pub use friction_regions::Floor;
pub use link_hull::{LinkHull, is_on_ball};
pub use patch::Patch;
pub use sunk_links::{SunkLinks, is_near};
pub use vertex_region::VertexRegion;
