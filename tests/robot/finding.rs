//! Soles of robots that name none.

use nalgebra::{Point3, Vector3};
use stiction::robot::{Robot, inspect};

use super::{BODY, load_urdf, shipped};

/// A sole's vertices in the URDF frame of its link.
pub fn polygon(robot: &Robot, sole: usize) -> Vec<Vector3<f64>> {
    let sole = &robot.model.soles[sole];
    let back = robot.model.links[sole.link.0].urdf_frame.inverse();
    sole.vertices.iter().map(|v| (back * Point3::from(*v)).coords).collect()
}

/// Equal as rings: some rotation of one is the other.
fn same_ring(a: &[Vector3<f64>], b: &[Vector3<f64>], tolerance: f64) -> bool {
    let n = a.len();
    n == b.len() && (0..n).any(|shift| (0..n).all(|i| (a[i] - b[(i + shift) % n]).norm() <= tolerance))
}

#[test]
fn the_bare_block_gets_the_sole_its_robot_file_gives() {
    let (given, found) = (shipped("block/block.toml"), shipped("block/block.urdf"));
    assert!(same_ring(&polygon(&given, 0), &polygon(&found, 0), 0.0), "{:?}", polygon(&found, 0));
    assert!(found.notices.iter().any(|n| n.message.contains("sole `block` found on link `block`")));
    assert!(given.notices.is_empty());
}

#[test]
fn bare_hoap2_gets_its_sole_plates() {
    let (given, found) = (shipped("hoap2/hoap2.toml"), shipped("hoap2/hoap2.urdf"));
    assert_eq!(found.model.soles.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["l_foot", "r_foot"]);
    for sole in 0..2 {
        // Rounding of the plate's centre and half size.
        assert!(same_ring(&polygon(&given, sole), &polygon(&found, sole), 1e-16), "{:?}", polygon(&found, sole));
    }
}

fn standing_on(collisions: &str) -> Robot {
    load_urdf(&format!("<robot name=\"r\"><link name=\"a\">{BODY}{collisions}</link></robot>")).unwrap()
}

#[test]
fn round_feet_are_points_and_lines() {
    let ball =
        standing_on("<collision><origin xyz=\"1 2 3\"/><geometry><sphere radius=\"0.5\"/></geometry></collision>");
    assert_eq!(polygon(&ball, 0), [Vector3::new(1.0, 2.0, 2.5)]);
    let lying = "<collision><origin rpy=\"0 1.5707963267948966 0\"/><geometry><cylinder radius=\"0.5\" length=\"2\"/></geometry></collision>";
    let roller = polygon(&standing_on(lying), 0);
    // Rounding of the quarter turn.
    assert!(same_ring(&roller, &[Vector3::new(-1.0, 0.0, -0.5), Vector3::new(1.0, 0.0, -0.5)], 1e-15), "{roller:?}");
    let upright =
        polygon(&standing_on("<collision><geometry><cylinder radius=\"0.5\" length=\"2\"/></geometry></collision>"), 0);
    assert_eq!(upright.len(), 8);
    assert!(upright.iter().all(|p| p.z == -1.0 && (p.xy().norm() - 0.5).abs() < 1e-15));
    let standing_capsule =
        polygon(&standing_on("<collision><geometry><capsule radius=\"0.5\" length=\"2\"/></geometry></collision>"), 0);
    assert_eq!(standing_capsule, [Vector3::new(0.0, 0.0, -1.5)]);
}

#[test]
fn a_foot_tilted_at_home_still_gives_its_whole_face() {
    let tilted = "<collision><origin rpy=\"0.1 0.2 0\"/><geometry><box size=\"0.2 0.1 0.04\"/></geometry></collision>";
    let found = polygon(&standing_on(tilted), 0);
    let turn = nalgebra::UnitQuaternion::from_euler_angles(0.1, 0.2, 0.0);
    let corner = |x: f64, y: f64| turn * Vector3::new(x, y, -0.02);
    let face = [corner(0.1, 0.05), corner(-0.1, 0.05), corner(-0.1, -0.05), corner(0.1, -0.05)];
    // Rounding of the rotation.
    assert!(same_ring(&found, &face, 1e-16), "{found:?}");
}

#[test]
fn vertices_run_counter_clockwise_seen_from_above() {
    for robot in [
        shipped("block/block.toml"),
        shipped("block/block.urdf"),
        shipped("hoap2/hoap2.toml"),
        shipped("hoap2/hoap2.urdf"),
    ] {
        for sole in 0..robot.model.soles.len() {
            // Both robots' foot links are level at home, so their z axes point up.
            let p = polygon(&robot, sole);
            let area: f64 = (0..p.len()).map(|i| p[i].xy().perp(&p[(i + 1) % p.len()].xy())).sum();
            assert!(area > 0.0, "{}", inspect(&robot));
        }
    }
}

#[test]
fn only_what_stands_is_a_sole() {
    let arm = |name: &str, z: f64| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"0 0 {z}\"/><parent link=\"a\"/><child link=\"{name}\"/></joint>\
             <link name=\"{name}\">{BODY}<collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision></link>"
        )
    };
    let text =
        format!("<robot name=\"r\"><link name=\"a\">{BODY}</link>{}{}</robot>", arm("hand", 0.5), arm("foot", -0.5));
    let robot = load_urdf(&text).unwrap();
    assert_eq!(robot.model.soles.len(), 1);
    assert_eq!(robot.model.soles[0].name, "foot");
    let fixed = shipped("pendulum/pendulum.urdf");
    assert!(fixed.model.soles.is_empty() && fixed.notices.iter().any(|n| n.message.contains("no soles")));
}
