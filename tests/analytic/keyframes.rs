//! Starts in the keyframes of an MJCF file.

use crate::cli::Place;
use crate::support::runs::simulation;
use std::path::Path;
use stiction::robot::load;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/robot/mjcf/keys.xml");

/// Positions of the robot's joints at the start.
fn start(robot: &str) -> Vec<f64> {
    let sim = simulation(&format!("robot = {{ model = \"tests/robot/mjcf/keys.xml\"{robot} }}\nduration = 0.1"));
    sim.plant().state.joints.clone()
}

#[test]
fn a_keyframe_is_the_start_except_for_joints_of_the_posture_and_followers() {
    // Joint z is twice y, whatever the key says.
    assert_eq!(start(""), [0.1, 0.0, 0.0]);
    assert_eq!(start(", keyframe = \"bent\""), [0.5, -0.2, -0.4]);
    assert_eq!(start(", keyframe = \"bent\", posture = { x = -0.3 }"), [-0.3, -0.2, -0.4]);
    let limit = std::f64::consts::FRAC_PI_2;
    assert_eq!(start(", keyframe = \"beyond\""), [limit, 0.0, 0.0], "within the range");
}

#[test]
fn objects_start_in_keyframes_too() {
    let sim = simulation(
        "robot = { model = \"robots/ground/ground.urdf\" }
        duration = 0.1
        object = [{ type = \"model\", model = \"tests/robot/mjcf/keys.xml\", keyframe = \"bent\" }]",
    );
    assert_eq!(sim.plant().objects.list[0].state.joints, [0.5, -0.2, -0.4]);
}

#[test]
fn unknown_keyframes_are_errors_at_their_key() {
    let place = Place::new();
    let run = |model: &str, name: &str| {
        place.write("s.toml", format!("duration = 0.1\n[robot]\nmodel = \"{model}\"\nkeyframe = \"{name}\"\n"));
        place.runner(&["check", "s.toml"]).exits(2).stderr
    };
    let found = run(MODEL, "bend");
    assert!(found.contains("has no keyframe `bend`") && found.contains("s.toml:4:12"), "{found}");
    assert!(found.contains("did you mean `bent`"), "{found}");
    let plain = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/block/block.urdf");
    let found = run(plain, "bent");
    assert!(found.contains("only MJCF files have keyframes"), "{found}");
}

/// Converted files and `inspect` have them all.
#[test]
fn keyframes_are_shown_and_written() {
    let place = Place::new();
    let shown = place.runner(&["inspect", MODEL]).exits(0).stdout;
    assert!(shown.contains("keyframes (2)") && shown.contains("0.5 -0.2 -0.41"), "{shown}");
    place.runner(&["convert", MODEL, "-o", "out.xml"]).exits(0);
    let [first, second] = [load(Path::new(MODEL)).unwrap(), load(&place.path("out.xml")).unwrap()];
    assert_eq!(second.model.home, first.model.home);
    let named = |name: &str| second.model.keyframes.iter().find(|k| k.name == name).map(|k| k.joints.clone());
    for keyframe in &first.model.keyframes {
        assert_eq!(named(&keyframe.name), Some(keyframe.joints.clone()));
    }
}
