//! Balance by forces: the split over contacts, the equilibrium it makes, and robots that stand on
//! it.

mod broken;
mod change;
mod distribution;
mod equilibrium;
mod null_space_motion;
mod standing;
