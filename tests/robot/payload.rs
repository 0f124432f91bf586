//! Payloads that a robot file welds to links.

use crate::support::runs::simulation;
use nalgebra::{Point3, Vector3};
use stiction::robot::Geometry;
use stiction::robot::adjustments::add_payload;

use super::{BODY, assert_fault, load_toml};

fn urdf() -> String {
    format!(
        r#"<robot name="r"><link name="base">{BODY}</link>
<joint name="knee" type="revolute"><origin xyz="0 0 -0.3" rpy="0.1 0.2 0.3"/><parent link="base"/><child link="foot"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint><link name="foot">{BODY}</link></robot>"#
    )
}

const PLAIN: &str = "urdf = \"robot.urdf\"\nsole = []\n";
const LOADED: &str = r#"urdf = "robot.urdf"
sole = []
[[payload]]
name = "box"
link = "foot"
mass = 3.0
position = [0.1, 0.2, 0.3]
size = [0.2, 0.4, 0.6]
"#;

#[test]
fn a_box_has_the_inertia_of_a_box_and_a_visual() {
    let loaded = load_toml(LOADED, &urdf()).unwrap().model;
    let mut by_hand = load_toml(PLAIN, &urdf()).unwrap().model;
    // 3 kg / 12 = 0.25 kg, times sums of squared edges.
    let inertia = [0.25 * (0.16 + 0.36), 0.25 * (0.04 + 0.36), 0.25 * (0.04 + 0.16), 0.0, 0.0, 0.0];
    add_payload(&mut by_hand, "foot", 3.0, Vector3::new(0.1, 0.2, 0.3), inertia).unwrap();
    let (foot, expected) = (&loaded.links[1], &by_hand.links[1]);
    assert_eq!(foot.mass, 4.0);
    // Rounding.
    assert!((foot.com - expected.com).norm() < 1e-15 && (foot.inertia - expected.inertia).norm() < 1e-14);
    let [shape] = &foot.visuals[..] else { panic!("{:?}", foot.visuals) };
    assert_eq!(shape.geometry, Geometry::Box(Vector3::new(0.2, 0.4, 0.6)));
    let centre = foot.urdf_frame.inverse() * (shape.pose * Point3::origin());
    assert!((centre.coords - Vector3::new(0.1, 0.2, 0.3)).norm() < 1e-15, "{centre}");
    assert_eq!(loaded.links[0], by_hand.links[0]);
}

#[test]
fn a_payload_may_give_an_inertia_or_be_a_point_mass() {
    let size = "size = [0.2, 0.4, 0.6]\n";
    let point = load_toml(&LOADED.replace(size, ""), &urdf()).unwrap().model;
    let given = "inertia = [0.13, 0.1, 0.05, 0, 0, 0]\n";
    let given = load_toml(&LOADED.replace(size, given), &urdf()).unwrap().model;
    let boxed = load_toml(LOADED, &urdf()).unwrap().model;
    assert!((given.links[1].inertia - boxed.links[1].inertia).norm() < 1e-14);
    assert!(point.links[1].visuals.is_empty() && given.links[1].visuals.is_empty());
    // The point mass lacks the box's own tensor, of trace 0.28.
    let lacking = boxed.links[1].inertia.trace() - point.links[1].inertia.trace();
    assert!((lacking - 0.28).abs() < 1e-14, "{lacking}");
}

const CASES: &[(&str, &str, usize, &str)] = &[
    ("link = \"foot\"", "link = \"foo\"", 5, "did you mean `foot`?"),
    ("mass = 3.0", "mass = 0.0", 6, "mass of the payload"),
    (
        "mass = 3.0",
        "mass = 3.0\n[[payload]]\nname = \"box\"\nlink = \"foot\"\nmass = 3.0",
        7,
        "there are two payloads named `box`",
    ),
    ("mass = 3.0", "mas = 3.0", 6, "did you mean `mass`?"),
    ("[0.1, 0.2, 0.3]", "[0.1, inf, 0.3]", 7, "position of the payload"),
    ("[0.2, 0.4, 0.6]", "[0.2, 0.0, 0.6]", 8, "size of the payload on link"),
    ("size = [0.2, 0.4, 0.6]", "inertia = [1, 1, 3, 0, 0, 0]", 8, "inertia of the payload"),
    (
        "size = [0.2, 0.4, 0.6]",
        "inertia = [1, 1, 1, 0, 0, 0]\nsize = [1, 1, 1]",
        9,
        "payload `box` has both `inertia` and `size`",
    ),
];

#[test]
fn each_error_is_reported_with_its_line() {
    for &(from, to, line, needle) in CASES {
        assert!(LOADED.contains(from), "`{from}` is not in the file: the case tests nothing");
        let case = format!("{from} -> {to}");
        assert_fault(&case, load_toml(&LOADED.replacen(from, to, 1), &urdf()), "robot.toml", line, needle);
    }
}

/// A payload of a robot file has the same effect in a scenario.
#[test]
fn a_scenario_accepts_the_payloads_of_a_robot_file() {
    let block = |payload: &str| {
        let text = format!("duration = 1\n[robot]\nmodel = \"robots/block/block.toml\"\npayload = [{payload}]\n");
        simulation(&text).plant().model.links[0].clone()
    };
    let load = "link = \"block\", mass = 1.2, position = [0, 0.1, 0.2]";
    let sized = block(&format!("{{ name = \"box\", {load}, size = [0.1, 0.2, 0.3] }}"));
    // m (b^2 + c^2) / 12 and so on.
    let given = block(&format!("{{ {load}, inertia = [0.013, 0.01, 0.005, 0, 0, 0] }}"));
    assert!((sized.inertia - given.inertia).amax() < 1e-16 && sized.mass == given.mass, "{}", sized.inertia);
    assert_eq!(sized.visuals.len(), given.visuals.len() + 1, "it is drawn");
}
