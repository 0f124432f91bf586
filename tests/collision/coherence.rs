//! Bounding boxes and cached results change the time, not the result; queries allocate nothing;
//! work is counted.

use super::cbi;
use crate::support::counting;
use stiction::collision::{CollisionModel, Detector, LinkPose, link_poses};
use stiction::random::Stream;
use stiction::robot::Model;

/// Greatest difference of two results for one query, each within 1e-12 m of the truth up to
/// rounding.
const BAR: f64 = 1e-11;

/// A motion through the joint ranges: small steps, sometimes a jump.
struct Motion {
    r: Stream,
    q: Vec<f64>,
}

impl Motion {
    fn new(model: &Model, seed: u64) -> Self {
        Self { r: Stream::new(seed, &["motion"]), q: model.home.clone() }
    }

    fn next(&mut self, model: &Model) -> &[f64] {
        let jump = self.r.below(20) == 0;
        for (q, joint) in self.q.iter_mut().zip(&model.joints) {
            let width = joint.upper - joint.lower;
            let to = if jump { joint.lower + width * self.r.unit() } else { *q + 0.02 * width * self.r.normal() };
            *q = to.clamp(joint.lower, joint.upper);
        }
        &self.q
    }
}

#[test]
fn results_depend_only_on_the_posture() {
    let robot = cbi();
    let model = CollisionModel::new(&robot.model, &robot.self_collision);
    let mut poses = vec![LinkPose::IDENTITY; robot.model.links.len()];
    // A detector that keeps its results through all queries, and one that discards them each time.
    let (mut warm, mut cold) = (Detector::new(&model), Detector::new(&model));
    let mut motion = Motion::new(&robot.model, 1);
    let (mut free, mut hit) = (0, 0);
    for step in 0..3_000 {
        link_poses(&robot.model, motion.next(&robot.model), &mut poses);
        cold.forget();
        cold.set_poses(&model, &poses);
        let truth: Vec<f64> = cold.distances(&model).iter().map(|p| p.distance).collect();
        let least = truth.iter().copied().fold(f64::INFINITY, f64::min);
        warm.set_poses(&model, &poses);
        let margin = [0.0, 0.005, 0.03][step % 3];
        // The order of the queries changes as well: each starts from the cache left by the others.
        for question in 0..4 {
            match (question + step) % 4 {
                0 => {
                    for (i, (p, expected)) in warm.distances(&model).iter().zip(&truth).enumerate() {
                        assert!(p.pair == i && (p.distance - expected).abs() < BAR, "step {step}, pair {i}");
                    }
                }
                1 => {
                    let found = warm.closest(&model, f64::INFINITY).expect("there are pairs");
                    assert!((found.distance - least).abs() < BAR, "step {step}");
                    assert!((truth[found.pair] - least).abs() < BAR, "step {step}");
                    let bounded = warm.closest(&model, margin).map(|p| p.distance);
                    assert!((least - margin).abs() < BAR || bounded.is_some() == (least < margin), "step {step}");
                    assert!(bounded.is_none_or(|d| (d - least).abs() < BAR), "step {step}");
                }
                2 => {
                    let any = warm.intersects(&model, margin);
                    assert!((least - margin).abs() < BAR || any == (least < margin), "step {step}: {least}");
                }
                _ => {
                    let found = warm.colliding(&model, margin).to_vec();
                    for (i, d) in truth.iter().enumerate() {
                        let is_found = found.contains(&i);
                        assert!((d - margin).abs() < BAR || is_found == (*d < margin), "step {step}, pair {i}: {d}");
                    }
                }
            }
        }
        if least > 0.0 { free += 1 } else { hit += 1 }
    }
    assert!(free > 200 && hit > 200, "{free} free and {hit} colliding postures");
}

#[test]
fn queries_allocate_nothing() {
    let robot = cbi();
    let model = CollisionModel::new(&robot.model, &robot.self_collision);
    let mut poses = vec![LinkPose::IDENTITY; robot.model.links.len()];
    let mut detector = Detector::new(&model);
    let mut motion = Motion::new(&robot.model, 2);
    let (mut ahead, still) = (robot.model.home.clone(), vec![0.1; robot.model.nj()]);
    let mut depths = 0;
    for _ in 0..300 {
        motion.next(&robot.model);
        let allocations = counting::count(|| {
            stiction::collision::extrapolate(&robot.model, &motion.q, &still, &still, 0.1, &mut ahead);
            link_poses(&robot.model, &ahead, &mut poses);
            detector.set_poses(&model, &poses);
            std::hint::black_box(detector.distances(&model).len());
            std::hint::black_box(detector.closest(&model, f64::INFINITY));
            std::hint::black_box(detector.intersects(&model, 0.01));
            std::hint::black_box(detector.colliding(&model, 0.0).len());
            detector.forget();
        });
        assert_eq!(allocations, 0);
        depths = detector.counts.depths;
    }
    assert!(depths > 30, "overlaps are among the postures: {depths}");
}

#[test]
fn work_is_counted() {
    let robot = cbi();
    let model = CollisionModel::new(&robot.model, &robot.self_collision);
    let n = model.pairs.len() as u64;
    let mut poses = vec![LinkPose::IDENTITY; robot.model.links.len()];
    link_poses(&robot.model, &robot.model.home, &mut poses);
    let mut detector = Detector::new(&model);
    detector.set_poses(&model, &poses);
    detector.distances(&model);
    assert_eq!((detector.counts.postures, detector.counts.boxes, detector.counts.exact), (1, 0, n));
    detector.counts = Default::default();
    assert!(!detector.intersects(&model, 0.0), "home is free");
    let counts = detector.counts;
    assert!(counts.boxes == n && counts.exact < n / 4, "boxes decide most pairs: {counts:?}");
    detector.counts = Default::default();
    detector.closest(&model, f64::INFINITY);
    assert!(detector.counts.boxes == n && detector.counts.exact < n / 2, "{:?}", detector.counts);
    assert_eq!(detector.counts.depths, 0);
}

#[test]
fn a_posture_that_is_not_finite_counts_as_a_collision() {
    let robot = cbi();
    let model = CollisionModel::every_pair(&robot.model, &robot.self_collision);
    let mut poses = vec![LinkPose::IDENTITY; robot.model.links.len()];
    let mut detector = Detector::new(&model);
    poses.iter_mut().for_each(|p| p.origin.fill(f64::NAN));
    detector.set_poses(&model, &poses);
    assert!(detector.intersects(&model, 0.0));
    assert_eq!(detector.colliding(&model, 0.0).len(), model.pairs.len());
    assert_eq!(detector.distances(&model).len(), model.pairs.len());
    // It has no effect on later queries.
    link_poses(&robot.model, &robot.model.home, &mut poses);
    detector.set_poses(&model, &poses);
    assert!(!detector.intersects(&model, 0.0));
}
