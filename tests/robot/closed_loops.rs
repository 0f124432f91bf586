//! Closed loops of robot files.

use super::{BODY, load_toml};
use nalgebra::{Isometry3, Point3, Vector3};
use stiction::robot::{LinkId, LoopClosure, LoopKind, Model};

/// Two links on a floating root: `b` turns about z at (1, 0, 0), `c` about y at (0, 0, 1), and `e` is welded to `b`.
fn urdf() -> String {
    let joint = |name: &str, child: &str, xyz: &str, axis: &str| {
        format!(
            "<link name=\"{child}\">{BODY}</link><joint name=\"{name}\" type=\"continuous\"><parent link=\"a\"/>\
             <child link=\"{child}\"/><origin xyz=\"{xyz}\"/><axis xyz=\"{axis}\"/></joint>"
        )
    };
    format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link>{}{}<link name=\"e\"/><joint name=\"f\" type=\"fixed\">\
         <parent link=\"b\"/><child link=\"e\"/><origin xyz=\"0 0 0.5\"/></joint></robot>",
        joint("first", "b", "1 0 0", "0 0 1"),
        joint("second", "c", "0 0 1", "0 1 0")
    )
}

fn loops(more: &str) -> Model {
    load_toml(&format!("urdf = \"robot.urdf\"\n{more}"), &urdf()).unwrap().model
}

/// A frame of a loop in the URDF frame of its link.
fn in_urdf_frame(model: &Model, link: LinkId, pose: &Isometry3<f64>) -> Isometry3<f64> {
    model.links[link.0].urdf_frame.inverse() * pose
}

#[test]
fn frames_left_out_are_those_of_the_home_posture() {
    let model = loops(
        "home = { first = \"90 deg\" }\n[[loop]]\nname = \"l\"\ntype = \"pin\"\nlink = \"e\"\nposition = [0.2, 0, 0]\n\
         axis = [0, 0, 2]\nto = \"c\"",
    );
    let LoopClosure { name, kind, link, pose, other, other_pose } = &model.loops[0];
    assert_eq!((name.as_str(), *kind, *link, *other), ("l", LoopKind::Pin, LinkId(1), Some(LinkId(2))));
    // Welded 0.5 m above b, and 0.2 m along its x: (1, 0.2, 0.5) after the quarter turn, (1, 0.2, -0.5) from c.
    let first = in_urdf_frame(&model, *link, pose);
    let second = in_urdf_frame(&model, LinkId(2), other_pose);
    assert!((first.translation.vector - Vector3::new(0.2, 0.0, 0.5)).norm() < 1e-15);
    assert!((second.translation.vector - Vector3::new(1.0, 0.2, -0.5)).norm() < 1e-15, "{second}");
    assert!((second.rotation * Vector3::z() - Vector3::z()).norm() < 1e-15);
}

#[test]
fn frames_given_are_kept() {
    let model = loops(
        "[[loop]]\nname = \"p\"\ntype = \"pin\"\nlink = \"b\"\naxis = [0, 0, -1]\nto = \"c\"\nto_position = [1, 2, 3]\n\
         to_axis = [1, 0, 0]\n[[loop]]\nname = \"w\"\ntype = \"weld\"\nlink = \"b\"\nrpy = [\"90 deg\", 0, 0]\nto = \"world\"\n\
         to_rpy = [0, 0, \"90 deg\"]\n[[loop]]\nname = \"q\"\ntype = \"point\"\nlink = \"b\"\nto = \"world\"\n\
         [[loop]]\nname = \"r\"\ntype = \"rod\"\nlink = \"b\"\nto = \"c\"\nto_position = [0, 0, 0.5]\nposition = [0, 0, 0.5]\n\
         [[loop]]\nname = \"s\"\ntype = \"rod\"\nlink = \"b\"\nto = \"c\"\nlength = 0.3",
    );
    let pin = &model.loops[0];
    assert!((in_urdf_frame(&model, LinkId(1), &pin.pose) * Vector3::z() + Vector3::z()).norm() < 1e-15);
    let other = in_urdf_frame(&model, LinkId(2), &pin.other_pose);
    assert!((other * Point3::origin() - Point3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
    assert!((other * Vector3::z() - Vector3::x()).norm() < 1e-15);
    let weld = &model.loops[1];
    assert_eq!((weld.kind, weld.other), (LoopKind::Weld, None));
    assert!((weld.pose.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!((weld.other_pose * Vector3::x() - Vector3::y()).norm() < 1e-15);
    assert!((weld.other_pose.translation.vector - Vector3::x()).norm() < 1e-15);
    assert_eq!(model.loops[2].kind, LoopKind::Ball);
    // From (1, 0, 0.5) to (0, 0, 1.5).
    let LoopKind::Rod(length) = model.loops[3].kind else { panic!("a rod") };
    assert!((length - 2.0f64.sqrt()).abs() < 1e-15);
    assert_eq!(model.loops[4].kind, LoopKind::Rod(0.3));
}

#[test]
fn what_no_loop_can_be_is_an_error_at_its_place() {
    let ball = "name = \"l\"\ntype = \"ball\"\nlink = \"b\"\nto = \"c\"";
    for (entry, line, expected) in [
        ("name = \"l\"\ntype = \"ball\"\nlink = \"x\"\nto = \"c\"", 5, "loop `l` names an unknown link: `x`"),
        ("name = \"l\"\ntype = \"ball\"\nlink = \"b\"\nto = \"d\"", 6, "loop `l` names an unknown link: `d`"),
        ("name = \"l\"\ntype = \"ball\"\nlink = \"b\"\nto = \"e\"", 6, "joins `b` to the same rigid body"),
        ("name = \"l\"\ntype = \"bal\"\nlink = \"b\"\nto = \"c\"", 4, "unknown variant `bal`"),
        ("name = \"l\"\ntype = \"ball\"\nlink = \"b\"", 2, "missing field `to`"),
        (&format!("{ball}\nposition = [0, nan, 0]"), 7, "position of loop `l` is not finite"),
        (&format!("{ball}\nto_position = [0, inf, 0]"), 7, "to_position of loop `l` is not finite"),
        (&format!("{ball}\naxis = [0, 0, 1]"), 7, "loop `l` has `axis`, which only a pin has"),
        (&format!("{ball}\nlength = 1"), 7, "loop `l` has `length`, which only a rod has"),
        (&format!("{ball}\nto_rpy = [0, 0, 0]"), 7, "loop `l` has `to_rpy`, which only a weld has"),
        (&format!("{ball}\n[[loop]]\n{ball}"), 7, "there are two loops named `l`"),
        (&ball.replace("ball", "pin").replace("to =", "axis = [0, 0, 0]\nto ="), 6, "axis of loop `l` has length 0"),
        (
            &ball.replace("ball", "rod").replace("to =", "length = -1\nto ="),
            6,
            "the length of loop `l` cannot be used: -1",
        ),
        (
            &ball.replace("ball", "rod").replace("to =", "position = [-1, 0, 1]\nto ="),
            2,
            "the length of loop `l` cannot be used",
        ),
    ] {
        let error = load_toml(&format!("urdf = \"robot.urdf\"\n[[loop]]\n{entry}\n"), &urdf()).unwrap_err().to_string();
        assert!(error.contains(expected), "{entry}\n{error}");
        assert!(error.contains(&format!(":{line}:")), "{entry}: line {line}\n{error}");
    }
}
