//! Self-collision: the links as convex polyhedra, their distances in a posture, and avoidance. The
//! four modules are the components of section IV of [Hale 2008]. All data are in the frame of the
//! given poses, such as that of the root link, in m.
//!
//! - [`spatial`]: [`CollisionModel`], the bodies of a robot and the monitored pairs; immutable.
//! - [`kinematics`]: link poses for joint positions, and extrapolated joint positions.
//! - [`detection`]: [`Detector`], distances, nearest points and collisions of a posture; the
//!   workspace.
//! - [`avoidance`]: [`Avoider`], which keeps joint commands free of collisions.
//!
//! Hulls come from `parry` (`geometry::convex_hull_3d`), distances and depths do not: `parry3d`
//! 0.31
//!
//! - stops GJK at a relative gap of the bounds of sqrt(10 eps) = 5e-8; here the bounds meet to
//!   1e-12 m,
//! - does not return the proven lower bound, which ends most tests early and which avoidance needs
//!   for its proofs,
//! - scans all vertices for a support point; here a climb starts at the pair's last result,
//! - allocates in EPA; the stepping loop here must not allocate.
//!
//! Imports: `math`, `geometry`, `random`, `robot`, `motion`. Used by: `sim`, `assemble`, `cli`.

pub mod avoidance;
pub mod detection;
mod inspect;
pub mod kinematics;
mod model_cache;
pub mod spatial;

pub use avoidance::Avoider;
pub use detection::{Counts, Detector, Proximity};
pub use inspect::inspect;
pub use kinematics::{LinkPose, extrapolate, link_poses};
pub use model_cache::shared_model;
pub use spatial::{Body, CollisionModel, Pair};
