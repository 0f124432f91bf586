//! Tests that the saved scenario of a session gives the same bits as the session.

use std::path::Path;

use super::{export, hoap2, log_of, session};
use crate::cli::Place;

/// Every command that changes a motion, with events between the commands.
const LINES: &str = "start sine joints.left_shoulder_pitch.amplitude=0.2 ramp=0.2
force constant link=torso force=[0.5,0,0]
run 0.3
push torso 5 2 0 for 0.1 at 0 0 0.05
run 0.2
floor 0.4 0.3
store z
run 0.137
change sine joints.left_shoulder_pitch.amplitude=0.1
friction left_knee coulomb=0.05 viscous=0.01
payload torso 0.5 -0.05 0 0.1
set force.0.force=[0,0.5,0] robot.joint.right_knee.kp=90
run 0.3
force spring link=torso stiffness=50 damping=2 duration=0.2
force carried-object link=r_hand mass=0.2 duration=0.3
step 250
stop sine
run 0.1
restore z
run 0.2
store a
start script file=\"wave.luau\" params={ amplitude = 0.3, frequency = 2.0, duration = 1.0 }
step
run 0.1
change script params.amplitude=0.1
set gravity=[0,0.2,-9.7] contact.restitution=0.1
run 0.2
restore z
stop all
drive left_elbow=-0.4 right_elbow=\"-30 deg\" in 0.3
run 0.1
run until 1.9
";

/// All commands that only print.
const QUERIES: &str =
    "status\ntasks\nbase\ncom\nzmp\ncontact\njoints\njacobian com\njacobian l_foot 0.1 0 0\nframe r_hand
value base_z_m joint.*.effort_Nm\ncolumns\nevents\nforce\nstates\nget floor.friction\nfloor\nexpect base_z_m min=-1\n";

fn script() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/tasks/wave.luau")).unwrap()
}

/// Runs a session, saves scenario and recording, runs the scenario, and compares all cells of both
/// logs.
#[track_caller]
fn assert_replays(place: &Place, name: &str, saved: &str, lines: &str) {
    let file = format!("{name}.toml");
    let lines = format!("record\n{lines}save session {saved}.toml\nsave recording {name}.mcap\n");
    session(place, &file, &lines).exits(0);
    let results = format!("{name}-results");
    place.runner(&[&format!("{saved}.toml"), "-o", &results]).exits(0);
    let again = log_of(place, &results, saved.rsplit('/').next().unwrap());
    let log = format!("{name}.mcap");
    for more in [&[][..], &["--events"]] {
        let (recorded, rerun) = (export(place, &log, more), export(place, &again, more));
        assert_eq!(recorded.header, rerun.header, "{name}");
        for (row, other) in recorded.rows.iter().zip(&rerun.rows) {
            let differs = |i: &usize| row[*i] != other[*i];
            if let Some(i) = (0..row.len()).find(differs) {
                panic!("{name} at {} s: {} is {}, then {}", row[0], recorded.header[i], row[i], other[i]);
            }
        }
        assert_eq!(recorded.rows.len(), rerun.rows.len(), "{name}");
        let least = if more.is_empty() { 200 } else { 1 };
        assert!(recorded.rows.len() >= least, "{name}: {} rows", recorded.rows.len());
    }
}

#[test]
fn a_saved_session_gives_the_same_bits() {
    let place = Place::new();
    place.write("wave.luau", script());
    for (name, more) in [
        ("exact", ""),
        (
            "squats",
            "task = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 2 }]\nforce = [{ type = \"random-pushes\", links = [\"torso\"], number = 5, magnitude = [1, 5] }]\nevent = [{ at = 0.45, set = { \"floor.friction\" = 0.6 } }, { at = 1.5, save = \"b\" }]",
        ),
        (
            "sensed",
            "control = { estimator = \"inertial\" }\nsensors = { joint_position = { noise = 1e-4 }, gyroscope = { noise = 1e-3 }, sole_force = { delay = 0.002 } }",
        ),
        ("steps", "integrator = { method = \"rk4\", step = 7e-4 }\ncontact = { events = \"step\" }"),
        ("slow-ticks", "control = { rate = 130.0 }"),
        ("one-step", "contact = { method = \"one-step\" }\nintegrator = { method = \"semi-implicit\" }"),
        ("coarse", "contact = { method = \"ncp\" }\nintegrator = { method = \"semi-implicit\", step = 3e-3 }"),
        // The end is not an instant of the log.
        (
            "between",
            "contact = { method = \"one-step\" }\nintegrator = { method = \"semi-implicit\" }\nlog = { rate = 333.0 }",
        ),
        ("springs", "contact = { method = \"penalty\" }"),
        ("avoiding", "self_collision = { method = 2, rate = 100, margin = 0.002 }"),
    ] {
        // Some methods have no restitution.
        let lines = match name {
            "one-step" | "coarse" | "between" | "springs" => LINES.replace(" contact.restitution=0.1", ""),
            // The scenario has a force before that of the session.
            "squats" => LINES.replace("force.0", "force.1"),
            "slow-ticks" => LINES.replace("step 250", "step 32"),
            _ => LINES.to_owned(),
        };
        hoap2(&place, &format!("{name}.toml"), &format!("duration = 2.0\n{more}"));
        assert_replays(&place, name, &format!("{name}-again"), &lines);
    }
}

#[cfg(unix)]
#[test]
fn a_saved_walk_gives_the_same_bits() {
    let place = Place::new();
    let walk =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/hoap2-walk.toml")).unwrap();
    // Paths in the saved scenario are relative to its own folder.
    std::os::unix::fs::symlink(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots"), place.path("robots")).unwrap();
    place.write("walk.toml", walk.replace("../robots", "robots"));
    std::fs::create_dir_all(place.path("deep/er")).unwrap();
    std::os::unix::fs::symlink("deep/er", place.path("elsewhere")).unwrap();
    assert_replays(&place, "walk", "elsewhere/walk", "run 0.9\npush torso 1 1 0\nrun 0.5\n");
}

/// Starts and changes each type of task that accepts new parameters.
#[test]
fn task_changes_take_effect_and_are_saved() {
    let place = Place::new();
    place.write("wave.luau", script());
    let bow =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/motions/bow.toml")).unwrap();
    place.write("bow.toml", bow);
    for (name, lines) in [
        (
            "playback",
            "start playback file=\"bow.toml\"\nrun 0.4\nchange playback speed=0.3\nrun 0.6\nchange playback speed=1.5\n",
        ),
        (
            "position",
            "start balance control=position\nrun 0.1\nchange balance position.offset=[0.004,0.002]\nrun 0.9\n",
        ),
        ("force", "start balance control=force\nrun 0.1\nchange balance force.offset=[0.004,0.002,-0.002]\nrun 0.9\n"),
        ("compensation", "start gravity-compensation\nrun 0.1\nchange gravity-compensation damping=0.5\nrun 0.9\n"),
        (
            "sine",
            "start sine joints.head_pan.amplitude=0.2\nrun 0.2\nchange sine joints.head_pan.frequency=3.0\nrun 0.8\n",
        ),
        (
            "script",
            "start script file=\"wave.luau\" params={ amplitude = 0.3, frequency = 2.0, duration = 1.0 }\nrun 0.2\nchange script params.amplitude=0.1\nrun 0.8\n",
        ),
    ] {
        hoap2(&place, &format!("{name}.toml"), "duration = 2.0");
        assert_replays(&place, name, &format!("{name}-again"), lines);
        // The change affects the desired joint values.
        let desired = |lines: &str, log: &str| {
            session(&place, &format!("{name}.toml"), &format!("record\n{lines}save recording {log}\n")).exits(0);
            export(&place, log, &["--columns", "joint.*.desired_*,joint.*.desired_effort_Nm"]).rows
        };
        let without: String =
            lines.lines().filter(|line| !line.starts_with("change")).map(|l| format!("{l}\n")).collect();
        assert_ne!(desired(lines, "with.mcap"), desired(&without, "without.mcap"), "{name}");
    }
}

#[test]
fn queries_change_no_bit() {
    let place = Place::new();
    place.write("wave.luau", script());
    for (name, more) in [
        ("exact", ""),
        ("one-step", "contact = { method = \"one-step\" }\nintegrator = { method = \"semi-implicit\" }"),
        ("springs", "contact = { method = \"penalty\" }"),
        ("avoiding", "self_collision = { method = 3, rate = 100, margin = 0.002 }"),
    ] {
        hoap2(&place, &format!("{name}.toml"), &format!("duration = 2.0\n{more}"));
        let plain = LINES.replace(" contact.restitution=0.1", "");
        let with_queries: String = plain.lines().map(|line| format!("{line}\n{QUERIES}")).collect();
        for (lines, log) in [(&plain, "plain"), (&with_queries, "queries")] {
            let lines = format!("record\n{lines}save recording {name}-{log}.mcap\n");
            session(&place, &format!("{name}.toml"), &lines).exits(0);
        }
        let rows = |log: &str| export(&place, &format!("{name}-{log}.mcap"), &[]).rows;
        assert_eq!(rows("plain"), rows("queries"), "{name}");
    }
}

/// Neither pauses nor recording change a session.
#[test]
fn pauses_change_no_bit() {
    let place = Place::new();
    hoap2(
        &place,
        "s.toml",
        "task = [{ type = \"sine\", ramp = 0.1, joints = { head_pan = { amplitude = 0.3 } }, duration = 0.2 }]",
    );
    let value = |lines: &str| {
        let done =
            session(&place, "s.toml", &format!("{lines}\nvalue base_* joint.*.position_rad joint.*.effort_Nm\n"));
        let done = done.exits(0);
        let from = done.stdout.find("base_x_m").unwrap();
        done.stdout[from..].to_owned()
    };
    let whole = value("push torso 3 1 0 for 0.1\nrun 0.5");
    assert_eq!(value("push torso 3 1 0 for 0.1\nrun 0.1\nstep 33\nrecord\nstep\nrecord stop\nrun until 0.5"), whole);
    assert_ne!(value("push torso 3 1 0 for 0.1\nrun 0.4"), whole);
    // Undone changes have no effect.
    let undone = "push torso 3 1 0 for 0.1\nrun 0.2\nfloor 0.1\nrun 0.1\nfriction left_knee coulomb=1\nrun 0.1\nundo\nundo\nrun 0.3";
    assert_eq!(value(undone), whole);
    // A reset restores the initial state.
    assert_eq!(value("floor 0.1\nrun 0.2\nreset\npush torso 3 1 0 for 0.1\nrun 0.5"), whole);
}

/// A session may last longer than the scenario, but has the random pushes of the scenario.
#[test]
fn random_pushes_are_those_of_the_scenario() {
    let place = Place::new();
    hoap2(
        &place,
        "s.toml",
        "duration = 1.0\ncontrol = { idle_ticks = true }\nforce = [{ type = \"random-pushes\", links = [\"torso\"], number = 8, magnitude = [1, 5] }]",
    );
    place.runner(&["s.toml"]).exits(0);
    session(&place, "s.toml", "record\nrun 1\nsave recording s.mcap\n").exits(0);
    let whole = export(&place, &log_of(&place, "results", "s"), &["--events"]);
    assert_eq!(export(&place, "s.mcap", &["--events"]).rows, whole.rows);
    assert!(whole.rows.iter().filter(|row| row[1] == "push").count() >= 8);
}

/// The log of a run that stops early equals the beginning of the full log. Random pushes are drawn
/// for the full duration in both.
#[test]
fn a_run_that_stops_early_equals_the_beginning_of_the_full_run() {
    let place = Place::new();
    hoap2(
        &place,
        "s.toml",
        "duration = 1.0\nforce = [{ type = \"random-pushes\", links = [\"torso\"], number = 8, magnitude = [1, 5] }]",
    );
    place.runner(&["s.toml", "-o", "whole"]).exits(0);
    place.runner(&["s.toml", "--set", "stop.at=0.6", "-o", "part"]).exits(0);
    assert_eq!(place.summary("part").numbers("duration_s"), [0.6]);
    let (whole, part) = (log_of(&place, "whole", "s"), log_of(&place, "part", "s"));
    let (whole, part) = (export(&place, &whole, &[]), export(&place, &part, &[]));
    assert_eq!(part.rows.len(), 121);
    // The last instant of the short run is its end, so it is not compared.
    assert_eq!(whole.rows[..120], part.rows[..120]);
}
