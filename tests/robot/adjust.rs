//! Changes that scenarios make to a robot.

use nalgebra::{Matrix3, Point3, Vector3};
use stiction::robot::adjustments::{DriveSettings, SolePolygon, add_payload, set_default_drive, set_drive, set_soles};
use stiction::robot::{DriveMode, Model};

use super::{BODY, load_urdf, shipped};

fn hoap2() -> Model {
    shipped("hoap2/hoap2.toml").model
}

/// Inertia of all links about the root's origin at the zero posture. By its definition (sum of
/// tensors and m (|r|^2 1 - r r^T)) it does not depend on the division into links.
fn about_origin(model: &Model) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let zero = vec![0.0; model.nj()];
    let poses = super::convention::by_model(model, &zero);
    let (mut mass, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for link in &model.links {
        let pose = poses[&link.name] * link.urdf_frame.inverse().to_homogeneous();
        let r = pose.fixed_view::<3, 3>(0, 0).into_owned();
        let c = pose.transform_point(&Point3::from(link.com)).coords;
        mass += link.mass;
        first += c * link.mass;
        second +=
            r * link.inertia * r.transpose() + (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * link.mass;
    }
    (mass, first, second)
}

#[test]
fn a_payload_adds_its_own_moments_on_any_link() {
    let inertia = [3e-3, 4e-3, 5e-3, 1e-4, -2e-4, 3e-4];
    let position = Vector3::new(0.05, -0.02, 0.1);
    // The foot's internal frame is rotated (its axis is x), the torso's is not.
    for link in ["torso", "l_foot"] {
        let mut model = hoap2();
        let before = about_origin(&model);
        let poses = super::convention::by_model(&model, &vec![0.0; model.nj()]);
        add_payload(&mut model, link, 2.0, position, inertia).unwrap();
        let after = about_origin(&model);
        // At zero every URDF frame is parallel to the root's.
        let c = poses[link].transform_point(&Point3::from(position)).coords;
        let own = Matrix3::new(3e-3, 1e-4, -2e-4, 1e-4, 4e-3, 3e-4, -2e-4, 3e-4, 5e-3);
        let expected = own + (Matrix3::identity() * c.norm_squared() - c * c.transpose()) * 2.0;
        // Rounding of sums of size 1.
        assert!((after.0 - before.0 - 2.0).abs() < 1e-14);
        assert!((after.1 - before.1 - c * 2.0).norm() < 1e-14, "{link}");
        assert!((after.2 - before.2 - expected).norm() < 1e-14, "{link}: {}", after.2 - before.2 - expected);
    }
}

#[test]
fn invalid_payloads_are_refused() {
    let mut model = hoap2();
    let untouched = model.clone();
    let zero = Vector3::zeros();
    let mut fails = |link: &str, mass: f64, at: Vector3<f64>, inertia: [f64; 6], needle: &str| {
        let error = add_payload(&mut model, link, mass, at, inertia).unwrap_err().to_string();
        assert!(error.contains(needle), "{error}");
        assert_eq!(model, untouched);
    };
    fails("tors", 1.0, zero, [0.0; 6], "did you mean `torso`?");
    fails("torso", 0.0, zero, [0.0; 6], "mass of the payload");
    fails("torso", f64::NAN, zero, [0.0; 6], "mass of the payload");
    fails("torso", 1.0, Vector3::new(0.0, f64::NAN, 0.0), [0.0; 6], "position of the payload");
    fails("torso", 1.0, zero, [1.0, 1.0, 3.0, 0.0, 0.0, 0.0], "principal moments");
    fails("torso", 1.0, zero, [1.0, 1.0, 1.0, 2.0, 0.0, 0.0], "principal moments");
    add_payload(&mut model, "torso", 1.0, zero, [0.0; 6]).unwrap();
    assert_eq!(model.links[0].mass, untouched.links[0].mass + 1.0);
}

#[test]
fn drives_change_only_the_named_values() {
    let mut model = hoap2();
    let before = model.clone();
    let settings = DriveSettings { kp: Some(50.0), coulomb: Some(0.1), effort: Some(3.0), ..Default::default() };
    set_drive(&mut model, "left_knee", &settings).unwrap();
    let knee = model.joint("left_knee").unwrap().0;
    let (new, old) = (&model.joints[knee], &before.joints[knee]);
    assert_eq!((new.drive.kp, new.drive.kd, new.drive.mode), (50.0, old.drive.kd, DriveMode::Position));
    assert_eq!((new.friction, new.effort_limit, new.armature), (0.1, 3.0, old.armature));
    for j in (0..model.nj()).filter(|&j| j != knee) {
        assert_eq!(model.joints[j], before.joints[j]);
    }
    let bad = set_drive(&mut model, "left_kne", &settings).unwrap_err().to_string();
    assert!(bad.contains("did you mean `left_knee`?"), "{bad}");
    let negative = DriveSettings { kd: Some(-1.0), ..Default::default() };
    assert!(set_drive(&mut model, "left_knee", &negative).unwrap_err().to_string().contains("kd of joint `left_knee`"));
}

#[test]
fn default_drives_fill_only_unconfigured_joints() {
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link><link name=\"b\">{BODY}</link><link name=\"c\">{BODY}</link>\
         <joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint>\
         <joint name=\"k\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/></joint></robot>"
    );
    let mut model = load_urdf(&text).unwrap().model;
    set_drive(&mut model, "k", &DriveSettings { mode: Some(DriveMode::Force), ..Default::default() }).unwrap();
    set_default_drive(&mut model, &DriveSettings { kp: Some(100.0), kd: Some(5.0), ..Default::default() }).unwrap();
    assert_eq!((model.joints[0].drive.mode, model.joints[0].drive.kp), (DriveMode::Position, 100.0));
    assert_eq!((model.joints[1].drive.mode, model.joints[1].drive.kp), (DriveMode::Force, 0.0));
}

#[test]
fn soles_are_replaced_in_the_urdf_frame() {
    let mut model = hoap2();
    let before = model.soles.clone();
    let [right, left] = [("right", -0.031), ("left", 0.031)].map(|(name, y): (&str, f64)| SolePolygon {
        name: name.into(),
        link: if y > 0.0 { "l_foot".into() } else { "r_foot".into() },
        // Clockwise seen from above: the order is reversed, the first vertex stays first.
        polygon: [(0.0582, 0.031), (0.0582, -0.031), (-0.0358, -0.031), (-0.0358, 0.031)]
            .map(|(x, y)| Vector3::new(x, y, -0.0405))
            .to_vec(),
    });
    set_soles(&mut model, &[left.clone(), right]).unwrap();
    assert_eq!(model.soles, before);
    set_soles(&mut model, &[]).unwrap();
    assert!(model.soles.is_empty());
    let error = set_soles(&mut model, &[left.clone(), left.clone()]).unwrap_err().to_string();
    assert!(error.contains("used twice"), "{error}");
    let lost = SolePolygon { link: "l_fot".into(), ..left.clone() };
    assert!(set_soles(&mut model, &[lost]).unwrap_err().to_string().contains("did you mean `l_foot`?"));
    let star: Vec<Vector3<f64>> = (0..5)
        .map(|i| f64::from(i) * 0.8 * std::f64::consts::PI)
        .map(|a| Vector3::new(a.cos(), a.sin(), 0.0))
        .collect();
    let error = set_soles(&mut model, &[SolePolygon { polygon: star, ..left }]).unwrap_err().to_string();
    assert!(error.contains("more than once"), "{error}");
    assert!(model.soles.is_empty(), "a refused change leaves the model as it was");
}
