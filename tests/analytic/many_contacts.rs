//! Dozens of contacts at once: loads and slip by their closed forms.

use super::body::G;
use super::objects::{assert_clean, finished};
use super::support::{TIGHT, finish, simulation};
use std::fmt::Write;
use std::path::Path;
use stiction::sim::NullObserver;

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
