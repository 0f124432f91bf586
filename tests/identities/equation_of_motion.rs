//! M, h, their factor and the three routes to accelerations agree with each other.

use super::numeric::{GRAVITY, along, assert_near, dense, error, prepared};
use super::random_tree::samples;
use nalgebra::{DMatrix, DVector, Vector3};
use stiction::dynamics::{DynamicsError, aba, crba, factor, kinematics, rnea};

/// Rounding of sums over up to 30 links, amplified by the condition of M (up to about 1e4 on these trees).
const ROUNDING: f64 = 1e-11;

#[test]
fn mass_matrix_columns_are_inverse_dynamics_of_unit_accelerations() {
    for (model, state, _) in samples() {
        let mut ws = prepared(&model, &state);
        let mass = dense(&ws.mass);
        for k in 0..model.nv() {
            let mut vdot = vec![0.0; model.nv()];
            vdot[k] = 1.0;
            let mut tau = vec![0.0; model.nv()];
            rnea::inverse_dynamics(&model, &mut ws, &vdot, &GRAVITY, &mut tau);
            let column: Vec<f64> = tau.iter().zip(&ws.bias).map(|(t, h)| t - h).collect();
            // h is subtracted: rounding relative to h, of order 100 here.
            assert_near("column", &column, mass.column(k).as_slice(), 1e-12 * 100.0);
        }
    }
}

#[test]
fn inverse_dynamics_is_mass_times_acceleration_plus_bias() {
    for (model, state, mut r) in samples() {
        let mut ws = prepared(&model, &state);
        let vdot = r.list(model.nv(), 5.0);
        let mut tau = vec![0.0; model.nv()];
        rnea::inverse_dynamics(&model, &mut ws, &vdot, &GRAVITY, &mut tau);
        let mut truth = vec![0.0; model.nv()];
        ws.mass.multiply(&vdot, &mut truth);
        truth.iter_mut().zip(&ws.bias).for_each(|(t, h)| *t += h);
        assert_near("M vdot + h", &tau, &truth, ROUNDING);
        let by_dense = dense(&ws.mass) * DVector::from_vec(vdot) + DVector::from_column_slice(&ws.bias);
        assert_near("TreeMatrix::multiply", &truth, by_dense.as_slice(), ROUNDING);
    }
}

#[test]
fn forward_dynamics_inverts_inverse_dynamics() {
    for (model, state, mut r) in samples() {
        let mut ws = prepared(&model, &state);
        let vdot = r.list(model.nv(), 5.0);
        let mut tau = vec![0.0; model.nv()];
        rnea::inverse_dynamics(&model, &mut ws, &vdot, &GRAVITY, &mut tau);
        let by_rnea: Vec<_> = ws.links.iter().map(|l| l.acceleration).collect();

        let mut by_aba = vec![0.0; model.nv()];
        aba::forward_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut by_aba).unwrap();
        assert_near("ABA", &by_aba, &vdot, ROUNDING);
        for (a, b) in ws.links.iter().zip(&by_rnea) {
            assert_near("linear", a.acceleration.linear.as_slice(), b.linear.as_slice(), ROUNDING * 10.0);
            assert_near("angular", a.acceleration.angular.as_slice(), b.angular.as_slice(), ROUNDING * 10.0);
        }

        let mut by_factor: Vec<f64> = tau.iter().zip(&ws.bias).map(|(t, h)| t - h).collect();
        factor::solve(&ws, &mut by_factor);
        assert_near("M^-1 (tau - h)", &by_factor, &vdot, ROUNDING);
    }
}

#[test]
fn the_product_of_the_factor_is_the_mass_matrix() {
    for (model, state, mut r) in samples() {
        let mut ws = prepared(&model, &state);
        let shift: Vec<f64> = r.list(model.nv(), 0.5).iter().map(|x| x.abs()).collect();
        for shifted in [false, true] {
            let mut truth = dense(&ws.mass);
            if shifted {
                factor::factorize_shifted(&mut ws, &shift).unwrap();
                truth += DMatrix::from_diagonal(&DVector::from_column_slice(&shift));
            }
            let l = DMatrix::from_fn(model.nv(), model.nv(), |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Less => 0.0,
                std::cmp::Ordering::Equal => 1.0 / ws.factor.get(i, i),
                std::cmp::Ordering::Greater => ws.factor.get(i, j),
            });
            let product = l.transpose() * &l;
            // Backward error of a Cholesky factorisation: nv times machine epsilon.
            assert_near("L^T L", product.as_slice(), truth.as_slice(), 1e-14);

            let x = DVector::from_vec(r.list(model.nv(), 1.0));
            let mut halves = (&truth * &x).as_slice().to_vec();
            factor::solve_lt(&ws.factor, &mut halves);
            assert_near("L^-T", &halves, (&l * &x).as_slice(), ROUNDING);
            factor::solve_l(&ws.factor, &mut halves);
            assert_near("L^-1", &halves, x.as_slice(), ROUNDING);
        }
    }
}

#[test]
fn products_with_the_mass_matrix_are_those_of_the_dense_one() {
    for (model, state, mut r) in samples() {
        let (nv, ws) = (model.nv(), prepared(&model, &state));
        let (mass, x) = (dense(&ws.mass), r.list(model.nv(), 3.0));
        let truth = &mass * DVector::from_column_slice(&x);
        let mut whole = vec![0.0; nv];
        ws.mass.multiply(&x, &mut whole);
        let rows: Vec<f64> = (0..nv).map(|k| ws.mass.row_times(k, &x)).collect();
        let mut columns = vec![0.0; nv];
        (0..nv).for_each(|k| ws.mass.add_column(k, x[k], &mut columns));
        // Rounding of sums.
        for product in [&whole, &rows, &columns] {
            assert_near("M x", product, truth.as_slice(), 1e-14);
        }
    }
}

#[test]
fn mass_matrix_is_symmetric_positive_definite_and_sparse_between_branches() {
    for (model, state, _) in samples() {
        let ws = prepared(&model, &state);
        let mass = dense(&ws.mass);
        assert!(mass.clone().cholesky().is_some());
        for (i, link) in model.links.iter().enumerate().skip(1) {
            let k = model.nb() + i - 1;
            let parent = link.parent.unwrap().0;
            let chain = ws.mass.pattern().chain(k);
            let truth = ws.support(stiction::robot::LinkId(parent));
            assert_eq!(&chain[..chain.len() - 1], truth, "support of {}", link.name);
        }
    }
}

/// d/dt M along the motion is 2 C plus a skew part, and C v = h at zero gravity, so v^T (Mdot v - 2
/// h) = 0. The stronger statement is w^T Mdot w = 2 w^T C w for every w, with C the Christoffel
/// matrix. C comes from differentiating h in v: dh/dv = C + C' with h quadratic in v, and Mdot = C
/// + C^T.
#[test]
fn mass_matrix_rate_minus_twice_coriolis_is_skew() {
    for (model, state, _) in samples() {
        let nv = model.nv();
        let nb = model.nb();
        if nb != 0 {
            // Floating velocities are quasi-coordinates, so Christoffel symbols do not apply; the
            // test of the power balance covers them. Here the weaker v^T (Mdot - 2 C) v = 0.
            let mut ws = prepared(&model, &state);
            rnea::bias(&mut ws, &Vector3::zeros());
            let h: f64 = ws.bias.iter().zip(&state.v).map(|(h, v)| h * v).sum();
            let rate = along(&state, &state.v, 1e-5, |s| {
                let ws = prepared(&model, s);
                let mut x = vec![0.0; nv];
                ws.mass.multiply(&state.v, &mut x);
                vec![x.iter().zip(&state.v).map(|(x, v)| x * v).sum()]
            });
            // Central difference with step 1e-5: truncation and rounding near 1e-9 of an energy rate of order 100.
            assert_near("v^T Mdot v", &[2.0 * h], &rate, 1e-7);
            continue;
        }
        let mass_at = |s: &stiction::dynamics::State| dense(&prepared(&model, s).mass).as_slice().to_vec();
        // dM/dq_k for each joint, hence Christoffel's C_ij = 1/2 sum_k (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) v_k.
        let derivative: Vec<DMatrix<f64>> = (0..nv)
            .map(|k| {
                let mut unit = vec![0.0; nv];
                unit[k] = 1.0;
                DMatrix::from_vec(nv, nv, along(&state, &unit, 1e-5, mass_at))
            })
            .collect();
        let mut c = DMatrix::<f64>::zeros(nv, nv);
        for i in 0..nv {
            for j in 0..nv {
                for k in 0..nv {
                    let d = derivative[k][(i, j)] + derivative[j][(i, k)] - derivative[i][(j, k)];
                    c[(i, j)] += 0.5 * d * state.v[k];
                }
            }
        }
        let mut ws = prepared(&model, &state);
        rnea::bias(&mut ws, &Vector3::zeros());
        let cv: DVector<f64> = &c * DVector::from_column_slice(&state.v);
        assert_near("C v = h", &ws.bias, cv.as_slice(), 1e-7);
        let rate = DMatrix::from_vec(nv, nv, along(&state, &state.v, 1e-5, mass_at));
        let skew = rate - c * 2.0;
        let symmetric = &skew + skew.transpose();
        assert_near("Mdot - 2C + its transpose", symmetric.as_slice(), &vec![0.0; nv * nv], 1e-7);
    }
}

#[test]
fn a_joint_that_moves_no_mass_is_refused_by_name() {
    let (mut model, state, _) = samples().nth(4).unwrap();
    let last = model.links.len() - 1;
    model.links[last].mass = 0.0;
    model.links[last].inertia.fill(0.0);
    model.joints[last - 1].armature = 0.0;
    let mut ws = stiction::dynamics::Workspace::new(&model);
    kinematics::update(&model, &state, &mut ws);
    crba::mass_matrix(&model, &mut ws);
    let dof = model.nb() + last - 1;
    let refused = |e: DynamicsError| {
        let DynamicsError::Singular { dof: found, .. } = e;
        assert_eq!(found, dof);
        assert!(e.to_string().contains(&dof.to_string()));
    };
    refused(factor::factorize(&mut ws).unwrap_err());
    let tau = vec![0.0; model.nv()];
    let mut vdot = tau.clone();
    refused(aba::forward_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut vdot).unwrap_err());

    // Armature alone is enough to move.
    model.joints[last - 1].armature = 0.01;
    crba::mass_matrix(&model, &mut ws);
    factor::factorize(&mut ws).unwrap();
    aba::forward_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut vdot).unwrap();
    rnea::bias(&mut ws, &GRAVITY);
    let mut truth: Vec<f64> = ws.bias.iter().map(|h| -h).collect();
    factor::solve(&ws, &mut truth);
    assert!(error(&vdot, &truth) < ROUNDING);
}

/// Two joints on one axis with nothing between them: M is singular up to rounding, which must not
/// count as inertia.
#[test]
fn redundant_joints_are_refused() {
    let mut r = super::random_tree::Random::new(77);
    for seed in 0..20 {
        let mut model = super::random_tree::tree(seed, 4, stiction::robot::Base::Floating);
        model.joints.iter_mut().for_each(|j| {
            j.kind = stiction::robot::JointKind::Revolute;
            j.armature = 0.0;
        });
        for (i, link) in model.links.iter_mut().enumerate().skip(1) {
            link.parent = Some(stiction::robot::LinkId(i - 1));
        }
        model.links[3].mass = 0.0;
        model.links[3].inertia.fill(0.0);
        model.links[4].rotation.fill_with_identity();
        model.links[4].offset.fill(0.0);
        let state = super::random_tree::state(&model, &mut r);
        let mut ws = stiction::dynamics::Workspace::new(&model);
        let got = stiction::dynamics::prepare(&model, &state, &GRAVITY, &mut ws);
        assert!(matches!(got, Err(DynamicsError::Singular { dof: 8, .. })), "{got:?} {:?}", ws.factor.row(8).last());
    }
}

#[test]
fn a_state_that_is_not_finite_is_refused() {
    let (model, mut state, _) = samples().nth(2).unwrap();
    state.joints[0] = f64::NAN;
    let mut ws = stiction::dynamics::Workspace::new(&model);
    let got = stiction::dynamics::prepare(&model, &state, &GRAVITY, &mut ws);
    assert!(matches!(got, Err(DynamicsError::Singular { .. })));
}
