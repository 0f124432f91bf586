//! External forces against closed forms and conservation laws.

mod carried_object;
mod drag;
mod end_effector;
mod events;
mod fixed;
mod ramp;
mod random_pushes;
mod spring;

use crate::analytic::body::Body;
use crate::support::runs::{TIGHT, finish, simulation};
use nalgebra::Vector3;
use stiction::sim::{Metrics, NullObserver};

/// Standard gravity of a scenario, m/s^2.
const G: f64 = 9.81;

/// State of a body at the end of a run.
struct End {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    metrics: Metrics,
}

/// Runs a box in the air without a sole, starting at `position` with `velocity`; `text` is the rest
/// of the scenario.
fn fly(body: &Body, position: [f64; 3], velocity: [f64; 3], duration: f64, text: &str) -> End {
    let robot = body.floating(&format!("position = {position:?}, linear_velocity = {velocity:?}"));
    let mut sim = simulation(&format!("duration = {duration:?}\n{robot}{TIGHT}{text}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    let state = &sim.plant().state;
    let v = &state.v;
    End { position: state.position, velocity: Vector3::new(v[0], v[1], v[2]), metrics }
}
