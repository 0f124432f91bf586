//! Contact solvers on problems built by hand, without robots or stepping.

mod capacity;
mod hard_problems;
mod impact;
mod law;
mod pair;
mod pairs;
mod point_forces;
mod residual;
mod rest;
mod rigid;
mod stepping;
mod turning;
