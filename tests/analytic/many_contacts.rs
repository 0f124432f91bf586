//! Dozens of contacts at once: loads and slip by their closed forms.

use super::body::G;
use super::objects::{assert_clean, finished, motion};
use crate::support::runs::{TIGHT, finish, simulation};
use nalgebra::Vector3;
use std::fmt::Write;
use std::path::Path;
use stiction::sim::{NullObserver, Simulation};

/// 45 boxes of 1 to 5.4 kg on the floor, and a stack of three of 1 kg: the floor carries the weight of
/// each, and nothing moves.
#[test]
fn forty_five_boxes_and_a_stack_stand() {
    let mass = |i: usize| 1.0 + 0.1 * i as f64;
    let mut objects = String::new();
    for i in 0..45 {
        let (x, y) = (0.2 * (i % 9) as f64, 0.2 * (i / 9) as f64);
        let _ = writeln!(
            objects,
            "{{ type = \"box\", size = [0.1, 0.1, 0.1], mass = {}, position = [{x}, {y}, 0.05] }},",
            mass(i)
        );
    }
    for z in [0.05, 0.15, 0.25] {
        let _ = writeln!(objects, "{{ type = \"box\", size = [0.2, 0.2, 0.1], mass = 1.0, position = [-1, 0, {z}] }},");
    }
    let (sim, m) = finished(&format!("duration = 0.02\nfloor.friction = 0.5\nobject = [\n{objects}]"));
    let plant = sim.plant();
    assert_eq!(plant.polygons.len(), 48);
    for s in 0..48 {
        let load = plant.solution.wrench[6 * s + 2];
        // Of the stack the floor carries three, the next box two.
        let expected = if s < 45 { mass(s) * G } else { (48 - s) as f64 * G };
        assert!((load - expected).abs() < 1e-9, "{} {load} {expected}", plant.polygons[s].name());
    }
    assert!(m.final_object_shift_m.unwrap() < 1e-12 && m.final_object_speed_m_per_s.unwrap() < 1e-12);
    assert_clean(&m);
}

/// A plate of 2 kg on a grid of 36 points, each a sole, is pushed by a force that grows by 20 N/s: it
/// carries its weight, and slips at mu m g.
#[test]
fn a_plate_on_36_points_slips_at_its_friction() {
    let folder = tempfile::tempdir().unwrap();
    write_plate(folder.path());
    let robot = folder.path().join("plate.toml");
    let mut sim = simulation(&format!(
        "{}duration = 0.6
        floor.friction = 0.5
        log.rate = 0
        robot = {{ model = {robot:?}, base = {{ position = [0, 0, 0.05] }} }}
        force = [{{ type = \"ramp\", link = \"plate\", force = [20, 0, 0], start = 0.0, duration = 1.0 }}]",
        TIGHT
    ));
    let m = finish(&mut sim, &mut NullObserver);
    assert_eq!(sim.plant().polygons.len(), 36);
    let slips = 0.5 * 2.0 * G / 20.0;
    assert!((m.first_slip_s.unwrap() - slips).abs() < 1e-9, "{:?} {slips}", m.first_slip_s);
    // 2 m a = 20 (t - slips)
    let way = 10.0 * (0.6 - slips).powi(3) / 6.0;
    assert!((m.final_base_position[0] - way).abs() < 1e-9, "{:?} {way}", m.final_base_position);
    assert!((m.final_normal_force_n.unwrap() - 2.0 * G).abs() < 1e-9, "{:?}", m.final_normal_force_n);
    assert_clean(&m);
}

/// A scene of fixed steps of 1 ms with these objects.
fn stepped(method: &str, end: f64, objects: &str) -> Simulation {
    let mut sim = simulation(&format!(
        "robot = {{ model = \"robots/ground/ground.urdf\" }}
        integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
        contact = {{ method = \"{method}\" }}
        log = {{ rate = 0 }}
        floor.friction = 0.4
        duration = {end}
        object = [\n{objects}]"
    ));
    finish(&mut sim, &mut NullObserver);
    sim
}

/// Boxes that do not touch each other move together as each by itself, to the same bits where states are chosen: one slides and turns to
/// rest, one lands on an edge and topples, two form a stack of which the upper one slides.
#[test]
fn objects_apart_move_as_alone() {
    let groups = [
        "{ type = \"box\", size = [0.3, 0.2, 0.1], mass = 2.0, position = [0, 0, 0.05], linear_velocity = [0.5, 0.2, 0], angular_velocity = [0, 0, 2] },\n",
        "{ type = \"box\", size = [0.2, 0.2, 0.3], mass = 1.0, position = [3, 0, 0.3], rpy = [0.4, 0, 0] },\n",
        "{ type = \"box\", size = [0.3, 0.3, 0.1], mass = 1.0, position = [6, 0, 0.05] },
        { type = \"box\", size = [0.2, 0.2, 0.1], mass = 0.5, position = [6, 0, 0.15], linear_velocity = [0.4, 0, 0] },\n",
    ];
    for method in ["exact", "one-step", "lcp", "ncp"] {
        let all = stepped(method, 0.4, &groups.concat());
        let mut first = 0;
        for group in groups {
            let alone = stepped(method, 0.4, group);
            let count = alone.plant().objects.list.len();
            for o in 0..count {
                let (one, other) = (motion(&alone, o), motion(&all, first + o));
                // The typical load differs, by which `lcp` and `ncp` scale: rounding.
                let is_close = (one.0 - other.0).norm() < 1e-15 && (one.1 - other.1).norm() < 1e-15;
                assert!(one == other || is_close && ["lcp", "ncp"].contains(&method), "{method} {one:?} {other:?}");
            }
            first += count;
        }
    }
}

/// A stack of boxes stands in fixed steps from the first step on, in which all bodies would fall alike.
#[test]
fn a_stack_stands_in_fixed_steps() {
    let at = |i: usize| Vector3::new(0.01 * (i % 2) as f64, 0.0, 0.05 + 0.1 * i as f64);
    let mut objects = String::new();
    for i in 0..12 {
        let p = at(i);
        let _ = writeln!(
            objects,
            "{{ type = \"box\", size = [0.2, 0.2, 0.1], mass = 1.0, position = [{}, 0, {}] }},",
            p.x, p.z
        );
    }
    for method in ["exact", "one-step", "lcp"] {
        let sim = stepped(method, 0.2, &objects);
        // Rounding of the loads, about 1e-14 of the weight, over 200 steps.
        let moved = (0..12).map(|i| (motion(&sim, i).0 - at(i)).norm()).fold(0.0, f64::max);
        assert!(moved < 1e-12, "{method} {moved:e}");
    }
}

/// A plate of 0.5 m with a sole at each of 6 x 6 points.
fn write_plate(folder: &Path) {
    let urdf = "<robot name=\"plate\"><link name=\"plate\"><inertial>
            <mass value=\"2\"/><inertia ixx=\"0.05\" iyy=\"0.05\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>
        </inertial></link></robot>";
    std::fs::write(folder.join("plate.urdf"), urdf).unwrap();
    let mut robot = "urdf = \"plate.urdf\"\n".to_owned();
    for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
        let (x, y) = (0.1 * f64::from(i) - 0.25, 0.1 * f64::from(j) - 0.25);
        let _ = writeln!(robot, "[[sole]]\nname = \"{i}{j}\"\nlink = \"plate\"\npolygon = [[{x:.2}, {y:.2}, -0.05]]");
    }
    std::fs::write(folder.join("plate.toml"), robot).unwrap();
}
