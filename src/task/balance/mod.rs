//! `balance`: keep the centre of mass above the soles. One file per way of control.

pub mod course;
pub mod distribution;
pub mod force;
pub mod position;
pub mod slack;
pub mod stance;
