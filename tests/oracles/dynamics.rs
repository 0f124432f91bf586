//! Compares rigid-body dynamics with Pinocchio 4.1 on real robots.

use super::dynamics_oracle::{Configuration, Oracle, Subject, matrix};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use stiction::dynamics::{self, Reduced, State, Workspace, aba, body, factor, jacobian, reduced, rnea};
use stiction::robot::LinkId;

/// Rounding of both sides: a few hundred operations, and for accelerations the condition of M (1e3
/// to 1e5 on these robots).
const BOUND: f64 = 1e-10;

/// Asserts agreement relative to the greatest entry of the true values.
#[track_caller]
fn assert_agrees(what: &str, got: &[f64], truth: &[f64]) {
    assert_eq!(got.len(), truth.len(), "{what}");
    let scale = truth.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for (i, (g, t)) in got.iter().zip(truth).enumerate() {
        // This form of the comparison also fails for NaN.
        assert!((g - t).abs() <= BOUND * scale, "{what}[{i}]: {g} against {t}");
    }
}

fn floats(m: &dynamics::Motion) -> [f64; 6] {
    dynamics::Force::new(m.linear, m.angular).to_array()
}

fn check(oracle: &Oracle, subject: &Subject) {
    let gravity = Vector3::from(oracle.gravity);
    assert!(!oracle.configurations.is_empty());
    assert_agrees("mass", &[subject.model.mass()], &[oracle.total_mass]);
    for truth in &oracle.configurations {
        let mut state = State::home(&subject.model);
        state.position = Vector3::from(truth.position);
        let turn = Rotation3::from_matrix_unchecked(matrix(&truth.rotation));
        state.rotation = UnitQuaternion::from_rotation_matrix(&turn);
        for (&j, q) in subject.joint.iter().zip(&truth.joints) {
            state.joints[j] = *q;
        }
        state.v = subject.ours(&truth.v);
        let mut ws = Workspace::new(&subject.model);
        dynamics::prepare(&subject.model, &state, &gravity, &mut ws).expect("real robots move mass everywhere");
        poses(subject, truth, &ws);
        whole_body(subject, truth, &ws, &gravity);
        equation_of_motion(subject, truth, &mut ws, &gravity);
        frames(oracle, subject, truth, &mut ws);
        contact(subject, truth, &ws);
    }
}

fn poses(subject: &Subject, truth: &Configuration, ws: &Workspace) {
    for (l, &link) in subject.link.iter().enumerate() {
        let frame = &subject.frame[l];
        let position = ws.point(LinkId(link), &frame.translation.vector);
        let rotation = ws.links[link].rotation * frame.rotation.to_rotation_matrix();
        assert_agrees("position", (position - ws.position).as_slice(), &{
            let p = Vector3::from(truth.positions[l]) - ws.position;
            // The root is at zero, which gives no scale.
            if l == 0 { [0.0; 3] } else { [p.x, p.y, p.z] }
        });
        assert_agrees("rotation", rotation.as_slice(), matrix(&truth.rotations[l]).as_slice());
    }
}

fn whole_body(subject: &Subject, truth: &Configuration, ws: &Workspace, gravity: &Vector3<f64>) {
    let momentum = body::momentum(ws);
    assert_agrees("com", body::center_of_mass(ws).as_slice(), &truth.com);
    assert_agrees("com velocity", body::center_of_mass_velocity(ws).as_slice(), &truth.com_velocity);
    assert_agrees("linear momentum", momentum.linear.as_slice(), &truth.momentum[..3]);
    assert_agrees("angular momentum", momentum.angular.as_slice(), &truth.momentum[3..]);
    assert_agrees("kinetic energy", &[body::kinetic_energy(&subject.model, ws)], &[truth.kinetic_energy]);
    assert_agrees("potential energy", &[body::potential_energy(ws, gravity)], &[truth.potential_energy]);
}

fn equation_of_motion(subject: &Subject, truth: &Configuration, ws: &mut Workspace, gravity: &Vector3<f64>) {
    let model = &subject.model;
    let nv = model.nv();
    let pairs = (0..nv).flat_map(|i| (0..=i).map(move |j| (i, j)));
    let mass: Vec<f64> = pairs.map(|(i, j)| ws.mass.get(subject.velocity(i), subject.velocity(j))).collect();
    assert_agrees("M", &mass, &truth.mass_lower);
    assert_agrees("h", &ws.bias, &subject.ours(&truth.bias));

    let mut tau = vec![0.0; nv];
    rnea::inverse_dynamics(model, ws, &subject.ours(&truth.vdot), gravity, &mut tau);
    assert_agrees("inverse dynamics", &tau, &subject.ours(&truth.inverse_dynamics));

    let tau = subject.ours(&truth.tau);
    let forward = subject.ours(&truth.forward_dynamics);
    let mut vdot = vec![0.0; nv];
    aba::forward_dynamics(model, ws, &tau, gravity, &mut vdot).expect("as above");
    assert_agrees("forward dynamics by ABA", &vdot, &forward);
    let mut vdot: Vec<f64> = tau.iter().zip(&ws.bias).map(|(t, h)| t - h).collect();
    factor::solve(ws, &mut vdot);
    assert_agrees("forward dynamics by the factor", &vdot, &forward);
}

fn frames(oracle: &Oracle, subject: &Subject, truth: &Configuration, ws: &mut Workspace) {
    let nv = subject.model.nv();
    dynamics::kinematics::accelerations(ws, &subject.ours(&truth.vdot));
    for (i, frame) in truth.frames.iter().enumerate() {
        let sole = &subject.model.soles[i];
        let point = ws.point(sole.link, &sole.vertices[0]);
        assert_agrees("frame", point.as_slice(), &frame.point);
        let mut j = vec![0.0; 6 * nv];
        jacobian::frame(ws, sole.link, &point, &mut j);
        let truth: Vec<f64> = (0..6).flat_map(|r| subject.ours(&frame.jacobian[r])).collect();
        let got: Vec<f64> = (0..6).flat_map(|r| (0..nv).map(move |k| 6 * k + r)).map(|at| j[at]).collect();
        assert_agrees("J", &got, &truth);
        assert_agrees("twist", &floats(&jacobian::link_twist(ws, sole.link, &point)), &frame.velocity);
        assert_agrees(
            "p'', omega'",
            &floats(&jacobian::point_acceleration(ws, sole.link, &point)),
            &frame.acceleration,
        );
    }
    assert_eq!(truth.frames.len(), oracle.soles.len());
}

fn contact(subject: &Subject, truth: &Configuration, ws: &Workspace) {
    let mut problem = Reduced::new(&subject.model, ws);
    reduced::assemble(ws, &matrix(&truth.floor), &subject.ours(&truth.tau), &mut problem);
    let size = 6 * problem.n;
    let lower = (0..size).flat_map(|i| (0..=i).map(move |j| i + size * j));
    let w: Vec<f64> = lower.map(|at| problem.w[at]).collect();
    assert_agrees("W", &w, &truth.contact_w_lower);
    assert_agrees("a0", &problem.a0, &truth.contact_a0);
    assert_agrees("sole velocity", &problem.velocity, &truth.contact_velocity);
}

macro_rules! frozen {
    ($($name:ident),*) => {$(
        #[test]
        fn $name() {
            let oracle = Oracle::parse(include_str!(concat!("dynamics_", stringify!($name), ".json")));
            check(&oracle, &oracle.recorded());
        }
    )*};
}

frozen!(talos, solo12, tiago, panda);

#[test]
fn hoap2() {
    let oracle = Oracle::parse(include_str!("dynamics_hoap2.json"));
    check(&oracle, &oracle.loaded("robots/hoap2/hoap2.toml"));
}
