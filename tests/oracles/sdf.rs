//! Compares models of SDFormat files with Drake 1.51: masses, link poses, mass matrices.

use nalgebra::{Matrix3, Point3, Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use stiction::dynamics::{self, State, Workspace};
use stiction::robot::load;

/// Rounding of both sides, relative to the greatest entry.
const BOUND: f64 = 1e-12;

#[derive(Deserialize)]
struct Oracle {
    total_mass: f64,
    joints: Vec<String>,
    states: Vec<Truth>,
}

#[derive(Deserialize)]
struct Truth {
    position: Option<[f64; 3]>,
    quaternion: Option<[f64; 4]>,
    joints: Vec<f64>,
    mass: Vec<Vec<f64>>,
    links: BTreeMap<String, [f64; 12]>,
}

#[test]
fn masses_poses_and_mass_matrices_of_sdf_files_are_those_of_drake() {
    let all: BTreeMap<String, Oracle> = serde_json::from_str(include_str!("sdf.json")).unwrap();
    assert_eq!(all.len(), 4);
    for (name, oracle) in all {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/robot/sdf").join(format!("{name}.sdf"));
        let model = load(&path).unwrap_or_else(|error| panic!("{}", error.render(false))).model;
        // The mass of a fixed root does not count here, in Drake that of the link on it does.
        let fixed = if model.nb() == 0 { model.links[0].mass } else { 0.0 };
        assert!((model.mass() + fixed - oracle.total_mass).abs() <= BOUND * oracle.total_mass, "{name}");
        let joints: Vec<usize> = oracle.joints.iter().map(|joint| model.joint(joint).unwrap().0).collect();
        assert_eq!(joints.len(), model.nj(), "{name}");
        let column = |k: usize| if k < model.nb() { k } else { model.nb() + joints[k - model.nb()] };
        for truth in &oracle.states {
            let mut state = State::home(&model);
            state.position = truth.position.unwrap_or_default().into();
            let [w, x, y, z] = truth.quaternion.unwrap_or([1.0, 0.0, 0.0, 0.0]);
            state.rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            for (&j, q) in joints.iter().zip(&truth.joints) {
                state.joints[j] = *q;
            }
            let mut ws = Workspace::new(&model);
            dynamics::prepare(&model, &state, &Vector3::zeros(), &mut ws).unwrap();
            let scale = truth.mass.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
            for (i, row) in truth.mass.iter().enumerate() {
                for (j, entry) in row.iter().enumerate().take(i + 1) {
                    let (a, b) = (column(i).max(column(j)), column(i).min(column(j)));
                    let ours = ws.mass.get(a, b);
                    assert!((ours - entry).abs() <= BOUND * scale, "{name} M[{i}, {j}]: {ours} against {entry}");
                }
            }
            for (link, pose) in &truth.links {
                let (id, frame) = model.link(link).unwrap_or_else(|| panic!("{name}: no link {link}"));
                let origin = ws.point(id, &frame.translation.vector);
                let rotation = ws.links[id.0].rotation * frame.rotation.to_rotation_matrix();
                assert!(
                    (Point3::from(origin) - Point3::new(pose[0], pose[1], pose[2])).norm() <= BOUND,
                    "{name} {link}"
                );
                let turn = Matrix3::from_row_slice(&pose[3..]);
                assert!((rotation * turn.transpose() - Matrix3::identity()).amax() <= BOUND, "{name} {link}");
            }
        }
    }
}
