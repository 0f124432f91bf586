//! Objects that are models and meshes, through the program: records, logs, replay, resume, comparison.

use std::fs;
use std::path::Path;

use foxglove::messages::{FrameTransforms, SceneUpdate};
use mcap::MessageStream;
use serde_json::Value;

use super::{Place, Table};

/// A place with a door, a wedge and the ground.
pub fn place() -> Place {
    let place = Place::new();
    for name in ["door/door.urdf", "ground/ground.urdf"] {
        place.write(name, fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name)).unwrap());
    }
    let corners = ["0 -0.1 0", "0.5 -0.1 0", "0.5 -0.1 0.25", "0 0.1 0", "0.5 0.1 0", "0.5 0.1 0.25"];
    let vertices: String = corners.iter().map(|corner| format!("v {corner}\n")).collect();
    place.write("wedge.obj", vertices + "f 1 2 3\nf 4 6 5\nf 1 4 5\nf 1 5 2\nf 2 5 6\nf 2 6 3\nf 1 3 6\nf 1 6 4\n");
    place
}

/// A ball rolls against a door, next to a wedge; a force opens the door later.
pub const SCENE: &str = r#"
duration = 0.6
[robot]
model = "ground/ground.urdf"
[floor]
friction = 0.5
[[object]]
type = "model"
name = "door"
model = "door/door.urdf"
servo = [{ stiffness = 10, damping = 5 }]
[[object]]
type = "sphere"
name = "ball"
radius = 0.1
mass = 2
position = [0.6, -0.3, 0.1]
linear_velocity = [0, 1, 0]
[[object]]
type = "mesh"
name = "wedge"
file = "wedge.obj"
mass = 1
position = [3, 0, 0]
[[force]]
type = "push"
object = "door"
link = "leaf"
point = [0.75, 0, 1]
force = [0, 12, 0]
frame = "link"
start = 0.3
duration = 0.2
[log]
viewer_rate = 1000
rate = 100
"#;

fn only_folder(place: &Place, scenario: &str) -> String {
    let mut entries = fs::read_dir(place.path("results").join(scenario)).unwrap();
    format!("results/{scenario}/{}", entries.next().unwrap().unwrap().file_name().to_str().unwrap())
}

pub fn messages<T: prost::Message + Default>(log: &Path, topic: &str) -> Vec<T> {
    let bytes = fs::read(log).unwrap();
    let of_topic = MessageStream::new(&bytes).unwrap().map(Result::unwrap).filter(|m| m.channel.topic == topic);
    of_topic.map(|m| T::decode(m.data.as_ref()).unwrap()).collect()
}

#[test]
fn a_run_with_models_and_meshes_is_recorded_logged_and_replayed() {
    let place = place();
    place.write("door.toml", SCENE);
    place.runner(&["door.toml"]).exits(0);
    let folder = only_folder(&place, "door");
    let record: Value = serde_json::from_slice(&fs::read(place.path(&folder).join("run.json")).unwrap()).unwrap();
    let inputs: Vec<&str> = record["inputs"].as_array().unwrap().iter().map(|i| i["name"].as_str().unwrap()).collect();
    assert_eq!(inputs, ["ground.urdf", "door.urdf", "wedge.obj"]);
    let log = place.path(&folder).join("log.mcap");
    let frames = messages::<FrameTransforms>(&log, "/tf");
    let names: Vec<&str> = frames[0].transforms.iter().map(|t| t.child_frame_id.as_str()).collect();
    for name in ["object/door", "object/door/leaf", "object/ball", "object/wedge"] {
        assert!(names.contains(&name), "{name} is not among {names:?}");
    }
    let turn = |k: usize| {
        let leaf = frames[k].transforms.iter().find(|t| t.child_frame_id == "object/door/leaf").unwrap();
        2.0 * leaf.rotation.unwrap().z.asin()
    };
    // The ball opens the door, which is at rest before.
    assert!(turn(10).abs() < 1e-12 && turn(frames.len() - 1) > 1e-3, "{} {}", turn(10), turn(frames.len() - 1));
    // `export` shows the same.
    let table = Table::parse(&place.runner(&["export", log.to_str().unwrap()]).exits(0).stdout);
    let yaw = table.numbers("object.door/leaf.yaw_rad");
    assert_eq!(yaw.len(), frames.len());
    assert!((0..frames.len()).all(|k| (yaw[k] - turn(k)).abs() < 1e-12), "{yaw:?}");
    assert!(table.numbers("object.ball.y_m")[0] == -0.3 && table.numbers("object.wedge.x_m")[0] == 3.0);
    let scene = &messages::<SceneUpdate>(&log, "/scene")[0];
    let entity = |id: &str| scene.entities.iter().find(|e| e.id == id).unwrap_or_else(|| panic!("{id}"));
    assert_eq!((entity("object/door").cubes.len(), entity("object/door/leaf").cubes.len()), (2, 1));
    assert_eq!(entity("object/wedge").triangles[0].indices.len(), 8 * 3);
    let replayed = place.runner(&["replay", &folder]).exits(0);
    assert!(replayed.stdout.contains("same bits"), "{}", replayed.stdout);
    // A changed model is found by replay, and makes a resumed batch run again.
    let urdf = fs::read_to_string(place.path("door/door.urdf")).unwrap();
    place.write("door/door.urdf", urdf.replace("value=\"20\"", "value=\"21\""));
    let replayed = place.runner(&["replay", &folder]);
    assert!(replayed.stdout.contains("door.urdf has changed") || replayed.stderr.contains("door.urdf has changed"));
    let resumed = place.runner(&["door.toml", "--resume"]).exits(0);
    assert!(!resumed.stdout.contains("1 resumed"), "{}", resumed.stdout);
    assert_ne!(only_folder(&place, "door"), "", "it ran");
    assert_eq!(fs::read_dir(place.path("results/door")).unwrap().count(), 2, "another key\n{}", resumed.stdout);
}

#[test]
fn the_path_of_a_model_is_not_part_of_the_key() {
    let place = place();
    place.write("door.toml", SCENE);
    place.runner(&["door.toml", "--no-log"]).exits(0);
    let before = only_folder(&place, "door");
    fs::rename(place.path("door"), place.path("gate")).unwrap();
    place.write("door.toml", SCENE.replace("door/door", "gate/door"));
    place.runner(&["door.toml", "--no-log", "--resume"]).exits(0);
    assert_eq!(fs::read_dir(place.path("results/door")).unwrap().count(), 1);
    assert_eq!(only_folder(&place, "door"), before);
}

#[test]
fn a_model_that_cannot_be_read_is_an_error_at_its_key() {
    let place = place();
    for (from, to, message) in [
        ("door/door.urdf", "door/gone.urdf", "gone.urdf"),
        ("wedge.obj", "gone.obj", "cannot read"),
        ("door/door.urdf", "wedge.obj", "it is not a .toml, .urdf, .xml, .mjcf, .sdf or .world file"),
    ] {
        place.write("door.toml", SCENE.replace(from, to));
        let done = place.runner(&["check", "door.toml"]).exits(2);
        assert!(done.stderr.contains(message) && done.stderr.contains("door.toml:"), "{}", done.stderr);
    }
    place.write("door/door.urdf", "<robot name=\"x\"><link name=\"a\"/><link name=\"a\"/></robot>");
    place.write("door.toml", SCENE);
    let done = place.runner(&["check", "door.toml"]).exits(2);
    assert!(done.stderr.contains("door.urdf"), "{}", done.stderr);
}

/// Bodies without gravity drift apart from the reference as their velocities differ.
#[test]
fn comparison_includes_objects() {
    let place = place();
    let text = |reference: &str| {
        format!(
            "duration = 0.5\ngravity = [0, 0, 0]\n[robot]\nmodel = \"ground/ground.urdf\"\n[log]\nrate = 100\n\
            [integrator]\nmethod = \"semi-implicit\"\nstep = 0.7e-3\n[contact]\nmethod = \"one-step\"\n\
            [[object]]\ntype = \"model\"\nmodel = \"door/door.urdf\"\nposture = {{ hinge = 0.5 }}\nposition = [0, 0, 5]\n\
            [[object]]\ntype = \"box\"\nsize = [1, 1, 1]\nmass = 1\nposition = [5, 0, 5]\n\
            [compare]\nreference = {{ {reference} }}\n"
        )
    };
    place.write("s.toml", text("\"object.0.velocity.hinge\" = 0.3, \"object.1.linear_velocity\" = [0, 0.4, 0.3]"));
    place.runner(&["s.toml", "--no-log"]).exits(0);
    let table = place.summary("results");
    let instants = (0..=50).map(|k| f64::from(k) / 100.0);
    let mean = instants.map(|t| t * t).sum::<f64>() / 51.0;
    let near = |column: &str, expected: f64| {
        let found = table.numbers(column)[0];
        assert!((found - expected).abs() < 1e-12, "{column}: {found} {expected}");
    };
    // Steps do not end at the instants; the interpolant of a steady motion is exact.
    near("error_object_joint_rms_rad", 0.3 * mean.sqrt());
    near("error_object_position_rms_m", 0.5 * (0.5 * mean).sqrt());
    near("error_final_object_position_m", 0.25);
    near("error_position_rms_m", 0.0);
    place.write("other.toml", text("object = [{ type = \"sphere\", radius = 0.1, mass = 1, position = [0, 0, 5] }]"));
    let refused = place.runner(&["check", "other.toml"]).exits(2);
    let message = "the reference has 1 objects with [0] joints, the run 2 objects with [1, 0] joints";
    assert!(refused.stderr.contains(message), "{}", refused.stderr);
}

/// Pairs of bodies come and go: their forces must not be taken for those of soles.
#[test]
fn a_run_with_objects_that_touch_does_not_differ_from_itself() {
    let place = place();
    let compare = "[compare]\nreference = {}\n";
    place.write("self.toml", format!("{SCENE}{compare}"));
    place.runner(&["self.toml", "--no-log"]).exits(0);
    let table = place.summary("results");
    for column in ["error_object_position_rms_m", "error_object_joint_rms_rad", "error_final_object_position_m"] {
        assert_eq!(table.numbers(column), [0.0], "{column}");
    }
    assert_eq!(table.column("error_force_rms_N"), [""], "no soles");
}
