//! `balance`: keeps the centre of mass above the soles, under force control or position control.

pub mod distribution;
pub mod force_balance;
pub mod null_space_motion;
pub mod position_balance;
pub mod reference_trajectory;
pub mod stance;
