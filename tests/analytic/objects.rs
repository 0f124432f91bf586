//! Objects on the floor, on each other and against each other, by their closed forms.

use super::body::G;
use super::support::{finish, simulation};
use nalgebra::Vector3;
use stiction::sim::{Metrics, NullObserver, Simulation};

/// No robot, and tolerances at which the closed forms below hold to 1e-9.
const ALONE: &str = "robot = { model = \"robots/ground/ground.urdf\" }
    integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }
    contact = { distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }
    log = { rate = 0 }\n";

fn finished(scenario: &str) -> (Simulation, Metrics) {
    let mut sim = simulation(&format!("{ALONE}{scenario}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    (sim, metrics)
}

/// Position and velocities of object `o`.
fn motion(sim: &Simulation, o: usize) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let state = &sim.plant().objects.list[o].state;
    let part = |k: usize| Vector3::from_column_slice(&state.v[k..k + 3]);
    (state.position, part(0), part(3))
}

fn assert_clean(m: &Metrics) {
    assert!(m.max_penetration_m < 1e-9 && m.energy_error_j.abs() < 1e-9 && m.inconsistent == 0, "{m:?}");
    assert!(m.max_cone_excess < 1e-9 && m.max_tension_n < 1e-9, "{m:?}");
}

#[test]
fn a_ball_rolls_down_an_incline() {
    let tilt: f64 = 0.2;
    let (sim, m) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = 0.5, rpy = [0, {tilt}, 0] }}
        object = [{{ type = \"sphere\", radius = 0.1, mass = 2.0, position = [{}, 0, {}] }}]",
        0.1 * tilt.sin(),
        0.1 * tilt.cos()
    ));
    let (position, velocity, omega) = motion(&sim, 0);
    let a = 5.0 / 7.0 * G * tilt.sin();
    let down = Vector3::new(tilt.cos(), 0.0, -tilt.sin());
    let start = Vector3::new(tilt.sin(), 0.0, tilt.cos()) * 0.1;
    assert!((position - start - down * (0.5 * a)).norm() < 1e-9, "{}", (position - start).norm() - 0.5 * a);
    assert!((velocity - down * a).norm() < 1e-9 && (omega - Vector3::y() * (a / 0.1)).norm() < 1e-8);
    assert_clean(&m);
}

#[test]
fn a_sliding_ball_begins_to_roll() {
    let (mu, v0) = (0.3, 2.0);
    let (sim, m) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = {mu} }}
        object = [{{ type = \"sphere\", radius = 0.1, mass = 2.0, position = [0, 0, 0.1], linear_velocity = [{v0}, 0, 0] }}]"
    ));
    let until = 2.0 * v0 / (7.0 * mu * G);
    let (position, velocity, omega) = motion(&sim, 0);
    assert!((m.first_stick_s.unwrap() - until).abs() < 1e-9, "{:?} {until}", m.first_stick_s);
    let v = 5.0 / 7.0 * v0;
    assert!((velocity - Vector3::x() * v).norm() < 1e-9 && (omega - Vector3::y() * (v / 0.1)).norm() < 1e-8);
    let way = v0 * until - 0.5 * mu * G * until * until + v * (1.0 - until);
    assert!((position - Vector3::new(way, 0.0, 0.1)).norm() < 1e-9, "{position} {way}");
    assert_clean(&m);
}

#[test]
fn a_box_slides_over_the_floor_and_stops() {
    let (mu, v0) = (0.4, 1.5);
    let (sim, m) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = {mu} }}
        object = [{{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 2.0, position = [0, 0, 0.05], linear_velocity = [{v0}, 0, 0] }}]"
    ));
    let (position, velocity, _) = motion(&sim, 0);
    assert!((position - Vector3::new(v0 * v0 / (2.0 * mu * G), 0.0, 0.05)).norm() < 1e-9, "{position}");
    assert!(velocity.norm() < 1e-12);
    assert!((m.first_stick_s.unwrap() - v0 / (mu * G)).abs() < 1e-9);
    assert_clean(&m);
}

/// The upper box slides on the lower one, which the floor holds: its friction is the smaller one.
#[test]
fn a_box_slides_on_a_box() {
    let (mu, v0) = (0.2, 0.8);
    let (sim, m) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = 0.5 }}
        object = [
            {{ type = \"box\", size = [1.0, 0.4, 0.1], mass = 2.0, position = [0, 0, 0.05] }},
            {{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 1.0, position = [-0.1, 0, 0.15], linear_velocity = [{v0}, 0, 0], friction = {mu} }},
        ]"
    ));
    let way = v0 * v0 / (2.0 * mu * G);
    assert!((motion(&sim, 1).0 - Vector3::new(-0.1 + way, 0.0, 0.15)).norm() < 1e-9, "{}", motion(&sim, 1).0);
    assert!((motion(&sim, 0).0 - Vector3::new(0.0, 0.0, 0.05)).norm() < 1e-9, "{}", motion(&sim, 0).0);
    assert_clean(&m);
}

/// A block on a free frictionless wedge-like pair: a box falls on a box, both come to rest.
#[test]
fn a_box_lands_on_a_box() {
    let (sim, m) = finished(
        "duration = 0.5
        floor = { friction = 0.5 }
        object = [
            { type = \"box\", size = [0.4, 0.4, 0.1], mass = 2.0, position = [0, 0, 0.05] },
            { type = \"box\", size = [0.2, 0.1, 0.1], mass = 1.0, position = [0.03, 0.02, 0.25] },
        ]",
    );
    assert!((motion(&sim, 1).0 - Vector3::new(0.03, 0.02, 0.15)).norm() < 1e-9, "{}", motion(&sim, 1).0);
    assert!((m.impact_loss_j - G * 0.1).abs() < 1e-9, "{}", m.impact_loss_j);
    assert_clean(&m);
}
