//! Objects on the floor, on each other and against each other, by their closed forms.

use super::body::G;
use crate::support::runs::{finish, simulation};
use nalgebra::Vector3;
use stiction::sim::{Metrics, NullObserver, Simulation};

/// No robot, and tolerances at which the closed forms below hold to 1e-9.
const ALONE: &str = "robot = { model = \"robots/ground/ground.urdf\" }
    integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }
    contact = { distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }
    log = { rate = 0 }\n";

pub(super) fn finished(scenario: &str) -> (Simulation, Metrics) {
    let mut sim = simulation(&format!("{ALONE}{scenario}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    (sim, metrics)
}

/// Position and velocities of object `o`.
pub(super) fn motion(sim: &Simulation, o: usize) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let state = &sim.plant().objects.list[o].state;
    let part = |k: usize| Vector3::from_column_slice(&state.v[k..k + 3]);
    (state.position, part(0), part(3))
}

pub(super) fn assert_clean(m: &Metrics) {
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

/// A box slides without friction over a plate that turns, both free without gravity: the plane of the contact
/// turns below it, and its normal acceleration has Coriolis and centripetal terms.
#[test]
fn a_box_slides_over_a_plate_that_turns() {
    let (w, u, s0) = (-2.0, 1.0, 0.1);
    let (sim, m) = finished(&format!(
        "duration = 0.4
        gravity = [0, 0, 0]
        floor = {{ plane = false, friction = 0.0 }}
        object = [
            {{ type = \"box\", size = [2, 0.2, 0.1], mass = 3.0, angular_velocity = [0, {w}, 0] }},
            {{ type = \"box\", size = [0.1, 0.1, 0.1], mass = 1.0, position = [{s0}, 0, 0.1], linear_velocity = [{}, 0, {}], angular_velocity = [0, {w}, 0] }},
        ]",
        u + 0.1 * w,
        -s0 * w
    ));
    let momentum = |sim: &Simulation| {
        let (mut linear, mut angular) = (Vector3::zeros(), 0.0);
        for (o, mass, inertia) in [(0, 3.0, 3.0 * (4.0 + 0.01) / 12.0), (1, 1.0, 0.02 / 12.0)] {
            let (p, v, omega) = motion(sim, o);
            linear += v * mass;
            angular += p.cross(&v).y * mass + inertia * omega.y;
        }
        (linear, angular)
    };
    let (linear, angular) = momentum(&sim);
    let start = Vector3::new(u + 0.1 * w, 0.0, -s0 * w);
    let spin = (0.1 * start.x - s0 * start.z) + w * (3.0 * 4.01 + 0.02) / 12.0;
    assert!((linear - start).norm() < 1e-9 && (angular - spin).abs() < 1e-9, "{linear} {angular} {spin}");
    // It stays flat on the plate and keeps its turn, and has slid by some 0.4 m.
    let ((p, _, one), (q, _, other)) = (motion(&sim, 0), motion(&sim, 1));
    assert!((one - other).norm() < 1e-9 && (q - p).norm() > 0.45, "{one} {other} {p} {q}");
    assert!(m.impacts == 0 && m.state_changes == 0, "{m:?}");
    assert_clean(&m);
}

/// Velocities of objects follow those of a robot with kinematic joints, which have columns of its own mass
/// matrix only: CB-i's eyes, next to a ball in free fall.
#[test]
fn robots_with_kinematic_joints_and_objects_move_together() {
    for integrator in ["dopri5", "semi-implicit"] {
        let mut sim = simulation(&format!(
            "duration = 0.05
            robot = {{ model = \"robots/cbi/cbi.toml\" }}
            integrator = {{ method = \"{integrator}\" }}
            object = [{{ type = \"sphere\", radius = 0.1, mass = 1.0, position = [2, 0, 1] }}]
            log.rate = 0\n"
        ));
        let m = finish(&mut sim, &mut NullObserver);
        let fallen = if integrator == "dopri5" { 0.5 * G * 0.05 * 0.05 } else { 0.5 * G * 0.05 * 0.051 };
        let position = motion(&sim, 0).0;
        assert!((position - Vector3::new(2.0, 0.0, 1.0 - fallen)).norm() < 1e-9, "{integrator}: {position}");
        // Steps of order 1 of a robot that settles on its servos.
        assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 2e-2, "{integrator}: {m:?}");
    }
}
