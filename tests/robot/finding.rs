//! Detection of soles of robots that name none.

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
fn the_bare_block_gets_the_sole_of_its_robot_file() {
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

/// A robot whose only foot is a link with these shapes.
fn standing_on_foot(collisions: &str) -> Robot {
    let joint =
        "<joint name=\"j\" type=\"continuous\"><parent link=\"hip\"/><child link=\"a\"/><axis xyz=\"0 1 0\"/></joint>";
    let links = format!("<link name=\"hip\">{BODY}</link><link name=\"a\">{BODY}{collisions}</link>");
    load_urdf(&format!("<robot name=\"r\">{links}{joint}</robot>")).unwrap()
}

#[test]
fn round_feet_are_points_and_lines() {
    let ball =
        standing_on_foot("<collision><origin xyz=\"1 2 3\"/><geometry><sphere radius=\"0.5\"/></geometry></collision>");
    assert_eq!(polygon(&ball, 0), [Vector3::new(1.0, 2.0, 2.5)]);
    let lying = "<collision><origin rpy=\"0 1.5707963267948966 0\"/><geometry><cylinder radius=\"0.5\" length=\"2\"/></geometry></collision>";
    let roller = polygon(&standing_on_foot(lying), 0);
    // Rounding of the quarter turn.
    assert!(same_ring(&roller, &[Vector3::new(-1.0, 0.0, -0.5), Vector3::new(1.0, 0.0, -0.5)], 1e-15), "{roller:?}");
    let upright = polygon(
        &standing_on_foot("<collision><geometry><cylinder radius=\"0.5\" length=\"2\"/></geometry></collision>"),
        0,
    );
    assert_eq!(upright.len(), 8);
    // Rounding of the frame at the link's centre of mass.
    assert!(upright.iter().all(|p| (p.z + 1.0).abs() < 1e-15 && (p.xy().norm() - 0.5).abs() < 1e-15), "{upright:?}");
    let standing_capsule = polygon(
        &standing_on_foot("<collision><geometry><capsule radius=\"0.5\" length=\"2\"/></geometry></collision>"),
        0,
    );
    assert_eq!(standing_capsule, [Vector3::new(0.0, 0.0, -1.5)]);
}

#[test]
fn a_body_of_one_ball_has_no_sole() {
    let ball = standing_on("<collision><geometry><sphere radius=\"0.5\"/></geometry></collision>");
    assert!(ball.model.soles.is_empty());
    let [notice] = &ball.notices[..] else { panic!("{:?}", ball.notices) };
    assert_eq!(notice.message, "no sole on `a`: it is round, and touches with its shape");
}

/// The axis of the joint is y, from where the link's frame is.
#[test]
fn wheels_have_no_soles() {
    let lying = |xyz: &str| {
        format!(
            "<collision><origin xyz=\"{xyz}\" rpy=\"1.5707963267948966 0 0\"/>\
             <geometry><cylinder radius=\"0.5\" length=\"0.2\"/></geometry></collision>"
        )
    };
    for wheel in [lying("0 0.3 0"), lying("0 1 0") + &lying("0 -1 0")] {
        let robot = standing_on_foot(&wheel);
        assert!(robot.model.soles.is_empty());
        let notice = robot.notices.last().map(|notice| notice.message.as_str());
        assert_eq!(notice, Some("no sole on `a`: it is a wheel, and rolls on its shape"));
    }
    // Beside its axis it is a cam, and with a box no wheel.
    let boxed = lying("0 0 0") + "<collision><geometry><box size=\"0.1 0.1 0.1\"/></geometry></collision>";
    for foot in [lying("0.1 0.3 0"), boxed] {
        assert_eq!(standing_on_foot(&foot).model.soles.len(), 1);
    }
}

#[test]
fn balls_at_the_corners_of_a_foot_form_one_sole() {
    let ball = |x: f64, y: f64, z: f64, r: f64| {
        format!("<collision><origin xyz=\"{x} {y} {z}\"/><geometry><sphere radius=\"{r}\"/></geometry></collision>")
    };
    // A ball on the shin does not count.
    let balls =
        [ball(0.1, 0.0, 0.0, 0.01), ball(0.0, 0.2, 0.0, 0.01), ball(-0.1, 0.0, 0.01, 0.02), ball(0.0, 0.0, 1.0, 0.01)];
    let found = polygon(&standing_on(&balls.concat()), 0);
    let corners = [Vector3::new(0.1, 0.0, -0.01), Vector3::new(0.0, 0.2, -0.01), Vector3::new(-0.1, 0.0, -0.01)];
    assert!(same_ring(&found, &corners, 1e-16), "{found:?}");
}

#[test]
fn a_link_without_collision_shapes_has_the_sole_of_its_visual_shapes() {
    let seen = "<visual><geometry><box size=\"0.2 0.1 0.04\"/></geometry></visual>";
    let robot = standing_on(seen);
    assert_eq!(polygon(&robot, 0).len(), 4);
    assert!(robot.notices.iter().any(|n| n.message.contains("by its visual shapes")), "{:?}", robot.notices);
}

/// A foot given as a mesh: `corners` of its bottom, tapering to a point at height `top`.
fn on_mesh(corners: &[Vector3<f64>], top: f64) -> Robot {
    let mut obj: String = corners.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    obj += &format!("v 0 0 {top}\n");
    let n = corners.len();
    for i in 0..n {
        obj += &format!("f {} {} {}\n", i + 1, (i + 1) % n + 1, n + 1);
        if i >= 2 {
            obj += &format!("f 1 {} {}\n", i + 1, i);
        }
    }
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}<collision><geometry><mesh filename=\"m.obj\"/></geometry></collision></link></robot>"
    );
    let folder = super::folder(&[("r.urdf", &text), ("m.obj", &obj)]);
    stiction::robot::load(&folder.path().join("r.urdf")).unwrap()
}

#[test]
fn a_bumpy_mesh_gives_a_flat_sole_and_a_small_one_a_point() {
    // Corners of a plate, one of them 0.2 mm up: less than 1 degree off.
    let plate = |size: f64, up: f64| {
        [(1.0, 0.5, 0.0), (-1.0, 0.5, up), (-1.0, -0.5, 0.0), (1.0, -0.5, 0.0)]
            .map(|(x, y, z)| Vector3::new(size * x, size * y, z))
    };
    let robot = on_mesh(&plate(0.1, 2e-4), 1.0);
    let p = polygon(&robot, 0);
    assert_eq!(p.len(), 4);
    let normal = (p[1] - p[0]).cross(&(p[2] - p[0])).normalize();
    // Rounding of coordinates of size 0.1.
    assert!(normal.dot(&(p[3] - p[0])).abs() < 1e-16, "{p:?}");
    assert!(p.iter().zip(plate(0.1, 2e-4)).all(|(a, _)| a.z.abs() < 2e-4), "{p:?}");
    assert!(robot.notices.iter().any(|n| n.message.contains("mm onto one plane")), "{:?}", robot.notices);
    // 2 cm below a robot of 1 m.
    assert_eq!(polygon(&on_mesh(&plate(0.01, 0.0), 1.0), 0).len(), 1);
    // 10 cm by 5 mm: a line.
    let blade = [(0.05, 0.002), (-0.05, 0.002), (-0.05, -0.002), (0.05, -0.002)].map(|(x, y)| Vector3::new(x, y, 0.0));
    assert_eq!(polygon(&on_mesh(&blade, 1.0), 0).len(), 2);
}

/// A slab with a rounded top of very many vertices; the time of its hull grows as their square.
#[test]
fn the_sole_of_a_mesh_of_many_vertices_is_its_lowest_face() {
    let (n, half) = (200, 0.1);
    let mut obj = String::new();
    for (x, y) in [(-half, -half), (half, -half), (half, half), (-half, half)] {
        obj += &format!("v {x} {y} -0.05\n");
    }
    obj += "f 1 3 2\nf 1 4 3\n";
    for i in 0..n {
        for j in 0..n {
            // On the sphere about (0, 0, -0.5) with radius 0.6, so all are on the hull.
            let (x, y) = (half * (2 * i + 1 - n) as f64 / n as f64, half * (2 * j + 1 - n) as f64 / n as f64);
            obj += &format!("v {x} {y} {}\n", (0.36 - x * x - y * y).sqrt() - 0.5);
        }
    }
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let corner = |i: i32, j: i32| 5 + i * n + j;
            obj += &format!("f {} {} {}\n", corner(i, j), corner(i + 1, j), corner(i, j + 1));
        }
    }
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}<collision><geometry><mesh filename=\"m.obj\"/></geometry></collision></link></robot>"
    );
    let folder = super::folder(&[("r.urdf", &text), ("m.obj", &obj)]);
    let robot = stiction::robot::load(&folder.path().join("r.urdf")).unwrap();
    let [sole] = &robot.model.soles[..] else { panic!("{:?}", robot.notices) };
    // The OBJ reader keeps 24 bits: rounding to micrometres.
    let mut found: Vec<[f64; 3]> = sole.vertices.iter().map(|v| (*v).map(|x| (x * 1e6).round() / 1e6).into()).collect();
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(found, [[-half, -half, -0.05], [-half, half, -0.05], [half, -half, -0.05], [half, half, -0.05]]);
}

#[test]
fn a_foot_tilted_at_home_gives_its_whole_face() {
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
fn only_leaves_at_the_lowest_height_have_soles() {
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
