//! Selection of the monitored bodies and pairs.

use super::cbi;
use std::collections::HashSet;
use stiction::collision::spatial::{Search, WhyBody, WhyPair};
use stiction::collision::{CollisionModel, Detector, LinkPose, link_poses};
use stiction::random::Stream;
use stiction::robot::Robot;

fn named(model: &CollisionModel, bodies: [usize; 2]) -> [&str; 2] {
    bodies.map(|b| model.bodies[b].name.as_str())
}

fn reason(model: &CollisionModel, pair: [&str; 2]) -> Option<WhyPair> {
    model.dropped_pairs.iter().find(|p| named(model, p.bodies) == pair).map(|p| p.why)
}

fn watched(model: &CollisionModel, pair: [&str; 2]) -> bool {
    model.pairs.iter().any(|p| named(model, p.bodies) == pair)
}

fn model(robot: &Robot) -> CollisionModel {
    CollisionModel::new(&robot.model, &robot.self_collision)
}

#[test]
fn cbi_has_the_size_of_the_papers_model() {
    let model = model(&cbi());
    // The paper: 19 bodies of 6 to 232 triangles, 2627 in all; the eyes are inside the head.
    assert_eq!((model.bodies.len(), model.triangles()), (19, 2620));
    let inner: Vec<&str> = model.dropped_bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(inner, ["r_eye_pan", "r_eye", "l_eye_pan", "l_eye"]);
    assert!(model.dropped_bodies.iter().all(|b| b.why == WhyBody::Inside("head".into())));
    assert_eq!(model.pairs.len() + model.dropped_pairs.len(), 19 * 18 / 2);
}

#[test]
fn pairs_are_dropped_for_a_reason() {
    let robot = cbi();
    let found = model(&robot);
    assert_eq!(reason(&found, ["l_thigh", "l_shank"]), Some(WhyPair::Adjacent), "through the knee, which has no body");
    let far = reason(&found, ["head", "l_foot"]);
    assert!(matches!(far, Some(WhyPair::CannotMeet(d)) if d > 0.2), "{far:?}");
    // The paper's figure 7: the right hand at the thigh.
    let pair = found.pairs.iter().find(|p| named(&found, p.bodies) == ["r_hand", "r_thigh"]).expect("watched");
    let between: Vec<&str> = pair.joints.iter().map(|j| robot.model.joints[j.0].name.as_str()).collect();
    let want = [
        "B_TR", "B_TAA", "B_TFE", "R_SFE", "R_SAA", "R_HR", "R_EB", "R_WR", "R_WFE", "R_WAA", "R_HAA", "R_HFE", "R_HFR",
    ];
    assert_eq!(between, want);
    // Both sides alike.
    let mirrored = |name: &str| match name.split_at_checked(2) {
        Some(("l_", rest)) => format!("r_{rest}"),
        Some(("r_", rest)) => format!("l_{rest}"),
        _ => name.to_owned(),
    };
    let set = |turn: &dyn Fn(&str) -> String| -> HashSet<[String; 2]> {
        let sorted = |p: [&str; 2]| {
            let mut p = p.map(turn);
            p.sort();
            p
        };
        found.pairs.iter().map(|p| sorted(named(&found, p.bodies))).collect()
    };
    assert_eq!(set(&|n| n.to_owned()), set(&mirrored));
}

#[test]
fn the_robot_file_overrides_the_selection_of_pairs() {
    let mut robot = cbi();
    let link = |robot: &Robot, name: &str| robot.model.link(name).unwrap().0;
    robot.self_collision.ignore = vec![[link(&robot, "r_hand"), link(&robot, "l_hand")]];
    robot.self_collision.watch =
        vec![[link(&robot, "head"), link(&robot, "l_foot")], [link(&robot, "torso"), link(&robot, "pelvis")]];
    let found = model(&robot);
    assert_eq!(reason(&found, ["l_hand", "r_hand"]), Some(WhyPair::Ignored));
    assert!(watched(&found, ["head", "l_foot"]) && watched(&found, ["pelvis", "torso"]));
    robot.self_collision = Default::default();
    robot.self_collision.bodies = Some(["l_hand", "l_eye", "head"].map(|n| link(&robot, n)).to_vec());
    let found = model(&robot);
    let names: Vec<&str> = found.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["head", "l_eye", "l_hand"], "an eye that is listed is a body");
    let not_listed = found.dropped_bodies.iter().filter(|b| b.why == WhyBody::NotListed).count();
    assert_eq!(not_listed, 23 - 3);
}

#[test]
fn bodies_that_overlap_at_home_are_not_monitored() {
    let mut robot = cbi();
    let hand = robot.model.link("l_hand").unwrap().0;
    let big = stiction::robot::Geometry::Box(nalgebra::Vector3::new(0.2, 0.6, 0.3));
    robot.model.links[hand.0].collisions[0].geometry = big;
    let found = model(&robot);
    let why = reason(&found, ["l_hand", "l_thigh"]);
    assert!(matches!(why, Some(WhyPair::OverlapAtHome(depth)) if depth > 0.05), "{why:?}");
}

/// Random postures outside the search: none of the dropped pairs meets.
#[test]
fn pairs_that_cannot_meet_do_not_meet() {
    let robot = cbi();
    let found = model(&robot);
    let mut dropped = CollisionModel::every_pair(&robot.model, &robot.self_collision);
    let cannot = |p: [usize; 2]| {
        let why = found.dropped_pairs.iter().find(|d| d.bodies == p).map(|d| d.why);
        matches!(why, Some(WhyPair::CannotMeet(_)))
    };
    dropped.pairs.retain(|p| cannot(p.bodies));
    assert!(dropped.pairs.len() > 50);
    let mut detector = Detector::new(&dropped);
    let mut poses = vec![LinkPose::IDENTITY; robot.model.links.len()];
    let mut r = Stream::new(99, &["other"]);
    for _ in 0..50_000 {
        let draw = |joint: &stiction::robot::Joint| {
            joint.lower + (joint.upper - joint.lower) * (1.4 * r.unit() - 0.2).clamp(0.0, 1.0)
        };
        let q: Vec<f64> = robot.model.joints.iter().map(draw).collect();
        link_poses(&robot.model, &q, &mut poses);
        detector.set_poses(&dropped, &poses);
        assert!(!detector.intersects(&dropped, 0.0), "{q:?}");
    }
    // A search with other random numbers drops the same pairs.
    let search = Search { postures: 8_000, descents: 200, steps: 100, seed: 2, ..Search::default() };
    let repeated = CollisionModel::searched(&robot.model, &robot.self_collision, search);
    assert_eq!(repeated.pairs, found.pairs);
}
