//! Joints with several or dependent motions, and vectors with commas.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use stiction::robot::{Base, DriveMode, JointId, JointKind, Model};

use super::{BODY, load_toml, load_urdf};

fn two(kind: &str, inside: &str) -> String {
    format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link><link name=\"b\">{BODY}</link><joint name=\"j\" type=\"{kind}\">\
         <origin xyz=\"1 2 3\" rpy=\"0.1 0.2 0.3\"/><parent link=\"a\"/><child link=\"b\"/>{inside}</joint></robot>"
    )
}

/// Pose of the last link's URDF frame in the root's, by joint positions.
fn pose(model: &Model, q: &[f64]) -> Isometry3<f64> {
    let mut pose = Isometry3::identity();
    for (i, link) in model.links.iter().enumerate().skip(1) {
        let turn = nalgebra::Rotation3::from_matrix_unchecked(link.rotation);
        pose *= Isometry3::from_parts(Translation3::from(link.offset), UnitQuaternion::from_rotation_matrix(&turn));
        pose *= match model.joints[i - 1].kind {
            JointKind::Prismatic => Isometry3::translation(0.0, 0.0, q[i - 1]),
            _ => Isometry3::rotation(Vector3::z() * q[i - 1]),
        };
    }
    pose * model.links[model.links.len() - 1].urdf_frame
}

fn origin() -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3))
}

#[test]
fn a_planar_joint_is_two_slides_and_a_turn() {
    let robot = load_urdf(&two("planar", "<axis xyz=\"0 0 1\"/>")).unwrap();
    let names: Vec<&str> = robot.model.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["j/x", "j/y", "j/turn"]);
    assert!(robot.model.joints.iter().all(|j| j.drive_configured && j.drive.mode == DriveMode::Passive));
    let expected = origin() * Isometry3::translation(0.4, 0.5, 0.0) * Isometry3::rotation(Vector3::z() * 0.6);
    // Rounding of a chain of rotations over some metres.
    assert!((pose(&robot.model, &[0.4, 0.5, 0.6]).to_homogeneous() - expected.to_homogeneous()).amax() < 1e-14);
    assert!(robot.notices.iter().any(|n| n.message.contains("`j/x`, `j/y`, `j/turn`")), "{:?}", robot.notices);
}

#[test]
fn a_floating_joint_inside_the_tree_is_six_motions() {
    let robot = load_urdf(&two("floating", "")).unwrap();
    assert_eq!(robot.model.nj(), 6);
    let q = [0.4, -0.5, 0.6, 0.7, -0.8, 0.9];
    let turn = UnitQuaternion::from_euler_angles(q[5], q[4], q[3]);
    let expected = origin() * Isometry3::from_parts(Translation3::new(q[0], q[1], q[2]), turn);
    // Rounding of a chain of rotations over some metres.
    assert!((pose(&robot.model, &q).to_homogeneous() - expected.to_homogeneous()).amax() < 1e-14);
    assert!(robot.notices.iter().any(|n| n.message.contains("must not pitch by 90 degrees")), "{:?}", robot.notices);
}

/// Below a root without mass it is the floating base.
#[test]
fn a_floating_joint_under_a_massless_root_is_the_base() {
    let text = two("floating", "").replacen(&format!("<link name=\"a\">{BODY}</link>"), "<link name=\"a\"/>", 1);
    let model = load_urdf(&text).unwrap().model;
    assert_eq!((model.base, model.nj(), model.links[0].name.as_str()), (Base::Floating, 0, "b"));
}

#[test]
fn a_mimic_joint_follows() {
    let joint = |name: &str, parent: &str, child: &str, inside: &str| {
        format!(
            "<link name=\"{child}\">{BODY}</link><joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/>\
             <child link=\"{child}\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>{inside}</joint>"
        )
    };
    let urdf = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link>{}{}{}</robot>",
        // The second mimics a joint that comes after it.
        joint("last", "a", "b", "<mimic joint=\"next\" multiplier=\"-1\"/>"),
        joint("next", "b", "c", "<mimic joint=\"leader\" multiplier=\"0.5\" offset=\"0.1\"/>"),
        joint("leader", "c", "d", ""),
    );
    let robot = load_toml("urdf = \"robot.urdf\"\n[home]\nleader = 0.4", &urdf).unwrap();
    let home = |name: &str| robot.model.home[robot.model.joint(name).unwrap().0];
    assert_eq!(robot.model.nj(), 3);
    assert_eq!([home("leader"), home("next"), home("last")], [0.4, 0.5 * 0.4 + 0.1, -(0.5 * 0.4 + 0.1)]);
    // Couplings come after those of the joints that they follow, and followers have no drive.
    let name = |id: JointId| robot.model.joints[id.0].name.as_str();
    let couplings: Vec<_> = robot.model.couplings.iter().map(|c| (name(c.joint), name(c.leader))).collect();
    assert_eq!(couplings, [("next", "leader"), ("last", "next")]);
    assert_eq!(robot.model.couplings[0].coefficients, [0.1, 0.5, 0.0, 0.0, 0.0]);
    assert_eq!(robot.model.couplings[1].evaluate(0.3), (-0.3, -1.0, 0.0));
    let joint = |name: &str| &robot.model.joints[robot.model.joint(name).unwrap().0];
    assert_eq!(joint("last").drive.mode, DriveMode::Passive);
    assert!(joint("last").drive_configured && !joint("leader").drive_configured);
    // A drive by default is for leaders; one by name for any joint, but a follower is not kinematic.
    let file = "urdf = \"robot.urdf\"\njoint_default = { kp = 5.0, kd = 1.0, armature = 0.1 }\njoint.next = { mode = \"position\", kp = 2.0 }\n";
    let robot = load_toml(file, &urdf).unwrap();
    let joint = |name: &str| &robot.model.joints[robot.model.joint(name).unwrap().0];
    assert_eq!([joint("leader"), joint("next"), joint("last")].map(|j| j.drive.kp), [5.0, 2.0, 0.0]);
    assert_eq!([joint("leader"), joint("next"), joint("last")].map(|j| j.armature), [0.1; 3]);
    let robot = load_toml("urdf = \"robot.urdf\"\nkinematic = [\"*\"]", &urdf).unwrap();
    let modes: Vec<DriveMode> = robot.model.joints.iter().map(|j| j.drive.mode).collect();
    assert_eq!(modes, [DriveMode::Passive, DriveMode::Passive, DriveMode::Kinematic]);
    for kinematic in ["kinematic = [\"next\"]", "joint.next.mode = \"kinematic\""] {
        let error = load_toml(&format!("urdf = \"robot.urdf\"\n{kinematic}"), &urdf).unwrap_err().to_string();
        assert!(error.contains("mode of joint `next`") && error.contains("the joint follows `leader`"), "{error}");
    }
    // A home that the coupling does not give is an error; one that it gives is not.
    let with_home =
        |last: f64| load_toml(&format!("urdf = \"robot.urdf\"\n[home]\nleader = 0.4\nlast = {last}"), &urdf);
    assert!(with_home(-0.3).is_ok());
    let error = with_home(0.25).unwrap_err().to_string();
    assert!(error.contains("joint `last` follows `next`") && error.contains("-0.3"), "{error}");
    // One outside the limits is noted.
    let robot = load_toml("urdf = \"robot.urdf\"\n[home]\nleader = 1.0", &urdf.replace("0.5", "5")).unwrap();
    assert_eq!(robot.model.home, [-5.1, 5.1, 1.0]);
    assert_eq!(robot.notices.iter().filter(|n| n.message.contains("is outside its limits")).count(), 2);
}

/// A joint that follows a fixed one is held.
#[test]
fn a_mimic_of_a_joint_that_does_not_move_is_held() {
    let urdf = two(
        "revolute",
        "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/><mimic joint=\"f\" offset=\"0.5\"/>",
    );
    let fixed =
        "<link name=\"c\"/><joint name=\"f\" type=\"fixed\"><parent link=\"a\"/><child link=\"c\"/></joint></robot>";
    let robot = load_urdf(&urdf.replace("</robot>", fixed)).unwrap();
    let coupling = robot.model.couplings[0];
    assert_eq!((coupling.joint, coupling.leader, coupling.evaluate(0.2)), (JointId(0), JointId(0), (0.5, 0.0, 0.0)));
    assert_eq!(robot.model.home, [0.5]);
    assert!(robot.notices.iter().any(|n| n.message.contains("it is held at 0.5")), "{:?}", robot.notices);
}

#[test]
fn mimics_that_cannot_be_followed_are_reported() {
    let joint = |name: &str, child: &str, of: &str| {
        format!(
            "<link name=\"{child}\">{BODY}</link><joint name=\"{name}\" type=\"continuous\"><parent link=\"a\"/>\n\
             <child link=\"{child}\"/><axis xyz=\"0 0 1\"/><mimic joint=\"{of}\" offset=\"0.5\"/></joint>"
        )
    };
    for (joints, expected) in [
        (vec![("j", "j")], "joints mimic each other in a ring: `j`, `j`"),
        (vec![("j", "k"), ("k", "j")], "in a ring: `j`, `k`, `j`"),
        (vec![("left", "lift")], "joint `left` mimics `lift`, which is not a joint of the robot"),
        (
            vec![("left", "left_"), ("left_2", "left")],
            "`left_`, which is not a joint of the robot; did you mean `left`?",
        ),
    ] {
        let all: Vec<String> =
            joints.iter().enumerate().map(|(i, (name, of))| joint(name, &format!("l{i}"), of)).collect();
        let robot =
            load_urdf(&format!("<robot name=\"r\"><link name=\"a\">{BODY}</link>{}</robot>", all.concat())).unwrap();
        let notice = robot.notices.iter().find(|n| n.message.contains(expected));
        assert!(notice.is_some_and(|n| n.line() == 2), "{expected}: {:?}", robot.notices);
        assert_eq!(robot.model.home[0], 0.0, "{expected}");
    }
}

#[test]
fn joints_without_position_limits_are_unlimited() {
    let robot = load_urdf(&two("revolute", "<axis xyz=\"0 0 1\"/><limit effort=\"1\" velocity=\"2\"/>")).unwrap();
    let joint = &robot.model.joints[0];
    assert_eq!((joint.kind, joint.lower, joint.upper), (JointKind::Continuous, f64::NEG_INFINITY, f64::INFINITY));
    assert!(
        robot.notices.iter().any(|n| n.message.contains("joint `j` has no position limits")),
        "{:?}",
        robot.notices
    );
    let slide = load_urdf(&two("prismatic", "<axis xyz=\"0 0 1\"/>")).unwrap();
    assert_eq!((slide.model.joints[0].kind, slide.model.joints[0].upper), (JointKind::Prismatic, f64::INFINITY));
}

#[test]
fn vectors_with_commas_are_read_with_a_warning() {
    let good = two("continuous", "<axis xyz=\"0 0 1\"/>");
    let commas = good.replace("1 2 3", "1, 2,3").replace("0 0 1\"/></joint>", "0,0,1\"/></joint>");
    let (plain, read) = (load_urdf(&good).unwrap(), load_urdf(&commas).unwrap());
    assert_eq!(plain.model, read.model);
    let link = &read.model.links[1];
    assert_eq!(
        (link.urdf_frame.inverse() * Point3::origin(), link.offset),
        (Point3::origin(), Vector3::new(1.0, 2.0, 3.0))
    );
    let notice = |needle: &str| read.notices.iter().any(|n| n.message.contains(needle));
    assert!(notice("commas in `xyz=\"1, 2,3\"` are read as spaces") && notice("`xyz=\"0,0,1\"`"), "{:?}", read.notices);
}
