//! Measurements of a run: residual maxima, energy balance, milestones, samples and snapshots.
//!
//! Each type reads the plant and accumulates; none changes the motion.
//!
//! Imports plant, contact (residuals) and the data types in `report`. Called by the steppers and by
//! [`Simulation`](super::Simulation).

pub mod energy_balance;
pub mod milestones;
pub mod residual_maxima;
pub mod sampler;
pub mod snapshot;
