//! What an MJCF file becomes: links, joints, drives, couplings, loops, sensors and notices.

use nalgebra::Vector3;
use stiction::convert::description;
use stiction::robot::{Base, DriveMode, JointKind, LoopKind, Robot, load};

use super::{assert_fault, folder, load_mjcf, load_toml};

fn model(name: &str) -> Robot {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/robot/mjcf").join(name);
    load(&path).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

fn notice(robot: &Robot, needle: &str) -> bool {
    robot.notices.iter().any(|n| n.message.contains(needle))
}

/// A body with a hinge in each of two directions and the elements given.
fn two_hinges(rest: &str) -> String {
    format!(
        "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"a\"><joint name=\"x\" ref=\"0.5\"/><geom \
         size=\"0.1\" pos=\"1 0 0\"/><body name=\"b\" pos=\"1 0 0\"><joint name=\"y\" axis=\"0 1 0\"/><geom \
         size=\"0.1\" \
         pos=\"1 0 0\"/></body></body></worldbody>{rest}</mujoco>"
    )
}

#[test]
fn actuators_become_drives_and_effort_limits() {
    let robot = model("arm.xml");
    let joint = |name: &str| &robot.model.joints[robot.model.joint(name).unwrap().0];
    // A motor of gear 20 and controls up to 1.
    assert_eq!((joint("lift").drive.mode, joint("lift").effort_limit), (DriveMode::Force, 20.0));
    assert!(!joint("lift").drive_configured);
    // Gains at the joint are those of the actuator by the square of the gear.
    assert_eq!((joint("turn").drive.mode, joint("turn").drive.kp), (DriveMode::Position, 120.0));
    assert_eq!((joint("elbow").drive.kp, joint("elbow").drive.kd, joint("elbow").effort_limit), (11.0, 2.0, 6.0));
    assert_eq!((joint("wrist 1").drive.kp, joint("wrist 1").drive.kd), (5.0, 0.4));
    assert_eq!((joint("wrist 2").drive.mode, joint("wrist 2").drive.kd), (DriveMode::Velocity, 1.5));
    assert_eq!(joint("wrist 2").effort_limit, 4.0);
    assert_eq!((joint("follower").drive.mode, joint("follower").lag), (DriveMode::Force, 0.05));
}

#[test]
fn a_position_and_a_velocity_servo_of_one_joint_are_one() {
    let robot = load_mjcf(&two_hinges(
        "<actuator><position joint=\"x\" kp=\"7\"/><velocity joint=\"x\" kv=\"2\"/><motor joint=\"x\"/>\
         <intvelocity joint=\"y\"/><position site=\"s\"/></actuator>",
    ))
    .unwrap();
    let [x, y] = &robot.model.joints[..] else { panic!() };
    assert_eq!((x.drive.mode, x.drive.kp, x.drive.kd), (DriveMode::Position, 7.0, 2.0));
    assert_eq!((y.drive.mode, y.drive_configured), (DriveMode::Passive, true));
    for needle in ["a joint has two actuators", "<intvelocity> are ignored", "actuators on a site"] {
        assert!(notice(&robot, needle), "{needle}");
    }
}

#[test]
fn references_shift_the_zero_of_a_joint() {
    let robot = load_mjcf(&two_hinges("")).unwrap();
    assert_eq!(robot.model.home, [0.5, 0.0]);
    // At 0 the body is turned back by the reference.
    let x = robot.model.links[1].rotation * Vector3::x();
    assert!((x - Vector3::new(0.5f64.cos(), -0.5f64.sin(), 0.0)).norm() < 1e-15, "{x}");
}

#[test]
fn joint_equalities_become_couplings_in_powers_of_the_leader() {
    let equality = "<equality><joint joint1=\"y\" joint2=\"x\" polycoef=\"0.1 2\"/></equality>";
    let robot = load_mjcf(&two_hinges(equality)).unwrap();
    // y = 0.1 + 2 (x - 0.5).
    let [coupling] = &robot.model.couplings[..] else { panic!() };
    assert_eq!((coupling.joint.0, coupling.leader.0), (1, 0));
    assert!((coupling.coefficients[0] + 0.9).abs() < 1e-15 && coupling.coefficients[1] == 2.0);
    let ring = "<equality><joint joint1=\"y\" joint2=\"x\"/><joint joint1=\"x\" joint2=\"y\"/></equality>";
    let robot = load_mjcf(&two_hinges(ring)).unwrap();
    assert_eq!(robot.model.couplings.len(), 1);
    assert!(notice(&robot, "itself through others"));
    // A joint without another one is held, 0.1 from its reference; the home follows.
    let held = "<equality><joint joint1=\"x\" polycoef=\"0.1 7\"/><joint joint1=\"y\" joint2=\"x\"/></equality>";
    let robot = load_mjcf(&two_hinges(held)).unwrap();
    let [x, y] = &robot.model.couplings[..] else { panic!() };
    assert_eq!((x.joint, x.leader, x.coefficients), (x.joint, x.joint, [0.6, 0.0, 0.0, 0.0, 0.0]));
    assert_eq!((y.leader, robot.model.home.clone()), (x.joint, vec![0.6, 0.6 - 0.5]));
}

#[test]
fn connect_and_weld_become_loops_whose_frames_coincide_at_the_references() {
    let robot = model("arm.xml");
    let [ball, .., weld] = &robot.model.loops[..] else { panic!() };
    assert_eq!((ball.name.as_str(), ball.kind), ("loop", LoopKind::Ball));
    // The root of a fixed base stands for the world.
    assert_eq!((weld.name.as_str(), weld.kind, weld.other.map(|l| l.0)), ("to world", LoopKind::Weld, Some(0)));
    let robot = model("biped.xml");
    let [foot] = &robot.model.loops[..] else { panic!() };
    assert_eq!(foot.other, None);
    // The right foot is 0.1 m to the right of and 0.45 m below the trunk, which is 0.9 m up.
    assert!((foot.other_pose.translation.vector - Vector3::new(0.1, -0.1, 0.4)).norm() < 1e-12);
}

#[test]
fn ball_joints_are_chains_and_several_joints_of_a_body_too() {
    let robot = model("shapes.xml");
    let names: Vec<&str> = robot.model.joints.iter().map(|j| j.name.as_str()).collect();
    let first = ["ball/yaw", "ball/pitch", "ball/roll", "hinge", "joint2", "joint3"];
    assert_eq!(names[..6], first);
    assert_eq!(robot.model.base, Base::Fixed);
    let robot = model("arm.xml");
    let links: Vec<&str> = robot.model.links.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(links[..4], ["pedestal", "column/lift", "column", "upper arm"]);
    assert_eq!(robot.model.joints[0].kind, JointKind::Prismatic);
}

#[test]
fn the_robot_with_most_joints_is_read_and_the_others_are_reported() {
    let robot = model("biped.xml");
    assert_eq!((robot.model.base, robot.model.nj()), (Base::Floating, 5));
    let welded: Vec<&str> = robot.model.links[0].merged.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(welded, ["head", "antenna"]);
    for needle in ["body `ball` and what it carries are left out", "a body fixed to the world", "<tendon> is ignored"] {
        assert!(notice(&robot, needle), "{needle}");
    }
    // The key of all robots in the file: limits of the hip hold.
    assert_eq!(robot.model.home[1..], [0.1, -0.2, 0.3, -0.1]);
    assert!(notice(&robot, "position 10 of joint `left hip` is outside its range"));
    assert_eq!(robot.model.sensors.imu[0].name, "imu");
}

#[test]
fn pairs_that_are_excluded_are_not_checked() {
    let robot = model("arm.xml");
    let names = |pair: &[stiction::robot::LinkId; 2]| pair.map(|id| robot.model.links[id.0].name.clone());
    let pairs: Vec<[String; 2]> = robot.self_collision.ignore.iter().map(names).collect();
    assert_eq!(pairs, [["upper arm".to_owned(), "hand".to_owned()]]);
}

#[test]
fn geoms_without_contact_are_visual_and_hidden_ones_collide() {
    let robot = load_mjcf(
        "<mujoco><worldbody><body name=\"a\"><freejoint/><geom size=\"0.1\" group=\"3\"/><geom size=\"0.1\" \
         contype=\"0\" conaffinity=\"0\" mass=\"0\" rgba=\"1 0 0 1\"/><geom size=\"0.1\"/>\
         <geom type=\"ellipsoid\" size=\"1 2 3\" \
         contype=\"0\"/></body></worldbody></mujoco>",
    )
    .unwrap();
    let link = &robot.model.links[0];
    assert_eq!((link.visuals.len(), link.collisions.len()), (3, 3));
    assert_eq!(link.visuals[0].rgba, [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn equal_notices_are_counted() {
    let geoms = "<geom size=\"0.1\" friction=\"1 0 0\" later=\"1\"/>".repeat(200);
    let robot =
        load_mjcf(&format!("<mujoco><worldbody><body name=\"a\"><freejoint/>{geoms}</body></worldbody></mujoco>"));
    let robot = robot.unwrap();
    assert!(notice(&robot, "attribute `friction` of <geom> is ignored (200 times)"));
    assert!(notice(&robot, "unknown attribute `later` of <geom> is ignored (200 times)"));
    assert!(robot.notices.len() < 8, "{:?}", robot.notices);
}

#[test]
fn meshes_that_are_missing_matter_only_for_mass() {
    let text = |inertial: &str| {
        format!(
            "<mujoco>\n<asset><mesh name=\"m\" file=\"none.stl\"/></asset>\n<worldbody><body name=\"a\"><freejoint/>\n\
             <geom type=\"mesh\" mesh=\"m\"/>{inertial}</body></worldbody></mujoco>"
        )
    };
    let robot = load_mjcf(&text("<inertial mass=\"1\" pos=\"0 0 0\" diaginertia=\"1 1 1\"/>")).unwrap();
    assert!(notice(&robot, "mesh `m` cannot be read"));
    assert_fault("needed", load_mjcf(&text("")), "robot.xml", 4, "the mass of its geom is not known");
}

#[test]
fn included_files_are_relative_to_the_main_file_or_to_the_including_one() {
    let main = "<mujoco><include file=\"parts/all.xml\"/></mujoco>";
    let all = |name: &str| format!("<mujocoinclude><include file=\"{name}\"/></mujocoinclude>");
    let body = "<x><worldbody><body name=\"a\"><freejoint/><geom size=\"0.1\"/></body></worldbody></x>";
    for name in ["parts/body.xml", "body.xml", "../parts/body.xml"] {
        let folder = folder(&[("robot.xml", main), ("parts/all.xml", &all(name)), ("parts/body.xml", body)]);
        let robot = load(&folder.path().join("robot.xml")).unwrap_or_else(|e| panic!("{}", e.render(false)));
        assert_eq!(robot.files.len(), 3, "{name}");
    }
}

#[test]
fn attached_models_bring_their_meshes_and_must_have_the_same_settings() {
    let main = "<mujoco><compiler meshdir=\"assets\"/><asset>\n<model name=\"arm\" file=\"parts/arm.xml\"/></asset>\n\
                <worldbody><body name=\"a\"><freejoint/><geom size=\"0.1\"/>\n\
                <attach model=\"arm\" prefix=\"p\"/></body></worldbody></mujoco>";
    let arm = |settings: &str, rest: &str| {
        format!(
            "<mujoco><compiler meshdir=\"meshes\" {settings}/><asset><mesh file=\"t.obj\"/>{rest}</asset><worldbody>\
             <body name=\"b\"><joint/><geom type=\"mesh\" mesh=\"t\"/></body>\
             <attach model=\"x\" prefix=\"q\"/></worldbody></mujoco>"
        )
    };
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let read = |arm: &str| {
        let small = "<mujoco><worldbody><geom name=\"g\" size=\"0.1\"/></worldbody></mujoco>";
        let files = [("robot.xml", main), ("parts/arm.xml", arm), ("parts/meshes/t.obj", obj), ("parts/x.xml", small)];
        let folder = folder(&[&files[..], &[("assets/t.obj", "none")]].concat());
        load(&folder.path().join("robot.xml"))
    };
    let robot = read(&arm("", "<model file=\"x.xml\"/>")).unwrap_or_else(|e| panic!("{}", e.render(false)));
    let links: Vec<_> =
        robot.model.links.iter().map(|link| (link.name.as_str(), link.collisions.len(), link.merged.len())).collect();
    assert_eq!(links, [("a", 2, 0), ("pb", 1, 0)]);
    assert_eq!(robot.files.len(), 4);
    for (settings, rest, expected) in [
        ("angle=\"radian\"", "<model file=\"x.xml\"/>", "the attached model has another `angle` in <compiler>"),
        ("", "<model name=\"x\" file=\"../robot.xml\"/>", "`model` of <attach> cannot be used"),
    ] {
        let error = read(&arm(settings, rest)).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("arm.xml:1:"), "{error}");
    }
}

#[test]
fn robot_files_name_a_model_by_one_of_two_keys() {
    let mjcf = "<mujoco><worldbody><body name=\"a\"><freejoint/><geom size=\"0.1\"/></body></worldbody></mujoco>";
    for key in ["model", "urdf"] {
        let folder = folder(&[("robot.toml", &format!("{key} = \"r.xml\"\nbase = \"fixed\"\n")), ("r.xml", mjcf)]);
        let robot = load(&folder.path().join("robot.toml")).unwrap();
        assert_eq!((robot.model.base, robot.model.links[0].name.as_str()), (Base::Fixed, "a"));
    }
    let both = "model = \"robot.urdf\"\nurdf = \"robot.urdf\"\n";
    assert_fault("both", load_toml(both, "<robot/>"), "robot.toml", 1, "exclude each other");
    assert_fault("none", load_toml("base = \"fixed\"\n", "<robot/>"), "robot.toml", 1, "names no model");
}

#[test]
fn the_text_for_viewers_is_a_urdf_of_equal_mass_and_kinematics() {
    for name in ["arm.xml", "biped.xml", "shapes.xml"] {
        let robot = model(name);
        let again = super::load_urdf(&description(&robot.model)).unwrap_or_else(|e| panic!("{}", e.render(false)));
        assert!(again.model.joints.iter().map(|j| &j.name).eq(robot.model.joints.iter().map(|j| &j.name)));
        let mass = |robot: &Robot| robot.model.links[1..].iter().map(|l| l.mass).sum::<f64>();
        assert!((mass(&again) - mass(&robot)).abs() < 1e-9);
        let last = robot.model.links.last().unwrap();
        assert!(again.model.link(&last.name).is_some(), "{}", last.name);
    }
}
