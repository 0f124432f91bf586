//! Whole-body inverse kinematics for tasks that plan with positions.
//!
//! A task keeps a [`Figure`]: the robot as it wants it, a state and workspace of its own. [`Inverse`] moves the figure until
//! its soles, its centre of mass and its root are where the task's [`Goal`] says. Nothing here allocates after `new`.

pub mod feed_forward;
pub mod figure;
pub mod goal;
pub mod inverse;
pub mod poser;

pub use figure::{Figure, NotPlannable};
pub use goal::{Goal, Rates};
pub use inverse::{Inverse, Unknowns, Unreachable};
pub use poser::Poser;
