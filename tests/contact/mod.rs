//! The contact kernel on problems built by hand: no robot, no stepping.

mod capacity;
mod impact;
mod law;
mod pair;
mod pairs;
mod residual;
mod rest;
mod rigid;
mod stepping;
