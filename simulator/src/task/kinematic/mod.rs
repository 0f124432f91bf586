//! Whole-body inverse kinematics for tasks that plan positions.
//!
//! A task has a [`PlannedRobot`] with its own state and workspace. [`InverseKinematics`] moves it
//! until its soles, centre of mass and root meet the task's [`Goal`]. Nothing here allocates after
//! `new`.

pub mod feed_forward;
pub mod goal;
pub mod inverse_kinematics;
pub mod planned_robot;
pub mod posture_planner;

pub use goal::{Goal, Rates};
pub use inverse_kinematics::{InverseKinematics, Unknowns, Unreachable};
pub use planned_robot::{NotPlannable, PlannedRobot};
pub use posture_planner::PosturePlanner;
