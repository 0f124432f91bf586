//! Which bodies of a posture touch, and how far apart the others are.

mod boxes;
mod detector;
mod epa;
mod gjk;
mod nearness;
mod placed;
mod scene;
mod simplex;

pub use detector::{Counts, Detector, Proximity};
pub(crate) use gjk::{Nearest, Warm};
pub(crate) use nearness::Nearness;
