//! Robot files and URDF in, [`Model`] out.

pub mod model;

pub use model::*;
