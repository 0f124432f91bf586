//! The contact kernel on problems built by hand: no robot, no stepping.

mod capacity;
mod impact;
mod residual;
mod rest;
mod rigid;
