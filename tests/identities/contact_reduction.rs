//! The reduced contact problem against its dense definition and against differences of the sole's motion.

use super::numeric::{GRAVITY, along, assert_near, dense, prepared};
use super::random_tree::{Random, samples};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use stiction::dynamics::{Reduced, State, Workspace, factor, jacobian, kinematics, reduced};
use stiction::robot::{Model, SoleId};

fn assembled(model: &Model, state: &State, floor: &Matrix3<f64>, tau: &[f64]) -> (Workspace, Reduced) {
    let ws = prepared(model, state);
    let mut out = Reduced::new(model, &ws);
    reduced::assemble(&ws, floor, tau, &mut out);
    (ws, out)
}

/// J, 6F x nv in floor axes, assembled from the frame Jacobians.
fn dense_jacobian(model: &Model, ws: &Workspace, out: &Reduced, floor: &Matrix3<f64>) -> DMatrix<f64> {
    let mut j = DMatrix::zeros(6 * out.n, model.nv());
    let mut frame = vec![0.0; 6 * model.nv()];
    for (s, sole) in model.soles.iter().enumerate() {
        jacobian::frame(ws, sole.link, &out.reference[s], &mut frame);
        for k in 0..model.nv() {
            for half in 0..2 {
                let world = Vector3::from_column_slice(&frame[6 * k + 3 * half..6 * k + 3 * half + 3]);
                j.fixed_view_mut::<3, 1>(6 * s + 3 * half, k).copy_from(&(floor.transpose() * world));
            }
        }
    }
    j
}

fn cases() -> impl Iterator<Item = (Model, State, Matrix3<f64>, Vec<f64>, Random)> {
    samples().map(|(model, state, mut r)| {
        let floor = r.rotation();
        let tau = r.list(model.nv(), 20.0);
        (model, state, floor, tau, r)
    })
}

fn free(ws: &Workspace, out: &Reduced) -> Vec<f64> {
    let mut a = vec![0.0; ws.nv()];
    reduced::free(ws, out, &mut a);
    a
}

#[test]
fn w_and_the_free_acceleration_equal_their_dense_definitions() {
    for (model, state, floor, tau, _) in cases() {
        let (ws, out) = assembled(&model, &state, &floor, &tau);
        let j = dense_jacobian(&model, &ws, &out, &floor);
        let inverse = dense(&ws.mass).try_inverse().unwrap();
        // Rounding times the condition of M, up to about 1e4.
        assert_near("W", &out.w, (&j * &inverse * j.transpose()).as_slice(), 1e-11);
        let force = DVector::from_column_slice(&tau) - DVector::from_column_slice(&ws.bias);
        assert_near("free", &free(&ws, &out), (&inverse * force).as_slice(), 1e-11);
        let velocity = &j * DVector::from_column_slice(&state.v);
        assert_near("J v", &out.velocity, velocity.as_slice(), 1e-13);
        for (a, b) in [(0, 1), (2, 2), (3, 0)] {
            let block = out.block(SoleId(a), SoleId(b));
            assert_eq!(block[4][1], out.w[6 * a + 1 + 6 * out.n * (6 * b + 4)]);
        }
    }
}

#[test]
fn a0_is_the_rate_of_the_sole_velocity_under_the_free_acceleration() {
    for (model, state, floor, tau, _) in cases() {
        let (ws, out) = assembled(&model, &state, &floor, &tau);
        let free = free(&ws, &out);
        // Follow q(t), v(t) with v(t) = v + t vdot; q follows from the mean velocity, exact to
        // second order.
        let at = |t: f64| {
            let mut s = state.clone();
            let mean: Vec<f64> = state.v.iter().zip(&free).map(|(v, a)| t * (v + 0.5 * t * a)).collect();
            s.displace(&mean);
            s.v.iter_mut().zip(&free).for_each(|(v, a)| *v += t * a);
            assembled(&model, &s, &floor, &tau).1.velocity
        };
        let h = 1e-5;
        let rate: Vec<f64> = at(h).iter().zip(at(-h)).map(|(b, a)| (b - a) / (2.0 * h)).collect();
        // Central difference at step 1e-5: truncation h^2 times third derivatives (accelerations reach 1e3).
        assert_near("a0", &out.a0, &rate, 1e-5);
    }
}

#[test]
fn reference_points_move_with_the_velocity_and_vertices_keep_their_arms() {
    for (model, state, floor, tau, _) in cases() {
        let (_, out) = assembled(&model, &state, &floor, &tau);
        let rate = along(&state, &state.v, 1e-6, |s| {
            let (_, out) = assembled(&model, s, &floor, &tau);
            out.reference.iter().flat_map(|p| (floor.transpose() * p).as_slice().to_vec()).collect()
        });
        let linear: Vec<f64> = out.velocity.chunks(6).flat_map(|v| v[..3].to_vec()).collect();
        assert_near("reference velocity", &linear, &rate, 1e-8);
        for (s, sole) in model.soles.iter().enumerate() {
            let sum: Vector3<f64> = out.vertices(SoleId(s)).iter().sum();
            assert_near("centroid", sum.as_slice(), &[0.0; 3], 1e-15);
            let mut ws = Workspace::new(&model);
            kinematics::update(&model, &state, &mut ws);
            for (arm, vertex) in out.vertices(SoleId(s)).iter().zip(&sole.vertices) {
                let world = ws.point(sole.link, vertex);
                assert_near("vertex", (out.reference[s] + floor * arm).as_slice(), world.as_slice(), 1e-14);
            }
        }
    }
}

#[test]
fn applying_wrenches_gives_the_accelerations_predicted_by_w() {
    for (model, state, floor, tau, mut r) in cases() {
        let (ws, mut out) = assembled(&model, &state, &floor, &tau);
        let w = r.list(6 * out.n, 10.0);
        let mut vdot = vec![0.0; model.nv()];
        reduced::advance(&ws, &mut out, 1.0, &w, &mut vdot);
        // The same in two parts, and over another time.
        let mut part = vec![0.0; model.nv()];
        reduced::apply(&ws, &mut out, &w, &mut part);
        let free = free(&ws, &out);
        let sum = |dt: f64| -> Vec<f64> { free.iter().zip(&part).map(|(a, x)| dt * a + x).collect() };
        // Rounding times the condition of M, as above.
        assert_near("parts", &sum(1.0), &vdot, 1e-11);
        let mut step = vec![0.0; model.nv()];
        reduced::advance(&ws, &mut out, 0.3, &w, &mut step);
        assert_near("step", &sum(0.3), &step, 1e-11);

        let j = dense_jacobian(&model, &ws, &out, &floor);
        let mut truth: Vec<f64> = tau.iter().zip(&ws.bias).map(|(t, h)| t - h).collect();
        let pushed = j.transpose() * DVector::from_column_slice(&w);
        truth.iter_mut().zip(pushed.iter()).for_each(|(t, p)| *t += p);
        factor::solve(&ws, &mut truth);
        assert_near("M^-1 (tau + J^T w - h)", &vdot, &truth, 1e-11);

        // The classical acceleration of each reference point, by kinematics alone.
        let mut ws = ws;
        kinematics::accelerations(&mut ws, &vdot);
        let size = 6 * out.n;
        let promised = DVector::from_column_slice(&out.a0)
            + DMatrix::from_column_slice(size, size, &out.w) * DVector::from_column_slice(&w);
        for (s, sole) in model.soles.iter().enumerate() {
            let a = jacobian::point_acceleration(&ws, sole.link, &out.reference[s]);
            let mut got = (floor.transpose() * a.linear).as_slice().to_vec();
            got.extend((floor.transpose() * a.angular).as_slice());
            assert_near("a0 + W w", &got, &promised.as_slice()[6 * s..6 * s + 6], 1e-10);
        }
    }
}

#[test]
fn gravity_alone_makes_every_free_sole_fall() {
    for (model, mut state, floor, _, _) in cases().filter(|c| c.0.nb() == 6) {
        state.v.fill(0.0);
        let (_, out) = assembled(&model, &state, &floor, &vec![0.0; model.nv()]);
        for a in out.a0.chunks(6) {
            assert_near("p''", &a[..3], (floor.transpose() * GRAVITY).as_slice(), 1e-11);
            assert_near("omega'", &a[3..], &[0.0; 3], 1e-11);
        }
    }
}
