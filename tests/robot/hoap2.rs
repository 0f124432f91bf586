//! HOAP-2 against the published figures.

use nalgebra::{Matrix4, Point3, Vector3};
use stiction::robot::{Model, Robot};

use super::convention::by_model;
use super::finding::polygon;
use super::shipped;

fn robot() -> Robot {
    shipped("hoap2/hoap2.toml")
}

fn centre_of_mass(model: &Model, q: &[f64]) -> Vector3<f64> {
    let poses = by_model(model, q);
    let moment = |l: &stiction::robot::Link| {
        let internal = poses[&l.name] * l.urdf_frame.inverse().to_homogeneous();
        internal.transform_point(&Point3::from(l.com)).coords * l.mass
    };
    model.links.iter().map(moment).sum::<Vector3<f64>>() / model.mass()
}

/// All sole vertices in the root's frame.
fn feet(robot: &Robot, q: &[f64]) -> Vec<Vec<Vector3<f64>>> {
    let poses = by_model(&robot.model, q);
    let place = |pose: &Matrix4<f64>, p: Vector3<f64>| pose.transform_point(&Point3::from(p)).coords;
    (0..2)
        .map(|s| {
            let link = &robot.model.links[robot.model.soles[s].link.0].name;
            polygon(robot, s).into_iter().map(|p| place(&poses[link], p)).collect()
        })
        .collect()
}

#[test]
fn counts_and_mass_match_the_published_values() {
    let model = robot().model;
    assert_eq!((model.nj(), model.links.len(), model.nv(), model.soles.len()), (25, 26, 31, 2));
    // The sum of the 26 published masses, to the printed 10 g/1000.
    assert!((model.mass() - 7.120).abs() < 5e-4, "{}", model.mass());
    assert!(robot().notices.is_empty(), "{:?}", robot().notices);
}

#[test]
fn the_centre_of_mass_matches_the_published_value() {
    let model = robot().model;
    let com = centre_of_mass(&model, &[0.0; 25]);
    // x and y as published to their last digit (1e-4). The published height -0.0131 includes the
    // two simulation-only sole plates (0.020 kg each, 0.033 below the ankle), which the robot does
    // not have. The test adds them.
    assert!((com.xy() - Vector3::new(-0.0154, 0.0001, 0.0).xy()).norm() < 1e-4, "{com}");
    let plates = 2.0 * 0.020;
    let with_plates = (com.z * model.mass() + plates * (-0.055 - 0.200 - 0.033)) / (model.mass() + plates);
    assert!((with_plates + 0.0131).abs() < 5e-5, "{with_plates}");
}

#[test]
fn at_home_both_soles_are_level_below_the_centre_of_mass() {
    let robot = robot();
    let feet = feet(&robot, &robot.model.home);
    let floor = feet[0][0].z;
    for vertex in feet.iter().flatten() {
        assert!((vertex.z - floor).abs() < 1e-12, "{vertex}");
    }
    // Knees bent by 40 degrees: two segments of 0.1 m at 20 degrees.
    let height = 0.055 + 2.0 * 0.1 * 20f64.to_radians().cos() + 0.0405;
    assert!((floor + height).abs() < 1e-12, "{floor}");
    let com = centre_of_mass(&robot.model, &robot.model.home);
    let side = |pick: fn(f64, f64) -> f64, axis: usize| feet.iter().flatten().map(|v| v[axis]).reduce(pick).unwrap();
    let margins =
        [com.x - side(f64::min, 0), side(f64::max, 0) - com.x, com.y - side(f64::min, 1), side(f64::max, 1) - com.y];
    // The support is the rectangle around both soles, since they are side by side. At least 20 mm
    // to every edge.
    assert!(margins.iter().all(|m| *m > 0.020), "{margins:?}");
}

#[test]
fn right_mirrors_left() {
    let model = robot().model;
    let mirror = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
    let zero = vec![0.0; 25];
    let poses = by_model(&model, &zero);
    let mut pairs = 0;
    for (i, left) in model.links.iter().enumerate().filter(|(_, l)| l.name.starts_with("l_")) {
        let k = model.links.iter().position(|r| r.name == format!("r_{}", &left.name[2..])).unwrap();
        let right = &model.links[k];
        // Published left and right masses of thigh, upper arm and forearm differ by up to 2.4 g.
        assert!((left.mass - right.mass).abs() < 2.5e-3, "{}", left.name);
        let in_urdf = |l: &stiction::robot::Link| {
            let back = l.urdf_frame.inverse();
            let r = back.rotation.to_rotation_matrix().into_inner();
            ((back * Point3::from(l.com)).coords, r * l.inertia * r.transpose())
        };
        let ((cl, il), (cr, ir)) = (in_urdf(left), in_urdf(right));
        let flip = nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
        // Exact in the file; the conversion to the internal frame and back rounds.
        assert!((mirror(cl) - cr).norm() < 1e-16 && (flip * il * flip - ir).norm() < 1e-18, "{}", left.name);
        let origin = |name: &str| poses[name].fixed_view::<3, 1>(0, 3).into_owned();
        assert!((mirror(origin(&left.name)) - origin(&right.name)).norm() < 1e-16);
        // A mirror reverses rotations about x and z, and with them the limits.
        let axis = left.urdf_frame.rotation.inverse() * Vector3::z();
        assert!((axis - right.urdf_frame.rotation.inverse() * Vector3::z()).norm() < 1e-15);
        let (jl, jr) = (&model.joints[i - 1], &model.joints[k - 1]);
        let turned = if axis.y.abs() > 0.5 { (jl.lower, jl.upper) } else { (-jl.upper, -jl.lower) };
        assert_eq!(turned, (jr.lower, jr.upper), "{}", jl.name);
        assert_eq!(
            (jl.effort_limit, jl.velocity_limit, jl.armature),
            (jr.effort_limit, jr.velocity_limit, jr.armature)
        );
        assert_eq!((jl.drive, model.home[i - 1]), (jr.drive, model.home[k - 1]));
        pairs += 1;
    }
    assert_eq!(pairs, 11, "six leg links, four arm links and a hand");
}

/// The effect of a positive angle, as the sources describe it.
#[test]
fn joints_rotate_in_the_directions_of_the_figures() {
    let model = robot().model;
    let moved = |joint: &str, angle: f64, link: &str, point: Vector3<f64>| {
        let mut q = vec![0.0; 25];
        let at = |q: &[f64]| by_model(&model, q)[link].transform_point(&Point3::from(point)).coords;
        let before = at(&q);
        q[model.joint(joint).unwrap().0] = angle;
        at(&q) - before
    };
    let down = Vector3::new(0.0, 0.0, -0.1);
    assert!(moved("left_hip_pitch", -0.3, "l_shank", Vector3::zeros()).x > 0.02, "thigh forward");
    assert!(moved("left_knee", 0.3, "l_foot", Vector3::zeros()).x < -0.02, "knee flexes backward");
    assert!(moved("left_hip_roll", 0.3, "l_foot", Vector3::zeros()).y > 0.02, "left leg outward");
    assert!(moved("right_hip_roll", -0.3, "r_foot", Vector3::zeros()).y < -0.02, "right leg outward");
    assert!(moved("left_hip_yaw", 0.3, "l_foot", Vector3::new(0.05, 0.0, 0.0)).y > 0.01, "left toes outward");
    assert!(moved("left_ankle_pitch", -0.3, "l_foot", Vector3::new(0.05, 0.0, 0.0)).z > 0.01, "toes up");
    // The arms point forward at zero.
    assert!(moved("left_shoulder_pitch", 1.0, "l_hand", Vector3::zeros()).z < -0.1, "arm down");
    assert!(moved("left_shoulder_roll", 1.0, "l_hand", Vector3::zeros()).y > 0.1, "left arm outward");
    assert!(moved("right_shoulder_roll", -1.0, "r_hand", Vector3::zeros()).y < -0.1, "right arm outward");
    assert!(moved("left_elbow", -1.0, "l_hand", Vector3::zeros()).z > 0.05, "forearm up");
    assert!(moved("head_tilt", 0.5, "head", Vector3::new(0.05, 0.0, 0.0)).z < -0.02, "looks down");
    // The upper body is the root: bending it forward swings the legs forward in its frame.
    assert!(moved("waist_pitch", 0.5, "pelvis", down).x > 0.02, "bends forward");
}

#[test]
fn every_drive_is_stable_with_an_explicit_integrator() {
    let model = robot().model;
    for (i, joint) in model.joints.iter().enumerate() {
        let link = &model.links[i + 1];
        let own = link.inertia[(2, 2)] + link.mass * link.com.xy().norm_squared() + joint.armature;
        let (frequency, decay) = ((joint.drive.kp / own).sqrt(), joint.drive.kd / own);
        assert!(frequency < 1000.0 && decay < 1000.0, "{}: {frequency} rad/s, {decay} 1/s", joint.name);
        assert!(joint.drive.kp > 0.0 && joint.drive.kd > 0.0 && joint.armature > 0.0 && joint.effort_limit.is_finite());
    }
}
