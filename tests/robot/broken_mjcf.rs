//! MJCF files with one error each: the message must name the line and the cause.

use super::{assert_fault, folder, load_mjcf};
use stiction::robot::load;

const GOOD: &str = r#"<mujoco model="r">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <default class="c"><geom size="0.2"/></default>
  </default>
  <asset>
    <mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
  </asset>
  <worldbody>
    <body name="a" pos="0 0 1">
      <freejoint name="root"/>
      <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
      <site name="s"/>
      <body name="b" childclass="c">
        <joint name="j" axis="0 1 0" range="-1 1"/>
        <geom name="g" type="sphere"/>
        <geom type="mesh" mesh="m" mass="1"/>
      </body>
      <body name="d">
        <joint name="k" type="slide"/>
        <geom size="0.1" euler="1 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="j" kp="10"/></actuator>
  <equality>
    <joint joint1="j" joint2="k" polycoef="0 1"/>
    <connect body1="b" body2="d" anchor="0 0 0"/>
  </equality>
  <sensor><gyro site="s"/></sensor>
  <contact><exclude body1="b" body2="d"/></contact>
  <keyframe><key name="home" qpos="0 0 1 1 0 0 0 0.5 0"/></keyframe>
</mujoco>
"#;

/// Text, its replacement, the line that the error must name, text that the message must contain.
const CASES: &[(&str, &str, usize, &str)] = &[
    ("</sensor>", "</sensors>", 30, "not well-formed"),
    ("angle=\"radian\"", "angle=\"radians\"", 2, "did you mean `radian`"),
    ("angle=\"radian\"", "eulerseq=\"xyq\"", 2, "three letters of xyzXYZ"),
    ("angle=\"radian\"", "coordinate=\"global\"", 2, "local coordinates"),
    ("angle=\"radian\"", "boundmass=\"-1\"", 2, "not negative"),
    ("angle=\"radian\"", "angel=\"radian\"", 2, "did you mean `angle`"),
    ("<default class=\"c\">", "<default>", 4, "lacks the attribute `class`"),
    ("<default class=\"c\">", "<default class=\"main\">", 4, "two default classes"),
    ("childclass=\"c\"", "childclass=\"cc\"", 14, "did you mean `c`"),
    ("vertex=\"0 0 0 1", "vertex=\"0 0 1", 7, "`vertex` of mesh `m` cannot be used"),
    ("vertex=\"0 0 0 1", "inertia=\"convx\" vertex=\"0 0 0 1", 7, "did you mean `convex`"),
    ("name=\"m\" vertex", "vertex", 7, "lacks the attribute `name`"),
    ("pos=\"0 0 1\"", "pos=\"0 0\"", 10, "3 finite numbers"),
    ("pos=\"0 0 1\"", "pos=\"0 nan 1\"", 10, "3 finite numbers"),
    ("pos=\"0 0 1\"", "pos=\"0 0 1e300\"", 10, "3 finite numbers"),
    ("pos=\"0 0 1\"", "quat=\"0 0 0 0\"", 10, "a direction of length above 0"),
    ("pos=\"0 0 1\"", "quat=\"1 0 0 0\" euler=\"0 0 0\"", 10, "has two orientations, `quat` and `euler`"),
    ("pos=\"0 0 1\"", "xyaxes=\"1 0 0 2 0 0\"", 10, "a direction of length above 0"),
    ("name=\"b\"", "name=\"a\"", 14, "there are two bodies named `a`"),
    ("name=\"b\"", "name=\"world\"", 14, "`world` is the name of the world"),
    ("name=\"k\"", "name=\"j\"", 20, "there are two joints named `j`"),
    ("mass=\"1\" pos", "pos", 12, "lacks the attribute `mass`"),
    ("mass=\"1\" pos", "mass=\"-1\" pos", 12, "a mass in kg"),
    ("<inertial mass=\"1\" pos=\"0 0 0\"", "<inertial mass=\"1\"", 12, "lacks the attribute `pos`"),
    ("diaginertia=\"1 1 1\"", "diaginertia=\"1 1 3\"", 12, "breaks the triangle inequality"),
    ("diaginertia=\"1 1 1\"", "diaginertia=\"-1 1 1\"", 12, "is not positive definite"),
    ("diaginertia=\"1 1 1\"", "fullinertia=\"1 1 1 0 0 0\" euler=\"0 0 0\"", 12, "exclude each other"),
    ("<site name=\"s\"/>", "<inertial mass=\"1\" pos=\"0 0 0\"/>", 13, "body `a` has two <inertial>"),
    ("<site name=\"s\"/>", "<sitee name=\"s\"/>", 13, "did you mean `site`"),
    ("<site name=\"s\"/>", "<attach model=\"m\" body=\"b\" prefix=\"p\"/>", 13, "`model` of <attach> cannot be used"),
    ("<site name=\"s\"/>", "<replicate offset=\"1 0 0\"/>", 13, "<replicate> lacks the attribute `count`"),
    ("<site name=\"s\"/>", "<replicate count=\"0.5\"/>", 13, "`count` of <replicate> cannot be used"),
    ("<site name=\"s\"/>", "<replicate count=\"2\" offsets=\"1 0 0\"/>", 13, "<replicate> has no attribute `offsets`"),
    ("axis=\"0 1 0\"", "axis=\"0 0 0\"", 15, "a direction of length above 0"),
    ("range=\"-1 1\"", "range=\"1 -1\"", 15, "the first below the second"),
    ("range=\"-1 1\"", "damping=\"-1\"", 15, "not negative"),
    ("range=\"-1 1\"", "type=\"hing\"", 15, "did you mean `hinge`"),
    ("range=\"-1 1\"", "type=\"free\"", 15, "a free joint below another body"),
    ("range=\"-1 1\"", "rang=\"-1 1\"", 15, "did you mean `range`"),
    ("name=\"g\" type=\"sphere\"", "type=\"capsule\"", 4, "2 numbers above 0"),
    ("name=\"g\" type=\"sphere\"", "size=\"-1\"", 16, "1 numbers above 0"),
    ("name=\"g\" type=\"sphere\"", "type=\"sphere\" mass=\"-1\"", 16, "not negative"),
    ("mesh=\"m\" mass", "mesh=\"mm\" mass", 17, "did you mean `m`"),
    ("mesh=\"m\" mass", "mass", 17, "lacks the attribute `mesh`"),
    ("        <geom size=\"0.1\" euler=\"1 0 0\"/>\n", "", 20, "link `d` moves but has no mass"),
    ("<position joint=\"j\"", "<position joint=\"jj\"", 25, "did you mean `j`"),
    ("kp=\"10\"", "kp=\"1,0\"", 25, "a finite number"),
    ("joint2=\"k\"", "joint2=\"q\"", 27, "the name of a hinge or slide"),
    ("joint2=\"k\"", "joint2=\"j\"", 27, "another joint than joint1"),
    ("body2=\"d\" anchor=\"0 0 0\"", "body2=\"d\"", 28, "lacks the attribute `anchor`"),
    ("<connect body1=\"b\"", "<connect body1=\"bb\"", 28, "did you mean `b`"),
    ("<gyro site=\"s\"/>", "<gyro site=\"t\"/>", 30, "did you mean `s`"),
    ("<exclude body1=\"b\"", "<exclude body1=\"x\"", 31, "the name of a body"),
    ("0.5 0\"", "0.5\"", 32, "9 finite numbers"),
    ("<sensor>", "<senser>", 30, "not well-formed"),
];

#[test]
fn the_file_without_errors_loads() {
    let robot = load_mjcf(GOOD).unwrap_or_else(|e| panic!("{}", e.render(false)));
    assert_eq!(robot.model.nv(), 8);
    // The key gives 0.5, but the joint follows the other one.
    assert_eq!(robot.model.home, [0.0, 0.0]);
    assert!(robot.notices.iter().any(|n| n.message.contains("joint `j` follows `k`: its home is 0, not 0.5")));
}

#[test]
fn each_error_is_reported_with_its_line() {
    for &(from, to, line, needle) in CASES {
        assert!(GOOD.contains(from), "`{from}` is not in the file: the case tests nothing");
        let case = format!("{from} -> {to}");
        assert_fault(&case, load_mjcf(&GOOD.replacen(from, to, 1)), "robot.xml", line, needle);
    }
}

#[test]
fn files_without_one_robot_are_refused() {
    let world = |bodies: &str| format!("<mujoco>\n<worldbody>\n{bodies}</worldbody>\n</mujoco>");
    let free = |name: &str| format!("<body name=\"{name}\"><freejoint/><geom size=\"1\"/></body>\n");
    assert_fault("none", load_mjcf(&world("")), "robot.xml", 2, "no robot: 0 bodies");
    let two = world(&(free("a") + &free("b")));
    assert_fault("two", load_mjcf(&two), "robot.xml", 4, "several robots with 0 joints: `a`, `b`");
    assert_fault("fragment", load_mjcf("<mujocoinclude/>"), "robot.xml", 1, "not an MJCF file");
}

#[test]
fn errors_of_included_files_name_these() {
    let main = |file: &str| format!("<mujoco>\n<include file=\"{file}\"/>\n</mujoco>");
    let load_with = |file: &str, text: &str| {
        let folder = folder(&[("robot.xml", &main(file)), ("a/part.xml", text)]);
        load(&folder.path().join("robot.xml"))
    };
    let body = "<mujocoinclude>\n<worldbody>\n<body name=\"x\" pos=\"1\"/>\n</worldbody>\n</mujocoinclude>";
    assert_fault("part", load_with("a/part.xml", body), "part.xml", 3, "3 finite numbers");
    assert_fault("missing", load_with("part.xml", body), "robot.xml", 2, "part.xml");
    assert_fault("absolute", load_with("/etc/passwd", body), "robot.xml", 2, "absolute path");
    // Paths are relative to the main file, then to the including one, as in MuJoCo.
    let ring = "<mujocoinclude>\n<include file=\"a/part.xml\"/></mujocoinclude>";
    assert_fault("ring", load_with("a/part.xml", ring), "part.xml", 2, "includes itself");
    assert_fault("itself", load_with("robot.xml", body), "robot.xml", 2, "includes itself");
}

#[test]
fn hostile_files_are_errors_not_crashes() {
    let nested =
        |n: usize| format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", "<body>".repeat(n), "</body>".repeat(n));
    assert!(load_mjcf(&nested(100_000)).unwrap_err().to_string().contains("nest too deeply"));
    assert!(load_mjcf(&nested(1000)).is_ok());
    let attributes: String = (0..5000).map(|i| format!(" a{i}=\"\"")).collect();
    assert!(load_mjcf(&format!("<mujoco{attributes}/>")).unwrap_err().to_string().contains("attributes"));
    for text in ["", "<", "<mujoco/>", "<mujoco><worldbody/></mujoco>", "<!DOCTYPE a><mujoco/>"] {
        assert!(load_mjcf(text).is_err(), "`{text}` loaded");
    }
}
