//! Transmissions that couple joints of random trees: their rotors in every algorithm, and power.

use super::numeric::{GRAVITY, assert_near, dense, prepared};
use super::random_tree::{Random, samples};
use crate::support::counting::count;
use nalgebra::{DMatrix, DVector};
use stiction::dynamics::{aba, body, factor, rnea};
use stiction::robot::{JointId, Model, Transmission};

/// Rounding of sums over up to 30 links, amplified by the condition of M (up to about 1e4 on these trees).
const ROUNDING: f64 = 1e-11;

/// Up to three joints on the path to the last link, not in order, with T and T^-1.
fn transmission(model: &Model, r: &mut Random) -> (Transmission, DMatrix<f64>) {
    let path = std::iter::successors(Some(model.nj()), |l| model.links[*l].parent.map(|p| p.0));
    let mut joints: Vec<JointId> = path.take_while(|l| *l > 0).map(|l| JointId(l - 1)).take(3).collect();
    joints.rotate_left(1);
    let n = joints.len();
    // Diagonally dominant: regular.
    let gear = DMatrix::from_fn(n, n, |k, j| r.within(-1.0, 1.0) + if k == j { 5.0 } else { 0.0 });
    let inverse = gear.clone().try_inverse().expect("regular");
    let rows = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
    let inertia = (0..n).map(|_| r.within(0.0, 0.01)).collect();
    (Transmission::new("gear".into(), joints, rows(&gear), rows(&inverse), inertia), gear)
}

/// Velocities or efforts of its joints.
fn of_joints(of: &Transmission, all: &[f64]) -> DVector<f64> {
    DVector::from_iterator(of.number(), of.joints.iter().map(|id| all[id.0]))
}

#[test]
fn rotors_act_in_every_algorithm() {
    for (mut model, state, mut r) in samples() {
        let plain = dense(&prepared(&model, &state).mass);
        let (of, gear) = transmission(&model, &mut r);
        if !of.is_coupled() {
            continue;
        }
        let (nb, nv) = (model.nb(), model.nv());
        let rotors = DMatrix::from_diagonal(&DVector::from_vec(of.rotor_inertia.clone()));
        let reflected = gear.transpose() * rotors * &gear;
        let mut truth = plain;
        for (i, a) in of.joints.iter().enumerate() {
            for (j, b) in of.joints.iter().enumerate() {
                truth[(nb + a.0, nb + b.0)] += reflected[(i, j)];
            }
        }
        model.transmissions.push(of);
        let mut ws = prepared(&model, &state);
        // Rounding of two sums.
        assert!((dense(&ws.mass) - &truth).amax() < 1e-15 * truth.amax());
        let vdot = r.list(nv, 5.0);
        let tau: Vec<f64> =
            (&truth * DVector::from_column_slice(&vdot) + DVector::from_column_slice(&ws.bias)).as_slice().to_vec();
        let mut by_rnea = vec![0.0; nv];
        rnea::inverse_dynamics(&model, &mut ws, &vdot, &GRAVITY, &mut by_rnea);
        assert_near("RNEA", &by_rnea, &tau, ROUNDING);
        let mut by_aba = vec![0.0; nv];
        aba::forward_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut by_aba).expect("regular");
        assert_near("forward dynamics", &by_aba, &vdot, ROUNDING);
        let mut by_factor: Vec<f64> = tau.iter().zip(&ws.bias).map(|(t, h)| t - h).collect();
        factor::solve(&ws, &mut by_factor);
        assert_near("factor", &by_factor, &vdot, ROUNDING);
        let v = DVector::from_column_slice(&state.v);
        let energy = 0.5 * v.dot(&(&truth * &v));
        assert!((body::kinetic_energy(&model, &ws) - energy).abs() < ROUNDING * energy);
    }
}

#[test]
fn power_of_the_motors_is_that_of_the_joints() {
    for (model, state, mut r) in samples() {
        let (of, gear) = transmission(&model, &mut r);
        let (n, rates, tau) = (of.number(), &state.v[model.nb()..], r.list(model.nj(), 20.0));
        let torques: Vec<f64> = (0..n).map(|k| of.motor_torque(k, &tau)).collect();
        let speeds: Vec<f64> = (0..n).map(|k| of.motor_speed(k, rates)).collect();
        let of_motors: f64 = torques.iter().zip(&speeds).map(|(m, speed)| m * speed).sum();
        // Rounding of powers below 1000 W.
        assert!((of_motors - of_joints(&of, &tau).dot(&of_joints(&of, rates))).abs() < 1e-11);
        assert_near("speeds", &speeds, (gear * of_joints(&of, rates)).as_slice(), 1e-13);
        // Back to the efforts of the joints.
        let efforts: Vec<f64> = (0..n).map(|j| of.joint_effort(j, &torques)).collect();
        assert_near("efforts", &efforts, of_joints(&of, &tau).as_slice(), 1e-13);
    }
}

#[test]
fn rotors_allocate_nothing() {
    let (mut model, state, mut r) = samples().next().expect("a tree");
    let of = transmission(&model, &mut r).0;
    model.transmissions.push(of);
    let mut ws = prepared(&model, &state);
    let (tau, mut vdot) = (r.list(model.nv(), 1.0), vec![0.0; model.nv()]);
    let allocations = count(|| {
        aba::forward_dynamics(&model, &mut ws, &tau, &GRAVITY, &mut vdot).expect("regular");
        std::hint::black_box(body::kinetic_energy(&model, &ws));
    });
    assert_eq!(allocations, 0);
}
