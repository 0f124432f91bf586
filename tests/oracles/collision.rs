//! Bodies and distances of CB-i against Pinocchio, qhull and Coal.

use serde::Deserialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use stiction::collision::{CollisionModel, Detector, LinkPose, link_poses};

#[derive(Deserialize)]
struct Oracle {
    joints: Vec<String>,
    bodies: HashMap<String, [usize; 2]>,
    pairs: Vec<[String; 2]>,
    postures: Vec<Posture>,
}

#[derive(Deserialize)]
struct Posture {
    q: Vec<f64>,
    distances: Vec<f64>,
}

/// Compares all distances; returns the greatest errors of separated and of overlapping bodies.
fn compare(path: &Path) -> [f64; 2] {
    let text = std::fs::read_to_string(path).unwrap();
    let oracle: Oracle = serde_json::from_str(&text).unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/cbi/cbi.toml");
    let mut robot = stiction::robot::load(&path).expect("our own robot");
    let model = &robot.model;
    let link = |name: &String| model.link(name).unwrap().0;
    robot.self_collision.watch = oracle.pairs.iter().map(|[a, b]| [link(a), link(b)]).collect();
    let bodies = CollisionModel::every_pair(model, &robot.self_collision);
    for body in &bodies.bodies {
        let own = [body.polytope.vertices.len(), body.polytope.triangles.len()];
        assert_eq!(own, oracle.bodies[&body.name], "{}", body.name);
    }
    let name = |i: usize| bodies.bodies[i].name.as_str();
    let place_of = |pair: &[String; 2]| {
        let is_it = |[i, k]: [usize; 2]| {
            (name(i) == pair[0] && name(k) == pair[1]) || (name(i) == pair[1] && name(k) == pair[0])
        };
        bodies.pairs.iter().position(|p| is_it(p.bodies)).unwrap()
    };
    let indices: Vec<usize> = oracle.pairs.iter().map(place_of).collect();
    assert_eq!((bodies.pairs.len(), indices.len()), (171, 171));
    let order: Vec<usize> = oracle.joints.iter().map(|n| model.joint(n).unwrap().0).collect();

    let mut detector = Detector::new(&bodies);
    let mut poses = vec![LinkPose::IDENTITY; model.links.len()];
    let mut worst = [0.0f64; 2];
    for (k, posture) in oracle.postures.iter().enumerate() {
        let mut q = vec![0.0; model.nj()];
        order.iter().zip(&posture.q).for_each(|(&j, x)| q[j] = *x);
        link_poses(model, &q, &mut poses);
        detector.set_poses(&bodies, &poses);
        let ours = detector.distances(&bodies);
        for ((at, truth), pair) in indices.iter().zip(&posture.distances).zip(&oracle.pairs) {
            let own = ours[*at].distance;
            let error = (own - truth).abs();
            assert!(error <= 1e-6, "posture {k}, {pair:?}: {own} instead of {truth}");
            worst[usize::from(*truth < 0.0)] = worst[usize::from(*truth < 0.0)].max(error);
        }
        for (at, truth) in indices.iter().zip(&posture.distances).filter(|(_, d)| d.abs() > 1e-6) {
            assert_eq!(detector.is_within(&bodies, *at, 0.0), *truth < 0.0, "posture {k}, pair {at}: {truth}");
        }
    }
    worst
}

#[test]
fn distances_and_depths_agree_with_coal() {
    let worst = compare(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracles/collision_cbi.json"));
    println!("worst errors: {worst:?} m");
}

/// The same with more postures than the repository stores; see `make_collision.py`.
#[test]
#[ignore = "needs a file made by make_collision.py, named by COLLISION_ORACLE"]
fn many_postures() {
    let path = std::env::var_os("COLLISION_ORACLE").expect("COLLISION_ORACLE names the file");
    let worst = compare(&PathBuf::from(path));
    println!("worst errors: {worst:?} m");
}
