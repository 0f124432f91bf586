//! Loop closures against Pinocchio's constraint dynamics (`make_loops.py`).

use super::dynamics_oracle::matrix;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use stiction::dynamics::{self, Reduced, State, Workspace, reduced};
use stiction::robot::{LinkId, LoopClosure, LoopKind, Model};

#[derive(Deserialize)]
struct Oracle {
    gravity: [f64; 3],
    names: Vec<String>,
    armature: Vec<f64>,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    position: [f64; 3],
    rotation: [[f64; 3]; 3],
    joints: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    acceleration: Vec<f64>,
    loops: Vec<Loop>,
}

#[derive(Deserialize)]
struct Loop {
    #[serde(rename = "type")]
    kind: String,
    link: String,
    to: Option<String>,
    rotation: [[f64; 3]; 3],
    position: [f64; 3],
    to_rotation: [[f64; 3]; 3],
    to_position: [f64; 3],
    force: [f64; 3],
    moment: [f64; 3],
}

/// A frame of the joint that moves a link, in our internal frame of that link.
fn frame(model: &Model, link: LinkId, rotation: &[[f64; 3]; 3], position: [f64; 3]) -> Isometry3<f64> {
    model.links[link.0].urdf_frame * pose(rotation, position)
}

fn pose(rotation: &[[f64; 3]; 3], position: [f64; 3]) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix(rotation)));
    Isometry3::from_parts(Translation3::from(Vector3::from(position)), turn)
}

fn closure(model: &Model, name: String, of: &Loop) -> LoopClosure {
    let link = |joint: &str| LinkId(model.joint(joint).expect("joint of that name").0 + 1);
    let (first, second) = (link(&of.link), of.to.as_deref().map(link));
    LoopClosure {
        name,
        kind: if of.kind == "weld" { LoopKind::Weld } else { LoopKind::Ball },
        link: first,
        pose: frame(model, first, &of.rotation, of.position),
        other: second,
        other_pose: match second {
            Some(second) => frame(model, second, &of.to_rotation, of.to_position),
            None => pose(&of.to_rotation, of.to_position),
        },
    }
}

fn close(name: &str, mine: f64, truth: f64, scale: f64) {
    // Rounding of both solutions, amplified by the condition of the loops, up to 1e2.
    assert!((mine - truth).abs() < 1e-10 * scale, "{name}: {mine} {truth}");
}

#[test]
fn accelerations_and_forces_of_loops_are_those_of_pinocchio() {
    let oracle: Oracle = serde_json::from_str(include_str!("loops_hoap2.json")).expect("written by make_loops.py");
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.urdf");
    let mut model = stiction::robot::load(&path).expect("our own robot").model;
    let ours: Vec<usize> = oracle.names.iter().map(|n| model.joint(n).expect("joint of that name").0).collect();
    for (&j, &armature) in ours.iter().zip(&oracle.armature) {
        model.joints[j].armature = armature;
    }
    model.soles.clear();
    for (number, case) in oracle.cases.iter().enumerate() {
        model.loops = case.loops.iter().enumerate().map(|(i, of)| closure(&model, format!("loop {i}"), of)).collect();
        let index = |k: usize| if k < 6 { k } else { 6 + ours[k - 6] };
        let mut state = State::home(&model);
        state.position = Vector3::from(case.position);
        state.rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix(&case.rotation)));
        let mut tau = vec![0.0; model.nv()];
        for (k, (v, t)) in case.v.iter().zip(&case.tau).enumerate() {
            (state.v[index(k)], tau[index(k)]) = (*v, *t);
        }
        ours.iter().zip(&case.joints).for_each(|(&j, q)| state.joints[j] = *q);
        let mut ws = Workspace::new(&model);
        dynamics::prepare(&model, &state, &Vector3::from(oracle.gravity), &mut ws).expect("a regular mass matrix");
        // The loops hold where the oracle has placed them.
        assert!(ws.constraints.greatest_error() < 1e-12, "case {number}");
        let mut reduced = Reduced::new(&model, &ws);
        reduced::assemble(&ws, &Matrix3::identity(), &tau, &mut reduced);
        let mut free = vec![0.0; model.nv()];
        reduced::free(&ws, &reduced, &mut free);
        let scale = case.acceleration.iter().fold(1.0, |most: f64, a| most.max(a.abs()));
        for (k, truth) in case.acceleration.iter().enumerate() {
            close(&format!("case {number}, acceleration {k}"), free[index(k)], *truth, scale);
        }
        let mut lambda = vec![0.0; ws.constraints.number()];
        reduced::multipliers(&ws, &mut reduced, 0, &[], &mut lambda);
        for (of, (_, rows)) in case.loops.iter().zip(model.loop_conditions()) {
            let [force, moment] = ws.constraints.loop_load(rows.start, &lambda[rows]);
            let scale = Vector3::from(of.force).norm();
            for i in 0..3 {
                close(&format!("case {number}, force {i}"), force[i], of.force[i], scale);
                close(&format!("case {number}, moment {i}"), moment[i], of.moment[i], scale);
            }
        }
    }
}
