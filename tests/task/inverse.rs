//! Whole-body inverse kinematics on HOAP-2.

use super::hoap2;
use crate::support::counting::count;
use nalgebra::{UnitQuaternion, Vector2, Vector3};
use stiction::dynamics::Motion;
use stiction::robot::Model;
use stiction::task::kinematic::{
    InverseKinematics, PlannedRobot, Rates, Unknowns, Unreachable, feed_forward, planned_robot,
};

/// Length of HOAP-2's thigh and shank, m (robots/hoap2/README.md).
const LIMB: f64 = 0.100;

fn joint(model: &Model, planned: &PlannedRobot, name: &str) -> f64 {
    planned.state.joints[model.joint(name).unwrap().0]
}

/// World position of a joint's origin.
fn origin(model: &Model, planned: &PlannedRobot, name: &str) -> Vector3<f64> {
    let link = stiction::robot::LinkId(model.joint(name).unwrap().0 + 1);
    planned.ws.point(link, &Vector3::zeros())
}

#[test]
fn legs_are_the_limbs_that_move_one_sole() {
    let (model, _) = hoap2();
    let names = |joints: Vec<usize>| joints.iter().map(|&j| model.joints[j].name.clone()).collect::<Vec<_>>();
    let legs = names(planned_robot::leg_joints(&model));
    assert_eq!(legs.len(), 12);
    assert!(legs.iter().all(|n| ["hip", "knee", "ankle"].iter().any(|part| n.contains(part))), "{legs:?}");
    // The waist carries both soles: it belongs to no leg, but it carries.
    let carrying = names(planned_robot::carrying_joints(&model));
    assert_eq!(carrying.len(), 13);
    assert!(carrying.contains(&"waist_pitch".to_owned()));
}

#[test]
fn goals_are_met_and_the_knees_obey_the_law_of_cosines() {
    let (model, mut planned) = hoap2();
    let mut inverse = InverseKinematics::of_legs(&model, &planned);
    let mut goal = planned.goal();
    let rest = Rates::zero(2);
    let start = goal.clone();
    for (x, y, z) in [(0.0, 0.0, -0.01), (0.01, 0.02, -0.03), (-0.01, -0.03, -0.02), (0.0, 0.0, 0.0)] {
        goal.com = start.com + Vector3::new(x, y, z);
        // A foot lifted and forward.
        goal.soles[0].translation.vector = start.soles[0].translation.vector + Vector3::new(-x, 0.0, -0.3 * z);
        inverse.solve(&model, &mut planned, &goal, &rest).unwrap();
        // Newton stops below 1e-11; the compared poses add rounding of 1e-16.
        for s in 0..2 {
            let off = goal.soles[s].inv_mul(&planned.sole(s));
            assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle() < 1e-9, "{off}");
        }
        assert!((planned.com() - goal.com).norm() < 1e-9);
        assert!(planned.state.rotation.angle_to(&goal.root) < 1e-9);
        for side in ["left", "right"] {
            let of = |part: &str| format!("{side}_{part}");
            let apart = origin(&model, &planned, &of("hip_pitch")) - origin(&model, &planned, &of("ankle_pitch"));
            // Two limbs of equal length l: the knee's angle from straight is 2 acos(d / 2l). Near a
            // bend of 0.7 rad its derivative is 1/(l sin 0.35) = 30 per m, so 1e-11 m of error are
            // 3e-10.
            let knee = 2.0 * (apart.norm() / (2.0 * LIMB)).acos();
            assert!((joint(&model, &planned, &of("knee")) - knee).abs() < 1e-9);
            // Root upright, sole level: rolls cancel, and so do pitches where there is no roll.
            let roll = joint(&model, &planned, &of("hip_roll")) + joint(&model, &planned, &of("ankle_roll"));
            let pitches: f64 =
                ["hip_pitch", "knee", "ankle_pitch"].map(|p| joint(&model, &planned, &of(p))).iter().sum();
            assert!(roll.abs() < 1e-9 && pitches.abs() < 1e-9, "{roll} {pitches}");
        }
    }
}

#[test]
fn joint_velocities_are_the_derivative_of_joint_positions() {
    let (model, mut planned) = hoap2();
    let mut inverse = InverseKinematics::of_legs(&model, &planned);
    let start = planned.goal();
    let rates = Rates {
        soles: vec![
            Motion::new(Vector3::new(0.1, 0.02, 0.05), Vector3::new(0.1, -0.2, 0.3)),
            Motion::new(Vector3::zeros(), Vector3::zeros()),
        ],
        com: Vector3::new(0.03, -0.05, -0.1),
        root: Vector3::new(0.1, 0.2, -0.1),
    };
    let at = |h: f64| {
        let mut goal = start.clone();
        goal.com += rates.com * h + Vector3::new(0.0, 0.0, -0.02);
        goal.root = UnitQuaternion::from_scaled_axis(rates.root * h) * goal.root;
        for (pose, rate) in goal.soles.iter_mut().zip(&rates.soles) {
            pose.translation.vector += rate.linear * h;
            pose.rotation = UnitQuaternion::from_scaled_axis(rate.angular * h) * pose.rotation;
        }
        goal
    };
    let h = 1e-4;
    let mut solve = |h: f64| {
        inverse.solve(&model, &mut planned, &at(h), &rates).unwrap();
        planned.state.clone()
    };
    let (before, after, here) = (solve(-h), solve(h), solve(0.0));
    for j in planned_robot::leg_joints(&model) {
        let slope = (after.joints[j] - before.joints[j]) / (2.0 * h);
        // Central difference: h^2 times third derivatives of some 100 rad/s^3, and 1e-11 / h of the
        // solver.
        assert!((slope - here.v[6 + j]).abs() < 1e-5, "{}: {slope} {}", model.joints[j].name, here.v[6 + j]);
    }
}

#[test]
fn unreachable_goals_are_errors() {
    let (model, planned) = hoap2();
    let mut inverse = InverseKinematics::of_legs(&model, &planned);
    let rest = Rates::zero(2);
    // Straight legs end 0.2 m above the ankles; the home posture is 12 mm below that.
    let mut high = planned.goal();
    high.com.z += 0.05;
    let failure = inverse.solve(&model, &mut planned.clone(), &high, &rest).unwrap_err();
    assert!(matches!(failure, Unreachable::TooFar { error } if error > 1e-3), "{failure}");
    // At a very low height the ankles' 61 degrees are not enough.
    let mut low = planned.goal();
    low.com.z -= 0.11;
    let failure = inverse.solve(&model, &mut planned.clone(), &low, &rest).unwrap_err();
    assert!(
        matches!(&failure, Unreachable::Limit { joint, .. } if joint.contains("ankle") || joint.contains("hip")),
        "{failure}"
    );
}

#[test]
fn steps_do_not_move_the_soles_and_stop_at_limits() {
    let (model, mut planned) = hoap2();
    let mut mobility = vec![0.0; model.nj()];
    planned_robot::carrying_joints(&model).into_iter().for_each(|j| mobility[j] = 1.0);
    let unknowns = Unknowns { mobility, com_axes: 2, root: false };
    let mut inverse = InverseKinematics::new(&model, &planned, unknowns);
    let start = planned.goal();
    let mut goal = start.clone();
    let mut v = 0.0;
    for i in 1..=100 {
        goal.com = start.com + Vector3::new(1e-4, 2e-4, 0.0) * f64::from(i);
        inverse.advance(&model, &mut planned, &goal, 1e-3);
        v = planned.state.v[6 + model.joint("left_ankle_roll").unwrap().0];
    }
    let off = (0..2).map(|s| start.soles[s].inv_mul(&planned.sole(s)).translation.vector.norm()).fold(0.0, f64::max);
    // One Newton step a call. The centre of mass moves by 2.24e-4 m over legs of 0.2 m, which
    // rotate by 1.1e-3 rad. A step misses half the square of that times 0.2 m, 1.3e-7 m, and the
    // same again remains of the previous step.
    assert!(off < 2.6e-7 && (planned.com() - goal.com).xy().norm() < 1e-6, "{off}");
    assert!(v.abs() > 0.01);
    // Under an unlimited bow command, joints stop at their limits.
    goal.com.x += 0.3;
    for _ in 0..200 {
        inverse.advance(&model, &mut planned, &goal, 1e-3);
    }
    for (joint, q) in model.joints.iter().zip(&planned.state.joints) {
        assert!(*q >= joint.lower && *q <= joint.upper, "{} at {q}", joint.name);
    }
}

#[test]
fn feed_forward_efforts_do_the_work_of_gravity_and_motion() {
    let (model, mut planned) = hoap2();
    let mut inverse = InverseKinematics::of_legs(&model, &planned);
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let goal = planned.goal();
    let mut rates = Rates::zero(2);
    let mut efforts = vec![0.0; model.nj()];
    for (com, acceleration) in [
        (Vector3::z(), Vector3::zeros()),
        (Vector3::y(), Vector3::zeros()),
        (Vector3::new(0.3, -0.2, 0.5), Vector3::new(0.4, 1.0, -0.6)),
    ] {
        rates.com = com;
        planned.state.v.fill(0.0);
        inverse.solve(&model, &mut planned, &goal, &rates).unwrap();
        let v = planned.state.v.clone();
        // At rest: the efforts then have no velocity products.
        planned.state.v.fill(0.0);
        planned.update(&model);
        let zmp: Vector2<f64> = Vector2::new(0.01, 0.015);
        feed_forward::efforts(&model, &mut planned, &gravity, &acceleration, &zmp, &mut efforts);
        let power: f64 = efforts.iter().zip(&v[6..]).map(|(t, q)| t * q).sum();
        // Soles at rest take no power and the root does not rotate, so joints work only against the
        // apparent gravity, and the floor's force is in equilibrium: sum f = -m (g - c'').
        // Velocities are damped by 1e-14 over the least eigenvalue of J J^T, some 1e-4: a relative
        // 1e-10.
        let truth = -model.mass() * (gravity - acceleration).dot(&com);
        assert!((power - truth).abs() < 1e-9 * truth.abs().max(10.0), "{power} {truth}");
    }
}

#[test]
fn balance_allocates_nothing() {
    let (model, mut planned) = hoap2();
    let mut inverse = InverseKinematics::of_legs(&model, &planned);
    let mut goal = planned.goal();
    goal.com.z -= 0.01;
    let (rates, mut efforts) = (Rates::zero(2), vec![0.0; model.nj()]);
    let allocations = count(|| {
        inverse.solve(&model, &mut planned, &goal, &rates).unwrap();
        inverse.advance(&model, &mut planned, &goal, 1e-3);
        let still = Vector3::zeros();
        feed_forward::efforts(&model, &mut planned, &still, &still, &Vector2::zeros(), &mut efforts);
    });
    assert_eq!(allocations, 0);
}
