//! Does the robot touch itself: the links as convex polyhedra, and how near they are in a posture.
//!
//! - [`spatial`]: [`CollisionModel`], the bodies of a robot and the pairs of them that are watched; immutable.
//! - [`kinematics`]: poses of the links for joint positions, and joint positions ahead in time.
//! - [`detection`]: [`Detector`], distances, nearest points and collisions of a posture; the workspace.
//! - [`avoidance`]: [`Avoider`], which keeps what the joints are asked free of collisions.
//!
//! These are the four components of the paper's section IV. Everything is in the root link's frame or any other
//! that the given poses share, in m.

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
