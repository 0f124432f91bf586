//! Link poses against those of the dynamics, and predicted postures.

use super::cbi;
use nalgebra::Vector3;
use stiction::collision::{LinkPose, extrapolate, link_poses};
use stiction::dynamics::{State, Workspace, kinematics};

#[test]
fn poses_are_those_of_the_dynamics() {
    let model = cbi().model;
    let mut state = State::home(&model);
    state.position = Vector3::zeros();
    state.rotation = nalgebra::UnitQuaternion::identity();
    state.joints.iter_mut().enumerate().for_each(|(i, q)| *q = (i as f64).sin());
    let mut ws = Workspace::new(&model);
    kinematics::positions(&model, &state, &mut ws);
    let mut poses = vec![LinkPose::IDENTITY; model.links.len()];
    link_poses(&model, &state.joints, &mut poses);
    for (pose, link) in poses.iter().zip(&ws.links) {
        // The same products in the same order.
        assert!((pose.rotation - link.rotation).norm() < 1e-14 && (pose.origin - link.origin).norm() < 1e-14);
    }
}

#[test]
fn predicted_postures_stay_within_speeds_and_ranges() {
    let mut model = cbi().model;
    let n = model.nj();
    for joint in &mut model.joints {
        joint.velocity_limit = 2.0;
    }
    let (q, mut out) = (model.home.clone(), vec![0.0; n]);
    // Slow and short: no cap is active, and the path is a parabola.
    extrapolate(&model, &q, &vec![0.1; n], &vec![-0.5; n], 0.2, &mut out);
    for (i, joint) in model.joints.iter().enumerate() {
        let want = (q[i] + 0.1 * 0.2 - 0.25 * 0.04f64).clamp(joint.lower, joint.upper);
        assert!((out[i] - want).abs() < 1e-15);
    }
    // Fast: at the cap from the start, 2 rad/s for 0.1 s; over a long time: at the end of the
    // range.
    extrapolate(&model, &q, &vec![9.0; n], &vec![3.0; n], 0.1, &mut out);
    for (i, joint) in model.joints.iter().enumerate() {
        assert!((out[i] - (q[i] + 0.2).min(joint.upper)).abs() < 1e-15);
    }
    extrapolate(&model, &q, &vec![0.0; n], &vec![-3.0; n], 10.0, &mut out);
    assert!(out.iter().zip(&model.joints).all(|(q, joint)| *q == joint.lower));
}
