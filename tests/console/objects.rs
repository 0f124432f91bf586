//! Sessions with objects: a saved session gives the same bits, wherever it is saved.

use std::fs;
use std::path::Path;

use foxglove::messages::FrameTransforms;

use super::{log_of, session};
use crate::cli::object_models::{SCENE, messages, place};

/// Forces are added and changed, states stored and restored.
const LINES: &str = "record
run 0.2
force constant object=door link=leaf point=[0.5,0,1] force=[0,5,0] frame=link duration=0.2
force spring object=ball stiffness=30 damping=1
run 0.05
store a
floor 0.2
run 0.1
set force.0.force=[0,-9,0]
restore a
run 0.15
";

#[test]
fn a_saved_session_with_objects_gives_the_same_bits() {
    let place = place();
    place.write("scene.toml", SCENE);
    let lines = format!("{LINES}save session deep/er/again.toml\nsave recording session.mcap\n");
    session(&place, "scene.toml", &lines).exits(0);
    let saved = fs::read_to_string(place.path("deep/er/again.toml")).unwrap();
    assert!(saved.contains("../../door/door.urdf") && saved.contains("../../wedge.obj"), "{saved}");
    place.runner(&["deep/er/again.toml"]).exits(0);
    let rerun = log_of(&place, "results", "again");
    let frames = |log: &Path| messages::<FrameTransforms>(log, "/tf");
    let (recorded, again) = (frames(&place.path("session.mcap")), frames(Path::new(&rerun)));
    assert_eq!(recorded.len(), again.len());
    assert!(recorded == again, "all poses of objects and links");
    // The session differs from the scenario that it began with.
    place.runner(&["scene.toml", "-o", "first"]).exits(0);
    let first = frames(Path::new(&log_of(&place, "first", "scene")));
    let turn = |frames: &FrameTransforms| {
        let leaf = frames.transforms.iter().find(|t| t.child_frame_id == "object/door/leaf").unwrap();
        2.0 * leaf.rotation.unwrap().z.asin()
    };
    // Steps of the session end at every tick, so that even before its first force bits differ.
    assert!((turn(&first[20]) - turn(&again[20])).abs() < 1e-6);
    assert!((turn(&first[45]) - turn(&again[45])).abs() > 1e-4, "{} {}", turn(&first[45]), turn(&again[45]));
}

#[test]
fn the_models_of_objects_are_fixed_in_a_session() {
    let place = place();
    place.write("scene.toml", SCENE);
    fs::copy(place.path("door/door.urdf"), place.path("door/other.urdf")).unwrap();
    let done = session(&place, "scene.toml", "set object.0.model=\"door/other.urdf\"\n");
    let said = done.stdout + &done.stderr;
    assert!(said.contains("`object.N.model` cannot be set in a session"), "{said}");
}
