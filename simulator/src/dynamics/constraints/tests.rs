//! Conditions against difference quotients and dense solutions.

use super::*;
use crate::dynamics::closing::{close, project};
use crate::dynamics::reduced::ContactFrame;
use crate::dynamics::{self, Reduced, reduced};
use crate::dynamics::{State, Workspace};
use crate::robot::{Coupling, JointId, SoleId, parse};
use crate::robot::{LinkId, LoopKind};
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, UnitQuaternion};
use std::path::Path;

/// A floating tree of two branches with all kinds of conditions in turn.
fn model(kind: Option<LoopKind>) -> Model {
    let inertial = |m: f64| {
        format!(
            "<inertial><origin xyz='0.02 -0.01 0.1'/><mass value='{m}'/><inertia ixx='0.02' iyy='0.03' izz='0.025' \
             ixy='0.001' ixz='0.002' iyz='-0.001'/></inertial>"
        )
    };
    let mut text = String::from("<robot name='t'>");
    for (i, mass) in [5.0, 1.0, 0.7, 0.9, 0.5, 0.6, 0.8, 0.4, 0.55].into_iter().enumerate() {
        text += &format!("<link name='l{i}'>{}</link>", inertial(mass));
    }
    let axes = ["1 0.2 0", "0 1 0.1", "0.3 0 1", "0 1 0", "1 0 0.5", "0 0.4 1", "1 1 0", "0.2 1 1"];
    for (i, (parent, child)) in [(0, 1), (1, 2), (2, 3), (0, 4), (4, 5), (5, 6), (6, 7), (7, 8)].into_iter().enumerate()
    {
        let kind = if i == 4 { "prismatic" } else { "revolute" };
        text += &format!(
            "<joint name='j{i}' type='{kind}'><parent link='l{parent}'/><child link='l{child}'/><origin \
             xyz='0.1 {} 0.2'/><axis xyz='{}'/><limit lower='-3' upper='3' effort='1' velocity='1'/></joint>",
            0.1 * i as f64,
            axes[i]
        );
    }
    text += "</robot>";
    let mut model = parse(Path::new("t.urdf"), text, None).expect("a valid URDF").model;
    let frame = |x: f64, y: f64, z: f64| {
        Isometry3::from_parts(Vector3::new(x, y, z).into(), UnitQuaternion::from_euler_angles(y, z, x))
    };
    if let Some(kind) = kind {
        let (link, other) = (LinkId(3), Some(LinkId(8)));
        let (pose, other_pose) = (frame(0.1, 0.2, 0.3), frame(-0.1, 0.3, 0.2));
        model.loops = vec![LoopClosure { name: "loop".into(), kind, link, pose, other, other_pose }];
    }
    let coefficients = [0.1, 0.7, -0.2, 0.3, 0.05];
    model.couplings = vec![Coupling { joint: JointId(1), leader: JointId(0), coefficients }];
    model
}

fn state(model: &Model) -> State {
    let mut state = State::home(model);
    state.rotation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
    state.joints.iter_mut().enumerate().for_each(|(i, q)| *q = 0.3 - 0.2 * i as f64);
    state.v.iter_mut().enumerate().for_each(|(i, v)| *v = 0.4 - 0.13 * i as f64);
    state
}

const KINDS: [Option<LoopKind>; 5] =
    [None, Some(LoopKind::Ball), Some(LoopKind::Pin), Some(LoopKind::Weld), Some(LoopKind::Rod(0.4))];

/// Constrained acceleration for efforts, from the reduced problem.
fn accelerate(model: &Model, state: &State, tau: &[f64]) -> (Workspace, Reduced) {
    let mut ws = Workspace::new(model);
    dynamics::prepare(model, state, &Vector3::new(0.0, 0.0, -9.81), &mut ws).expect("a regular mass matrix");
    let contact = crate::dynamics::reduced::BodyId { mechanism: 0, link: LinkId(8) };
    let frames = [ContactFrame::Pair(contact, None)];
    let mut reduced = Reduced::of_contacts(frames.into_iter(), (&ws).into());
    reduced.set_frame(0, &Matrix3::identity(), &ws.point(LinkId(8), &Vector3::new(0.1, 0.0, 0.2)));
    reduced::assemble(&ws, &Matrix3::identity(), tau, &mut reduced);
    (ws, reduced)
}

fn free_of(ws: &Workspace, reduced: &Reduced) -> Vec<f64> {
    let mut out = vec![0.0; ws.nv()];
    reduced::free(ws, reduced, &mut out);
    out
}

/// Difference quotients of c along a motion give `G v` and `G v' + g`.
#[test]
fn conditions_have_the_derivatives_of_their_errors() {
    for kind in KINDS {
        let model = model(kind);
        let state = state(&model);
        let (ws, _) = accelerate(&model, &state, &vec![0.0; model.nv()]);
        // Each at its own step: rounding over h^2 and truncation h^2 are about equal.
        let h = 1e-4;
        let errors = |time: f64| {
            let mut moved = state.clone();
            moved.displace(&state.v.iter().map(|v| v * time).collect::<Vec<_>>());
            let mut ws = Workspace::new(&model);
            super::super::kinematics::update(&model, &moved, &mut ws);
            ws.constraints.error
        };
        let (before, now, after) = (errors(-h), errors(0.0), errors(h));
        let mut rates = vec![0.0; now.len()];
        ws.constraints.rates(&state.v, &mut rates);
        for i in 0..now.len() {
            let first = (after[i] - before[i]) / (2.0 * h);
            let second = (after[i] - 2.0 * now[i] + before[i]) / (h * h);
            assert!((first - rates[i]).abs() < 1e-7, "{kind:?} {i}: {first} {}", rates[i]);
            assert!((second - ws.constraints.drift[i]).abs() < 1e-6, "{kind:?} {i}: {second}");
        }
    }
}

/// `M v' + h = tau + G^T lambda + J^T w` with `G v' + g = 0`, solved densely.
#[test]
fn reduced_problem_solves_the_equations_with_multipliers() {
    for kind in KINDS {
        let model = model(kind);
        let (nv, state) = (model.nv(), state(&model));
        let tau: Vec<f64> = (0..nv).map(|k| 0.3 * k as f64 - 1.0).collect();
        let (ws, mut reduced) = accelerate(&model, &state, &tau);
        let m = ws.constraints.number();
        let w = [1.0, -2.0, 3.0, 0.2, -0.1, 0.3];
        let point = reduced.reference[0];
        let mut jacobian = vec![0.0; 6 * nv];
        dynamics::jacobian::frame(&ws, LinkId(8), &point, &mut jacobian);
        let j = DMatrix::from_column_slice(6, nv, &jacobian);
        let g = DMatrix::from_row_slice(m, nv, &ws.constraints.jacobian);
        let mut kkt = DMatrix::zeros(nv + m, nv + m);
        for (r, c) in (0..nv).flat_map(|r| (0..nv).map(move |c| (r, c))) {
            kkt[(r, c)] = ws.mass.get(r.max(c), r.min(c));
        }
        kkt.view_mut((0, nv), (nv, m)).copy_from(&-g.transpose());
        kkt.view_mut((nv, 0), (m, nv)).copy_from(&g);
        let solve = |w: &[f64]| {
            let mut right = DVector::zeros(nv + m);
            let load = j.transpose() * DVector::from_column_slice(w);
            (0..nv).for_each(|k| right[k] = tau[k] - ws.bias[k] + load[k]);
            (0..m).for_each(|i| right[nv + i] = -ws.constraints.drift[i]);
            kkt.clone().lu().solve(&right).expect("independent conditions")
        };
        assert_eq!(ws.constraints.rank(), m, "{kind:?}");
        let (free, loaded) = (solve(&[0.0; 6]), solve(&w));
        let unloaded = free_of(&ws, &reduced);
        let mut acceleration = vec![0.0; nv];
        reduced::advance(&ws, &mut reduced, 1.0, &w, &mut acceleration);
        let change = &j * (&loaded - &free).rows(0, nv);
        let mut lambda = vec![0.0; m];
        reduced::multipliers(&ws, &mut reduced, 0, &w, &mut lambda);
        for (i, lambda) in lambda.iter().enumerate() {
            // Rounding of the dense solution.
            assert!((lambda - loaded[nv + i]).abs() < 1e-10, "{kind:?} {i}: {lambda} {}", loaded[nv + i]);
        }
        let block = reduced.block(SoleId(0), SoleId(0));
        for k in 0..nv {
            // Rounding of the dense solution.
            assert!((unloaded[k] - free[k]).abs() < 1e-10, "{kind:?} {k}");
            assert!((acceleration[k] - loaded[k]).abs() < 1e-10, "{kind:?} {k}");
        }
        for r in 0..6 {
            let response: f64 = (0..6).map(|c| block[c][r] * w[c]).sum();
            assert!((response - change[r]).abs() < 1e-10, "{kind:?} {r}: {response} {}", change[r]);
            let along: f64 = (0..nv).map(|k| j[(r, k)] * unloaded[k]).sum();
            let mut still = State { v: state.v.clone(), ..state.clone() };
            still.time = 0.0;
            let tree = {
                let mut bare = model.clone();
                bare.loops.clear();
                bare.couplings.clear();
                bare
            };
            let (tree_ws, of_tree) = accelerate(&tree, &still, &tau);
            let tree_free = free_of(&tree_ws, &of_tree);
            let of_velocities = of_tree.a0[r] - (0..nv).map(|k| j[(r, k)] * tree_free[k]).sum::<f64>();
            assert!((reduced.a0[r] - along - of_velocities).abs() < 1e-10, "{kind:?} {r}");
        }
    }
}

#[test]
fn states_near_a_solution_are_moved_to_it() {
    for kind in KINDS {
        let mut model = model(kind);
        let mut state = state(&model);
        let mut ws = Workspace::new(&model);
        // Coupling and loop hold at this state, which is then disturbed.
        state.joints[1] = model.couplings[0].evaluate(state.joints[0]).0;
        super::super::kinematics::update(&model, &state, &mut ws);
        let pose = |link: LinkId| {
            let of = &ws.links[link.0];
            let rotation = nalgebra::Rotation3::from_matrix_unchecked(of.rotation);
            Isometry3::from_parts(of.origin.into(), UnitQuaternion::from_rotation_matrix(&rotation))
        };
        if let Some(closure) = model.loops.first_mut().filter(|closure| !matches!(closure.kind, LoopKind::Rod(_))) {
            closure.other_pose = pose(LinkId(8)).inverse() * pose(LinkId(3)) * closure.pose;
        }
        state.joints.iter_mut().enumerate().for_each(|(i, q)| *q += 1e-3 * (i as f64 - 2.0));
        let error = close(&model, &mut state, &[], &mut ws).expect("a regular mass matrix").position;
        let mut rates = vec![0.0; ws.constraints.number()];
        ws.constraints.rates(&state.v, &mut rates);
        // Rounding of positions and velocities of the order of 1.
        assert!(error < 1e-14, "{kind:?}: {error:e}");
        assert!(rates.iter().all(|rate| rate.abs() < 1e-14), "{kind:?}: {rates:?}");
        let mut near = state.clone();
        near.joints.iter_mut().enumerate().for_each(|(i, q)| *q += 1e-5 * (i as f64 - 2.0));
        project(&model, &mut near, &[], &mut ws).expect("a regular mass matrix");
        assert!(ws.constraints.greatest_error() < 1e-14, "{kind:?}: {:?}", ws.constraints.error);
        // Held velocities and displacements stay, and the others obey.
        let held = [6, 9];
        let before: Vec<f64> = held.iter().map(|k| near.joints[k - 6]).collect();
        near.joints[2] += 1e-2;
        let rates: Vec<f64> = held.iter().map(|k| near.v[*k]).collect();
        close(&model, &mut near, &held, &mut ws).expect("a regular mass matrix");
        assert!(ws.constraints.greatest_error() < 1e-14, "{kind:?}: {:?}", ws.constraints.error);
        assert_eq!(held.map(|k| near.joints[k - 6]).to_vec(), before, "{kind:?}");
        assert_eq!(held.map(|k| near.v[k]).to_vec(), rates, "{kind:?}");
    }
}

/// The same loop twice changes nothing.
#[test]
fn redundant_loops_are_left_out() {
    let mut model = model(Some(LoopKind::Pin));
    let state = state(&model);
    let tau = vec![0.5; model.nv()];
    let (ws, mut once) = accelerate(&model, &state, &tau);
    let (mut of_one, mut of_two) = ([0.0; 6], [0.0; 11]);
    let w = [1.0, -2.0, 3.0, 0.2, -0.1, 0.3];
    reduced::multipliers(&ws, &mut once, 0, &w, &mut of_one);
    let free_once = free_of(&ws, &once);
    model.loops.push(model.loops[0].clone());
    let (ws, mut twice) = accelerate(&model, &state, &tau);
    reduced::multipliers(&ws, &mut twice, 0, &w, &mut of_two);
    // The least norm shares the forces equally. Rounding.
    for i in 1..6 {
        assert!((of_two[i] - 0.5 * of_one[i]).abs() < 1e-10, "{of_one:?} {of_two:?}");
        assert!((of_two[i + 5] - 0.5 * of_one[i]).abs() < 1e-10, "{of_one:?} {of_two:?}");
    }
    assert_eq!((ws.constraints.number(), ws.constraints.rank()), (11, 6));
    // Rounding.
    assert!(free_once.iter().zip(&free_of(&ws, &twice)).all(|(a, b)| (a - b).abs() < 1e-10));
}
