//! How a biped walks: where its feet go, where its zero-moment point is to be, and how the centre of mass then moves.

pub mod footsteps;
pub mod preview;

pub use footsteps::{Footsteps, Stride};
pub use preview::{Preview, Sample};
