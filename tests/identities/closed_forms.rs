//! Robots with closed-form equations of motion.

use super::numeric::assert_near;
use super::random_tree::{Random, joint, link};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use stiction::dynamics::{self, State, Workspace, aba, body, factor};
use stiction::robot::{Base, JointKind, Model};

fn fixed(name: &str) -> Model {
    let root = link("root", None, (0.0, Vector3::zeros(), Matrix3::zeros()));
    Model::tree(name.into(), Base::Fixed, vec![root], vec![])
}

/// `vdot` by the factorised mass matrix and by ABA, after checking that they agree.
fn acceleration(model: &Model, state: &State, tau: &[f64], gravity: &Vector3<f64>) -> Vec<f64> {
    let mut ws = Workspace::new(model);
    dynamics::prepare(model, state, gravity, &mut ws).unwrap();
    let mut x: Vec<f64> = tau.iter().zip(&ws.bias).map(|(t, h)| t - h).collect();
    factor::solve(&ws, &mut x);
    let mut by_aba = vec![0.0; model.nv()];
    aba::forward_dynamics(model, &mut ws, tau, gravity, &mut by_aba).unwrap();
    assert_near("ABA and M^-1", &by_aba, &x, 1e-12);
    x
}

/// Two bars swinging in the vertical plane: joint axes along world -y, angles from hanging straight down.
///
/// With l1 the first bar's length, c1 and c2 the distances of the centres of mass, I1 and I2 the inertias about them:
///
/// ```text
/// M11 = I1 + I2 + m1 c1^2 + m2 (l1^2 + c2^2 + 2 l1 c2 cos q2),  M12 = I2 + m2 (c2^2 + l1 c2 cos q2),  M22 = I2 + m2 c2^2
/// h1 = -m2 l1 c2 sin q2 (2 q1' q2' + q2'^2) + g ((m1 c1 + m2 l1) sin q1 + m2 c2 sin(q1 + q2))
/// h2 =  m2 l1 c2 sin q2 q1'^2 + g m2 c2 sin(q1 + q2)
/// ```
#[test]
fn double_pendulum() {
    let (m1, c1, l1, i1) = (1.3, 0.4, 0.7, 0.05);
    let (m2, c2, i2) = (0.8, 0.25, 0.03);
    let g = 9.81;
    let mut model = fixed("double pendulum");
    model.home = vec![0.0; 2];
    // Internal frame: z along world -y, x down. Only the inertia about z matters, so the others
    // have arbitrary values.
    let inertia = |about_z: f64| Matrix3::from_diagonal(&Vector3::new(0.4, 0.7, about_z));
    let mut first = link("first", Some(0), (m1, Vector3::new(c1, 0.0, 0.05), inertia(i1)));
    first.rotation = Matrix3::from_columns(&[-Vector3::z(), Vector3::x(), -Vector3::y()]);
    let mut second = link("second", Some(1), (m2, Vector3::new(c2, 0.0, -0.03), inertia(i2)));
    second.offset = Vector3::new(l1, 0.0, 0.1);
    model.links.extend([first, second]);
    model.joints = vec![joint("q1", JointKind::Revolute), joint("q2", JointKind::Continuous)];

    let mut r = Random::new(3);
    for _ in 0..20 {
        let mut state = State::home(&model);
        state.joints = r.list(2, 3.0);
        state.v = r.list(2, 5.0);
        let tau = r.list(2, 3.0);
        let (q1, q2, w1, w2) = (state.joints[0], state.joints[1], state.v[0], state.v[1]);

        let m11 = i1 + i2 + m1 * c1 * c1 + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * q2.cos());
        let m12 = i2 + m2 * (c2 * c2 + l1 * c2 * q2.cos());
        let m22 = i2 + m2 * c2 * c2;
        let h1 = -m2 * l1 * c2 * q2.sin() * (2.0 * w1 * w2 + w2 * w2)
            + g * ((m1 * c1 + m2 * l1) * q1.sin() + m2 * c2 * (q1 + q2).sin());
        let h2 = m2 * l1 * c2 * q2.sin() * w1 * w1 + g * m2 * c2 * (q1 + q2).sin();

        let mut ws = Workspace::new(&model);
        let gravity = Vector3::new(0.0, 0.0, -g);
        dynamics::prepare(&model, &state, &gravity, &mut ws).unwrap();
        // A few dozen operations on numbers of order 1 to 100: rounding only.
        assert_near("M", &[ws.mass.get(0, 0), ws.mass.get(0, 1), ws.mass.get(1, 1)], &[m11, m12, m22], 1e-12);
        assert_near("h", &ws.bias, &[h1, h2], 1e-12);
        let (b1, b2, det) = (tau[0] - h1, tau[1] - h2, m11 * m22 - m12 * m12);
        let truth = [(m22 * b1 - m12 * b2) / det, (m11 * b2 - m12 * b1) / det];
        assert_near("q''", &acceleration(&model, &state, &tau, &gravity), &truth, 1e-12);
    }
}

/// A mass on a vertical slide hanging on a horizontal one: x'' = f / (m1 + m2), z'' = f2 / m2 - g.
#[test]
fn crossed_slides() {
    let (m1, m2) = (2.0, 0.5);
    let mut model = fixed("slides");
    model.home = vec![0.0; 2];
    let mut across = link("across", Some(0), (m1, Vector3::zeros(), Matrix3::identity()));
    across.rotation = Matrix3::from_columns(&[Vector3::y(), Vector3::z(), Vector3::x()]);
    let mut up = link("up", Some(1), (m2, Vector3::new(0.1, 0.2, 0.3), Matrix3::identity()));
    up.rotation = across.rotation.transpose();
    model.links.extend([across, up]);
    model.joints = vec![joint("x", JointKind::Prismatic), joint("z", JointKind::Prismatic)];
    let mut state = State::home(&model);
    state.joints = vec![0.4, -0.7];
    state.v = vec![1.0, -2.0];
    let got = acceleration(&model, &state, &[3.0, 4.0], &Vector3::new(0.0, 0.0, -9.81));
    assert_near("x'', z''", &got, &[3.0 / (m1 + m2), 4.0 / m2 - 9.81], 1e-14);
    let com = body::center_of_mass(&{
        let mut ws = Workspace::new(&model);
        dynamics::kinematics::update(&model, &state, &mut ws);
        ws
    });
    let truth = [0.4 + m2 * 0.1 / (m1 + m2), m2 * 0.2 / (m1 + m2), m2 * (0.3 - 0.7) / (m1 + m2)];
    assert_near("com", com.as_slice(), &truth, 1e-15);
}

/// Armature adds to the inertia of its joint: q'' = tau / (I + m c^2 + J).
#[test]
fn armature_adds_to_the_inertia_of_a_wheel() {
    let mut model = fixed("wheel");
    model.home = vec![0.0];
    model.links.push(link("wheel", Some(0), (2.0, Vector3::new(0.1, 0.0, 0.0), Matrix3::identity() * 0.3)));
    model.joints.push(joint("spin", JointKind::Continuous));
    model.joints[0].armature = 0.25;
    let mut state = State::home(&model);
    state.v = vec![7.0];
    let got = acceleration(&model, &state, &[1.5], &Vector3::zeros());
    assert_near("q''", &got, &[1.5 / (0.3 + 2.0 * 0.01 + 0.25)], 1e-15);
    let mut ws = Workspace::new(&model);
    dynamics::kinematics::update(&model, &state, &mut ws);
    assert_near("T", &[body::kinetic_energy(&model, &ws)], &[0.5 * 0.57 * 49.0], 1e-14);
}

/// Torque-free body whose frame is away from its centre of mass. Euler's equations I w' = -w x I w
/// hold in body axes, and the centre of mass falls with gravity. The origin's acceleration follows
/// by rigid-body kinematics.
#[test]
fn free_body_follows_euler() {
    let mut r = Random::new(8);
    for _ in 0..20 {
        let turn = r.rotation();
        let inertia = turn * Matrix3::from_diagonal(&Vector3::new(0.2, 0.5, 0.6)) * turn.transpose();
        let com = r.vector(0.4);
        let model =
            Model { base: Base::Floating, links: vec![link("body", None, (1.7, com, inertia))], ..fixed("body") };
        let mut state = State::home(&model);
        state.position = r.vector(1.0);
        state.rotation = UnitQuaternion::from_scaled_axis(r.vector(2.0));
        state.v = r.list(6, 4.0);
        let g = Vector3::new(0.1, 0.2, -9.81);
        let got = acceleration(&model, &state, &[0.0; 6], &g);

        let w = Vector3::new(state.v[3], state.v[4], state.v[5]);
        let body_w = state.rotation.inverse() * w;
        // w' is the same vector whether differentiated in the body or in the world, since w x w = 0.
        let body_wdot = -inertia.try_inverse().unwrap() * body_w.cross(&(inertia * body_w));
        let wdot = state.rotation * body_wdot;
        let c = state.rotation * com;
        let p = g - wdot.cross(&c) - w.cross(&w.cross(&c));
        assert_near("p''", &got[..3], p.as_slice(), 1e-13);
        assert_near("w'", &got[3..], wdot.as_slice(), 1e-13);
    }
}

/// A torque-free body spun about its middle axis flips over (Dzhanibekov); energy and momentum are
/// conserved. Midpoint rule.
#[test]
fn a_tumbling_body_conserves_energy_and_momentum() {
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.2, 0.5, 0.6));
    let body = link("body", None, (1.7, Vector3::new(0.1, -0.2, 0.3), inertia));
    let model = Model { base: Base::Floating, links: vec![body], ..fixed("top") };
    let mut state = State::home(&model);
    state.v = vec![0.3, -0.1, 0.2, 0.01, 3.0, 0.02];
    let mut ws = Workspace::new(&model);
    let mut rate = |s: &State| {
        let mut a = vec![0.0; 6];
        dynamics::kinematics::update(&model, s, &mut ws);
        let conserved = (body::kinetic_energy(&model, &ws), body::momentum(&ws));
        aba::forward_dynamics(&model, &mut ws, &[0.0; 6], &Vector3::zeros(), &mut a).unwrap();
        (a, conserved)
    };
    let before = rate(&state).1;
    let dt = 1e-3;
    let mut least_spin = f64::INFINITY;
    for _ in 0..7000 {
        let (a, _) = rate(&state);
        let mut middle = state.clone();
        middle.displace(&state.v.iter().map(|v| 0.5 * dt * v).collect::<Vec<_>>());
        middle.v.iter_mut().zip(&a).for_each(|(v, a)| *v += 0.5 * dt * a);
        let (a, _) = rate(&middle);
        state.displace(&middle.v.iter().map(|v| dt * v).collect::<Vec<_>>());
        state.v.iter_mut().zip(&a).for_each(|(v, a)| *v += dt * a);
        let spin = state.rotation.inverse() * Vector3::new(state.v[3], state.v[4], state.v[5]);
        least_spin = least_spin.min(spin.y);
    }
    assert!(least_spin < -2.5, "it must flip for the test to mean anything: {least_spin}");
    let after = rate(&state).1;
    // Midpoint rule: global error (w dt)^2 w t / 6 = 2e-5.
    assert_near("T", &[after.0], &[before.0], 1e-4);
    assert_near("k", after.1.angular.as_slice(), before.1.angular.as_slice(), 1e-4);
    assert_near("l", after.1.linear.as_slice(), before.1.linear.as_slice(), 1e-4);
}
