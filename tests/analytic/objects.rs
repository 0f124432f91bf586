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
            {{ type = \"box\", size = [1.0, 0.4, 0.1], mass = 2.0, position = [0, 0, 0.05], friction = 0.4 }},
            {{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 1.0, position = [-0.1, 0, 0.15], linear_velocity = [{v0}, 0, 0], friction = {mu} }},
        ]"
    ));
    let way = v0 * v0 / (2.0 * mu * G);
    assert!((motion(&sim, 1).0 - Vector3::new(-0.1 + way, 0.0, 0.15)).norm() < 1e-9, "{}", motion(&sim, 1).0);
    assert!((motion(&sim, 0).0 - Vector3::new(0.0, 0.0, 0.05)).norm() < 1e-9, "{}", motion(&sim, 0).0);
    assert_clean(&m);
}

/// A box falls flat on a box: m g h are lost in one plastic impact.
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

/// Two boxes on a floor without friction meet in line: momentum, and Newton's restitution e.
#[test]
fn a_box_hits_a_box_in_line() {
    let (m, n, v) = (2.0, 0.5, 0.8);
    for e in [0.0, 0.5] {
        let scenario = ALONE.replace("contact = {", &format!("contact = {{ restitution = {e},"));
        let mut sim = simulation(&format!(
            "{scenario}duration = 0.4
            floor = {{ friction = 0.0 }}
            object = [
                {{ type = \"box\", size = [0.2, 0.1, 0.1], mass = {m}, position = [0, 0, 0.05], linear_velocity = [{v}, 0, 0] }},
                {{ type = \"box\", size = [0.2, 0.1, 0.1], mass = {n}, position = [0.4, 0, 0.05] }},
            ]"
        ));
        let metrics = finish(&mut sim, &mut NullObserver);
        let after = [(m - e * n) / (m + n) * v, m * (1.0 + e) / (m + n) * v];
        for (o, expected) in after.into_iter().enumerate() {
            assert!((motion(&sim, o).1 - Vector3::x() * expected).norm() < 1e-9, "{e} {o}: {}", motion(&sim, o).1);
        }
        let loss = 0.5 * m * n / (m + n) * v * v * (1.0 - e * e);
        assert!((metrics.impact_loss_j - loss).abs() < 1e-9, "{} {loss}", metrics.impact_loss_j);
        assert_clean(&metrics);
    }
}

/// A robot whose links touch slides into a box.
#[test]
fn a_robot_pushes_a_box() {
    let v = 0.8;
    let (sim, metrics) = {
        let scenario = ALONE.replace("ground/ground.urdf\" }", "block/block.toml\", contact = \"bodies\", base = { position = [0, 0, 0.05], linear_velocity = [0.8, 0, 0] } }");
        let mut sim = simulation(&format!(
            "{scenario}duration = 0.5
            floor = {{ friction = 0.0 }}
            object = [{{ type = \"box\", size = [0.2, 0.2, 0.1], mass = 3.0, position = [0.4, 0, 0.05] }}]"
        ));
        let metrics = finish(&mut sim, &mut NullObserver);
        (sim, metrics)
    };
    let robot = sim.plant().state.v[0];
    assert!((robot - v / 4.0).abs() < 1e-9 && (motion(&sim, 0).1.x - v / 4.0).abs() < 1e-9, "{robot}");
    assert!((metrics.impact_loss_j - 0.5 * 0.75 * v * v).abs() < 1e-9, "{}", metrics.impact_loss_j);
    assert_clean(&metrics);
}

/// A plank of length l and thickness t leans at the angle a against a wall without friction. It needs
/// mu >= (l cos a - t sin a) / (2 l sin a) at the floor.
#[test]
fn a_plank_against_a_wall_slips_below_the_angle_of_friction() {
    let (l, t, a) = (1.0, 0.05, 1.0f64);
    let needed = (l * a.cos() - t * a.sin()) / (2.0 * l * a.sin());
    // The lower edge is at the origin, the upper one at l (cos a, sin a).
    let centre = Vector3::new(a.cos(), 0.0, a.sin()) * (0.5 * l) + Vector3::new(-a.sin(), 0.0, a.cos()) * (0.5 * t);
    for (factor, slips) in [(1.0 + 1e-6, false), (1.0 - 1e-6, true)] {
        let (sim, m) = finished(&format!(
            "duration = 0.2
            floor = {{ friction = {} }}
            terrain = [{{ type = \"box\", size = [0.2, 2, 2], position = [{}, 0, 1], friction = 0.0 }}]
            object = [{{ type = \"box\", size = [{l}, 0.3, {t}], mass = 3.0, position = [{}, 0, {}], rpy = [0, {}, 0] }}]",
            needed * factor,
            l * a.cos() + 0.1,
            centre.x,
            centre.z,
            -a
        ));
        let moved = (motion(&sim, 0).0 - centre).norm();
        assert_eq!(moved > 1e-9, slips, "{factor}: {moved}");
        assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9, "{m:?}");
    }
}

/// A plank on two boxes, and a box on the plank off its middle, stand without creeping.
#[test]
fn a_bridge_stands() {
    let (sim, m) = finished(
        "duration = 5.0
        floor = { friction = 0.5 }
        object = [
            { type = \"box\", size = [0.1, 0.2, 0.2], mass = 1.0, position = [-0.4, 0, 0.1] },
            { type = \"box\", size = [0.1, 0.2, 0.2], mass = 1.0, position = [0.4, 0, 0.1] },
            { type = \"box\", size = [1.0, 0.1, 0.05], mass = 2.0, position = [0, 0, 0.225] },
            { type = \"sphere\", radius = 0.05, mass = 1.0, position = [0.1, 0, 0.3] },
        ]",
    );
    assert!(m.final_object_shift_m.unwrap() < 1e-12, "{:?}", m.final_object_shift_m);
    assert!(m.max_static_creep_m < 1e-12);
    assert_clean(&m);
    // The floor carries all.
    let plant = sim.plant();
    let floor: f64 = (0..plant.polygons.len())
        .filter(|&s| plant.polygons[s].name().ends_with("on floor"))
        .map(|s| plant.solution.wrench[6 * s + 2])
        .sum();
    assert!((floor - 5.0 * G).abs() < 1e-9, "{floor}");
}
