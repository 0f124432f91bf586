//! Whole-body inverse kinematics for tasks that plan with positions.
//!
//! A task keeps a [`PlannedRobot`]: the robot as it wants it, a state and workspace of its own. [`InverseKinematics`] moves the planned until
//! its soles, its centre of mass and its root are where the task's [`Goal`] says. Nothing here allocates after `new`.

pub mod feed_forward;
pub mod goal;
pub mod inverse_kinematics;
pub mod planned_robot;
pub mod posture_planner;

pub use goal::{Goal, Rates};
pub use inverse_kinematics::{InverseKinematics, Unknowns, Unreachable};
pub use planned_robot::{NotPlannable, PlannedRobot};
pub use posture_planner::PosturePlanner;
