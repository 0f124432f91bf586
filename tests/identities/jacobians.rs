//! Jacobians, point motions and forces on points against differences and against each other.

use super::numeric::{GRAVITY, along, assert_near, prepared};
use super::random_tree::{Random, samples};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use stiction::dynamics::{State, Workspace, body, jacobian, kinematics, link_force};
use stiction::robot::{LinkId, Model};

/// A link and a point fixed in it (internal frame).
fn pick(model: &Model, r: &mut Random) -> (LinkId, Vector3<f64>) {
    (LinkId(r.below(model.links.len())), r.vector(0.3))
}

fn at(model: &Model, state: &State) -> Workspace {
    let mut ws = Workspace::new(model);
    kinematics::update(model, state, &mut ws);
    ws
}

#[test]
fn frame_jacobian_is_the_derivative_of_the_pose() {
    for (model, state, mut r) in samples() {
        let (link, local) = pick(&model, &mut r);
        let ws = at(&model, &state);
        let mut j = vec![0.0; 6 * model.nv()];
        jacobian::frame(&ws, link, &ws.point(link, &local), &mut j);
        for k in 0..model.nv() {
            let mut unit = vec![0.0; model.nv()];
            unit[k] = 1.0;
            let rate = along(&state, &unit, 1e-5, |s| {
                let ws = at(&model, s);
                let mut pose = ws.point(link, &local).as_slice().to_vec();
                pose.extend(ws.links[link.0].rotation.as_slice());
                pose
            });
            // [omega]x = R' R^T
            let spin = Matrix3::from_column_slice(&rate[3..]) * ws.links[link.0].rotation.transpose();
            let mut truth = rate[..3].to_vec();
            truth.extend([spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]]);
            // Central difference with step 1e-5: about 1e-10 truncation plus 1e-11 rounding.
            assert_near("column", &j[6 * k..6 * k + 6], &truth, 1e-9);
        }
    }
}

#[test]
fn point_velocity_is_jacobian_times_v_and_force_is_its_transpose() {
    for (model, state, mut r) in samples() {
        let (link, local) = pick(&model, &mut r);
        let ws = at(&model, &state);
        let point = ws.point(link, &local);
        let mut j = vec![0.0; 6 * model.nv()];
        jacobian::frame(&ws, link, &point, &mut j);
        let j = DMatrix::from_vec(6, model.nv(), j);
        let twist = jacobian::link_twist(&ws, link, &point);
        let got = [twist.linear.as_slice(), twist.angular.as_slice()].concat();
        let truth = &j * DVector::from_column_slice(&state.v);
        assert_near("J v", &got, truth.as_slice(), 1e-13);
        assert_eq!(jacobian::point_velocity(&ws, link, &point), twist.linear);

        let (f, n) = (r.vector(10.0), r.vector(10.0));
        let before = r.list(model.nv(), 1.0);
        let mut tau = before.clone();
        link_force::accumulate(&ws, link, &point, &f, &n, &mut tau);
        let wrench = DVector::from_iterator(6, f.iter().chain(n.iter()).copied());
        let truth = j.transpose() * wrench + DVector::from_vec(before);
        assert_near("J^T (f, n)", &tau, truth.as_slice(), 1e-13);
    }
}

#[test]
fn point_acceleration_is_the_rate_of_point_velocity() {
    for (model, state, mut r) in samples() {
        let (link, local) = pick(&model, &mut r);
        let vdot = r.list(model.nv(), 5.0);
        let mut ws = at(&model, &state);
        kinematics::accelerations(&mut ws, &vdot);
        let a = jacobian::point_acceleration(&ws, link, &ws.point(link, &local));
        let got = [a.linear.as_slice(), a.angular.as_slice()].concat();
        let twist_at = |t: f64| {
            let mut s = state.clone();
            s.displace(&state.v.iter().zip(&vdot).map(|(v, a)| t * (v + 0.5 * t * a)).collect::<Vec<_>>());
            s.v.iter_mut().zip(&vdot).for_each(|(v, a)| *v += t * a);
            let ws = at(&model, &s);
            let twist = jacobian::link_twist(&ws, link, &ws.point(link, &local));
            [twist.linear.as_slice(), twist.angular.as_slice()].concat()
        };
        let h = 1e-5;
        let rate: Vec<f64> = twist_at(h).iter().zip(twist_at(-h)).map(|(b, a)| (b - a) / (2.0 * h)).collect();
        // Truncation h^2 times the third derivative (1e3 to 1e4 on the longest chains).
        assert_near("p'', omega'", &got, &rate, 1e-6);
    }
}

#[test]
fn centre_of_mass_jacobian_gives_its_velocity() {
    for (model, state, _) in samples() {
        let ws = prepared(&model, &state);
        let mut j = vec![0.0; 3 * model.nv()];
        jacobian::center_of_mass(&ws, &mut j);
        let got = DMatrix::from_vec(3, model.nv(), j) * DVector::from_column_slice(&state.v);
        let velocity = body::center_of_mass_velocity(&ws);
        assert_near("J_com v", got.as_slice(), velocity.as_slice(), 1e-13);
        let rate = along(&state, &state.v, 1e-5, |s| body::center_of_mass(&at(&model, s)).as_slice().to_vec());
        assert_near("d com / dt", velocity.as_slice(), &rate, 1e-9);
    }
}

/// The gravity part of h is the gradient of the potential energy.
#[test]
fn bias_at_rest_is_the_gradient_of_potential_energy() {
    for (model, mut state, _) in samples() {
        state.v.fill(0.0);
        let ws = prepared(&model, &state);
        let gradient: Vec<f64> = (0..model.nv())
            .map(|k| {
                let mut unit = vec![0.0; model.nv()];
                unit[k] = 1.0;
                along(&state, &unit, 1e-4, |s| vec![body::potential_energy(&at(&model, s), &GRAVITY)])[0]
            })
            .collect();
        // Energies reach 1e3 J, so rounding in the difference is 1e-9 and truncation about the same.
        assert_near("h at rest", &ws.bias, &gradient, 1e-8);
    }
}
