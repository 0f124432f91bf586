//! Balance by forces: distribution over contacts, the resulting equilibrium, and robots that stand
//! on it.

mod broken;
mod change;
mod distribution;
mod equilibrium;
mod null_space_motion;
mod standing;
