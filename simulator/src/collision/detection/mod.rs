//! Collisions and distances of the bodies in a posture.

mod axis_box;
mod detector;
mod epa;
mod gjk;
mod pair_distance;
mod posed_bodies;
mod simplex;
mod support_mapping;

pub use detector::{Counts, Detector, Proximity};
pub(crate) use gjk::{Nearest, Warm};
pub(crate) use pair_distance::PairDistance;
