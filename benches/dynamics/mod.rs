//! Dynamics algorithms on HOAP-2 (31 velocities), on a humanoid of Unitree G1's size (35) and on the
//! robots of `standing.toml`, each with two soles.

mod humanoid;

use super::standing;
use divan::Bencher;
use humanoid::humanoid;
use nalgebra::{Matrix3, Vector3};
use stiction::dynamics::{self, Reduced, State, Workspace, aba, crba, factor, kinematics, reduced, rnea};
use stiction::robot::Model;

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Names of the robots that are there; they live as long as the program.
fn robots() -> Vec<&'static str> {
    let others = standing::robots().into_iter().map(|robot| &*robot.name.leak()).filter(|name| *name != "hoap2");
    ["hoap2", "humanoid"].into_iter().chain(others).collect()
}

struct Setup {
    model: Model,
    state: State,
    ws: Workspace,
    tau: Vec<f64>,
    out: Vec<f64>,
}

fn setup(robot: &str) -> Setup {
    let model = match robot {
        "hoap2" => {
            let path = crate::repository().join("robots/hoap2/hoap2.toml");
            stiction::robot::load(&path).expect("our own robot").model
        }
        "humanoid" => humanoid([6, 7, 3]),
        _ => {
            let named = standing::robots().into_iter().find(|other| other.name == robot);
            stiction::robot::load(&named.expect("in the list").file).expect("a robot").model
        }
    };
    let mut state = State::home(&model);
    for (i, q) in state.joints.iter_mut().enumerate() {
        *q = 0.1 + 0.03 * i as f64;
    }
    for (i, v) in state.v.iter_mut().enumerate() {
        *v = 0.2 - 0.01 * i as f64;
    }
    let mut ws = Workspace::new(&model);
    dynamics::prepare(&model, &state, &GRAVITY, &mut ws).expect("every joint moves mass");
    let (tau, out) = (vec![0.1; model.nv()], vec![0.0; model.nv()]);
    Setup { model, state, ws, tau, out }
}

#[divan::bench(args = robots())]
fn kinematics(bencher: Bencher, robot: &str) {
    let mut s = setup(robot);
    super::each(bencher, || kinematics::update(&s.model, &s.state, &mut s.ws));
}

/// Kinematics and the bias force.
#[divan::bench(args = robots())]
fn rnea(bencher: Bencher, robot: &str) {
    let mut s = setup(robot);
    super::each(bencher, || {
        kinematics::update(&s.model, &s.state, &mut s.ws);
        rnea::inverse_dynamics(&s.model, &mut s.ws, &s.tau, &GRAVITY, &mut s.out);
    });
}

/// Positions, mass matrix and its factor.
#[divan::bench(args = robots())]
fn crba_and_factor(bencher: Bencher, robot: &str) {
    let mut s = setup(robot);
    super::each(bencher, || {
        kinematics::positions(&s.model, &s.state, &mut s.ws);
        crba::mass_matrix(&s.model, &mut s.ws);
        factor::factorize(&mut s.ws).is_ok()
    });
}

/// Kinematics and articulated bodies.
#[divan::bench(args = robots())]
fn aba(bencher: Bencher, robot: &str) {
    let mut s = setup(robot);
    super::each(bencher, || {
        kinematics::update(&s.model, &s.state, &mut s.ws);
        aba::forward_dynamics(&s.model, &mut s.ws, &s.tau, &GRAVITY, &mut s.out).is_ok()
    });
}

/// The reduced problem alone, for a prepared state.
#[divan::bench(args = robots())]
fn reduced_problem(bencher: Bencher, robot: &str) {
    let s = setup(robot);
    let mut problem = Reduced::new(&s.model, &s.ws);
    super::each(bencher, || reduced::assemble(&s.ws, &Matrix3::identity(), &s.tau, &mut problem));
}

/// The full evaluation from the state to the acceleration with both soles clamped: kinematics, h,
/// M, factor, W, a0, a Cholesky solve for the wrenches, the acceleration.
#[divan::bench(args = robots())]
fn constrained_forward_dynamics(bencher: Bencher, robot: &str) {
    let mut s = setup(robot);
    let mut problem = Reduced::new(&s.model, &s.ws);
    super::each(bencher, || {
        dynamics::prepare(&s.model, &s.state, &GRAVITY, &mut s.ws).expect("every joint moves mass");
        reduced::assemble(&s.ws, &Matrix3::identity(), &s.tau, &mut problem);
        let w = nalgebra::SMatrix::<f64, 12, 12>::from_column_slice(&problem.w);
        let a0 = nalgebra::SVector::<f64, 12>::from_column_slice(&problem.a0);
        let wrench = w.cholesky().expect("bent legs: W is regular").solve(&-a0);
        reduced::advance(&s.ws, &mut problem, 1.0, wrench.as_slice(), &mut s.out);
    });
}
