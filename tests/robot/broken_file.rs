//! Robot files with one error each.

use super::{BODY, assert_fault, load_toml};
use nalgebra::{Rotation3, Vector3};

fn urdf() -> String {
    format!(
        r#"<robot name="r"><link name="base">{BODY}</link>
<joint name="knee" type="revolute"><parent link="base"/><child link="foot"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint><link name="foot">{BODY}</link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint><link name="cart">{BODY}</link></robot>"#
    )
}

const GOOD: &str = r#"urdf = "robot.urdf"
base = "floating"
[home]
knee = "20 deg"
[[sole]]
name = "s"
link = "foot"
polygon = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
[joint.knee]
mode = "position"
kp = 10.0
kd = 1.0
[joint_default]
mode = "passive"
"#;

const CASES: &[(&str, &str, usize, &str)] = &[
    ("urdf = \"robot.urdf\"", "urdf = \"robot.urdf", 1, "invalid basic string"),
    ("urdf = \"robot.urdf\"", "urdf = \"none.urdf\"", 1, "none.urdf"),
    ("urdf = \"robot.urdf\"", "urdf = 1979-05-27", 1, "the date or time 1979-05-27, expected a string"),
    ("base = \"floating\"", "urdf = \"other.urdf\"", 2, "the first is on line 1; keep one of them"),
    ("base = \"floating\"", "base = \"floating\"\nbase = \"fixed\"", 3, "duplicate key `base`"),
    ("urdf = \"robot.urdf\"\n", "", 1, "the robot file names no model"),
    ("base = \"floating\"", "bas = \"floating\"", 2, "did you mean `base`?"),
    ("base = \"floating\"", "base = \"flying\"", 2, "unknown variant `flying`"),
    ("knee = \"20 deg\"", "kne = \"20 deg\"", 4, "did you mean `knee`?"),
    ("knee = \"20 deg\"", "knee = \"20 grad\"", 4, "such as \"30 deg\""),
    ("knee = \"20 deg\"", "knee = nan", 4, "a finite number of radians"),
    ("knee = \"20 deg\"", "knee = \"90 deg\"", 4, "outside the joint's limits: 1.57"),
    ("knee = \"20 deg\"", "slide = \"20 deg\"", 4, "joint `slide` is prismatic"),
    ("link = \"foot\"", "link = \"foo\"", 7, "did you mean `foot`?"),
    ("[0, 1, 0]]", "[0, 1, 0.1]]", 8, "sole `s`: it is not flat"),
    ("[1, 1, 0], [0, 1, 0]]", "[0, 1, 0], [1, 1, 0]]", 8, "not in order"),
    ("[1, 1, 0], [0, 1, 0]]", "[0.2, 0.2, 0], [0, 1, 0]]", 8, "not convex"),
    ("[1, 1, 0], [0, 1, 0]]", "[2, 0, 0], [0, 1, 0]]", 8, "point 1 lies on the line"),
    ("[1, 1, 0], [0, 1, 0]]", "[1, 0, 0], [0, 1, 0]]", 8, "points 1 and 2 coincide"),
    ("[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]", "[]", 8, "it has no points"),
    ("[[0, 0, 0]", "[[0, inf, 0]", 8, "point 0 is not finite"),
    ("[[0, 0, 0]", "[[0, 0]", 8, "array of length 3"),
    ("[joint.knee]", "[joint.nee]", 9, "did you mean `knee`?"),
    (
        "[joint.knee]\n",
        "[[sole]]\nname = \"s\"\nlink = \"base\"\npolygon = [[0, 0, 0]]\n[joint.knee]\n",
        9,
        "two soles named `s`",
    ),
    ("kp = 10.0", "lag = -0.1", 11, "lag of joint `knee` cannot be used: -0.1"),
    ("mode = \"position\"\nkp = 10.0\nkd = 1.0", "mode = \"velocity\"\nkd = 0.0", 9, "velocity drive of joint `knee`"),
    ("mode = \"position\"", "mode = \"positon\"", 10, "did you mean `position`?"),
    ("kp = 10.0", "kq = 10.0", 11, "did you mean `kp`?"),
    ("kp = 10.0", "kp = -10.0", 11, "kp of joint `knee` cannot be used: -10"),
    ("kp = 10.0", "kp = nan", 11, "kp of joint `knee` cannot be used"),
    ("kp = 10.0\n", "", 9, "position drive of joint `knee`"),
    ("kd = 1.0", "friction = { coulomb = 1.0, viscos = 1.0 }", 12, "did you mean `viscous`?"),
    ("kd = 1.0", "friction = { coulomb = -1.0 }", 12, "friction.coulomb of joint `knee`"),
    ("kd = 1.0", "friction = { coulomb = 1.0, static = 0.5 }", 9, "at least friction.coulomb, 1"),
    ("kd = 1.0", "friction = { slip_velocity = 0.0 }", 12, "friction.slip_velocity of joint `knee`"),
    ("kd = 1.0", "stop = { stiffness = 0.0 }", 12, "stop.stiffness of joint `knee`"),
    ("kd = 1.0", "stop = { damping = 1.0 }", 12, "missing field `stiffness`"),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[[end_effector]]\nname = \"tip\"\nlink = \"fot\"",
        17,
        "did you mean `foot`?",
    ),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[self_collision]\nignore = [[\"foot\", \"bas\"]]",
        16,
        "did you mean `base`?",
    ),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[self_collision]\nbodies = [\"foot\"]",
        16,
        "link `foot` has no collision shapes",
    ),
    ("mode = \"passive\"", "mode = \"passive\"\n[self_collision]\nwatch = [[\"foot\", \"foot\"]]", 16, "are one body"),
    ("mode = \"passive\"", "mode = \"passive\"\n[self_collision]\nresolution = 7", 16, "8 to 128"),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[sensors]\nimu = [{ name = \"i\", link = \"torso\" }]",
        16,
        "unknown link",
    ),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[sensors]\nimu = [{ name = \"i\", link = \"foot\" }, { name = \"i\", link = \"cart\" }]",
        16,
        "there are two IMUs named `i`",
    ),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[sensors]\nimu = [{ name = \"i\", link = \"foot\", position = [0, nan, 0] }]",
        16,
        "position of IMU `i` is not finite",
    ),
    (
        "mode = \"passive\"",
        "mode = \"passive\"\n[sensors]\nimu = [{ name = \"i\", lnk = \"foot\" }]",
        16,
        "did you mean `link`?",
    ),
    ("[home]", "kinematic = [\"eye_*\"]\n[home]", 3, "no moving joint of the URDF matches `eye_*`"),
    ("[home]", "kinematic = [\"sl*\", \"kne\"]\n[home]", 3, "did you mean `knee`?"),
    ("[home]", "kinematic = [\"k*\"]\n[home]", 11, "joint `knee` is matched by `k*` of `kinematic`"),
];

#[test]
fn the_file_without_errors_loads() {
    let robot = load_toml(GOOD, &urdf()).unwrap();
    assert_eq!(robot.files.len(), 2);
    assert!(robot.files[0].0.ends_with("robot.toml") && robot.files[1].0.ends_with("robot.urdf"));
    assert_eq!(robot.files[0].1, GOOD.as_bytes());
    assert_eq!(robot.model.home, [20f64.to_radians(), 0.0]);
}

#[test]
fn each_error_is_reported_with_its_line() {
    for &(from, to, line, needle) in CASES {
        assert!(GOOD.contains(from), "`{from}` is not in the file: the case tests nothing");
        let case = format!("{from} -> {to}");
        assert_fault(&case, load_toml(&GOOD.replacen(from, to, 1), &urdf()), "robot.toml", line, needle);
    }
}

#[test]
fn joint_default_fills_values_that_a_joint_omits() {
    use stiction::robot::DriveMode;
    let text = "urdf = \"robot.urdf\"\n[joint_default]\nkp = 7.0\nkd = 1.0\n[joint.knee]\nkd = 2.0\nfriction = { coulomb = 0.5 }\n";
    let robot = load_toml(text, &urdf()).unwrap();
    let [knee, slide] = &robot.model.joints[..] else { panic!() };
    assert_eq!((knee.drive.mode, knee.drive.kp, knee.drive.kd), (DriveMode::Position, 7.0, 2.0));
    assert_eq!((slide.drive.mode, slide.drive.kp, slide.drive.kd), (DriveMode::Position, 7.0, 1.0));
    assert_eq!((knee.friction, slide.friction), (0.5, 0.0));
    assert!(knee.drive_configured && slide.drive_configured);
    let plain = load_toml("urdf = \"robot.urdf\"\n[joint.knee]\narmature = 0.1\n", &urdf()).unwrap();
    assert!(!plain.model.joints[0].drive_configured);
    assert_eq!(plain.model.joints[0].armature, 0.1);
}

/// With no joints, nothing else would check the table.
#[test]
fn joint_default_is_checked_even_without_joints() {
    let alone = format!("<robot name=\"r\"><link name=\"base\">{BODY}</link></robot>");
    for (key, needle) in [
        ("stop = { stiffness = 0 }", "stop.stiffness of joint_default cannot be used: 0"),
        ("stop = { stiffness = 1, damping = -1 }", "stop.damping of joint_default"),
        ("friction = { slip_velocity = 0.0 }", "friction.slip_velocity of joint_default"),
        ("friction = { stribeck_velocity = 0.0 }", "friction.stribeck_velocity of joint_default"),
        ("armature = -1", "armature of joint_default"),
    ] {
        let text = format!("urdf = \"robot.urdf\"\n[joint_default]\n{key}\n");
        for (of, urdf) in [("no joints", &alone), ("two joints", &urdf())] {
            assert_fault(&format!("{key}, {of}"), load_toml(&text, urdf), "robot.toml", 3, needle);
        }
    }
    load_toml("urdf = \"robot.urdf\"\n[joint_default]\nstop = { stiffness = 1 }\n", &alone).unwrap();
}

#[test]
fn end_effectors_are_frames_of_their_links() {
    let two = "[[end_effector]]\nname = \"tip\"\nlink = \"foot\"\nposition = [0.1, 0.2, 0.3]\nrpy = [\"90 deg\", 0, 0.5]\n\
               [[end_effector]]\nname = \"root\"\nlink = \"base\"\n";
    let robot = load_toml(&format!("{GOOD}{two}"), &urdf()).unwrap();
    let model = &robot.model;
    let [tip, root] = &model.end_effectors[..] else { panic!("{:?}", model.end_effectors) };
    assert_eq!((tip.name.as_str(), root.name.as_str(), model.end_effector("root")), ("tip", "root", Some(1)));
    let (link, frame) = model.link("foot").unwrap();
    assert_eq!(tip.link, link);
    // In the link's own frame: at the given position, rotated about fixed axes x y z.
    let own = frame.inverse() * tip.pose;
    assert!((own.translation.vector - Vector3::new(0.1, 0.2, 0.3)).norm() < 1e-15);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.5)
        * Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    assert!((own.rotation.to_rotation_matrix().matrix() - turn.matrix()).norm() < 1e-15);
    let twice = format!("{GOOD}{two}[[end_effector]]\nname = \"tip\"\nlink = \"base\"\n");
    let error = load_toml(&twice, &urdf()).unwrap_err().to_string();
    assert!(error.contains("two end effectors named `tip`"), "{error}");
}

#[test]
fn imus_are_frames_of_their_links_and_are_listed() {
    let more = "[sensors]\nimu = [{ name = \"head\", link = \"cart\" },\n\
                { name = \"leg\", link = \"foot\", position = [0.1, 0.2, 0.3], rpy = [\"90 deg\", 0, 0.5] }]\n";
    let robot = load_toml(&format!("{GOOD}{more}"), &urdf()).unwrap();
    let [head, leg] = &robot.model.sensors.imu[..] else { panic!("{:?}", robot.model.sensors) };
    assert_eq!((head.name.as_str(), leg.name.as_str()), ("head", "leg"));
    let (link, frame) = robot.model.link("foot").unwrap();
    assert_eq!(leg.mount.link, link);
    let own = frame.inverse() * leg.mount.pose;
    assert!((own.translation.vector - Vector3::new(0.1, 0.2, 0.3)).norm() < 1e-15);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.5)
        * Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    assert!((own.rotation.to_rotation_matrix().matrix() - turn.matrix()).norm() < 1e-15);
    assert!(robot.notices.is_empty(), "{:?}", robot.notices);
    let shown = stiction::robot::inspect(&robot);
    assert!(shown.contains("frames (2)") && shown.contains("IMU leg"), "{shown}");
    assert!(shown.contains("on foot: [0.1 0.2 0.3], rpy [1.5708 0 0.5]"), "{shown}");
}

#[test]
fn force_sensors_are_accepted_only_on_links_with_a_sole() {
    let more = "[sensors]\nforce = [{ name = \"a\", link = \"foot\", position = [0, 0, 0.1] },\n\
                { name = \"b\", link = \"foot\" },\n{ name = \"c\", link = \"base\" }]\n";
    let robot = load_toml(&format!("{GOOD}{more}"), &urdf()).unwrap();
    let notice: Vec<String> = robot.notices.iter().map(ToString::to_string).collect();
    assert_eq!(notice.len(), 2, "{notice:?}");
    assert!(
        notice[0].contains("`b` is not read: `a` is on the same link") && robot.notices[0].line() == 17,
        "{notice:?}"
    );
    assert!(
        notice[1].contains("`c` is not read: link `base` has no sole") && robot.notices[1].line() == 18,
        "{notice:?}"
    );
    assert!(stiction::robot::inspect(&robot).contains("force sensor a"));
}

#[test]
fn the_schema_knows_every_key() {
    let schema = stiction::robot::schema();
    let properties = schema["properties"].as_object().unwrap();
    for key in [
        "model",
        "urdf",
        "base",
        "home",
        "sole",
        "joint",
        "joint_default",
        "payload",
        "kinematic",
        "end_effector",
        "sensors",
        "self_collision",
    ] {
        assert!(properties.contains_key(key), "{key}");
    }
    assert_eq!(schema["additionalProperties"], false);
    // One of `model` and `urdf` is required, which the loader checks.
    assert_eq!(schema["required"], serde_json::Value::Null);
}
