//! Self-collision queries for sequences of postures: along a motion (coherent) and random
//! (unrelated). CB-i with all 153 pairs of non-adjacent bodies, as counted in the paper, and with
//! the pairs that can meet. Talos' hulls too, if EXAMPLE_ROBOT_DATA names the folder of the Python
//! package example-robot-data. The timing includes the update of the bounding boxes, but not of the
//! link poses.

use divan::Bencher;
use std::path::PathBuf;
use stiction::collision::{CollisionModel, Detector, LinkPose, link_poses};
use stiction::math;
use stiction::random::Stream;
use stiction::robot::{Model, Robot};

const POSTURES: usize = 1000;

#[derive(Clone, Copy, Debug)]
enum Bodies {
    CbiAllPairs,
    CbiWatched,
    TalosAllPairs,
}

const CASES: &[(Bodies, &str)] = &[
    (Bodies::CbiAllPairs, "coherent"),
    (Bodies::CbiAllPairs, "unrelated"),
    (Bodies::CbiWatched, "coherent"),
    (Bodies::CbiWatched, "unrelated"),
    (Bodies::TalosAllPairs, "coherent"),
    (Bodies::TalosAllPairs, "unrelated"),
];

fn talos() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("EXAMPLE_ROBOT_DATA")?);
    let paths = [folder.join("robots"), folder].map(|f| f.join("talos_data/robots/talos_reduced.urdf"));
    paths.into_iter().find(|p| p.is_file())
}

fn cases() -> impl Iterator<Item = Case> {
    let is_available = |bodies: &Bodies| !matches!(bodies, Bodies::TalosAllPairs) || talos().is_some();
    CASES.iter().filter(move |(b, _)| is_available(b)).map(|(bodies, postures)| Case { bodies: *bodies, postures })
}

struct Case {
    bodies: Bodies,
    postures: &'static str,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} {}", self.bodies, self.postures)
    }
}

/// Positions of the joints along a motion of 0.5 Hz sampled at 100 Hz, or at random.
fn postures(model: &Model, kind: &str) -> Vec<Vec<f64>> {
    let mut r = Stream::new(1, &["bench"]);
    let phases: Vec<f64> = model.joints.iter().map(|_| std::f64::consts::TAU * r.unit()).collect();
    let mut posture = |k: usize| -> Vec<f64> {
        let share = |phase: &f64| match kind {
            "coherent" => 0.5 + 0.4 * math::sin(phase + std::f64::consts::TAU * 0.005 * k as f64),
            _ => r.unit(),
        };
        let joints = model.joints.iter().zip(phases.iter().map(share));
        joints.map(|(j, s)| j.lower.max(-3.0) + s * (j.upper.min(3.0) - j.lower.max(-3.0))).collect()
    };
    (0..POSTURES).map(&mut posture).collect()
}

struct Setup {
    model: CollisionModel,
    detector: Detector,
    poses: Vec<Vec<LinkPose>>,
    at: usize,
}

fn setup(case: &Case) -> Setup {
    let cbi = crate::repository().join("robots/cbi/cbi.toml");
    let path = if let Bodies::TalosAllPairs = case.bodies { talos().expect("listed only if found") } else { cbi };
    let Robot { model: robot, self_collision, .. } = stiction::robot::load(&path).expect("a robot that loads");
    let model = match case.bodies {
        Bodies::CbiWatched => CollisionModel::new(&robot, &self_collision),
        _ => CollisionModel::every_pair(&robot, &self_collision),
    };
    let pose = |q: &Vec<f64>| {
        let mut poses = vec![LinkPose::IDENTITY; robot.links.len()];
        link_poses(&robot, q, &mut poses);
        poses
    };
    let poses = postures(&robot, case.postures).iter().map(pose).collect();
    Setup { detector: Detector::new(&model), model, poses, at: 0 }
}

impl Setup {
    /// Updates the bounding boxes to the next posture and runs the query.
    fn query<T>(&mut self, mut run: impl FnMut(&mut Detector, &CollisionModel) -> T) -> T {
        self.at = (self.at + 1) % POSTURES;
        self.detector.set_poses(&self.model, &self.poses[self.at]);
        run(&mut self.detector, &self.model)
    }
}

#[divan::bench(args = cases())]
fn distances_of_all_pairs(bencher: Bencher, case: &Case) {
    let mut s = setup(case);
    super::each(bencher, || s.query(|d, m| d.distances(m).len()));
}

#[divan::bench(args = cases())]
fn smallest_distance(bencher: Bencher, case: &Case) {
    let mut s = setup(case);
    super::each(bencher, || s.query(|d, m| d.closest(m, f64::INFINITY).map(|p| p.distance)));
}

#[divan::bench(args = cases())]
fn any_collision(bencher: Bencher, case: &Case) {
    let mut s = setup(case);
    super::each(bencher, || s.query(|d, m| d.intersects(m, 0.0)));
}

#[divan::bench(args = cases())]
fn colliding_pairs(bencher: Bencher, case: &Case) {
    let mut s = setup(case);
    super::each(bencher, || s.query(|d, m| d.colliding(m, 0.0).len()));
}

/// Poses of all 39 links of CB-i; add this time to any of the above.
#[divan::bench]
fn kinematics(bencher: Bencher) {
    let cbi = crate::repository().join("robots/cbi/cbi.toml");
    let robot = stiction::robot::load(&cbi).expect("our own robot").model;
    let (all, mut at) = (postures(&robot, "unrelated"), 0);
    let mut poses = vec![LinkPose::IDENTITY; robot.links.len()];
    super::each(bencher, || {
        at = (at + 1) % POSTURES;
        link_poses(&robot, &all[at], &mut poses);
        poses[38].origin.x
    });
}

/// Bodies and pairs of CB-i, including the search for pairs that cannot meet.
#[divan::bench(sample_count = 10)]
fn building_the_model(bencher: Bencher) {
    let cbi = crate::repository().join("robots/cbi/cbi.toml");
    let robot = stiction::robot::load(&cbi).expect("our own robot");
    super::each(bencher, || CollisionModel::new(&robot.model, &robot.self_collision).pairs.len());
}
