//! URDF files with one error each: the message must name the line and the cause.

use super::{assert_fault, load_urdf};

const GOOD: &str = r#"<robot name="r">
  <link name="a">
    <inertial>
      <mass value="1"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <joint name="j" type="revolute">
    <origin xyz="0 0 1" rpy="0 0 0"/>
    <parent link="a"/>
    <child link="b"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/>
  </joint>
  <link name="b">
    <inertial><mass value="2"/><inertia ixx="3" ixy="0" ixz="0" iyy="3" iyz="0" izz="3"/></inertial>
  </link>
</robot>
"#;

/// Text, its replacement, the line that the error must name, text that the message must contain.
const CASES: &[(&str, &str, usize, &str)] = &[
    ("<robot name=\"r\">", "<sdf name=\"r\">", 19, "not well-formed"),
    ("  </link>\n  <joint", "  </lnk>\n  <joint", 8, "not well-formed"),
    ("xyz=\"0 0 1\" rpy", "xyz=\"0,, 1\" rpy", 10, "3 finite numbers"),
    ("xyz=\"0 0 1\" rpy", "xyz=\"0, 1\" rpy", 10, "3 finite numbers"),
    ("effort=\"5\"", "effort=\"5,0\"", 14, "a finite number"),
    ("xyz=\"0 0 1\" rpy", "xyz=\"0 1 x 0\" rpy", 10, "3 finite numbers"),
    ("xyz=\"0 0 1\" rpy", "xyz=\"0 1\" rpy", 10, "3 finite numbers"),
    ("rpy=\"0 0 0\"", "rpy=\"0 nan 0\"", 10, "3 finite numbers"),
    ("lower=\"-1\"", "lower=\"-inf\"", 14, "a finite number"),
    ("xyz=\"0 0 1\" rpy", "xyz=\"0 0 ${h}\" rpy", 10, "xacro"),
    ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", 13, "axis of length 0"),
    ("<child link=\"b\"/>", "<child link=\"B\"/>", 12, "did you mean `b`"),
    ("<parent link=\"a\"/>", "<parent link=\"nobody\"/>", 11, "unknown parent link"),
    ("<child link=\"b\"/>", "", 9, "joint `j`: <joint> lacks <child>"),
    ("<parent link=\"a\"/>", "<parent link=\"b\"/>", 16, "the joints form a loop through the links `b`"),
    ("name=\"b\"", "name=\"a\"", 16, "there are two links named `a`"),
    ("</robot>", "<link name=\"c\"/></robot>", 19, "2 root links: `a`, `c`"),
    ("type=\"revolute\"", "type=\"spherical\"", 9, "joint `j`: spherical joints are not available"),
    ("type=\"revolute\"", "type=\"revolut\"", 9, "did you mean `revolute`"),
    ("lower=\"-1\" ", "", 14, "joint `j` has no lower limit"),
    ("upper=\"1\" ", "", 14, "joint `j` has no upper limit"),
    ("lower=\"-1\"", "lower=\"4\"", 14, "the lower limit is above the upper: 4 > 1"),
    ("effort=\"5\"", "effort=\"-5\"", 14, "not negative"),
    ("value=\"1\"", "value=\"-1\"", 4, "link `a`: `value` of <mass> cannot be used: `-1`"),
    ("value=\"1\"", "value=\"1e300\"", 4, "a mass in kg, not negative and at most 1e12"),
    ("<inertial><mass value=\"2\"/>", "<inertial><origin xyz=\"1e200 0 0\"/><mass value=\"2\"/>", 17, "at most 1e4"),
    ("<inertial><mass value=\"2\"/>", "<inertial>", 17, "<inertial> lacks <mass>"),
    ("iyy=\"1\" ", "", 5, "lacks the attribute `iyy`"),
    ("ixx=\"1\"", "ixx=\"-1\"", 5, "inertia of link `a` is not positive definite"),
    (
        "ixy=\"0\" ixz=\"0\" iyy=\"1\"",
        "ixy=\"2\" ixz=\"0\" iyy=\"1\"",
        5,
        "principal moments -1.000000e0, 1.000000e0, 3",
    ),
    ("izz=\"1\"", "izz=\"2.5\"", 5, "link `a` breaks the triangle inequality"),
    (
        "<inertial><mass value=\"2\"/><inertia ixx=\"3\" ixy=\"0\" ixz=\"0\" iyy=\"3\" iyz=\"0\" izz=\"3\"/></inertial>",
        "",
        16,
        "link `b` moves but has no mass",
    ),
    (
        "ixx=\"3\" ixy=\"0\" ixz=\"0\" iyy=\"3\" iyz=\"0\" izz=\"3\"",
        "ixx=\"3\" ixy=\"0\" ixz=\"0\" iyy=\"3\" iyz=\"0\" izz=\"0\"",
        17,
        "link `b` is not positive definite",
    ),
    ("size=\"1 1 1\"", "size=\"1 0 1\"", 7, "3 finite numbers above 0"),
    ("<box size=\"1 1 1\"/>", "<cone radius=\"1\"/>", 7, "<cone> is not a shape"),
    ("<box size=\"1 1 1\"/>", "<box size=\"1 1 1\"/><sphere radius=\"1\"/>", 7, "must hold one shape"),
    ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 1\"/><axis xyz=\"1 0 0\"/>", 13, "more than one <axis>"),
    ("name=\"j\" type", "name=\"j \" type", 9, "without spaces around it"),
];

#[test]
fn the_file_without_errors_loads() {
    let robot = load_urdf(GOOD).unwrap();
    assert_eq!(robot.model.nv(), 7);
}

#[test]
fn each_error_is_reported_with_its_line() {
    for &(from, to, line, needle) in CASES {
        assert!(GOOD.contains(from), "`{from}` is not in the file: the case tests nothing");
        let case = format!("{from} -> {to}");
        assert_fault(&case, load_urdf(&GOOD.replacen(from, to, 1)), "robot.urdf", line, needle);
    }
}

#[test]
fn a_root_element_other_than_robot_is_reported() {
    assert_fault("robots", load_urdf("<robots>\n</robots>"), "robot.urdf", 1, "not a URDF");
}

#[test]
fn loops_are_reported() {
    let joint = |name: &str, a: &str, b: &str| {
        format!("<joint name=\"{name}\" type=\"continuous\"><parent link=\"{a}\"/><child link=\"{b}\"/></joint>\n")
    };
    let links = "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n<link name=\"c\"/>\n<link name=\"d\"/>\n";
    let closed = [joint("1", "b", "c"), joint("2", "c", "d"), joint("3", "d", "b")].concat();
    let ring = format!("{links}{closed}</robot>");
    assert_fault(
        "a ring apart from the root",
        load_urdf(&ring),
        "robot.urdf",
        3,
        "a loop through the links `b`, `c`, `d`",
    );
    let all = format!("{links}{closed}{}{}</robot>", joint("4", "b", "a"), "");
    assert_fault("no root at all", load_urdf(&all), "robot.urdf", 2, "every link is moved by a joint");
    let diamond = [joint("1", "a", "b"), joint("2", "a", "c"), joint("3", "b", "d"), joint("4", "c", "d")].concat();
    let needle = "link `d` is the child of both joint `3` and joint `4`";
    assert_fault("a diamond", load_urdf(&format!("{links}{diamond}</robot>")), "robot.urdf", 9, needle);
}

#[test]
fn hostile_files_are_errors_not_crashes() {
    let deep = format!("<robot name=\"r\">{}{}</robot>", "<a>".repeat(200_000), "</a>".repeat(200_000));
    assert!(load_urdf(&deep).unwrap_err().to_string().contains("no links"));
    let long: String = (0..3000)
        .map(|i| {
            let joint = format!("<parent link=\"l{i}\"/><child link=\"l{}\"/>", i + 1);
            format!("<joint name=\"j{i}\" type=\"fixed\">{joint}</joint><link name=\"l{}\"/>", i + 1)
        })
        .collect();
    let chain = format!("<robot name=\"r\"><link name=\"l0\">{}</link>{long}</robot>", super::BODY);
    assert_eq!(load_urdf(&chain).unwrap().model.links[0].merged.len(), 3000);
    for text in ["", "<", "<robot/>", "<robot name=\"r\"/>", "\u{feff}<robot name=\"r\"/>", "<!DOCTYPE a><robot/>"] {
        assert!(load_urdf(text).is_err(), "`{text}` loaded");
    }
}
