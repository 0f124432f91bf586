//! Gait of a biped: the footstep plan with its zero-moment point, and the resulting centre-of-mass
//! motion.

pub mod footsteps;
pub mod preview;

pub use footsteps::{Footsteps, Stride};
pub use preview::{Preview, Sample};
