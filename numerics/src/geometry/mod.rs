//! Geometry without state: planes, polygons, convex hulls, the point of optimal stability.
//!
//! - `planar_hull`: the hull of points projected along a plane's normal, computed in each tick
//!   without allocation.
//! - `outline`: the outline of a point set in space with a tolerance, for soles, and its
//!   simplification.
//! - `spatial_hull`: hulls of bodies.
//! - `polyhedron`: volume, centre and inertia of bodies.
//! - `angles`: roll, pitch and yaw.
//! - `distinct_points`: points without repetition, of meshes.
//! - `convex_polygon`, `simple_polygon`: checks of polygons in input files.
//! - `stable_point`: the centre of the largest disc in a polygon.
//!
//! Imports: `math`. Used by: `mesh`, `robot`, `terrain`, `task`, `sim`, `scenario`, `convert`,
//! `assemble`, `batch`, `export`, `console`, `collision`.

mod angles;
pub mod convex_polygon;
mod distinct_points;
pub mod outline;
pub mod planar_hull;
pub mod plane;
pub mod polyhedron;
pub mod simple_polygon;
pub mod spatial_hull;
pub mod stable_point;

pub use angles::roll_pitch_yaw;
pub use distinct_points::distinct_points;
pub use planar_hull::convex_hull;
pub use plane::Plane;
pub use spatial_hull::convex_hull_3d;
pub use stable_point::{StablePoint, stable_point};
