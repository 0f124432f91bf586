//! Inertias that no body can have: refused with the link's name, or repaired and listed.

use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion, Vector3};
use stiction::robot::{InertiaPolicy, Robot, RobotError, load_with};

use super::{BODY, folder};

fn with_inertia(tensor: &Matrix3<f64>, policy: InertiaPolicy) -> Result<Robot, RobotError> {
    let t = tensor;
    let text = format!(
        "<robot name=\"r\"><link name=\"a\"><inertial><origin xyz=\"1 2 3\"/><mass value=\"5\"/>\
         <inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial></link></robot>",
        t.m11, t.m12, t.m13, t.m22, t.m23, t.m33
    );
    let folder = folder(&[("r.urdf", &text)]);
    load_with(&folder.path().join("r.urdf"), Some(policy))
}

/// The smallest share of the second moment of mass along an axis in a repaired tensor.
const THINNEST: f64 = 1e-3;

#[test]
fn an_unphysical_tensor_is_replaced_by_the_nearest_physical_one() {
    let e = THINNEST;
    let turn = UnitQuaternion::from_euler_angles(0.3, -0.5, 1.1).to_rotation_matrix().into_inner();
    // In principal axes: onto the face below the largest moment along its normal (1-e, 1-e, -1-e),
    // and onto the ray (2e, 1-e, 1-e) of a rod.
    let n = Vector3::new(1.0 - e, 1.0 - e, -1.0 - e);
    let far = Vector3::new(1.0, 2.0, 4.0);
    let plate = far - n * (n.dot(&far) / n.norm_squared());
    let rod = Vector3::new(2.0 * e, 1.0 - e, 1.0 - e);
    let rod = rod * (rod.dot(&Vector3::new(-0.5, 2.0, 2.0)) / rod.norm_squared());
    for (given, nearest) in [(far, plate), (Vector3::new(-0.5, 2.0, 2.0), rod)] {
        let tensor = turn * Matrix3::from_diagonal(&given) * turn.transpose();
        let refused = with_inertia(&tensor, InertiaPolicy::Refuse).unwrap_err().to_string();
        assert!(refused.contains("inertia of link `a`") && refused.contains("--repair"), "{refused}");
        let robot = with_inertia(&tensor, InertiaPolicy::Repair).unwrap();
        let link = &robot.model.links[0];
        let expected = turn * Matrix3::from_diagonal(&nearest) * turn.transpose();
        // Rounding of the rotations and of the eigenvalues of tensors of size 4.
        assert!((link.inertia - expected).amax() < 1e-14, "{} {expected}", link.inertia);
        assert_eq!((link.mass, link.com), (5.0, Vector3::new(1.0, 2.0, 3.0)), "mass and centre stay");
        let notice =
            &robot.notices.iter().find(|n| n.message.contains("inertia of link `a` repaired")).unwrap().message;
        let mut before: Vec<f64> = given.iter().copied().collect();
        before.sort_by(f64::total_cmp);
        let mut after: Vec<f64> = SymmetricEigen::new(link.inertia).eigenvalues.iter().copied().collect();
        after.sort_by(f64::total_cmp);
        for moment in before.iter().chain(&after) {
            assert!(notice.contains(&format!("{moment:.6e}")), "{moment:.6e} is not in {notice}");
        }
    }
}

#[test]
fn a_physical_tensor_is_unchanged() {
    let tensor = Matrix3::new(2.0, 0.1, 0.0, 0.1, 3.0, 0.2, 0.0, 0.2, 4.0);
    let robots = [InertiaPolicy::Refuse, InertiaPolicy::Repair].map(|policy| with_inertia(&tensor, policy).unwrap());
    assert_eq!(robots[0].model, robots[1].model);
    let [refuse, repair] = robots.map(|r| r.notices.into_iter().map(|n| n.message).collect::<Vec<_>>());
    assert_eq!(refuse, repair);
}

fn chain(last: &str) -> String {
    format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link><link name=\"b\"/><link name=\"c\">{last}</link>\
         <joint name=\"roll\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"1 0 0\"/></joint>\
         <joint name=\"pitch\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/><axis xyz=\"0 1 0\"/></joint></robot>"
    )
}

/// A link without mass is valid if its descendants have inertia about its joint.
#[test]
fn massless_links_and_point_masses_are_valid_with_inertia_about_the_joint() {
    let point = "<inertial><origin xyz=\"0 0 1\"/><mass value=\"1\"/>\
                 <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial>";
    let refused = |text: &str, link: &str| {
        let folder = folder(&[("r.urdf", text)]);
        let error = load_with(&folder.path().join("r.urdf"), None).unwrap_err().to_string();
        assert!(error.contains(link), "{error}");
    };
    let loads = |text: &str| {
        let folder = folder(&[("r.urdf", text)]);
        load_with(&folder.path().join("r.urdf"), None).unwrap_or_else(|e| panic!("{e}"))
    };
    let robot = loads(&chain(BODY));
    assert_eq!(robot.model.nj(), 2);
    assert!(robot.notices.iter().any(|n| n.message.contains("link `b` has no mass")), "{:?}", robot.notices);
    loads(&chain(point));
    // A point mass on its own axis has no inertia about it; parallel axes share the links behind
    // them.
    refused(&chain(&point.replace("0 0 1", "0 1 0")), "link `c`");
    refused(&chain(point).replace("1 0 0", "0 1 0"), "link `b`");
    refused(&chain(""), "link `c` moves but has no mass");
}

#[test]
fn joints_without_inertia_are_locked_by_the_repair() {
    let folder = folder(&[("r.urdf", &chain(""))]);
    let robot = load_with(&folder.path().join("r.urdf"), Some(InertiaPolicy::Repair)).unwrap();
    assert_eq!((robot.model.nj(), robot.model.links[0].merged.len()), (0, 2));
    for joint in ["roll", "pitch"] {
        let needle = format!("joint `{joint}` is locked at 0");
        assert!(robot.notices.iter().any(|n| n.message.contains(&needle)), "{:?}", robot.notices);
    }
}

/// Order of precedence: scenario, robot file, default.
#[test]
fn the_robot_file_may_request_the_repair() {
    let urdf = "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/>\
                <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"3\"/></inertial></link></robot>";
    let place = folder(&[
        ("r.urdf", urdf),
        ("repair.toml", "urdf = \"r.urdf\"\ninertia = \"repair\""),
        ("refuse.toml", "urdf = \"r.urdf\"\ninertia = \"refuse\""),
    ]);
    let load = |name: &str, policy| load_with(&place.path().join(name), policy);
    assert!(load("repair.toml", None).is_ok());
    assert!(load("repair.toml", Some(InertiaPolicy::Refuse)).is_err());
    assert!(load("refuse.toml", None).is_err());
    assert!(load("refuse.toml", Some(InertiaPolicy::Repair)).is_ok());
    assert!(load("r.urdf", None).is_err());
}
