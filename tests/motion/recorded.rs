//! Motions from logs: playback of a recorded run.

use crate::cli::Place;
use std::path::Path;
use stiction::log::Trajectory;
use stiction::results::RunRecord;

/// HOAP-2 bends its knees on the floor; 1.6 s, logged at `rate`.
fn knee_bend(rate: f64, task: &str) -> String {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    format!(
        "duration = 1.6\nrobot = {{ model = \"{}\" }}\nlog = {{ rate = {rate}, topics = [\"state\"] }}\n{task}",
        robot.display()
    )
}

const BEND: &str = "[[task]]
type = \"posture\"
start = 0.2
duration = 1.0
[task.joints]
left_hip_pitch = \"-30 deg\"
left_knee = \"60 deg\"
left_ankle_pitch = \"-30 deg\"
right_hip_pitch = \"-30 deg\"
right_knee = \"60 deg\"
right_ankle_pitch = \"-30 deg\"
";

/// The folder of the only run of a scenario.
fn folder(place: &Place, scenario: &str) -> String {
    let key =
        std::fs::read_dir(place.path(&format!("results/{scenario}"))).unwrap().next().unwrap().unwrap().file_name();
    format!("results/{scenario}/{}", key.to_str().unwrap())
}

/// Greatest distances of joint positions and of heights of the base between two runs.
fn apart(a: &Trajectory, b: &Trajectory) -> (f64, f64) {
    assert_eq!(a.times, b.times);
    let (a, b) = (a.motion.as_ref().unwrap(), b.motion.as_ref().unwrap());
    let distance = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let joints = a.joints.iter().zip(&b.joints).map(|(a, b)| distance(&a.position, &b.position)).fold(0.0, f64::max);
    let heights = |m: &stiction::log::Motion| m.base_position.iter().map(|p| p.z).collect::<Vec<_>>();
    (joints, distance(&heights(a), &heights(b)))
}

#[test]
fn a_logged_run_can_be_replayed_as_a_motion() {
    let place = Place::new();
    place.write("bend.toml", knee_bend(1000.0, BEND));
    place.runner(&["bend.toml"]).exits(0);
    let source = format!("{}/log.mcap", folder(&place, "bend"));
    let first = Trajectory::read(&place.path(&source)).unwrap();
    let task = format!("[[task]]\ntype = \"playback\"\nfile = \"{source}\"\n");
    place.write("again.toml", knee_bend(1000.0, &task));
    place.runner(&["again.toml"]).exits(0);
    let again = Trajectory::read(&place.path(&format!("{}/log.mcap", folder(&place, "again")))).unwrap();
    // Commanded positions are those logged, to the last bits; velocities are the curve's. They
    // differ at the two ends of the bend, where its jerk jumps by 60 * 20 deg / (1 s)^3. The
    // difference is less than 21 h^2 rad/s for a few ms, h = 1 ms. A servo with kd/kp = 0.04 s
    // turns it into less than 1e-6 rad for a moment.
    let (joints, height) = apart(&first, &again);
    assert!(joints > 0.0 && joints < 1e-8, "{joints}");
    assert!(height < 1e-8, "{height}");
}

#[test]
fn an_exported_table_plays_like_its_log() {
    let place = Place::new();
    place.write("bend.toml", knee_bend(200.0, BEND));
    place.runner(&["bend.toml"]).exits(0);
    let run = folder(&place, "bend");
    place.runner(&["export", &run, "--columns", "joint.*.desired_position_*", "-o", "bend.csv"]).exits(0);
    for (name, file) in [("log", format!("{run}/log.mcap")), ("table", "bend.csv".into())] {
        let task = format!("[[task]]\ntype = \"playback\"\nfile = \"{file}\"\n");
        place.write(&format!("{name}.toml"), knee_bend(200.0, &task));
    }
    place.runner(&["log.toml", "table.toml"]).exits(0);
    let read = |name: &str| Trajectory::read(&place.path(&format!("{}/log.mcap", folder(&place, name)))).unwrap();
    assert_eq!(read("log").motion, read("table").motion, "to the last bit");
    // The log stores the text of the table, but does not store another log.
    let attached = |name: &str| read(name).attachments.iter().map(|a| a.name.clone()).collect::<Vec<_>>();
    assert_eq!(attached("table"), ["table.toml", "hoap2.toml", "hoap2.urdf", "bend.csv"]);
    assert_eq!(attached("log"), ["log.toml", "hoap2.toml", "hoap2.urdf"]);
    let inputs =
        |name: &str| RunRecord::read(&place.path(&format!("{}/run.json", folder(&place, name)))).unwrap().inputs;
    assert_eq!(inputs("log").last().unwrap().name, "log.mcap");
    assert_eq!(inputs("table").last().unwrap().name, "bend.csv");
}

#[test]
fn measured_positions_can_be_played() {
    let place = Place::new();
    place.write("bend.toml", knee_bend(200.0, BEND));
    place.runner(&["bend.toml"]).exits(0);
    let source = format!("{}/log.mcap", folder(&place, "bend"));
    let task = format!(
        "[[task]]\ntype = \"playback\"\nfile = \"{source}\"\nrecorded = \"actual\"\nends = \"natural\"\nblend = 0\n"
    );
    place.write("again.toml", knee_bend(200.0, &task));
    place.runner(&["again.toml"]).exits(0);
    let read = |name: &str| Trajectory::read(&place.path(&format!("{}/log.mcap", folder(&place, name)))).unwrap();
    let (first, again) = (read("bend").motion.unwrap(), read("again").motion.unwrap());
    for (a, b) in first.joints.iter().zip(&again.joints) {
        let rows = 40..300;
        let late = rows.clone().map(|i| (a.position[i] - b.desired_position[i]).abs()).fold(0.0, f64::max);
        // The curve passes through its knots, up to rounding.
        assert!(late < 1e-13, "{}: {late}", a.name);
    }
}

#[test]
fn logs_that_cannot_be_played_are_refused() {
    let place = Place::new();
    let rod = "[robot]\nmodel = \"block/block.toml\"\nbase = { position = [0, 0, 1] }\n[log]\ntopics = [\"contact\"]\n";
    place.write("fall.toml", format!("duration = 0.05\n{rod}"));
    place.runner(&["fall.toml"]).exits(0);
    let source = format!("{}/log.mcap", folder(&place, "fall"));
    let play = |file: &str| knee_bend(200.0, &format!("[[task]]\ntype = \"playback\"\nfile = \"{file}\"\n"));
    place.write("a.toml", play(&source));
    assert!(place.runner(&["check", "a.toml"]).exits(2).stderr.contains("the log has no topic `state`"));
    let bytes = std::fs::read(place.path(&source)).unwrap();
    place.write("cut.mcap", &bytes[..bytes.len() / 2]);
    place.write("b.toml", play("cut.mcap"));
    let output = place.runner(&["check", "b.toml"]).exits(2).stderr;
    assert!(output.contains("cut short") && output.contains("b.toml:6:8"), "{output}");
    place.write("no.mcap", "time,a\n0,1\n");
    place.write("c.toml", play("no.mcap"));
    assert!(place.runner(&["check", "c.toml"]).exits(2).stderr.contains("not a log of this program"));
}
