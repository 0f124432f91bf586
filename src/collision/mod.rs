//! Self-collision: the links as convex polyhedra, their distances in a posture, and avoidance. The
//! four parts are the components of section IV of [Hale 2008]. All data are in the root link's
//! frame or any frame shared by the given poses, in m.
//!
//! - [`spatial`]: [`CollisionModel`], the bodies of a robot and the monitored pairs; immutable.
//! - [`kinematics`]: link poses for joint positions, and extrapolated joint positions.
//! - [`detection`]: [`Detector`], distances, nearest points and collisions of a posture; the
//!   workspace.
//! - [`avoidance`]: [`Avoider`], which keeps joint commands free of collisions.
//!
//! Imports robot, geometry, motion and random. Called by sim, assemble and cli (`inspect`).
//!
//! Hulls come from `parry` (`geometry::convex_hull_3d`). Distances and depths do not, because `parry3d`
//! 0.31 (read in its source)
//! - stops GJK at a relative gap of the bounds of sqrt(10 eps) = 5e-8; here the bounds meet to
//!   1e-12 m;
//! - does not return the proven lower bound, which ends most tests early and on which avoidance's
//!   proofs rest;
//! - scans all vertices for a support point; here a climb starts at the pair's last answer;
//! - allocates in EPA; the stepping loop here allocates nothing.

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
