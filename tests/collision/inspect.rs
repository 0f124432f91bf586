//! Bodies and pairs in the output of `runner inspect`.

use super::cbi;
use stiction::collision::{CollisionModel, inspect};

#[test]
fn inspect_lists_bodies_triangles_pairs_and_reasons() {
    let mut robot = cbi();
    let link = |name: &str| robot.model.link(name).unwrap().0;
    robot.self_collision.ignore = vec![[link("l_hand"), link("r_hand")]];
    let model = CollisionModel::new(&robot.model, &robot.self_collision);
    let text = inspect(&model);
    for part in [
        "self-collision: 19 bodies of 2620 triangles in all, 78 pairs",
        "l_foot               12 vertices, 20 triangles",
        "not a body: l_eye                always inside head",
        "watched: torso with l_upper_arm",
        "not watched: pelvis with torso: adjacent",
        "not watched: pelvis with head: never nearer than 287 mm",
        "not watched: l_hand with r_hand: the robot file ignores it",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
}
