//! Plane geometry shared by the rooms: what is seen from above the floor.

pub mod hull;
pub mod plane;
pub mod stable_point;

pub use hull::convex_hull;
pub use plane::Plane;
pub use stable_point::{StablePoint, stable_point};
